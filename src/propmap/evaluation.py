"""Batches through the theory: blocks of equal size on all cores, in float64."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import jax
import numpy as np
from numpy.typing import NDArray

from propmap.schedule import Accuracy, Floats, Job, may_stall, plan
from propmap.theory.loads import RotorLoads, disk_loads
from propmap.theory.momentum import static_inflow as equation_12
from propmap.theory.parameters import Blade, Medium, Section
from propmap.theory.velocities import AzimuthNodes, azimuth_nodes

BLOCK = 32
"""Operating points per call of a compiled program: enough to fill the vector units, few
enough to stay in the processor's cache."""

LARGE_BLOCK = 128
"""The same where many points are evaluated alike, to spread what a step costs at any size."""

ATTACHED = 0.9
"""Attached share below which a result from fixed panels is not accepted where following
stall would have helped: the forecast was wrong."""

Theory = tuple[Blade, Section, Medium]


class Prepared(NamedTuple):
    """A rotor ready for evaluation: its arrays, the same as JAX arrays, the forecast's inputs."""

    theory: Theory
    on_device: Theory
    forecast: tuple[Floats, Floats, Floats, tuple[float, float]]


def prepare(theory: Theory) -> Prepared:
    """Do once what every evaluation of a rotor needs; theory in NumPy float64."""
    with jax.enable_x64(True):
        return Prepared(theory, jax.device_put(theory), _forecast_inputs(theory))


class Evaluation(NamedTuple):
    """Flat results (N,), see ``rotor.Loads`` and ``theory.loads.RotorLoads``."""

    thrust: Floats
    drag: Floats
    torque: Floats
    roll_moment: Floats
    roots: NDArray[np.int64]
    ring: Floats
    mean_inflow: Floats
    attached: Floats
    mirrored: NDArray[np.bool_]


def evaluate(
    rotor: Prepared, setting: Accuracy, omega: Floats, v_axial: Floats, v_inplane: Floats
) -> Evaluation:
    """Loads at N operating points; omega [rad/s], velocities [m/s], all (N,), v_inplane >= 0."""
    tip = float(rotor.theory[0].station[-1])
    with np.errstate(divide="ignore", invalid="ignore"):
        advance = np.where(v_inplane > 0.0, v_inplane / (omega * tip), 0.0)
    v_hover = np.zeros_like(omega)
    down = v_axial < 0.0
    if down.any():
        rates, where = np.unique(omega[down], return_inverse=True)
        v_hover[down] = static_inflow(rotor, setting, rates)[where]
    flow = (omega, v_axial, v_inplane, v_hover)
    stalls = may_stall(*rotor.forecast, omega, v_axial, v_inplane)
    everyone = np.arange(omega.size)
    results = _empty(omega.size)
    _run(rotor, setting, plan(setting, advance, stalls, everyone), flow, results)
    unforeseen = ~stalls & ~(results.attached > ATTACHED) & np.isfinite(results.thrust)
    if unforeseen.any():
        jobs = plan(setting, advance[unforeseen], stalls[unforeseen] | True, everyone[unforeseen])
        _run(rotor, setting, [j for j in jobs if len(j.panels) > 1], flow, results)
    return results


def static_inflow(rotor: Prepared, setting: Accuracy, omega: Floats) -> Floats:
    """Static inflow (12) [m/s] at omega (N,) [rad/s]."""
    still = np.zeros_like(omega)
    thrust: Any = evaluate(rotor, setting, omega, still, still).thrust
    with jax.enable_x64(True):
        return np.asarray(equation_12(thrust, rotor.theory[2].density, rotor.theory[0].station[-1]))


