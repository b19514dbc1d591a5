"""Bounds on equation (11): where to start above its largest root, and how far one may safely step.

The residual of (11) is blade-element thrust minus momentum thrust, negative above the largest root.
The bounds hold for any section law with ``LawBounds`` and any factors with ``FactorBounds``.

Nothing here is divided by a square root that has no other use: XLA on a CPU would compute its
reciprocal instead, which is not vectorised, and then vectorise nothing else in the loop.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from propmap.arrays.namespace import Array, xp
from propmap.arrays.precision import precision_of
from propmap.physics.element import Annulus
from propmap.physics.sections.law import LawBounds
from propmap.physics.velocities import floored_norm, floored_square
from propmap.physics.wake import Wake

GUESS_MARGIN = 1.03
"""Factor on the lift in ``_attached_guess``, so that the guess is nearly always above the root: it
takes sin(alpha) for alpha, which is 2 % larger at stall."""

GUESS_STEPS = 4
"""Newton steps to the guess; they evaluate no blade elements."""


class Bounds(NamedTuple):
    """Bounds on equation (11) that stay the same during the search for its root.

    Attributes
    ----------
    law : LawBounds
        Bounds on the section law.
    half : Array
        N_b c / 2 [m].
    friction : Array
        The term f / sqrt(Re) of C_D times ``half`` and sqrt(U) [m^1.5/s^0.5].
    speed : Array
        Root mean square of U_T over azimuth [m/s].
    start : Array
        v_i above which there is no root [m/s].
    attached_from, attached_to : Array
        The v_i between which no element is near stall [m/s]; an empty range if there are none.
    guess : Array
        v_i above which there is no root, provided that there the residual is negative and falls
        with v_i [m/s].
    """

    law: LawBounds
    half: Array
    friction: Array
    speed: Array
    start: Array
    attached_from: Array
    attached_to: Array
    guess: Array


def find_bounds(at: Annulus, wake: Wake) -> Bounds:
    """The bounds of (11) at all stations and operating points."""
    law = at.law.bounds()
    half = 0.5 * at.blades * at.chord
    speed = floored_norm(at.turning, at.v_inplane / np.sqrt(2.0))
    margin = precision_of(at.v_axial).newton_step  # for rounding errors of the bound
    start = _start(at, wake, half * law.lift, speed)
    start = start * (1.0 + margin) + margin * (speed + xp.abs(at.v_axial)) * (at.chord > 0.0)
    attached_from, attached_to = _attached_range(at, law)
    guess = _attached_guess(at, wake, law, speed, start, attached_from, attached_to)
    friction = half * law.friction * at.station.inverse_root
    return Bounds(law, half, friction, speed, start, attached_from, attached_to, guess)


def _start(at: Annulus, wake: Wake, lift: Array, speed: Array) -> Array:
    """A v_i [m/s] above which there is no root.

    With u = V cos(beta) + v_i >= 0 the blade-element thrust is at most lift*(speed^2 + u*speed),
    where ``lift`` is half*C_L, and the momentum thrust at least 4 pi y F v_i u, where F is the
    factor of the wake.  The two are equal at the root of a quadratic.
    """
    k = lift / (4.0 * np.pi * at.radius)
    start = _start_of(at, k, speed)
    if not wake.is_plain:
        # The least F at any inflow gives a first v_i; F up to that v_i gives a lower one.
        highest = _start_of(at, k / wake.least_factor(at, 1e3 * start), speed)
        start = _start_of(at, k / wake.least_factor(at, highest), speed)
    return start


def _start_of(at: Annulus, k: Array, speed: Array) -> Array:
    b = at.v_axial + k * speed
    start = 0.5 * (b + xp.sqrt(b * b + 4.0 * k * speed**2)) - at.v_axial
    return xp.minimum(start, _oblique_start(at, speed, k, start))


def _oblique_start(at: Annulus, speed: Array, k: Array, above: Array) -> Array:
    """Another v_i [m/s] above which climb has no root, lower than ``above`` in fast oblique flow.

    The blade-element thrust is at most half*C_L times the mean of U U_T, which is at most
    speed*sqrt(speed^2 + u^2).  The momentum thrust is 4 pi y v_i sqrt(p^2 + u^2), p = V sin(beta).
    So a root has v_i <= most(v_i) = k speed sqrt((speed^2 + u^2)/(p^2 + u^2)), which falls with v_i
    for p <= speed.  Hence most(above) is below every v_i with v_i = most(v_i), and most of that is
    above it.  In descent the result is infinite.
    """
    p = xp.minimum(at.v_inplane, speed)

    def most(v: Array) -> Array:
        u = at.v_axial + v
        return k * speed * xp.sqrt(floored_square(speed, u) / floored_square(p, u))

    return xp.where(at.v_axial >= 0.0, most(most(above)), xp.inf)


def _attached_guess(
    at: Annulus,
    wake: Wake,
    law: LawBounds,
    speed: Array,
    start: Array,
    attached_from: Array,
    attached_to: Array,
) -> Array:
    """A v_i [m/s] a little above the root of attached flow; infinite where that cannot be shown.

    Without drag and stall, and with sin(alpha) for alpha, the blade-element thrust is linear in
    v_i, and Newton's steps from ``start`` come down to the root without passing it.  If they go
    below ``attached_from``, where some element stalls, the guess is ``attached_from``.

    A guess v needs to have no root above it.  From v to ``attached_to`` no element is near stall.
    With concave lift and convex momentum thrust the residual is concave there: it has no root if it
    is negative and falls at v, which the search checks.  Above ``attached_to`` there is no root if
    that is above ``start``, or if the lift is nowhere positive (see the advancing side).
    """
    if not wake.is_plain:
        return xp.full_like(start, xp.inf)
    sine, cosine = at.station.sine, at.station.cosine
    # |alpha| > |sin(alpha)|: with positive lift the margin makes up for it.
    lifting = speed * speed * sine > at.turning * cosine * at.v_axial
    margin = xp.where(lifting, GUESS_MARGIN, 1.0)
    k = margin * 0.5 * at.blades * at.chord * law.attached_slope / (4.0 * np.pi * at.radius)
    lift, loss = k * speed * speed * sine, k * at.turning * cosine
    v = start
    for _ in range(GUESS_STEPS):
        u = at.v_axial + v
        along = floored_norm(at.v_inplane, u)
        v = v - (lift - loss * u - v * along) / -(loss + along + v * u / along)
    v = xp.maximum(v, attached_from)
    u_end = at.v_axial + attached_to
    no_lift = (u_end >= 0.0) & (u_end * cosine >= (at.turning + at.v_inplane) * sine)
    rootless = no_lift | (attached_to >= start)
    # The momentum thrust is convex where 2 u/W + v (V sin(beta))^2 / W^3 > 0, as from v on.
    concave = (v < attached_to) & (at.v_axial + v >= xp.maximum(-0.5 * v, 0.0))
    concave = concave & (law.attached_slope > 0.0) & (law.attached_bend <= 0.0)
    return xp.where(rootless & concave, v, xp.inf)


def _attached_range(at: Annulus, law: LawBounds) -> tuple[Array, Array]:
    """The v_i [m/s] between which every element is attached; an empty range if there are none.

    Without reverse flow alpha is largest and smallest on the advancing and the retreating side.
    """
    advancing, retreating = at.turning + at.v_inplane, at.turning - at.v_inplane
    blade = at.station

    def inflow_ratio(alpha: Array) -> tuple[Array, Array]:
        sine, cosine = xp.sin(alpha), xp.cos(alpha)
        rise = blade.sine * cosine - blade.cosine * sine
        run = blade.cosine * cosine + blade.sine * sine
        return rise / xp.maximum(run, 0.05), run > 0.05

    low, low_known = inflow_ratio(law.attached_to)
    high, high_known = inflow_ratio(law.attached_from)
    start = xp.maximum(advancing * low, retreating * low) - at.v_axial
    end = xp.minimum(advancing * high, retreating * high) - at.v_axial
    ordered = (retreating > 0.0) & low_known
    return xp.where(ordered, start, xp.inf), xp.where(high_known, end, xp.inf)


def safe_step(
    at: Annulus, wake: Wake, bound: Bounds, v: Array, value: Array, slope: Array
) -> Array:
    """How far v_i may be lowered [m/s] without passing a root; the residual is ``value`` < 0.

    On [v - reach, v] the residual's second derivative is at most ``bend``.  So the residual is
    below a parabola with that second derivative, and negative down to the parabola's root.
    """
    full = 0.25 * (bound.speed + xp.abs(at.v_axial)) + 0.5 * xp.abs(v)
    along = _along_axis(at, wake, full, v, value, slope)
    step = _step_within(along.at, wake, bound, along.reach, v, along.value, along.slope)
    for reach in wake.shorter_reaches(at, v):
        short = xp.minimum(reach, along.reach)
        shorter = _step_within(along.at, wake, bound, short, v, along.value, along.slope)
        step = xp.maximum(step, shorter)
    return step


class _AlongAxis(NamedTuple):
    """What a safe step is computed from: annulus, residual, its slope, reach [m/s]."""

    at: Annulus
    value: Array
    slope: Array
    reach: Array


def _along_axis(
    at: Annulus, wake: Wake, reach: Array, v: Array, value: Array, slope: Array
) -> _AlongAxis:
    """The residual itself, or in nearly axial climb an upper bound of it without V sin(beta).

    In climb the slope of the wake's thrust changes by up to 8 pi y V cos(beta) about U_P = 0, over
    a range of U_P as wide as V sin(beta).  A parabola as bent as that allows only tiny steps.
    Axial flow has a kink there, where a step ends.  Its residual plus the largest difference on
    [v - reach, v] is an upper bound of that of the oblique flow, and has the same kink.

    Where the residual is no larger than that difference, the bend does count, but only over half of
    the way to the kink.
    """
    some = (at.v_axial > 0.0) & wake.nearly_axial(at)
    above, above_slope = wake.above_axial(at, v)
    raised = value + above + wake.most_below_axial(at, v - reach)
    clear = some & (raised < 0.5 * value)
    to_kink = xp.maximum(0.5 * xp.abs(at.v_axial + v), at.v_inplane)
    return _AlongAxis(
        at._replace(v_inplane=xp.where(clear, 0.0, at.v_inplane)),
        xp.where(clear, raised, value),
        xp.where(clear, slope + above_slope, slope),
        xp.where(some & ~clear & (at.v_inplane > 0.0), xp.minimum(to_kink, reach), reach),
    )


def _step_within(
    at: Annulus, wake: Wake, bound: Bounds, reach: Array, v: Array, value: Array, slope: Array
) -> Array:
    """``safe_step`` from bounds over one ``reach`` [m/s].

    With k = U_T/U and s = U_P/U the blade-element thrust per ``half`` has the second derivative
    k^3 (C_L + C_L'') - k^2 s (C_D + C_D'') - 2 (s C_D - k C_D').
    """
    law = bound.law
    u = at.v_axial + v
    u_low = u - reach
    # Without in-plane flow the wake's thrust has a kink at u = 0, where the parabola ends.  A step
    # may go slightly past it: one that becomes tiny before it would end the safe steps.
    u_end = xp.where(u > 0.0, xp.maximum(u_low, 0.0), u_low)
    to_kink = u - u_end + 2.0 * precision_of(v).safe_step * (bound.speed + xp.abs(at.v_axial))
    wake_bend = wake.largest_bend(at, v - reach, v)
    friction_bend = 2.0 * bound.friction * xp.sqrt(bound.speed) / bound.speed

    def by_bend(blade_bend: Array) -> Array:
        bend = wake_bend + friction_bend + bound.half * blade_bend
        root = xp.sqrt(xp.maximum(slope * slope - 2.0 * bend * value, 0.0))
        return xp.minimum(-2.0 * value / xp.maximum(root - slope, 1e-30), to_kink)

    rising = (v < bound.attached_to) & (bound.attached_from < xp.inf)
    anywhere = by_bend(_blade_bend(law, xp.where(rising, law.foot_bend, law.lift_bend)))
    attached = by_bend(_blade_bend(law, law.attached_bend))
    attached = xp.minimum(attached, v - bound.attached_from)
    attached = xp.where(v < bound.attached_to, attached, 0.0)
    # If rounding makes the value positive, this is a small step up.
    step = xp.where(value < 0.0, xp.maximum(anywhere, attached), anywhere)
    return xp.clip(step, -reach, reach)


def _blade_bend(law: LawBounds, lift_bend: Array) -> Array:
    """Second derivative of the blade-element thrust per ``half``, at most [-]; without friction."""
    return law.lift + law.drag_bend + lift_bend


def largest_curvature(at: Annulus, wake: Wake, bound: Bounds, v: Array, step: Array) -> Array:
    """Estimate of the largest |second derivative| of the residual within ``step`` of v [m]."""
    law = bound.law
    size = xp.abs(step)
    attached = (v - size > bound.attached_from) & (v + size < bound.attached_to)
    blade = _blade_bend(law, xp.where(attached, law.attached_bend, law.lift_bend))
    share = xp.sqrt(v * v / floored_square(at.v_inplane, at.v_axial + v))
    momentum = 4.0 * np.pi * at.radius * (2.0 + share)
    if not wake.is_plain:
        momentum = momentum + wake.largest_bend(at, v - size, v + size)
    return 2.0 * bound.half * blade + momentum
