"""What is run for a block of operating points: a compiled program, or NumPy without compiling."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import numpy as np

from propmap.arrays.namespace import by_numpy, xp
from propmap.arrays.types import Floats
from propmap.engine.lanes import in_groups, in_lanes
from propmap.physics.velocities import AzimuthNodes
from propmap.solve.disk import DiskSolution, solve_disk
from propmap.solve.problem import Case, RotorArrays
from propmap.solve.rotor_loads import loads_over_disk

COMPILER_OPTIONS = {
    # Spares a third of the evaluation where a processor has such vectors.
    "xla_cpu_prefer_vector_width": 512,
    # The first moves constants of a loop out of it, each into a kernel of its own; the second turns
    # the sums along the blade into trees of kernels.  Without them: a third less to compile.  The
    # third divides a kernel among threads, where each block of points has a thread already, and the
    # fourth leaves sums to a library, which ``lanes`` cannot.
    "xla_disable_hlo_passes": (
        "while-loop-invariant-code-motion,tree_reduction_rewriter,cpu-parallel-task-assigner,"
        "dot-library-rewriter"
    ),
}
"""How XLA compiles the theory on a CPU, for a single azimuth.

With wide vectors jaxlib 0.10.2 gives wrong values of ``jnp.arctan``, which the theory does not use;
a test holds the programs to NumPy's results."""

OBLIQUE_OPTIONS = COMPILER_OPTIONS | {"xla_backend_optimization_level": 2}
"""The same for several azimuths: a quarter less to compile, and as fast.  Axial flow would take a
fifth longer."""

AZIMUTHS_TOGETHER = 4
"""Azimuths that are computed at a time where a program takes a few points at a time: more chains of
operations for a processor to go on with.  For programs made of kernels it is not worth the
compilation, nor for derivatives, where each direction is a chain of its own."""


class Flow(NamedTuple):
    """Operating points (N,): omega [rad/s]; velocity along the axis and in the disk plane, and
    static inflow (12), read only in descent, None if there is none [m/s]: then programs are made
    without the wake states of descent."""

    omega: Floats
    v_axial: Floats
    v_inplane: Floats
    v_hover: Floats | None

    def part(self, which: Any) -> Flow:
        """Some of the points."""
        return Flow(*(None if a is None else a[which] for a in self))  # type: ignore[arg-type]


Program = Callable[[RotorArrays, Flow, AzimuthNodes, int], tuple[Any, DiskSolution]]
"""From B points to ``RotorLoads.rows``, (F, B), and the solution; the last
argument tells how many of the points are asked for, from the first on."""


def _search(
    panels: tuple[int, ...], rotor: RotorArrays, flow: Any, azimuth: AzimuthNodes
) -> tuple[Any, DiskSolution]:
    case = Case(rotor, *flow)
    solution, disk = solve_disk(case, panels, azimuth)
    found = loads_over_disk(case, disk, solution.several, panels, azimuth)
    # One array, since every further one takes as long to hand over as some points to evaluate.
    return xp.stack([values * 1.0 for values in found.rows]), solution


def _search_in_lanes(
    panels: tuple[int, ...], rotor: RotorArrays, flow: Any, azimuth: AzimuthNodes, used: Any
) -> tuple[Any, DiskSolution]:
    if not in_groups(flow.omega.size, panels):
        return _search(panels, rotor, flow, azimuth)
    same = isinstance(azimuth.count, int)

    def search(shared: RotorArrays, some: Any) -> tuple[Any, DiskSolution]:
        here, own = some
        return _search(panels, shared, here, azimuth if same else own)

    found: tuple[Any, DiskSolution]
    each = (flow, None if same else azimuth)
    found = in_lanes(search, rotor, each, used, AZIMUTHS_TOGETHER)
    return found


@functools.cache
def compiled_search(panels: tuple[int, ...], *, axial: bool) -> Any:
    """The compiled ``Program``; ``axial`` : whether there is a single azimuth.

    Without a default, which this cache would keep apart from the same value given.
    """
    options: Any = COMPILER_OPTIONS if axial else OBLIQUE_OPTIONS
    return jax.jit(functools.partial(_search_in_lanes, panels), compiler_options=options)


def search_by_numpy(panels: tuple[int, ...]) -> Program:
    """The same without compiling."""

    def program(*arguments: Any) -> tuple[Any, DiskSolution]:
        *asked, _ = arguments
        with by_numpy():
            found, solution = _search(panels, *asked)
        return np.asarray(found), solution

    return program
