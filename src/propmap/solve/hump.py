"""The hump of the residual of (11) near stall: its height and v_i at given radii.

Over v_i the residual has a maximum near stall, the hump.  Where its top is above zero, the largest
root is the attached one, at a larger v_i than the top; where it is below zero, the stalled one.
``split`` looks along the blade for where that changes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from propmap.arrays.loops import map_entries, repeat
from propmap.arrays.materialize import materialize
from propmap.arrays.namespace import Array, entry, xp
from propmap.arrays.precision import precision_of
from propmap.physics.velocities import AzimuthNodes, floored_norm
from propmap.solve.problem import AnnulusProblem, residual, residual_slope

TOP_STEPS = 2
"""Newton steps to the top of a hump."""

HUMP_ANGLES = np.array([-0.2, -0.13, -0.08, -0.045, -0.01, 0.03, 0.08, 0.13])
"""Angles from the stall angle [rad] at which the hump is looked for, in order of falling v_i."""

SHARP_STALL = 0.02
"""Width of stall [rad] from which on these angles are used; for a sharper stall they are scaled."""


class Angle(NamedTuple):
    """Sine and cosine [-] of an angle of attack from zero lift."""

    sine: Array
    cosine: Array


def angles_about_stall(problem: AnnulusProblem, side: Array, offsets: np.ndarray) -> Angle:
    """Angles of attack at ``offsets`` (K,) [rad] from the stall angle; (K, B) or (K, S, B).

    The stall is that at positive angles where ``side`` (B,) is 1, at negative ones where it is -1.
    Where it is sharper than ``SHARP_STALL``, the offsets are reduced in proportion.
    """
    at = problem.at
    stall = at.law.stall_angle(at.station.reynolds_per_speed * at.turning, side)
    scale = xp.minimum(at.law.bounds().stall_width / SHARP_STALL, 1.0)
    angle = stall + scale * offsets.reshape(-1, *(1,) * stall.ndim)
    return Angle(xp.sin(angle), xp.cos(angle))


def inflow_at_angle(problem: AnnulusProblem, alpha: Angle) -> Array:
    """v_i [m/s] at which the angle of attack from zero lift is alpha, for U_T rms over azimuth.

    (S, B); infinite where no inflow gives this angle.
    """
    at, blade = problem.at, problem.at.station
    sine, cosine = alpha
    rise = blade.sine * cosine - blade.cosine * sine
    run = blade.cosine * cosine + blade.sine * sine
    u_t = floored_norm(at.turning, at.v_inplane / np.sqrt(2.0))
    possible = run > 0.05
    v = u_t * rise / xp.where(possible, run, 1.0) - at.v_axial
    return xp.where(possible, v, xp.inf)


class Hump(NamedTuple):
    """The hump, or shoulder, at radii and operating points; all (S, B)."""

    height: Array  # the residual at its top [m^3/s^2], NaN where unknown
    inflow: Array  # v_i there [m/s]
    folded: Array  # whether the residual has three zeros there


def hump_before_stall(problem: AnnulusProblem, side: Array, azimuth: AzimuthNodes) -> Hump:
    """The residual's hump about the stall on a ``side`` (B,), see ``stall_side``.

    The hump is the local maximum at the largest v_i.  Where there is none but only a shoulder, the
    height is that of the flattest point.  Where that passes zero along the blade, the inflow does
    not jump but rises as steeply as a cube root, for which a panel's edge is needed as well.
    """

    def sample(angle: Angle) -> tuple[Array, Array]:
        v = inflow_at_angle(problem, angle)
        known = xp.isfinite(v)
        v = xp.where(known, v, 0.0)
        return v, xp.where(known, residual(problem, v, azimuth), xp.nan)

    v, height = map_entries(sample, angles_about_stall(problem, side, HUMP_ANGLES))
    seen = materialize(lambda: _between_samples(v, height), problem.at.blades)
    # In descent attached flow ends at low humps.  Elsewhere the interpolated top is as good, and
    # continuous with that of a shoulder.
    if problem.wake.windmill is None:
        here, at = residual(problem, seen.inflow, azimuth), seen.inflow
    else:
        low = seen.peak & (problem.at.v_axial < 0.0)
        here, at = _refined_top(problem, seen.inflow, low, seen.around, azimuth)
    folded = seen.peak & (here > 0.0) & (seen.depth < 0.0)
    return Hump(xp.where(seen.known, here, xp.nan), at, folded)


class _Around(NamedTuple):
    bend: Array  # second derivative of the residual between samples k and k + 2
    low: Array  # v_i of sample k + 2 [m/s]
    high: Array  # v_i of sample k


class _Samples(NamedTuple):
    """The hump as interpolated between samples over v_i, (S, B)."""

    inflow: Array  # v_i at the hump's top or the shoulder [m/s]
    known: Array  # whether that is known
    peak: Array  # whether it is a hump's top
    around: _Around  # samples about the top
    depth: Array  # least residual sampled at smaller v_i


def _between_samples(v: Array, height: Array) -> _Samples:
    """Interpolate v_i [m/s], falling, and the residual there, NaN where unknown; both (K, S, B)."""
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
    run = xp.diff(middle, axis=0)
    bend = xp.diff(slope, axis=0) / xp.where(run == 0.0, xp.nan, run)
    around = _Around(*(entry(a, first) for a in (bend, v[2:], v[:-2])))
    least = xp.min(depth, axis=0)
    return _Samples(xp.where(known, at, 0.0), known, some, around, least)


_Search = tuple[Array, Array, Array, Array, Array]
"""v_i, second derivative, v_i and slope of the step before, height."""


def _refined_top(
    problem: AnnulusProblem, at: Array, peak: Array, around: _Around, azimuth: AzimuthNodes
) -> tuple[Array, Array]:
    """The hump's height and v_i from a first guess ``at``; unchanged where there is no peak.

    The samples are too far apart for the height of a low hump.  With a wrong height a short stretch
    of attached flow may be missed, and with it several per cent of thrust in descent.
    """

    def improve(state: _Search) -> _Search:
        x, bend, x_before, slope_before, _ = state
        value, slope = residual_slope(problem, x, azimuth)
        moved = xp.abs(x - x_before) > precision_of(x).newton_step * (xp.abs(x) + 1e-9)
        run = xp.where(moved, x - x_before, 1.0)
        secant = xp.where(moved, (slope - slope_before) / run, bend)
        # Near an inflection the secant is wrong, and a step by it would leave the hump.
        bend = xp.where(secant < 0.0, xp.minimum(secant, 0.5 * around.bend), bend)
        step = -slope / xp.where(bend < 0.0, bend, -xp.inf)
        after = xp.where(peak, xp.clip(x + step, around.low, around.high), x)
        height = value + xp.where(peak, 0.5 * slope * (after - x), 0.0)
        return after, bend, x, slope, height

    nothing = xp.zeros_like(at)
    begin = (at, around.bend + nothing, at, nothing, nothing)
    top, _, _, _, height = repeat(TOP_STEPS, improve, begin)
    return height, xp.where(peak, top, at)


def _zeros(slope: Array, v: Array) -> Array:
    """The v at which the slope, linear between each two of (K, S, B), passes zero if it does."""
    steep = xp.where(slope[:-1] == slope[1:], 1.0, slope[:-1] - slope[1:])
    return v[:-1] + xp.clip(slope[:-1] / steep, 0.0, 1.0) * xp.diff(v, axis=0)


def _tops(slope: Array, v: Array) -> Array:
    """The v at which the parabola through each three slopes of (K, S, B) is largest, if concave."""
    chord = xp.diff(slope, axis=0) / xp.diff(v, axis=0)
    bend = (chord[:-1] - chord[1:]) / (v[:-2] - v[2:])
    top = 0.5 * (v[:-2] + v[1:-1]) - 0.5 * chord[:-1] / xp.where(bend < 0.0, bend, -1.0)
    return xp.where(bend < 0.0, xp.clip(top, v[2:], v[:-2]), v[1:-1])


def stall_side(problem: AnnulusProblem) -> Array:
    """1 where stall, if any, is that of positive angles, -1 where that of negative ones; (B,).

    Decided by the angle of attack without inflow at the one radius of ``problem``.
    """
    at = problem.at
    lifting = at.station.sine * at.turning - at.station.cosine * at.v_axial
    return xp.where(lifting[0] < 0.0, -1.0, 1.0)
