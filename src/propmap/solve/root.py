"""The hybrid inflow v_i(y): the largest root of eq. (11), and its derivative.

Near stall (11) has several roots, of which the largest, on the attached branch, is wanted.  A scan
or a Newton iteration can step over two roots that are close together and find a wrong one.  This
search starts at a v_i above all roots, where ``solve.bounds`` proves that the momentum thrust is
larger than the blade-element thrust.  From there it lowers v_i by safe steps, which by a bound on
the second derivative cannot pass a root, and ends with Newton steps.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import numpy as np

from propmap.arrays.loops import map_entries, steps_are_free, while_loop
from propmap.arrays.materialize import materialize
from propmap.arrays.namespace import Array, custom_jvp, on_numpy, stop_gradient, xp
from propmap.arrays.precision import precision_of
from propmap.physics.element import Station
from propmap.physics.velocities import AzimuthNodes
from propmap.solve.bounds import Bounds, find_bounds, largest_curvature, safe_step
from propmap.solve.problem import AnnulusProblem, residual, residual_slope

MAX_STEPS = 1000
"""Steps after which a search is given up.  Most roots take about seven, roots beside a fold up to
thirty, roots beside the kink of (10) in slow axial descent some hundreds."""

NEWTON_STEPS = 4
"""Newton steps at most; only double roots take all of them."""

FOUND = -1.0
"""Value of ``_Walk.newtons`` once the root is found."""

STATIONS_TOGETHER, LANES_TOGETHER = 4, 256
"""Stations searched together, at least; and stations times points, at least, which does not count
if ``steps_are_free``.  Small groups of neighbours are best: the slowest root of a group decides,
and slow roots are at neighbouring stations."""

SURE = 0.25
"""Largest relative change of the residual's slope along a Newton step that counts as safe.

