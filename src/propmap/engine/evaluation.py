"""Loads of batches: planned, cut into blocks, run on all cores."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import numpy as np

from propmap.arrays.namespace import by_numpy, on_accelerator
from propmap.arrays.types import Floats
from propmap.engine.batch import Block, cut, filled_up, nodes_of_each, run
from propmap.engine.plan import Accuracy, Outlook, may_leave_islands, may_stall, plan
from propmap.engine.programs import Flow, compiled_search, search_by_numpy
from propmap.physics.element import AnnulusLoads
from propmap.physics.momentum import static_inflow as equation_12
from propmap.physics.velocities import AzimuthNodes, azimuth_nodes
from propmap.solve.disk import DiskSolution
from propmap.solve.problem import RotorArrays
from propmap.solve.rotor_loads import RotorLoads

FEW = 512
"""Operating points below which a batch is not worth the compilation of programs of its own."""

CHUNK = 65536
"""Operating points that are planned and run together, at most, so that only what the loads take
grows with the batch."""

ATTACHED = 0.9
"""Attached share below which a result from fixed panels is not accepted where following
stall would have helped: the forecast was wrong."""

ROWS = len(AnnulusLoads._fields) + len(RotorLoads._fields) - 1
"""Of a batch's results, see ``RotorLoads.rows``."""

Solved = Callable[[Block, DiskSolution], None]
"""Told of a block of points whose inflow is found; last axis: the block's points, padded."""


class Prepared(NamedTuple):
    """A rotor ready for evaluation: its arrays, the same where programs run, the forecast's inputs,
    whether programs are compiled, whether the same serve batches of any size, and whether they
    work in float64 or else float32."""

    arrays: RotorArrays
    on_device: RotorArrays
    forecast: tuple[Floats, Floats, Floats, tuple[float, float]]
    compiled: bool
    uniform: bool
    double: bool


def prepare(
    arrays: RotorArrays, *, compiled: bool = True, uniform: bool = False, double: bool = True
) -> Prepared:
    """Do once what every evaluation of a rotor needs; arrays of NumPy float64."""
    on_device = arrays
    if compiled:
        with jax.enable_x64(double):
            on_device = jax.device_put(arrays)
    return Prepared(arrays, on_device, _forecast_inputs(arrays), compiled, uniform, double)


def evaluate(
    rotor: Prepared, setting: Accuracy, omega: Floats, v_axial: Floats, v_inplane: Floats
) -> RotorLoads:
    """Loads at N operating points; omega [rad/s], velocities [m/s], all (N,), v_inplane >= 0."""
    down = v_axial < 0.0
    v_hover = np.zeros_like(omega) if rotor.uniform or down.any() else None
    if v_hover is not None and down.any():
        rates, where = np.unique(omega[down], return_inverse=True)
        v_hover[down] = static_inflow(rotor, setting, rates)[where]
    return _in_parts(rotor, setting, Flow(omega, v_axial, v_inplane, v_hover))


