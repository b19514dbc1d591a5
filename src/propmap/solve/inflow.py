"""The hybrid inflow v_i(y), eq. (11): its root, the branch rule, its derivative.

Near stall (11) has several roots; the rule is to take the largest, the attached branch.
A scan or a Newton iteration can step over a close pair of roots and answer with the wrong
one.  This one cannot: it starts where the momentum is provably larger than the blade
elements' thrust and walks down with steps that provably stop short of the next root, from
bounds on the slope and on the curvature of the residual.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import numpy as np

from propmap.arrays.namespace import (
    Array,
    DerivativeByRule,
    held,
    of_each,
    on_numpy,
    settled,
    steps_are_free,
    while_loop,
    xp,
)
from propmap.arrays.precision import precision_of
from propmap.physics import element, momentum
from propmap.physics.element import Annulus
from propmap.physics.velocities import AzimuthNodes
from propmap.solve.bounds import Bounds, find_bounds, largest_curvature, safe_step

MAX_STEPS = 1000
"""Steps after which an unfinished root is given up; ordinary roots take about seven, roots
beside a fold up to thirty, beside the kink of (10) in slow axial descent some hundreds."""

NEWTON_STEPS = 4
"""Newton steps at most.  Only at a double root are they used up."""

FOUND = -1.0
"""Instead of Newton steps left: the last one was tiny, or the residual within tolerance."""

LIFTS, LIFT = 2, 1.5
"""How often a start below the root is lifted, and by how many Newton steps the first time."""

STATIONS_TOGETHER, LANES_TOGETHER = 4, 256
"""Stations whose roots are searched for together, and stations times operating points, at least,
unless steps are free.  All wait for the slowest, and slow roots are beside each other."""

SURE = 0.25
"""Share of its slope by which the residual's may change along a Newton step that is taken for
safe: then there is one root about it (Newton and Kantorovich ask for half).  Where no element is
near stall the bound is of upward bends alone: there the residual is concave, and no Newton step
from above a root passes it."""

CUBIC_FROM = (0.02, 1e-4)
"""Distances [-], of the last two places from each other and of the next Newton step, of the
speed, from which on the cubic through both is trusted."""


class InflowQuestion(NamedTuple):
    """One equation (11): the annulus, and 1 where it is on the windmill branch, else 0; None
    where nothing descends."""

    at: Annulus
    windmill: Array | None

    def stations(self, part: slice) -> InflowQuestion:
        """The same at some of the stations."""
        return jax.tree.map(lambda a: a[part] if xp.ndim(a) == 2 else a, self)


def residual(ask: InflowQuestion, inflow: Array, azimuth: AzimuthNodes) -> Array:
    """Blade-element thrust (5) minus momentum thrust (10), per radius and density [m^3/s^2].

    ask : annuli and wake states.  inflow : v_i [m/s], broadcast with them.  azimuth : nodes.
    """
    blade = element.annulus_thrust(ask.at, inflow, azimuth)
    return blade - _wake_thrust(ask, inflow)[0]  # Eq. (11)


def _wake_thrust(ask: InflowQuestion, inflow: Array) -> tuple[Array, Array]:
    """The momentum's thrust (10) and its derivative by v_i."""
    at = ask.at
    flow = (at.radius, at.v_axial, at.v_inplane, inflow)
    climb = momentum.annulus_thrust_slope(*flow)
    if ask.windmill is None:
        return climb
    down = ask.windmill > 0.0
    windmill = momentum.windmill_annulus_thrust_slope(*flow)
    return xp.where(down, windmill[0], climb[0]), xp.where(down, windmill[1], climb[1])


def residual_slope(
    ask: InflowQuestion, inflow: Array, azimuth: AzimuthNodes
) -> tuple[Array, Array]:
    """The residual [m^3/s^2] and its derivative with respect to v_i [m^2/s]."""
    thrust, slope = element.annulus_thrust_slope(ask.at, inflow, azimuth)
    wake, wake_slope = _wake_thrust(ask, inflow)
    return thrust - wake, slope - wake_slope


class _Seen(NamedTuple):
    v: Array  # where the residual was evaluated last, infinite if it was not
    value: Array
    per_slope: Array  # one over its slope