By the theorem of Newton and Kantorovich there is then one root near its end; it asks for 1/2.
Where no element is near stall only positive second derivatives count: the residual is concave
there, and no Newton step from above a root passes it."""

CUBIC_FROM = (0.02, 1e-4)
"""Largest distance between the last two v_i, and largest next Newton step, for which the cubic
through both places is used; relative to the speed [-]."""


class Search(NamedTuple):
    """Result of a search for roots; all (S, B).

    Attributes
    ----------
    inflow : Array
        Last v_i [m/s].
    found : Array
        Whether that is the largest root.
    residual : Array
        Last evaluated residual of (11) [m^3/s^2].
    steps : Array
        Number of steps until all searches had ended; a scalar.
    """

    inflow: Array
    found: Array
    residual: Array
    steps: Array


class _Evaluated(NamedTuple):
    v: Array  # v_i [m/s] of the last evaluation of the residual, infinite before the first
    value: Array
    per_slope: Array  # one over its slope


class _Walk(NamedTuple):
    v: Array
    newtons: Array  # Newton steps left, a float like v; FOUND or 0 where the search has ended
    before: _Evaluated


def search(problem: AnnulusProblem, max_steps: Array, azimuth: AzimuthNodes) -> Search:
    """Search for the largest root of (11) at all stations and operating points at once.

    Each search takes safe steps down until these are tiny, then Newton steps.  Where the bounds
    show that a Newton step is safe, it takes that at once.  The last step also uses the place
    before, so that its error is of the fourth order in the steps instead of the second.
    """
    at, wake = problem
    bound = find_bounds(at, wake)
    first = _first_place(problem, bound)

    def unfinished(state: tuple[_Walk, Array]) -> Array:
        walk, steps = state
        return (steps < max_steps) & xp.any(walk.newtons > 0)

    def step(state: tuple[_Walk, Array]) -> tuple[_Walk, Array]:
        walk, steps = state
        value, slope = materialize(lambda: residual_slope(problem, walk.v, azimuth), at.blades)
        return _step(problem, bound, walk, steps, value, slope), steps + 1

    nowhere = xp.full_like(first, xp.inf)
    begin = _Walk(first, xp.full_like(first, NEWTON_STEPS), _Evaluated(nowhere, nowhere, nowhere))
    walk, steps = while_loop(unfinished, step, (begin, xp.array(0)))
    return Search(walk.v, walk.newtons == FOUND, walk.before.value, steps)


def _first_place(problem: AnnulusProblem, bound: Bounds) -> Array:
    """First v_i [m/s], (S, B): above all roots by proof, or a guess that the first step checks."""
    first = xp.minimum(bound.start, bound.guess)
    if problem.wake.windmill is not None:
        first = xp.where(problem.wake.windmill > 0.0, bound.start, first)
    points = xp.shape(problem.at.omega)
    return xp.broadcast_to(first, xp.broadcast_shapes(xp.shape(first), points))


def _step(
    problem: AnnulusProblem, bound: Bounds, walk: _Walk, steps: Array, value: Array, slope: Array
) -> _Walk:
    """One step of the search, from where the residual has this ``value`` and ``slope``."""
    at, wake = problem
    v, within = walk.v, precision_of(walk.v)
    scale = bound.speed + xp.abs(at.v_axial) + 1e-30
    here = _Evaluated(v, value, 1.0 / xp.where(slope < 0.0, slope, -1e-30))
    newton = value * here.per_slope
    curvature = largest_curvature(at, wake, bound, v, newton)
    sure = curvature * xp.abs(newton) <= -SURE * slope
    safe = safe_step(at, wake, bound, v, value, slope)
    # Near a simple root the two steps agree; near a double one a Newton step may be far too long.
    limit = xp.where(sure, xp.inf, 4.0 * xp.abs(safe))
    newton = xp.clip(newton, -limit, limit)
    # Where the residual is positive or rises the guess was wrong: go back to ``bound.start``.
    back = (steps == 0) & ((value >= 0.0) | (slope >= 0.0)) & (v < bound.start)
    near = (value >= 0.0) | (safe <= within.safe_step * scale) | (walk.newtons < NEWTON_STEPS)
    near, sure = near & ~sure & ~back, (near | sure) & ~back

    beyond, cubic = _beyond_newton(walk.before, here)
    closes = xp.abs(walk.before.v - v) <= CUBIC_FROM[0] * scale
    closes = closes & (xp.abs(newton) <= CUBIC_FROM[1] * scale)
    # The error of the cubic is far less than its last term.
    closes = closes & (cubic <= 10.0 * within.left_over * scale)
    ends = 0.5 * curvature * newton * newton <= within.left_over * scale * xp.abs(slope)
    last = sure & (ends | closes | (xp.abs(newton) <= within.newton_step * scale))
    left = walk.newtons - xp.where(near, 1.0, 0.0)
    sizes = bound.half * bound.law.lift * scale * scale
    sizes = sizes + 4.0 * np.pi * at.radius * xp.abs(v) * (scale + xp.abs(v))
    solved = last | ((left <= 0.0) & (xp.abs(value) <= within.residual * sizes))

    active = walk.newtons > 0
    down = xp.where(sure, newton + xp.where(closes, beyond, 0.0), safe)
    return _Walk(
        xp.where(back, bound.start, xp.where(active, v - down, v)),
        xp.where(active, xp.where(solved, FOUND, left), walk.newtons),
        here,
    )


def _beyond_newton(before: _Evaluated, here: _Evaluated) -> tuple[Array, Array]:
    """How far the root is below the end of a Newton step from ``here`` [m/s], for v_i as a cubic of
    the residual; and the absolute value of the cubic term in that."""
    rise, apart = before.value - here.value, before.v - here.v
    share = -here.value / rise
    at_here, at_before = rise * here.per_slope, rise * before.per_slope
    square = share * share
    cubic = square * (1.0 - share) * (at_here + at_before - 2.0 * apart)
    return square * (at_here - apart) + cubic, xp.abs(cubic)


def find_root(problem: AnnulusProblem, max_steps: Array, azimuth: AzimuthNodes) -> Array:
    """The largest root v_i of eq. (11), without derivatives.

    Parameters
    ----------
    problem : AnnulusProblem
        S stations at B operating points.
    max_steps : Array
        Evaluations of the residual after which the search is given up.
    azimuth : AzimuthNodes
        Azimuths to average over.

    Returns
    -------
    Array
        [m/s], (S, B); NaN where it was not found.
    """
    problem = stop_gradient(problem)
    points = xp.broadcast_shapes(xp.shape(problem.at.omega), xp.shape(problem.at.radius)[1:])[-1]
    count = problem.at.radius.shape[0]

    def roots(station: Station) -> Array:
        some = problem._replace(at=problem.at._replace(station=station))
        ended = search(some, max_steps, azimuth)
        return xp.where(ended.found, ended.inflow, xp.nan)

    together = STATIONS_TOGETHER
    if not steps_are_free():
        together = max(together, -(-count // max(count * points // LANES_TOGETHER, 1)))
    if on_numpy() or count <= together:
        return roots(problem.at.station)

    def grouped(a: Array) -> Array:
        filled = xp.concatenate([a, xp.repeat(a[-1:], -count % together, axis=0)])
        return filled.reshape(-1, together, a.shape[1])

    found = map_entries(roots, jax.tree.map(grouped, problem.at.station))
    return found.reshape(-1, points)[:count]


def inflow_root(problem: AnnulusProblem, max_steps: Array, azimuth: AzimuthNodes) -> Array:
    """``find_root``, differentiable with respect to everything in ``problem``."""
    return moving_root(problem, find_root(problem, max_steps, azimuth), azimuth)


@custom_jvp
def moving_root(
    problem: AnnulusProblem,  # noqa: ARG001 - the derivative below needs it
    root: Array,
    azimuth: AzimuthNodes,  # noqa: ARG001
) -> Array:
    """A known ``root`` of (11) [m/s], differentiable with respect to everything in ``problem``.

    The derivative follows from the implicit function theorem.
    """
    return root


@moving_root.defjvp
def _moving_root_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    (problem, root, azimuth), (problem_dot, *_) = primals, tangents
    v = moving_root(problem, root, azimuth)
    _, slope = residual_slope(problem, v, azimuth)
    _, change = jax.jvp(lambda a: residual(a, v, azimuth), (problem,), (problem_dot,))
    at_rest = slope == 0.0
    return v, xp.where(at_rest, 0.0, -change / xp.where(at_rest, 1.0, slope))
