"""The hump of the residual of (11) just before stall, over v_i, at given radii.

Coming from above, the attached root lies on the far side of the hump; where its top is below
zero, the largest root is the stalled one.  ``split`` looks along the blade for where that
changes.
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
"""[rad] from the stall angle, where the hump may be, in the order of falling v_i."""

SHARP_STALL = 0.02
"""Width of stall [rad] up to which the hump is looked for at these angles."""


class Angle(NamedTuple):
    """Sine and cosine [-] of an angle of attack from zero lift."""

    sine: Array
    cosine: Array


def angles_about_stall(problem: AnnulusProblem, side: Array, offsets: np.ndarray) -> Angle:
    """Angles of attack at ``offsets`` (K,) [rad] from the stall angle; (K, B) or (K, S, B).

    The stall is that on a ``side`` (B,), 1 or -1.  Where it is sharper than ``SHARP_STALL``, the
    offsets are shorter in proportion.
    """
    at = problem.at
    stall = at.law.stall_angle(at.station.reynolds_per_speed * at.turning, side)
    scale = xp.minimum(at.law.bounds().stall_width / SHARP_STALL, 1.0)
    angle = stall + scale * offsets.reshape(-1, *(1,) * stall.ndim)
    return Angle(xp.sin(angle), xp.cos(angle))


def inflow_at_angle(problem: AnnulusProblem, alpha: Angle) -> Array:
    """v_i [m/s] at which the angle of attack from zero lift is alpha, V sin(beta) aside.

    (S, B); infinite where no inflow makes it so.
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
    """At radii and operating points (S, B)."""

    height: Array  # of the hump or shoulder [m^3/s^2], NaN where unknown; (S, B)
    inflow: Array  # v_i there [m/s]
    folded: Array  # whether the residual has three zeros about it


def hump_before_stall(problem: AnnulusProblem, side: Array, azimuth: AzimuthNodes) -> Hump:
    """The residual's hump about the stall on a ``side`` (B,), see ``stall_side``.

    The hump is the first local maximum that v_i meets on its way down.  Where the residual
    only has a shoulder, the height is that of its flattest point: the inflow rises there
    without a jump, but as steeply as a cube root, and deserves a panel's edge as well.
    """

    def sample(angle: Angle) -> tuple[Array, Array]:
        v = inflow_at_angle(problem, angle)
        known = xp.isfinite(v)
        v = xp.where(known, v, 0.0)
        return v, xp.where(known, residual(problem, v, azimuth), xp.nan)

    v, height = map_entries(sample, angles_about_stall(problem, side, HUMP_ANGLES))
    seen = materialize(lambda: _between_samples(v, height), problem.at.blades)
    # In descent the attached stretch ends in low humps; elsewhere the guess is as good, and
    # joins the shoulder's without a step.
    if problem.wake.windmill is None:
        here, at = residual(problem, seen.inflow, azimuth), seen.inflow
    else:
        low = seen.peak & (problem.at.v_axial < 0.0)
        here, at = _refined_top(problem, seen.inflow, low, seen.around, azimuth)
    folded = seen.peak & (here > 0.0) & (seen.depth < 0.0)
    return Hump(xp.where(seen.known, here, xp.nan), at, folded)


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
    depth: Array  # of the residual there


def _between_samples(v: Array, height: Array) -> _Samples:
    """From v_i [m/s], falling, and the residual there, NaN where unknown; both (K, S, B)."""
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
"""v_i, bend, v_i and slope before, height."""


def _refined_top(
    problem: AnnulusProblem, at: Array, peak: Array, around: _Around, azimuth: AzimuthNodes
) -> tuple[Array, Array]:
    """The hump's height and v_i from a first guess ``at``; unchanged where there is no peak.

    The samples are too far apart for the height of a low hump: where it is misjudged a short
    attached stretch of the blade is lost, and with it several per cent of thrust in descent.
    """

    def improve(state: _Search) -> _Search:
        x, bend, x_before, slope_before, _ = state
        value, slope = residual_slope(problem, x, azimuth)
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
    top, _, _, _, height = repeat(TOP_STEPS, improve, begin)
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


def stall_side(problem: AnnulusProblem) -> Array:
    """1 where a blade is near the stall of positive angles, -1 where of negative ones; (B,).

    The ``problem`` is of one radius, (1, 1) or (1, B).
    """
    at = problem.at
    lifting = at.station.sine * at.turning - at.station.cosine * at.v_axial
    return xp.where(lifting[0] < 0.0, -1.0, 1.0)
