"""The hump of the residual of (11) just before stall, over v_i, at given radii.

Coming from above, the attached root lies on the far side of the hump; where its top is below
zero, the largest root is the stalled one.  ``split`` looks along the blade for where that
changes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from propmap.arrays.namespace import Array, entry, of_each, repeated, settled, xp
from propmap.arrays.precision import precision_of
from propmap.physics.sections.blended import angle_of_attack, attached_share
from propmap.physics.velocities import AzimuthNodes, floored_norm
from propmap.solve.inflow import InflowQuestion, residual, residual_slope

TOP_STEPS = 2
"""Newton steps to the top of a hump."""

LONGEST_REACH = 3.0
"""Multiples of the last two samples' distance over which the residual's rise is carried on."""

HUMP_ANGLES = np.array([-0.2, -0.13, -0.08, -0.045, -0.01, 0.03, 0.08, 0.13])
"""[rad] from the stall angle, where the hump may be, in the order of falling v_i."""


def mean_attached_share(ask: InflowQuestion, inflow: Array) -> Array:
    """1 - sigma [-] at the angle of attack without the in-plane velocity; shape of inflow."""
    at = ask.at
    u_t, u_p = at.omega * at.radius, at.v_axial + inflow
    across, along = at.sine * u_t - at.cosine * u_p, at.cosine * u_t + at.sine * u_p
    alpha = angle_of_attack(along, across, floored_norm(u_t, u_p))
    return attached_share(alpha, at.blend)


class Angle(NamedTuple):
    """Sine and cosine [-] of an angle of attack from zero lift."""

    sine: Array
    cosine: Array


def angles_about(stall: Array, offsets: np.ndarray) -> Angle:
    """The angles ``stall`` (B,) + ``offsets`` (K,) [rad]; (K, B)."""
    angle = stall + offsets[:, None]
    return Angle(xp.sin(angle), xp.cos(angle))


def inflow_at_angle(ask: InflowQuestion, alpha: Angle) -> Array:
    """v_i [m/s] at which the angle of attack from zero lift is alpha, V sin(beta) aside.

    (S, B); infinite where no inflow makes it so.
    """
    at = ask.at
    sine, cosine = alpha
    rise, run = at.sine * cosine - at.cosine * sine, at.cosine * cosine + at.sine * sine
    u_t = floored_norm(at.omega * at.radius, at.v_inplane / np.sqrt(2.0))
    possible = run > 0.05
    v = u_t * rise / xp.where(possible, run, 1.0) - at.v_axial
    return xp.where(possible, v, xp.inf)


class Hump(NamedTuple):
    """At radii and operating points (S, B)."""

    height: Array  # of the hump or shoulder [m^3/s^2], NaN where unknown; (S, B)
    inflow: Array  # v_i there [m/s]
    behind: Array  # angle [rad] from the stall angle down to which, past it, there is no root
    folded: Array  # whether the residual has three zeros about it


def hump_before_stall(ask: InflowQuestion, stall: Array, azimuth: AzimuthNodes) -> Hump:
    """The residual's hump about the angle ``stall`` (B,).

    The hump is the first local maximum that v_i meets on its way down.  Where the residual
    only has a shoulder, the height is that of its flattest point: the inflow rises there
    without a jump, but as steeply as a cube root, and deserves a panel's edge as well.
    """

    def sample(angle: Angle) -> tuple[Array, Array]:
        v = inflow_at_angle(ask, angle)
        known = xp.isfinite(v)
        v = xp.where(known, v, 0.0)
        return v, xp.where(known, residual(ask, v, azimuth), xp.nan)

    v, height = of_each(sample, angles_about(stall, HUMP_ANGLES))
    descends = ask.at.v_axial < 0.0
    seen = settled(lambda: _between_samples(v, height, descends), ask.at.blades)
    # In descent the attached stretch ends in low humps; elsewhere the guess is as good, and
    # joins the shoulder's without a step.
    if ask.windmill is None:
        here, at = residual(ask, seen.inflow, azimuth), seen.inflow
    else:
        low = seen.peak & descends
        here, at = _refined_top(ask, seen.inflow, low, seen.around, azimuth)
    folded = seen.peak & (here > 0.0) & (seen.depth < 0.0)
    return Hump(xp.where(seen.known, here, xp.nan), at, seen.behind, folded)


class _Around(NamedTuple):
    bend: Array  # of the residual between samples k and k + 2
    low: Array  # v_i of sample k + 2 [m/s]
    high: Array  # v_i of sample k


class _Samples(NamedTuple):
    """What samples over v_i tell of the hump, (S, B)."""

    inflow: Array  # v_i at the hump's top or the shoulder [m/s]
    known: Array  # whether it is
    peak: Array  # whether it is a top
    around: _Around  # if it is
    behind: Array  # angle [rad] from the stall angle down to which, past it, there is no root
    depth: Array  # of the residual there


def _between_samples(v: Array, height: Array, descends: Array) -> _Samples:
    """From v_i [m/s], falling, and the residual there, NaN where unknown; both (K, S, B).

    descends (B,) : V cos(beta) < 0.  There the momentum's thrust vanishes where the disk is
    becalmed, with roots on both sides that no sample need show, so no zero is foretold.
    """
    gap = xp.diff(v, axis=0)
    slope = xp.diff(height, axis=0) / xp.where(gap == 0.0, xp.nan, gap)
    middle = 0.5 * (v[:-1] + v[1:])
    peak = (slope[:-1] <= 0.0) & (slope[1:] > 0.0)
    some = xp.any(peak, axis=0)
    first = xp.argmax(peak, axis=0)
    flattest = xp.argmax(xp.nan_to_num(slope[1:-1], nan=-xp.inf), axis=0)
    top, shoulder = entry(_zeros(slope, middle), first), entry(_tops(slope, middle), flattest)
    at = xp.where(some, top, shoulder)
    known = xp.isfinite(at)
    past = xp.arange(len(HUMP_ANGLES))[:, None, None] > xp.where(some, first + 1, flattest)
    depth = xp.where(past & xp.isfinite(height), height, xp.inf)
    valley = xp.asarray(HUMP_ANGLES, v.dtype)[xp.argmin(depth, axis=0)]
    behind = xp.where(descends, valley, _next_zero(past, height))
    run = xp.diff(middle, axis=0)
    bend = xp.diff(slope, axis=0) / xp.where(run == 0.0, xp.nan, run)
    around = _Around(*(entry(a, first) for a in (bend, v[2:], v[:-2])))
    least = xp.min(depth, axis=0)
    return _Samples(xp.where(known, at, 0.0), known, some, around, behind, least)


def _next_zero(past: Array, height: Array) -> Array:
    """Angle [rad] from the stall angle of the residual's zero past a hump below zero, (S, B).

    past : which of the samples at ``HUMP_ANGLES`` are past the hump's top.  height : the residual
    there [m^3/s^2]; both (K, S, B).
    """
    angles = xp.asarray(HUMP_ANGLES, height.dtype)[:, None, None]
    rise = height[1:] - height[:-1]
    share = -height[:-1] / xp.where(rise > 0.0, rise, xp.inf)
    ends = past[:-1] & (height[:-1] < 0.0) & (height[1:] >= 0.0)
    # Where the last sample is negative still, the residual goes on rising, but ever slower.
    k = xp.where(xp.any(ends, axis=0), xp.argmax(ends, axis=0), len(HUMP_ANGLES) - 2)
    share = xp.clip(share, 0.0, LONGEST_REACH)
    return entry(angles[:-1] + share * xp.diff(angles, axis=0), k)


_Search = tuple[Array, Array, Array, Array, Array]
"""v_i, bend, v_i and slope before, height."""


def _refined_top(
    ask: InflowQuestion, at: Array, peak: Array, around: _Around, azimuth: AzimuthNodes
) -> tuple[Array, Array]:
    """The hump's height and v_i from a first guess ``at``; unchanged where there is no peak.

    The samples are too far apart for the height of a low hump: where it is misjudged a short
    attached stretch of the blade is lost, and with it several per cent of thrust in descent.
    """

    def improve(state: _Search) -> _Search:
        x, bend, x_before, slope_before, _ = state
        value, slope = residual_slope(ask, x, azimuth)
        moved = xp.abs(x - x_before) > precision_of(x).newton_step * (xp.abs(x) + 1e-9)
        run = xp.where(moved, x - x_before, 1.0)
        secant = xp.where(moved, (slope - slope_before) / run, bend)
        # Next to an inflection the secant is no guide, and its step would leave the hump.
        bend = xp.where(secant < 0.0, xp.minimum(secant, 0.5 * around.bend), bend)
        step = -slope / xp.where(bend < 0.0, bend, -xp.inf)
        after = xp.where(peak, xp.clip(x + step, around.low, around.high), x)
        height = value + xp.where(peak, 0.5 * slope * (after - x), 0.0)
        return after, bend, x, slope, height

    nothing = xp.zeros_like(at)
    begin = (at, around.bend + nothing, at, nothing, nothing)
    top, _, _, _, height = repeated(TOP_STEPS, improve, begin)
    return height, xp.where(peak, top, at)


def _zeros(slope: Array, v: Array) -> Array:
    """The v between each two of (K, S, B) at which the slope passes zero if it does."""
    steep = xp.where(slope[:-1] == slope[1:], 1.0, slope[:-1] - slope[1:])
    return v[:-1] + xp.clip(slope[:-1] / steep, 0.0, 1.0) * xp.diff(v, axis=0)


def _tops(slope: Array, v: Array) -> Array:
    """The v between each three of (K, S, B) at which the slope is largest if the middle one is."""
    chord = xp.diff(slope, axis=0) / xp.diff(v, axis=0)
    bend = (chord[:-1] - chord[1:]) / (v[:-2] - v[2:])
    top = 0.5 * (v[:-2] + v[1:-1]) - 0.5 * chord[:-1] / xp.where(bend < 0.0, bend, -1.0)
    return xp.where(bend < 0.0, xp.clip(top, v[2:], v[:-2]), v[1:-1])


def stall_side(ask: InflowQuestion, alpha_0: Array) -> Array:
    """The stall angle that a blade is near [rad], alpha_0 or its negative; (B,).

    ask : at one radius (1, 1) or (1, B).
    """
    at = ask.at
    lifting = at.sine * at.omega * at.radius - at.cosine * at.v_axial
    return xp.where(lifting[0] < 0.0, -alpha_0, alpha_0)
