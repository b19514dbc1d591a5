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
from propmap.theory.parameters import Array
from propmap.theory.section_law import largest_lift, sharpest_lift, steepest_lift
from propmap.theory.velocities import AzimuthNodes, floored_norm

MAX_STEPS = 1000
"""Steps after which an unfinished root is given up; ordinary roots take about seven, roots
beside a fold up to thirty, beside the kink of (10) in slow axial descent some hundreds."""

SAFE_TOLERANCE = 1e-7
"""Size of a safe step, relative to the speeds at hand, after which Newton's steps follow."""

NEWTON_TOLERANCE = 1e-9
"""Size of a Newton step, likewise, after which the root is taken as found."""

NEWTON_STEPS = 4
"""Newton steps at most.  Only at a double root are they used up."""

GUESS_MARGIN = 1.03
"""Factor on the lift in the guess, so that it lies above the root as a rule: alpha exceeds
sin(alpha) by 2 % at stall."""

GUESS_STEPS = 4
"""Newton steps to the guess, which need no blade elements."""

GATHER_FROM = 3000
"""Lanes, stations times operating points, from which it pays to gather the slow ones."""

STEPS_TOGETHER = 5
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


class _Bounds(NamedTuple):
    """Bounds of one equation (11), constant during its solution."""

    half: Array  # N_b c / 2 [m]
    friction: Array
    speed: Array  # root mean square of U_T over azimuth [m/s]
    start: Array  # v_i above which there is no root [m/s]
    fall: Array  # of the lift, per U [-]
    bend: Array  # of lift and drag, anywhere [-]
    mild_bend: Array  # of lift and drag, where no element is near stall [-]
    mild_from: Array  # the stretch of v_i where none is [m/s]
    mild_to: Array
    guess: Array  # v_i above which there is no root if (11) is negative and falls there [m/s]


def _bounds(at: Annulus) -> _Bounds:
    law = at.section
    half = 0.5 * at.blades * at.chord
    speed = floored_norm(at.omega * at.radius, at.v_inplane / np.sqrt(2.0))
    lift = largest_lift(law)
    # With u = V cos(beta) + v_i >= 0 the blade gives at most half*C_L*(speed^2 + u*speed)
    # and the momentum at least 4 pi y v_i u; they meet at the root of a quadratic.
    k = half * lift / (4.0 * np.pi * at.radius)
    b = at.v_axial + k * speed
    start = 0.5 * (b + jnp.sqrt(b * b + 4.0 * k * speed**2)) - at.v_axial
    start = start * (1.0 + 1e-9) + 1e-9 * (speed + jnp.abs(at.v_axial)) * (at.chord > 0.0)
    mild_from, mild_to = _unstalled_stretch(at)
    mild = lift + 5.0 * law.c_d + 3.0 * law.c_d0
    bend = mild + sharpest_lift(law)
    friction = 0.5 * at.blades * at.friction_chord
    guess = _attached_guess(at, speed, start, mild_from, mild_to)
    return _Bounds(
        half, friction, speed, start, steepest_lift(law), bend, mild, mild_from, mild_to, guess
    )


def _attached_guess(
    at: Annulus, speed: Array, start: Array, mild_from: Array, mild_to: Array
) -> Array:
    """A v_i [m/s] a little above the root of attached flow; infinite where it proves nothing.

    Without drag and stall and with sin(alpha) for alpha, the blade's thrust is linear in v_i,
    and Newton's steps from ``start`` come down to the root without passing it.  Where no
    element is near stall (11) is concave in v_i, so if it is negative and falls at this v_i,
    which the walk checks, it has no root between there and ``mild_to``.  Above that no
    element lifts (the condition on the advancing side), so there is no root either.
    """
    k = GUESS_MARGIN * 0.5 * at.blades * at.chord * at.section.c_l1 / (4.0 * np.pi * at.radius)
    lift, loss = k * speed * speed * at.sine, k * at.omega * at.radius * at.cosine
    v = start
    for _ in range(GUESS_STEPS):
        u = at.v_axial + v
        along = floored_norm(at.v_inplane, u)
        v = v - (lift - loss * u - v * along) / -(loss + along + v * u / along)
    advancing = at.omega * at.radius + at.v_inplane
    u_end = at.v_axial + mild_to
    no_lift = (u_end >= 0.0) & (u_end * at.cosine >= advancing * at.sine)
    concave = (v >= mild_from) & (v < mild_to) & (v >= 0.0) & (at.v_axial + v >= 0.0)
    return jnp.where(no_lift & concave & (at.section.attached > 0.0), v, jnp.inf)


def _unstalled_stretch(at: Annulus) -> tuple[Array, Array]:
    """The v_i [m/s] between which every element has -a0 + 6/M < alpha < a0; empty if none.

    There the lift curve bends downwards only, (1 - sigma) c_l1 alpha being past no
    inflection.  The extremes of alpha are on the advancing and the retreating side, as long
    as there is no reverse flow.
    """
    law = at.section
    advancing = at.omega * at.radius + at.v_inplane
    retreating = at.omega * at.radius - at.v_inplane

    def inflow_ratio(alpha: Array) -> tuple[Array, Array]:
        rise = at.sine * jnp.cos(alpha) - at.cosine * jnp.sin(alpha)
        run = at.cosine * jnp.cos(alpha) + at.sine * jnp.sin(alpha)
        return rise / jnp.maximum(run, 0.05), run > 0.05

    low, low_known = inflow_ratio(law.alpha_0)
    high, high_known = inflow_ratio(-law.alpha_0 + 6.0 / law.sharpness)
    start = jnp.maximum(advancing * low, retreating * low) - at.v_axial
    end = jnp.minimum(advancing * high, retreating * high) - at.v_axial
    ordered = (retreating > 0.0) & low_known
    return jnp.where(ordered, start, jnp.inf), jnp.where(high_known, end, jnp.inf)


