"""Programs that find inflow and loads of a block of points, compiled or run by NumPy."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import numpy as np

from propmap.arrays.namespace import by_numpy, xp
from propmap.engine.lanes import in_lanes, known_jaxlib
from propmap.physics.rotor import RotorArrays
from propmap.physics.velocities import AzimuthNodes
from propmap.solve.disk import DiskSolution
from propmap.solve.problem import Case
from propmap.solve.rotor_loads import search_loads
from propmap.typing import Floats

COMPILER_OPTIONS: dict[str, Any] = {
    # An evaluation takes a third less time on a processor with such vectors.
    "xla_cpu_prefer_vector_width": 512,
    # The first pass moves constants of a loop into kernels before it; the second splits sums along
    # the blade into several kernels.  Without them compilation takes a third less time.  The third
    # divides a kernel among threads, but each block of points has a thread already.  The fourth
    # gives sums to a library, which ``engine.lanes`` forbids.
    "xla_disable_hlo_passes": (
        "while-loop-invariant-code-motion,tree_reduction_rewriter,cpu-parallel-task-assigner,"
        "dot-library-rewriter"
    ),
}
"""Options of XLA for programs with a single azimuth on a CPU.

With wide vectors jaxlib 0.10.2 gives wrong values of ``jnp.arctan``, which is not used here; a test
compares the programs with NumPy."""

OBLIQUE_OPTIONS = COMPILER_OPTIONS | {"xla_backend_optimization_level": 2}
"""The same for several azimuths: programs compile in a quarter less time and are as fast, while
those with a single azimuth would be a fifth slower."""

OF_KERNELS = {"xla_cpu_use_fusion_emitters": False}
"""XLA option for programs without lanes, those of a fit first of all.

Kernels are written by the older of XLA's two emitters, which takes a quarter less time for a
program, and are as fast.  Programs with lanes compile no sooner by it, and are 4 % slower."""

AZIMUTHS_TOGETHER = 4
"""Azimuths in one step of a loop for programs with lanes, see ``arrays.loops.TOGETHER``.  Without
lanes so many are not worth the compilation; nor for derivatives, whose directions are independent
computations already."""


class Flow(NamedTuple):
    """Operating points (N,): omega [rad/s]; velocities along the axis and in the disk plane [m/s];
    static inflow (12) [m/s], used in descent.  If that is None, no point descends, and programs
    leave out the wake states of descent."""

    omega: Floats
    v_axial: Floats
    v_inplane: Floats
    v_hover: Floats | None

    def part(self, which: Any) -> Flow:
        """The flow at some of the points."""
        return Flow(*(None if a is None else a[which] for a in self))  # type: ignore[arg-type]


Program = Callable[[RotorArrays, Flow, AzimuthNodes, int], tuple[Any, DiskSolution]]
"""Gives ``RotorLoads.rows``, (F, B), and the solution at B points; the last argument is the number
of points that are evaluated, from the first on."""


def _search(
    panels: tuple[int, ...], rotor: RotorArrays, flow: Any, azimuth: AzimuthNodes
) -> tuple[Any, DiskSolution]:
    found, solution = search_loads(Case(rotor, *flow), panels, azimuth)
    # One array: to hand over a further one takes as long as to evaluate some points.
    return xp.stack([values * 1.0 for values in found.rows]), solution


def _search_in_lanes(
    panels: tuple[int, ...],
    lanes: bool,
    rotor: RotorArrays,
    flow: Any,
    azimuth: AzimuthNodes,
    used: Any,
) -> tuple[Any, DiskSolution]:
    if not lanes:
        return _search(panels, rotor, flow, azimuth)
    same = isinstance(azimuth.count, int)

    def search(shared: RotorArrays, some: Any) -> tuple[Any, DiskSolution]:
        here, own = some
        return _search(panels, shared, here, azimuth if same else own)

    found: tuple[Any, DiskSolution]
    each = (flow, None if same else azimuth)
    found = in_lanes(search, rotor, each, used, AZIMUTHS_TOGETHER)
    return found


def with_lanes(options: dict[str, Any], lanes: bool) -> Any:
    """XLA's ``options`` for a program with lanes, or for one that is made of kernels."""
    return options if lanes or not known_jaxlib() else options | OF_KERNELS


@functools.cache
def compiled_search(panels: tuple[int, ...], *, axial: bool, lanes: bool) -> Any:
    """The compiled ``Program``.

    ``axial`` tells whether there is a single azimuth, ``lanes`` what ``in_groups`` says of its
    blocks.  They have no default, which the cache would keep apart from the same value given.
    """
    options = with_lanes(COMPILER_OPTIONS if axial else OBLIQUE_OPTIONS, lanes)
    return jax.jit(functools.partial(_search_in_lanes, panels, lanes), compiler_options=options)


def search_by_numpy(panels: tuple[int, ...]) -> Program:
    """The ``Program`` run by NumPy."""

    def program(*arguments: Any) -> tuple[Any, DiskSolution]:
        *asked, _ = arguments
        with by_numpy():
            found, solution = _search(panels, *asked)
        return np.asarray(found), solution

    return program
