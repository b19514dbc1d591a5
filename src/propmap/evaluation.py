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
from propmap.theory.inflow import MAX_STEPS
from propmap.theory.loads import RotorLoads, disk_loads
from propmap.theory.momentum import static_inflow as equation_12
from propmap.theory.parameters import Blade, Medium, Section
from propmap.theory.velocities import AzimuthNodes, azimuth_nodes

BLOCK = 64
"""Operating points per call of a compiled program: enough to fill the vector units, few
enough to stay in the processor's cache."""

FIRST_STEPS = 13
"""Steps of the root search at first.  A block takes as long as its slowest lane; the few
points that need more are collected and done again."""

ATTACHED = 0.9
"""Attached share below which a result from fixed panels is not accepted where following
stall would have helped: the forecast was wrong."""

Theory = tuple[Blade, Section, Medium]


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
    theory: Theory, setting: Accuracy, omega: Floats, v_axial: Floats, v_inplane: Floats
) -> Evaluation:
    """Loads at N operating points; omega [rad/s], velocities [m/s], all (N,), v_inplane >= 0."""
    tip = float(theory[0].station[-1])
    with np.errstate(divide="ignore", invalid="ignore"):
        advance = np.where(v_inplane > 0.0, v_inplane / (omega * tip), 0.0)
    v_hover = np.zeros_like(omega)
    down = v_axial < 0.0
    if down.any():
        rates, where = np.unique(omega[down], return_inverse=True)
        v_hover[down] = static_inflow(theory, setting, rates)[where]
    flow = (omega, v_axial, v_inplane, v_hover)
    stalls = may_stall(*_forecast_inputs(theory), omega, v_axial, v_inplane)
    everyone = np.arange(omega.size)
    results = _empty(omega.size)
    _run(theory, setting, plan(setting, advance, stalls, everyone), flow, results, FIRST_STEPS)
    unforeseen = ~stalls & ~(results.attached > ATTACHED) & np.isfinite(results.thrust)
    if unforeseen.any():
        jobs = plan(setting, advance[unforeseen], stalls[unforeseen] | True, everyone[unforeseen])
        _run(theory, setting, [j for j in jobs if len(j.panels) > 1], flow, results, FIRST_STEPS)
    return results


def static_inflow(theory: Theory, setting: Accuracy, omega: Floats) -> Floats:
    """Static inflow (12) [m/s] at omega (N,) [rad/s]."""
    still = np.zeros_like(omega)
    thrust: Any = evaluate(theory, setting, omega, still, still).thrust
    with jax.enable_x64(True):
        return np.asarray(equation_12(thrust, theory[2].density, theory[0].station[-1]))


def _run(
    theory: Theory,
    setting: Accuracy,
    jobs: list[Job],
    flow: tuple[Floats, ...],
    results: Evaluation,
    steps: int,
) -> None:
    """Evaluate jobs into ``results``, and again, with patience, what did not finish."""
    calls = []
    for job in jobs:
        size = 1 if job.points.size == 1 else BLOCK
        calls += [(job, job.points[k : k + size], size) for k in range(0, job.points.size, size)]

    def one(call: tuple[Job, NDArray[np.intp], int]) -> None:
        job, points, size = call
        padded = np.resize(points, size) if points.size < size else points
        nodes = _azimuths(job.azimuths, setting.most_azimuths)
        with jax.enable_x64(True):
            program = _program(job.panels)
            found = program(*theory, *(a[padded] for a in flow), nodes, steps)
            for target, values in zip(results, found, strict=True):
                target[points] = _flushed(np.asarray(values)[: points.size])

    if len(calls) > 1:
        with ThreadPoolExecutor(min(len(calls), os.cpu_count() or 1)) as pool:
            list(pool.map(one, calls))
    else:
        for call in calls:
            one(call)
    if steps < MAX_STEPS:
        again = []
        for job in jobs:
            left = job.points[~np.isfinite(results.thrust[job.points])]
            if left.size:
                again.append(Job(left, job.panels, job.azimuths))
        if again:
            _run(theory, setting, again, flow, results, MAX_STEPS)


@functools.cache
def _program(panels: tuple[int, ...]) -> Callable[..., RotorLoads]:
    def loads(
        blade: Blade,
        section: Section,
        medium: Medium,
        omega: Any,
        v_axial: Any,
        v_inplane: Any,
        v_hover: Any,
        azimuth: AzimuthNodes,
        max_steps: Any,
    ) -> RotorLoads:
        flow = (omega, v_axial, v_inplane, v_hover)
        return disk_loads(blade, section, medium, *flow, panels, azimuth, max_steps)

    return jax.jit(loads)


def _azimuths(count: int, most: int) -> AzimuthNodes:
    """Nodes padded to one length, so that one program serves every count but axial flow's."""
    nodes = azimuth_nodes(count)
    if count == 1:
        return nodes
    sines = np.zeros(most // 2)
    sines[: count // 2] = nodes.sines
    used: Any = np.array(count // 2)
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