def _in_parts(rotor: Prepared, setting: Accuracy, flow: Flow) -> RotorLoads:
    # Of one size, lest a few left over ask for programs of their own.
    points = np.arange(flow.omega.size)
    which = np.array_split(points, max(1, -(-points.size // CHUNK)))
    found = [evaluate_flow(rotor, setting, flow.part(part)) for part in which]
    rows: Any = [np.concatenate(row) for row in zip(*(one.rows for one in found), strict=True)]
    return RotorLoads.of_rows(rows)


def evaluate_flow(
    rotor: Prepared,
    setting: Accuracy,
    flow: Flow,
    *,
    alike: bool = False,
    size: int | None = None,
    solved: Solved | None = None,
) -> RotorLoads:
    """Loads at N operating points whose static inflow is known.

    alike : see ``schedule.plan``; otherwise stall is followed only where it is forecast.
    size : of the blocks, by default see ``blocks.cut``.  solved : told of each block; of a point
    twice where the forecast was wrong, the last time counts.
    """
    omega, v_axial, v_inplane, v_hover = flow
    advance = advance_ratio(rotor, omega, v_inplane)
    climb = advance_ratio(rotor, omega, v_axial)
    everyone = np.arange(omega.size)
    stalls = may_stall(*rotor.forecast, omega, v_axial, v_inplane) | alike
    islands = may_leave_islands(v_axial, 0.0 if v_hover is None else v_hover)
    outlook = Outlook(advance, climb, stalls, islands)
    results = np.full((ROWS, omega.size), np.nan)
    apart = not _few(rotor, flow)
    kinds = {"axial_apart": apart, "descent": v_hover is not None}
    jobs = plan(setting, outlook, everyone, alike=alike, **kinds)
    here = {"accelerator": rotor.compiled and on_accelerator(), "compiled": rotor.compiled}
    sizes = {"large": rotor.uniform, **here}
    blocks = cut(jobs, size, **sizes)
    _run(rotor, blocks, flow, results, solved)
    found = RotorLoads.of_rows(results)
    unforeseen = ~stalls & ~(found.attached > ATTACHED) & np.isfinite(found.loads.thrust)
    if unforeseen.any():
        again = outlook.stalling(unforeseen)
        jobs = plan(setting, again, everyone[unforeseen], **kinds)
        blocks = cut([j for j in jobs if len(j.panels) > 1], size, **sizes)
        _run(rotor, blocks, flow, results, solved)
    # Zero instead of what the speed floor leaves of a load at rest, 1e-45 and the like.
    results[np.abs(results) < 1e-30] = 0.0
    found = RotorLoads.of_rows(results)
    return found._replace(roots=found.roots.astype(int), mirrored=found.mirrored > 0.0)


def advance_ratio(rotor: Prepared, omega: Floats, velocity: Floats) -> Floats:
    """A component of V over Omega R [-], (N,); infinite for a rotor at rest in a wind."""
    tip = float(rotor.arrays.blade.station[-1])
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(velocity != 0.0, velocity / (omega * tip), 0.0)


def static_inflow(rotor: Prepared, setting: Accuracy, omega: Floats) -> Floats:
    """Static inflow (12) [m/s] at omega (N,) [rad/s]."""
    still = np.zeros_like(omega)
    # With the programs of the descent that asks for it.
    thrust: Any = _in_parts(rotor, setting, Flow(omega, still, still, still)).loads.thrust
    with by_numpy():
        return np.asarray(equation_12(thrust, rotor.arrays.medium.density, rotor.arrays.blade.tip))


def _run(
    rotor: Prepared,
    blocks: list[Block],
    flow: Flow,
    results: Floats,
    solved: Solved | None,
) -> None:
    """Evaluate blocks into ``results`` (F, N), as ``RotorLoads.rows``."""
    few = _few(rotor, flow)

    def one(block: Block) -> None:
        nodes = nodes_of(block, few=few)
        which = block.padded
        program = search_by_numpy(block.panels)
        if rotor.compiled:
            program = compiled_search(block.panels, axial=isinstance(nodes.count, int))
        # Without x64 JAX takes what is float64 for float32.
        with jax.enable_x64(rotor.double):
            asked = (flow.part(which), nodes, block.points.size)
            found, solution = program(rotor.on_device, *asked)
            results[:, block.points] = np.asarray(found)[:, : block.points.size]
            if solved is not None:
                solved(block, solution)

    run(blocks, one, in_turn=not rotor.compiled)


def nodes_of(block: Block, *, few: bool) -> AzimuthNodes:
    """Azimuth nodes of a block: axial flow has programs of its own, but for a few points, to
    compile less."""
    if block.azimuths[0] == 1 and not few:
        return azimuth_nodes(1)
    return nodes_of_each(filled_up(block.azimuths, block.size), block.most_azimuths)


def _few(rotor: Prepared, flow: Flow) -> bool:
    return flow.omega.size < FEW or rotor.uniform


def _forecast_inputs(
    arrays: RotorArrays,
) -> tuple[Floats, Floats, Floats, tuple[float, float]]:
    blade, law = arrays.blade, arrays.law
    with by_numpy():
        bounds = law.bounds()
    radius = np.linspace(float(blade.root), float(blade.tip), 12)
    chord = np.interp(radius, blade.station, blade.chord)
    twist = np.interp(radius, blade.station, blade.twist)
    slope = chord * float(blade.blades * bounds.attached_slope) / (8.0 * np.pi * radius)
    pitch = twist - float(law.zero_lift_angle)
    return radius, slope, pitch, (float(bounds.stall_angle), 1.0 / float(bounds.stall_width))
