"""The hybrid inflow v_i(y), eq. (11): its root, the branch rule, its derivative.

Near stall (11) has several roots; the rule is to take the largest, the attached branch.
A scan or a Newton iteration can step over a close pair of roots and answer with the wrong
one.  This one cannot: it starts where the momentum is provably larger than the blade
elements' thrust and walks down with steps that provably stop short of the next root, from
bounds on the slope and on the curvature of the residual.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from propmap.theory import blade_element, momentum
from propmap.theory.blade_element import Annulus
from propmap.theory.inflow_bounds import (
    SAFE_TOLERANCE,
    find_bounds,
    largest_curvature,
    safe_step,
)
from propmap.theory.parameters import Array
from propmap.theory.section_law import largest_lift
from propmap.theory.settled import settled
from propmap.theory.velocities import AzimuthNodes

MAX_STEPS = 1000
"""Steps after which an unfinished root is given up; ordinary roots take about seven, roots
beside a fold up to thirty, beside the kink of (10) in slow axial descent some hundreds."""

NEWTON_TOLERANCE = 1e-9
"""Size of a Newton step, relative to the speeds at hand, after which the root is taken as found."""

LEFT_OVER = 1e-12
"""The same for what a Newton step leaves, by the curvature: most steps of 1e-7 are the last."""

NEWTON_STEPS = 4
"""Newton steps at most.  Only at a double root are they used up."""

GATHER_FROM = 3000
"""Lanes, stations times operating points, from which it pays to gather the slow ones."""

STEPS_TOGETHER = 3
"""Steps that all lanes of a large batch take before the unfinished go on by themselves."""

RESIDUAL_TOLERANCE = 1e-9
"""Largest accepted residual, relative to the sizes of the terms of (11)."""


class InflowQuestion(NamedTuple):
    """One equation (11): the annulus, and 1 where it is on the windmill branch, else 0."""

    at: Annulus
    windmill: Array


def residual(ask: InflowQuestion, inflow: Array, azimuth: AzimuthNodes) -> Array:
    """Blade-element thrust (5) minus momentum thrust (10), per radius and density [m^3/s^2].

    ask : annuli and wake states.  inflow : v_i [m/s], broadcast with them.  azimuth : nodes.
    """
    blade = blade_element.annulus_thrust(ask.at, inflow, azimuth)
    return blade - _wake_thrust(ask, inflow)  # Eq. (11)


def _wake_thrust(ask: InflowQuestion, inflow: Array) -> Array:
    at = ask.at
    flow = (at.radius, at.v_axial, at.v_inplane, inflow)
    windmill = momentum.windmill_annulus_thrust(*flow)
    return jnp.where(ask.windmill > 0.0, windmill, momentum.annulus_thrust(*flow))


def residual_slope(
    ask: InflowQuestion, inflow: Array, azimuth: AzimuthNodes
) -> tuple[Array, Array]:
    """The residual [m^3/s^2] and its derivative with respect to v_i [m^2/s]."""
    thrust, slope = blade_element.annulus_thrust_slope(ask.at, inflow, azimuth)
    wake, wake_slope = jax.jvp(lambda v: _wake_thrust(ask, v), (inflow,), (jnp.ones_like(inflow),))
    return thrust - wake, slope - wake_slope


class _Walk(NamedTuple):
    v: Array
    newtons: Array  # Newton steps left; none where the search has ended
    good: Array  # whether the last step was tiny or the residual within tolerance


def _walk_on(
    ask: InflowQuestion, begin: _Walk, first: Array, most: Array, azimuth: AzimuthNodes
) -> tuple[_Walk, Array]:
    """Take steps ``first`` to ``most``, or until all lanes have ended; and the next step's number.

    One loop, so that the blade elements are compiled once: each lane walks down by safe
    steps until these are tiny, then takes Newton steps and stays.
    """
    at = ask.at
    bound = find_bounds(at)
    scale = bound.speed + jnp.abs(at.v_axial) + 1e-300

    def unfinished(state: tuple[_Walk, Array]) -> Array:
        walk, steps = state
        return (steps < most) & jnp.any(walk.newtons > 0)

    def step(state: tuple[_Walk, Array]) -> tuple[_Walk, Array]:
        walk, steps = state
        v = walk.v
        value, slope = settled(lambda: residual_slope(ask, v, azimuth), at.blades)
        safe = settled(lambda: safe_step(at, bound, v, value, slope), at.blades)
        # At a simple root the two steps agree; at a double one Newton's is not to be trusted.
        limit = 4.0 * jnp.abs(safe)
        newton = jnp.clip(value / jnp.where(slope < 0.0, slope, -1e-300), -limit, limit)
        near = (value >= 0.0) | (safe <= SAFE_TOLERANCE * scale) | (walk.newtons < NEWTON_STEPS)
        sizes = bound.half * largest_lift(
            at.section
        ) * scale * scale + 4.0 * np.pi * at.radius * jnp.abs(v) * (scale + jnp.abs(v))
        # A start that turns out to prove nothing is dropped.
        back = (steps == 0) & ((value >= 0.0) | (slope >= 0.0)) & (v < bound.start)
        near = near & ~back
        active = walk.newtons > 0
        curvature = largest_curvature(at, bound, v, newton)
        ends = 0.5 * curvature * newton * newton <= LEFT_OVER * scale * jnp.abs(slope)
        last = near & (ends | (jnp.abs(newton) <= NEWTON_TOLERANCE * scale))
        left = jnp.where(last, 0, walk.newtons - near)
        after = _Walk(
            jnp.where(back, bound.start, jnp.where(active, v - jnp.where(near, newton, safe), v)),
            jnp.where(active, left, walk.newtons),
            jnp.where(active, last | (jnp.abs(value) <= RESIDUAL_TOLERANCE * sizes), walk.good),
        )
        return after, steps + 1

    return lax.while_loop(unfinished, step, (begin, first))


def _search(
    ask: InflowQuestion, hint: Array, max_steps: Array, azimuth: AzimuthNodes
) -> tuple[Array, Array]:
    """The largest root [m/s], and whether it was reached and satisfies (11).

    Three lanes in four end within ``STEPS_TOGETHER`` steps.  In a large batch the others are
    then gathered and go on by themselves, or all would wait for the slowest.
    """
    shape = jnp.broadcast_shapes(*(jnp.shape(a) for a in jax.tree.leaves(ask)))
    bound = find_bounds(ask.at)
    proved = jnp.where(ask.windmill > 0.0, bound.start, jnp.minimum(bound.start, bound.guess))
    start = jnp.broadcast_to(jnp.minimum(proved, hint), shape)
    begin = _Walk(start, jnp.full(shape, NEWTON_STEPS), jnp.zeros(shape, bool))
    lanes = math.prod(shape)
    few = lanes // 8 if lanes >= GATHER_FROM else lanes
    together = jnp.minimum(STEPS_TOGETHER, max_steps) if few < lanes else max_steps
    walk, steps = _walk_on(ask, begin, jnp.array(0), together, azimuth)
    if few < lanes:
        flat = jax.tree.map(lambda a: jnp.broadcast_to(a, shape).ravel() if jnp.ndim(a) else a, ask)

        def some_left(state: tuple[_Walk, Array]) -> Array:
            walk, steps = state
            return jnp.any(walk.newtons > 0) & (steps < max_steps)

        def slow_ones(state: tuple[_Walk, Array]) -> tuple[_Walk, Array]:
            walk, steps = state
            (pick,) = jnp.nonzero(walk.newtons > 0, size=few, fill_value=0)
            mine = jax.tree.map(lambda a: a[pick] if jnp.ndim(a) else a, flat)
            part = _Walk(*(a[pick] for a in walk))
            part, steps = _walk_on(mine, part, steps, steps + STEPS_TOGETHER, azimuth)
            return _Walk(*(a.at[pick].set(b) for a, b in zip(walk, part, strict=True))), steps

        walk = _Walk(*(a.ravel() for a in walk))
        walk, _ = lax.while_loop(some_left, slow_ones, (walk, steps))
        walk = _Walk(*(a.reshape(shape) for a in walk))
    return walk.v, (walk.newtons <= 0) & walk.good


def inflow_root(
    ask: InflowQuestion, start: Array, max_steps: Array, azimuth: AzimuthNodes
) -> Array:
    """The largest root v_i [m/s] of eq. (11), NaN where it was not found.

    ask : arrays that broadcast, stations first, operating points last.
    start : v_i [m/s] above which there is known to be no root; infinite where it is not.
    max_steps : evaluations of the residual after which the search is given up.
    azimuth : nodes; not differentiated.
    Differentiable with respect to everything in ``ask``, see ``moving_root``.
    """
    return moving_root(ask, find_root(ask, start, max_steps, azimuth), azimuth)


def find_root(
    ask: InflowQuestion, start: Array, max_steps: Array, azimuth: AzimuthNodes
) -> Array:
    """``inflow_root`` as a mere number: its derivative is zero."""
    v, found = _search(*lax.stop_gradient((ask, start)), max_steps, azimuth)
    return jnp.where(found, v, jnp.nan)


@jax.custom_jvp
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
    return v, jnp.where(at_rest, 0.0, -change / jnp.where(at_rest, 1.0, slope))
