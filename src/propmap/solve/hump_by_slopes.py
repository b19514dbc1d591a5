"""A more accurate search for the hump, for stretches of attached flow of any length.

From the residual and its slope at some v_i, the slope is a parabola between each two of them.  The
hump's top is at the largest v_i at which the slope changes sign; where it does not, the shoulder is
where the slope comes closest to zero.  Where a hump becomes a shoulder the two are one point, so
that the height is continuous along the blade.
"""

from __future__ import annotations

import functools

from propmap.arrays.loops import map_entries, scan
from propmap.arrays.namespace import Array, entry, xp
from propmap.physics.velocities import AzimuthNodes, floored_norm
from propmap.solve.hump import HUMP_ANGLES, Hump, angles_about_stall, inflow_at_angle
from propmap.solve.problem import AnnulusProblem, residual_slope

CLOSER = (0.012, 0.003)
"""Half-widths [rad] of the ranges about the best place so far that are sampled next."""

Top = tuple[Array, Array, Array]
"""v_i [m/s] and height [m^3/s^2] of a hump's top or shoulder; whether it is a top; (S, B)."""


def hump_by_slopes(problem: AnnulusProblem, side: Array, azimuth: AzimuthNodes) -> Hump:
    """The residual's hump about the stall on a ``side`` (B,); see ``hump.hump_before_stall``."""

    def sample(v: Array) -> tuple[Array, Array]:
        known = xp.isfinite(v)
        pair = residual_slope(problem, xp.where(known, v, 0.0), azimuth)
        value, slope = (xp.where(known, a, xp.nan) for a in pair)
        return value, slope

    angles = angles_about_stall(problem, side, HUMP_ANGLES)
    v = map_entries(functools.partial(inflow_at_angle, problem), angles)
    value, slope = map_entries(sample, v)
    at, height, top = _first_top(v, value, slope)
    depth = xp.where((v < at) & xp.isfinite(value), value, xp.inf)
    speed = floored_norm(problem.at.turning, problem.at.v_inplane)

    def closer(best: Top, half: Array) -> Top:
        v = best[0] + half * speed * xp.asarray([1.0, 0.0, -1.0])[:, None, None]
        return _first_top(v, *map_entries(sample, v))

    at, height, top = scan(closer, (at, height, top), xp.asarray(CLOSER))
    folded = top & (height > 0.0) & (xp.min(depth, axis=0) < 0.0)
    return Hump(
        height,
        xp.where(xp.isfinite(at), at, 0.0),
        folded,
    )


def _first_top(v: Array, value: Array, slope: Array) -> Top:
    """The hump's top, or else the shoulder, from samples (K, S, B) with v falling."""
    run = v[:-1] - v[1:]
    # With t from 0 at sample k to 1 at k + 1 the value has the derivative a + b t + c t^2.
    a, end = -slope[:-1] * run, -slope[1:] * run
    climb = value[1:] - value[:-1]
    c = 3.0 * (a + end - 2.0 * climb)
    b = end - a - c
    lowest = xp.clip(xp.where(c > 0.0, -0.5 * b / xp.where(c > 0.0, c, 1.0), 1.0), 0.0, 1.0)
    lowest = xp.where((c <= 0.0) & (a < end), 0.0, lowest)
    least = a + (b + c * lowest) * lowest
    falls = (a > 0.0) & (least < 0.0)
    some = xp.any(falls, axis=0)
    # The zero of the derivative between 0 and ``lowest``.
    root = xp.sqrt(xp.maximum(b * b - 4.0 * a * c, 0.0))
    zero = 2.0 * a / xp.where(root > b, root - b, xp.inf)
    gentlest = xp.nan_to_num(least / run, nan=xp.inf)
    k = xp.where(some, xp.argmax(falls, axis=0), xp.argmin(gentlest, axis=0))
    t = xp.where(falls, xp.clip(zero, 0.0, 1.0), lowest)
    height = value[:-1] + t * (a + t * (0.5 * b + t * c / 3.0))
    at = v[:-1] - t * run
    at, height = (entry(x, k) for x in (at, height))
    return at, height, some
