"""Bounds on eq. (11) from which steps towards its largest root follow that cannot pass it.

No quotient here is by a square root that nothing else needs: XLA on a CPU makes a product with a
reciprocal root of it, which no vector unit evaluates, and with it nothing else in the loop.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from propmap.arrays.namespace import Array, xp
from propmap.arrays.precision import precision_of
from propmap.physics.element import Annulus
from propmap.physics.sections.blended import (
    largest_lift,
    sharpest_foot,
    sharpest_lift,
    steepest_lift,
)
from propmap.physics.velocities import floored_norm, floored_square

GUESS_MARGIN = 1.03
"""Factor on the lift in the guess, so that it lies above the root as a rule: alpha exceeds
sin(alpha) by 2 % at stall."""

GUESS_STEPS = 4
"""Newton steps to the guess, which need no blade elements."""


class Bounds(NamedTuple):
    """Bounds of one equation (11), constant during its solution."""

    half: Array  # N_b c / 2 [m]
    friction: Array
    speed: Array  # root mean square of U_T over azimuth [m/s]
    start: Array  # v_i above which there is no root [m/s]
    lift: Array  # largest lift coefficient [-]
    fall: Array  # of the lift, per U [-]
    bend: Array  # of lift and drag, anywhere [-]
    foot_bend: Array  # of lift and drag, where no element is near negative stall [-]
    mild_bend: Array  # of lift and drag, where no element is near stall [-]
    mild_from: Array  # the stretch of v_i where none is [m/s]
    mild_to: Array
    guess: Array  # v_i above which there is no root if (11) is negative and falls there [m/s]


def find_bounds(at: Annulus) -> Bounds:
    """The bounds of one annulus, or of many at once."""
    law = at.section
    half = 0.5 * at.blades * at.chord
    speed = floored_norm(at.omega * at.radius, at.v_inplane / np.sqrt(2.0))
    lift = largest_lift(law)
    # With u = V cos(beta) + v_i >= 0 the blade gives at most half*C_L*(speed^2 + u*speed)
    # and the momentum at least 4 pi y v_i u; they meet at the root of a quadratic.
    k = half * lift / (4.0 * np.pi * at.radius)
    b = at.v_axial + k * speed
    start = 0.5 * (b + xp.sqrt(b * b + 4.0 * k * speed**2)) - at.v_axial
    margin = precision_of(at.v_axial).newton_step  # for what rounding may take from the bound
    start = xp.minimum(start, _oblique_start(at, speed, k, start))
    start = start * (1.0 + margin) + margin * (speed + xp.abs(at.v_axial)) * (at.chord > 0.0)
    mild_from, mild_to = _unstalled_stretch(at)
    mild = lift + 5.0 * law.c_d + 3.0 * law.c_d0
    bend, foot_bend = mild + sharpest_lift(law), mild + sharpest_foot(law)
    friction = 0.5 * at.blades * at.friction_chord
    guess = _attached_guess(at, speed, start, mild_from, mild_to)
    return Bounds(
        half,
        friction,
        speed,
        start,
        lift,
        steepest_lift(law),
        bend,
        foot_bend,
        mild,
        mild_from,
        mild_to,
        guess,
    )


def _oblique_start(at: Annulus, speed: Array, k: Array, above: Array) -> Array:
    """A v_i [m/s] above which there is no root in climb, nearer to it in fast oblique flow than
    ``above``, which is another; infinite in descent.

    k : half*C_L over 4 pi y [-].  The blade gives at most half*C_L times the mean of U U_T, which
    is at most speed*sqrt(speed^2 + u^2), and the momentum 4 pi y v_i sqrt(p^2 + u^2) with
    p = V sin(beta).  So a root has v_i <= k speed sqrt((speed^2 + u^2)/(p^2 + u^2)), which falls
    with v_i where p is at most ``speed``: of ``above`` it is below the v_i at which the two meet,
    and of that above it.
    """
    p = xp.minimum(at.v_inplane, speed)

    def most(v: Array) -> Array:
        u = at.v_axial + v
        return k * speed * xp.sqrt(floored_square(speed, u) / floored_square(p, u))

    return xp.where(at.v_axial >= 0.0, most(most(above)), xp.inf)


def _attached_guess(
    at: Annulus, speed: Array, start: Array, mild_from: Array, mild_to: Array
) -> Array:
    """A v_i [m/s] a little above the root of attached flow; infinite where it proves nothing.

    Without drag and stall and with sin(alpha) for alpha, the blade's thrust is linear in v_i,
    and Newton's steps from ``start`` come down to the root without passing it.  Where that is
    past ``mild_from``, some element being stalled there, ``mild_from`` takes its place.  Where no
    element is near stall (11) is concave in v_i, so if it is negative and falls at this v_i,
    which the walk checks, it has no root between there and ``mild_to``.  There is none above that
    either, if it is past ``start`` or no element lifts there (the condition on the advancing side).
    """
    # alpha exceeds sin(alpha) whatever its sign.
    lifting = speed * speed * at.sine > at.omega * at.radius * at.cosine * at.v_axial
    margin = xp.where(lifting, GUESS_MARGIN, 1.0)
    k = margin * 0.5 * at.blades * at.chord * at.section.c_l1 / (4.0 * np.pi * at.radius)
    lift, loss = k * speed * speed * at.sine, k * at.omega * at.radius * at.cosine
    v = start
    for _ in range(GUESS_STEPS):
        u = at.v_axial + v
        along = floored_norm(at.v_inplane, u)
        v = v - (lift - loss * u - v * along) / -(loss + along + v * u / along)
    v = xp.maximum(v, mild_from)
    advancing = at.omega * at.radius + at.v_inplane
    u_end = at.v_axial + mild_to
    no_lift = (u_end >= 0.0) & (u_end * at.cosine >= advancing * at.sine)
    rootless = no_lift | (mild_to >= start)
    # Of the momentum's part too, 2 u/W + v (V sin(beta))^2 / W^3 being positive from there on.
    concave = (v < mild_to) & (at.v_axial + v >= xp.maximum(-0.5 * v, 0.0))
    return xp.where(rootless & concave & (at.section.attached > 0.0), v, xp.inf)


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
        sine, cosine = xp.sin(alpha), xp.cos(alpha)
        rise = at.sine * cosine - at.cosine * sine
        run = at.cosine * cosine + at.sine * sine
        return rise / xp.maximum(run, 0.05), run > 0.05

    low, low_known = inflow_ratio(law.alpha_0)
    high, high_known = inflow_ratio(-law.alpha_0 + 6.0 / law.sharpness)
    start = xp.maximum(advancing * low, retreating * low) - at.v_axial
    end = xp.minimum(advancing * high, retreating * high) - at.v_axial
    ordered = (retreating > 0.0) & low_known
    return xp.where(ordered, start, xp.inf), xp.where(high_known, end, xp.inf)


def safe_step(at: Annulus, bound: Bounds, v: Array, value: Array, slope: Array) -> Array:
    """How far v_i may be lowered [m/s] without passing a root; value < 0.

    Over the stretch [v - reach, v] the residual falls with v_i no faster than ``fall`` and
    bends upward no more than ``bend``, hence it stays negative until v - max(-value/fall,
    the root of its bounding parabola).  With k = U_T/U and s = U_P/U the blade's part is
    -dF/dv = U (k^2 C_L' - k s C_L + (1 + s^2) C_D - k s C_D') and
    d^2F/dv^2 = k^3 (C_L + C_L'') - k^2 s (C_D + C_D'') - 2 (s C_D - k C_D').
    """
    law = at.section
    u = at.v_axial + v
    reach = 0.25 * (bound.speed + xp.abs(at.v_axial)) + 0.5 * xp.abs(v)
    u_low, v_low = u - reach, v - reach
    u_max = xp.maximum(xp.abs(u), xp.abs(u_low))
    cross = xp.minimum(bound.speed, u_max)
    total = bound.speed + u_max
    blade_fall = bound.half * (
        bound.fall * bound.speed
        + (bound.lift + law.c_d) * cross
        + (law.c_d + law.c_d0) * (total + u_max)
    ) + bound.friction * 1.5 * xp.sqrt(total)
    along = floored_norm(at.v_inplane, u_max)
    lever = xp.where(u_low >= 0.0, xp.maximum(v, 0.0), xp.maximum(xp.abs(v), xp.abs(v_low)))
    fall = blade_fall + 4.0 * np.pi * at.radius * (along + lever)

    # The wake's part bends by -4 pi y (2 u/W + v (V sin(beta))^2 / W^3), of either sign where
    # it is mirrored on the windmill branch (u < 0), and has a kink at u = 0 without in-plane
    # flow; so the parabola is not carried past u = 0.
    u_end = xp.where(u > 0.0, xp.maximum(u_low, 0.0), u_low)
    # ... or only by so little that the walk does not take it for its end.
    to_kink = u - u_end + 2.0 * precision_of(v).safe_step * (bound.speed + xp.abs(at.v_axial))
    nearest = floored_norm(at.v_inplane, xp.where(u > 0.0, u_end, u))
    turn = at.v_inplane**2 / nearest**3
    v_max = xp.maximum(xp.abs(v), xp.abs(v_low))
    wake_bend = xp.where(u > 0.0, xp.maximum(-v_low, 0.0) * turn, 2.0 + v_max * turn)
    friction_bend = 2.0 * bound.friction * xp.sqrt(bound.speed) / bound.speed
    wake_bend = 4.0 * np.pi * at.radius * wake_bend + friction_bend

    def by_bend(bend: Array) -> Array:
        bend = wake_bend + bound.half * bend
        root = xp.sqrt(xp.maximum(slope * slope - 2.0 * bend * value, 0.0))
        return xp.minimum(-2.0 * value / xp.maximum(root - slope, 1e-30), to_kink)

    rising = (v < bound.mild_to) & (bound.mild_from < xp.inf)
    anywhere = by_bend(xp.where(rising, bound.foot_bend, bound.bend))
    mild = xp.minimum(by_bend(bound.mild_bend), v - bound.mild_from)
    mild = xp.where(v < bound.mild_to, mild, 0.0)
    step = xp.maximum(xp.maximum(anywhere, mild), -value / fall)
    # A value above zero, by rounding, gives a small step back up.
    return xp.clip(xp.where(value < 0.0, step, anywhere), -reach, reach)


def largest_curvature(at: Annulus, bound: Bounds, v: Array, step: Array) -> Array:
    """About how much the residual bends, up or down, within ``step`` of v_i [m]."""
    gentle = (v - xp.abs(step) > bound.mild_from) & (v + xp.abs(step) < bound.mild_to)
    blade = 2.0 * bound.half * xp.where(gentle, bound.mild_bend, bound.bend)
    share = xp.sqrt(v * v / floored_square(at.v_inplane, at.v_axial + v))
    return blade + 4.0 * np.pi * at.radius * (2.0 + share)
