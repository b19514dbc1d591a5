"""Batches of operating points with a state of their inflow."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import numpy as np

from propmap.arrays.namespace import by_numpy, xp
from propmap.engine.accuracy import Accuracy
from propmap.engine.batch import BLOCK, Block, nodes_of_each
from propmap.engine.evaluation import CHUNK, Prepared, evaluate_flow, flow_at
from propmap.engine.programs import OBLIQUE_OPTIONS, Flow
from propmap.loads import LOADS
from propmap.physics.dynamic_inflow import Disk
from propmap.physics.rotor import RotorArrays
from propmap.physics.velocities import AzimuthNodes
from propmap.solve.disk import DiskSolution
from propmap.solve.problem import Case
from propmap.solve.rotor_loads import RotorLoads
from propmap.solve.state_loads import state_loads
from propmap.typing import Floats

LEAST_AZIMUTHS = 16
"""Azimuths over which loads are averaged in axial flow too, where a state's gradients may not
vanish."""

ROWS = 7 + 4 * len(LOADS)
"""Number of arrays in ``_rows``."""


class Found(NamedTuple):
    """A batch of N operating points, each with a state of its inflow.

    Attributes
    ----------
    static : RotorLoads
        The static solution, (N,).
    disk : Disk
        What the motion of the inflow depends on.
    change : ndarray, shape (L, N)
        Loads with the state minus static loads, in the order of ``LOADS`` [N], [N m].
    forces : ndarray, shape (N, 3)
        Of these per density the thrust, the rolling moment and the moment that lifts the rear.
    """

    static: RotorLoads
    disk: Disk
    change: Floats
    forces: Floats


def with_states(
    rotor: Prepared,
    setting: Accuracy,
    omega: Floats,
    v_axial: Floats,
    v_inplane: Floats,
    states: Floats | None,
) -> Found:
    """Loads and inflow of N operating points with a state of the inflow each.

    Parameters
    ----------
    rotor, setting : Prepared, Accuracy
        As for ``evaluation.evaluate``.
    omega, v_axial, v_inplane : ndarray, shape (N,)
        [rad/s], [m/s]; v_inplane >= 0.
    states : ndarray, shape (N, 3), or None
        Mean inflow, v_s and v_c [m/s]; None for one without inflow, where only the rest is wanted.
    """
    flow = flow_at(rotor, setting, omega, v_axial, v_inplane)
    given = np.zeros((omega.size, 3)) if states is None else states
    rows = np.full((ROWS, omega.size), np.nan)
    parts = [
        _part(rotor, setting, flow, given, slice(start, start + CHUNK), rows)
        for start in range(0, max(omega.size, 1), CHUNK)
    ]
    static: Any = (np.concatenate(row) for row in zip(*(p.rows for p in parts), strict=True))
    own = RotorLoads.of_rows(static)
    lost = ~np.isfinite(own.loads.thrust)
    rows[:, lost] = np.nan
    density, count = float(rotor.arrays.medium.density), len(LOADS)
    change = rows[7 : 7 + count]
    slopes = rows[7 + count :].reshape(3, count, -1)
    mass_flow, by_thrust, by_roll, by_pitch = rows[3:7]
    disk = Disk(
        float(rotor.arrays.blade.tip),
        v_axial,
        v_inplane,
        rows[:3].T,
        mass_flow,
        by_thrust,
        by_roll,
        by_pitch,
        _moving(slopes.transpose(1, 0, 2)).transpose(2, 0, 1),
    )
    return Found(own, disk, density * change, _moving(change).T)


def _moving(loads: Floats) -> Floats:
    """Of loads (L, ...) those that move air: thrust, roll, and the moment that lifts the rear."""
    order = list(LOADS)
    thrust, roll, pitch = (
        loads[order.index(name)] for name in ("thrust", "roll_moment", "pitch_moment")
    )
    return np.stack([thrust, roll, -pitch])


def _part(
    rotor: Prepared, setting: Accuracy, flow: Flow, states: Floats, part: slice, rows: Floats
) -> RotorLoads:
    """Evaluate some of the points; write into their ``rows``."""
    here, mine, into = flow.part(part), states[part], rows[:, part]

    def look(block: Block, solution: DiskSolution) -> None:
        azimuths = np.maximum(block.azimuths, LEAST_AZIMUTHS)
        most = max(block.most_azimuths, LEAST_AZIMUTHS)
        solution = jax.tree.map(np.asarray, solution)
        width = min(BLOCK, block.size)
        for start in range(0, block.points.size, width):
            some = slice(start, start + width)
            points, size = block.points[some], width if rotor.compiled else None
            piece = block._replace(points=points, size=size or points.size)
            which = piece.padded
            turn = np.resize(azimuths[some], piece.size)
            own = jax.tree.map(functools.partial(_some, some, piece.size), solution)
            nodes = nodes_of_each(turn, most)
            program = _program(block.panels) if rotor.compiled else _by_numpy(block.panels)
            with jax.enable_x64(rotor.double):
                found = program(rotor.on_device, here.part(which), own, mine[which].T, nodes)
            into[:, points] = np.asarray(found)[:, : points.size]

    return evaluate_flow(rotor, setting, here, solved=look)


def _some(points: slice, size: int, values: Any) -> Any:
    """Of a solution's array those of some points, repeated up to ``size``; all if it is shared."""
    if values.shape[-1] == 1:
        return values
    some = values[..., points]
    return some.take(np.arange(size), axis=-1, mode="wrap")


def _rows(
    panels: tuple[int, ...],
    rotor: RotorArrays,
    flow: Any,
    solution: DiskSolution,
    states: Any,
    azimuth: AzimuthNodes,
) -> Any:
    found = state_loads(Case(rotor, *flow), solution, states, panels, azimuth)
    *first, change, slopes = found[1:]
    each = (*found.steady, *first, *change, *(load for by in slopes for load in by))
    return xp.stack([xp.broadcast_to(row, xp.shape(flow.omega)) for row in each])


@functools.cache
def _program(panels: tuple[int, ...]) -> Callable[..., Any]:
    options: Any = OBLIQUE_OPTIONS
    return jax.jit(functools.partial(_rows, panels), compiler_options=options)


def _by_numpy(panels: tuple[int, ...]) -> Callable[..., Any]:
    def program(*arguments: Any) -> Any:
        with by_numpy():
            return _rows(panels, *arguments)

    return program