def _run(
    rotor: Prepared,
    setting: Accuracy,
    jobs: list[Job],
    flow: tuple[Floats, ...],
    results: Evaluation,
) -> None:
    """Evaluate jobs into ``results``."""
    calls = [(job, *piece) for job in jobs for piece in _pieces(job.points)]
    # The longest first, so that all cores end together.
    calls.sort(key=lambda call: -call[2] * sum(call[0].panels) * call[0].azimuths)

    def one(call: tuple[Job, NDArray[np.intp], int]) -> None:
        job, points, size = call
        padded = np.resize(points, size) if points.size < size else points
        # Axial flow has programs of its own, but for single points, to compile less.
        nodes = _azimuths(job.azimuths, setting.most_azimuths, padded=size == 1)
        with jax.enable_x64(True):
            program = _program(job.panels, quickly=size == 1)
            found = program(*rotor.on_device, *(a[padded] for a in flow), nodes)
            for target, values in zip(results, found, strict=True):
                target[points] = _flushed(np.asarray(values)[: points.size])

    if len(calls) > 1:
        with ThreadPoolExecutor(min(len(calls), os.cpu_count() or 1)) as pool:
            list(pool.map(one, calls))
    else:
        for call in calls:
            one(call)


@functools.cache
def _program(panels: tuple[int, ...], *, quickly: bool) -> Callable[..., RotorLoads]:
    """The compiled program; compiled in half the time if ``quickly``, for the same speed on
    single points and half of it on blocks."""

    def loads(
        blade: Blade,
        section: Section,
        medium: Medium,
        omega: Any,
        v_axial: Any,
        v_inplane: Any,
        v_hover: Any,
        azimuth: AzimuthNodes,
    ) -> RotorLoads:
        flow = (omega, v_axial, v_inplane, v_hover)
        return disk_loads(blade, section, medium, *flow, panels, azimuth)

    options: Any = {"xla_cpu_use_fusion_emitters": False} if quickly else None
    return jax.jit(loads, compiler_options=options)


def _pieces(points: NDArray[np.intp]) -> list[tuple[NDArray[np.intp], int]]:
    """Points cut into blocks, each with the size that it is filled up to."""
    if points.size == 1:
        return [(points, 1)]
    pieces = []
    size = LARGE_BLOCK
    while points.size:
        if points.size <= LARGE_BLOCK - BLOCK:
            size = BLOCK
        pieces.append((points[:size], size))
        points = points[size:]
    return pieces


def _azimuths(count: int, most: int, *, padded: bool) -> AzimuthNodes:
    """Nodes padded to one length, so that one program serves every count.

    Unless ``padded``, axial flow's single node stays alone and its number static.
    """
    nodes = azimuth_nodes(count)
    if count == 1 and not padded:
        return nodes
    sines = np.zeros(most // 2)
    sines[: nodes.sines.size] = nodes.sines
    used: Any = np.array(nodes.sines.size)
    return AzimuthNodes(sines, used)


def _forecast_inputs(theory: Theory) -> tuple[Floats, Floats, Floats, tuple[float, float]]:
    blade, section, _ = theory
    radius = np.linspace(float(blade.root), float(blade.station[-1]), 12)
    chord = np.interp(radius, blade.station, blade.chord)
    twist = np.interp(radius, blade.station, blade.twist)
    slope = chord * float(blade.blades * section.c_l1) / (8.0 * np.pi * radius)
    pitch = twist - float(section.zero_lift_angle)
    return radius, slope, pitch, (float(section.alpha_0), float(section.sharpness))


def _flushed(values: NDArray[Any]) -> NDArray[Any]:
    """Zero instead of what the speed floor leaves of a load at rest, 1e-45 and the like."""
    return np.where(np.abs(values) < 1e-30, 0, values) if values.dtype.kind == "f" else values


def _empty(points: int) -> Evaluation:
    numbers = [np.full(points, np.nan) for _ in range(4)]
    roots, mirrored = np.zeros(points, np.int64), np.zeros(points, bool)
    rest = [np.full(points, np.nan) for _ in range(3)]
    return Evaluation(*numbers, roots, *rest, mirrored)  # type: ignore[call-arg]