class _Walk(NamedTuple):
    v: Array
    newtons: Array  # Newton steps left, a real number like v; FOUND or 0 where the search has ended
    before: _Seen


def _start_at(v: Array, newtons: Array) -> _Walk:
    nowhere = xp.full_like(v, xp.inf)
    return _Walk(v, newtons, _Seen(nowhere, nowhere, nowhere))


def _beyond_newton(before: _Seen, here: _Seen) -> tuple[Array, Array]:
    """How much further down than Newton's step from ``here`` the root lies [m/s], taking v_i for a
    cubic in the residual; and the cubic's own share of that."""
    rise, apart = before.value - here.value, before.v - here.v
    share = -here.value / rise
    at_here, at_before = rise * here.per_slope, rise * before.per_slope
    square = share * share
    cubic = square * (1.0 - share) * (at_here + at_before - 2.0 * apart)
    return square * (at_here - apart) + cubic, xp.abs(cubic)


def _walk_on(
    ask: InflowQuestion, bound: Bounds, begin: _Walk, most: Array, azimuth: AzimuthNodes
) -> _Walk:
    """Take up to ``most`` steps, until all lanes have ended.

    Each lane walks down by safe steps until these are tiny, then takes Newton steps and stays.
    Where a Newton step is safe by the bounds it takes that instead.  The last step also uses the
    place before, with an error of the fourth order in the steps instead of the second.
    """
    at = ask.at
    within = precision_of(at.v_axial)
    scale = bound.speed + xp.abs(at.v_axial) + 1e-30

    def unfinished(state: tuple[_Walk, Array]) -> Array:
        walk, steps = state
        return (steps < most) & xp.any(walk.newtons > 0)

    def step(state: tuple[_Walk, Array]) -> tuple[_Walk, Array]:
        walk, steps = state
        v = walk.v

        active = walk.newtons > 0
        value, slope = settled(lambda: residual_slope(ask, v, azimuth), at.blades)
        here = _Seen(v, value, 1.0 / xp.where(slope < 0.0, slope, -1e-30))
        newton = value * here.per_slope
        curvature = largest_curvature(at, bound, v, newton)
        sure = curvature * xp.abs(newton) <= -SURE * slope
        safe = safe_step(at, bound, v, value, slope)
        # At a simple root the two steps agree; at a double one Newton's is not to be trusted.
        limit = xp.where(sure, xp.inf, 4.0 * xp.abs(safe))
        newton = xp.clip(newton, -limit, limit)
        near = (value >= 0.0) | (safe <= within.safe_step * scale) | (walk.newtons < NEWTON_STEPS)
        sizes = bound.half * bound.lift * scale * scale + 4.0 * np.pi * at.radius * xp.abs(v) * (
            scale + xp.abs(v)
        )
        # A start that turns out to prove nothing is dropped.  One past a sunk hump in climb proves
        # itself by its sign, and is lifted if it lies a little below the root.
        expected = (v < bound.guess) & (at.v_axial >= 0.0)
        wrong = (value >= 0.0) | ((slope >= 0.0) & ~expected)
        back = (steps <= LIFTS) & (walk.newtons >= NEWTON_STEPS) & wrong & (v < bound.start)
        lift = (steps < LIFTS) & (slope < 0.0) & expected
        near, sure = near & ~sure & ~back, (near | sure) & ~back
        ends = 0.5 * curvature * newton * newton <= within.left_over * scale * xp.abs(slope)
        beyond, cubic = _beyond_newton(walk.before, here)
        closes = (xp.abs(walk.before.v - v) <= CUBIC_FROM[0] * scale) & (
            xp.abs(newton) <= CUBIC_FROM[1] * scale
        )
        # The terms of the series fall off: what is left of it is far less than its last one.
        closes = closes & (cubic <= 10.0 * within.left_over * scale)
        last = sure & (ends | closes | (xp.abs(newton) <= within.newton_step * scale))
        left = walk.newtons - xp.where(near, 1.0, 0.0)
        solved = last | ((left <= 0.0) & (xp.abs(value) <= within.residual * sizes))
        again = xp.where(
            lift, xp.minimum(v - LIFT * (1 + steps) * newton, bound.start), bound.start
        )
        down = xp.where(sure, newton + xp.where(closes, beyond, 0.0), safe)
        after = _Walk(
            xp.where(back, again, xp.where(active, v - down, v)),
            xp.where(active, xp.where(solved, FOUND, left), walk.newtons),
            here,
        )
        return after, steps + 1

    walk, _ = while_loop(unfinished, step, (begin, xp.array(0)))
    return walk