def _safe_step(ask: InflowQuestion, bound: _Bounds, v: Array, value: Array, slope: Array) -> Array:
    """How far v_i may be lowered [m/s] without passing a root; value < 0.

    Over the stretch [v - reach, v] the residual falls with v_i no faster than ``fall`` and
    bends upward no more than ``bend``, hence it stays negative until v - max(-value/fall,
    the root of its bounding parabola).  With k = U_T/U and s = U_P/U the blade's part is
    -dF/dv = U (k^2 C_L' - k s C_L + (1 + s^2) C_D - k s C_D') and
    d^2F/dv^2 = k^3 (C_L + C_L'') - k^2 s (C_D + C_D'') - 2 (s C_D - k C_D').
    """
    at, law = ask.at, ask.at.section
    u = at.v_axial + v
    reach = 0.25 * (bound.speed + jnp.abs(at.v_axial)) + 0.5 * jnp.abs(v)
    u_low, v_low = u - reach, v - reach
    u_max = jnp.maximum(jnp.abs(u), jnp.abs(u_low))
    cross = jnp.minimum(bound.speed, u_max)
    total = bound.speed + u_max
    blade_fall = bound.half * (
        bound.fall * bound.speed
        + (largest_lift(law) + law.c_d) * cross
        + (law.c_d + law.c_d0) * (total + u_max)
    ) + bound.friction * 1.5 * jnp.sqrt(total)
    along = floored_norm(at.v_inplane, u_max)
    lever = jnp.where(u_low >= 0.0, jnp.maximum(v, 0.0), jnp.maximum(jnp.abs(v), jnp.abs(v_low)))
    fall = blade_fall + 4.0 * np.pi * at.radius * (along + lever)

    # The wake's part bends by -4 pi y (2 u/W + v (V sin(beta))^2 / W^3), of either sign where
    # it is mirrored on the windmill branch (u < 0), and has a kink at u = 0 without in-plane
    # flow; so the parabola is not carried past u = 0.
    u_end = jnp.where(u > 0.0, jnp.maximum(u_low, 0.0), u_low)
    # ... or only by so little that the walk does not take it for its end.
    to_kink = u - u_end + 2.0 * SAFE_TOLERANCE * (bound.speed + jnp.abs(at.v_axial))
    nearest = floored_norm(at.v_inplane, jnp.where(u > 0.0, u_end, u))
    turn = at.v_inplane**2 / nearest**3
    v_max = jnp.maximum(jnp.abs(v), jnp.abs(v_low))
    wake_bend = jnp.where(u > 0.0, jnp.maximum(-v_low, 0.0) * turn, 2.0 + v_max * turn)
    wake_bend = 4.0 * np.pi * at.radius * wake_bend + 2.0 * bound.friction / jnp.sqrt(bound.speed)

    def by_bend(bend: Array) -> Array:
        bend = wake_bend + bound.half * bend
        root = jnp.sqrt(jnp.maximum(slope * slope - 2.0 * bend * value, 0.0))
        return jnp.minimum(-2.0 * value / jnp.maximum(root - slope, 1e-300), to_kink)

    anywhere = by_bend(bound.bend)
    mild = jnp.minimum(by_bend(bound.mild_bend), v - bound.mild_from)
    mild = jnp.where(v < bound.mild_to, mild, 0.0)
    step = jnp.maximum(jnp.maximum(anywhere, mild), -value / fall)
    # A value above zero, by rounding, gives a small step back up.
    return jnp.clip(jnp.where(value < 0.0, step, anywhere), -reach, reach)


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
    bound = _bounds(at)
    scale = bound.speed + jnp.abs(at.v_axial) + 1e-300

    def unfinished(state: tuple[_Walk, Array]) -> Array:
        walk, steps = state
        return (steps < most) & jnp.any(walk.newtons > 0)

    def step(state: tuple[_Walk, Array]) -> tuple[_Walk, Array]:
        walk, steps = state
        v = walk.v
        value, slope = residual_slope(ask, v, azimuth)
        safe = _safe_step(ask, bound, v, value, slope)
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
        last = near & (jnp.abs(newton) <= NEWTON_TOLERANCE * scale)
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
    bound = _bounds(ask.at)
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


@jax.custom_jvp
def inflow_root(
    ask: InflowQuestion, start: Array, max_steps: Array, azimuth: AzimuthNodes
) -> Array:
    """The largest root v_i [m/s] of eq. (11), NaN where it was not found.

    ask : arrays that broadcast, stations first, operating points last.
    start : v_i [m/s] above which there is known to be no root; infinite where it is not.
    max_steps : evaluations of the residual after which the search is given up.
    azimuth : nodes; not differentiated.
    Differentiable with respect to everything in ``ask`` by the implicit function theorem.
    """
    v, found = _search(ask, start, max_steps, azimuth)
    return jnp.where(found, v, jnp.nan)


@inflow_root.defjvp
def _inflow_root_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    (ask, start, max_steps, azimuth), (ask_dot, *_) = primals, tangents
    v = inflow_root(ask, start, max_steps, azimuth)
    _, slope = residual_slope(ask, v, azimuth)
    _, change = jax.jvp(lambda a: residual(a, v, azimuth), (ask,), (ask_dot,))
    at_rest = slope == 0.0
    return v, jnp.where(at_rest, 0.0, -change / jnp.where(at_rest, 1.0, slope))