def _search(ask: InflowQuestion, hint: Array, max_steps: Array, azimuth: AzimuthNodes) -> Array:
    """The largest root [m/s]; NaN where it was not reached or does not satisfy (11)."""
    shape = xp.broadcast_shapes(*(xp.shape(a) for a in jax.tree.leaves(ask)))
    bound = find_bounds(ask.at)
    proved = xp.minimum(bound.start, bound.guess)
    if ask.windmill is not None:
        proved = xp.where(ask.windmill > 0.0, bound.start, proved)
    start = xp.broadcast_to(xp.minimum(proved, hint), shape)
    begin = _start_at(start, xp.full_like(start, NEWTON_STEPS))
    walk = _walk_on(ask, bound, begin, max_steps, azimuth)
    return xp.where(walk.newtons == FOUND, walk.v, xp.nan)


def inflow_root(
    ask: InflowQuestion, start: Array, max_steps: Array, azimuth: AzimuthNodes
) -> Array:
    """The largest root v_i [m/s] of eq. (11), NaN where it was not found.

    ask : arrays that broadcast, stations first, operating points last.
    start : v_i [m/s] above which there is known to be no root, but for a little in climb; infinite
    where it is not.
    max_steps : evaluations of the residual after which the search is given up.
    azimuth : nodes; not differentiated.
    Differentiable with respect to everything in ``ask``, see ``moving_root``.
    """
    return moving_root(ask, find_root(ask, start, max_steps, azimuth), azimuth)


def find_root(ask: InflowQuestion, start: Array, max_steps: Array, azimuth: AzimuthNodes) -> Array:
    """``inflow_root`` as a mere number: its derivative is zero."""
    whole, form = jax.tree.flatten(held((ask, start)))
    by_station = [a for a in whole if xp.ndim(a) == 2]

    def search(stations: list[Array]) -> Array:
        mine = iter(stations)
        parts = [next(mine) if xp.ndim(a) == 2 else a for a in whole]
        some, above = jax.tree.unflatten(form, parts)
        return _search(some, above, max_steps, azimuth)

    count, points = xp.broadcast_shapes((1, 1), *(xp.shape(a) for a in whole))
    together = STATIONS_TOGETHER
    if not steps_are_free():
        together = max(together, -(-count // max(count * points // LANES_TOGETHER, 1)))
    if on_numpy() or count <= together:
        return search(by_station)

    def grouped(a: Array) -> Array:
        filled = xp.concatenate([a, xp.repeat(a[-1:], -count % together, axis=0)])
        return filled.reshape(-1, together, a.shape[1])

    found = of_each(search, [grouped(a) for a in by_station])
    return found.reshape(-1, points)[:count]


@DerivativeByRule
def moving_root(
    ask: InflowQuestion,  # noqa: ARG001 - what the root moves with, in the derivative below
    root: Array,
    azimuth: AzimuthNodes,  # noqa: ARG001
) -> Array:
    """A root of (11) [m/s] that is known, made to move with ``ask``.

    ask : arrays that broadcast.  root : v_i [m/s], the root of (11) there.  azimuth : nodes.
    Differentiable with respect to everything in ``ask`` by the implicit function theorem.
    """
    return root


@moving_root.defjvp
def _moving_root_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    (ask, root, azimuth), (ask_dot, *_) = primals, tangents
    v = moving_root(ask, root, azimuth)
    _, slope = residual_slope(ask, v, azimuth)
    _, change = jax.jvp(lambda a: residual(a, v, azimuth), (ask,), (ask_dot,))
    at_rest = slope == 0.0
    return v, xp.where(at_rest, 0.0, -change / xp.where(at_rest, 1.0, slope))
