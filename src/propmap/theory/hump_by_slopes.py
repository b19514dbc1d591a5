"""The hump of ``stall_hump``, well enough that an attached stretch of any length is seen.

Residual and slope at a few v_i make the slope a parabola between each two of them.  The hump's
top is where, coming from above, the slope changes sign; where it does not, the shoulder is where
the slope comes closest to it.  In the cusp between the two both are one point, so that the
height has no step along the blade.
"""

from __future__ import annotations

import functools

import jax.numpy as jnp
from jax import lax

from propmap.theory.inflow import InflowQuestion, residual_slope
from propmap.theory.parameters import Array
from propmap.theory.stall_hump import HUMP_ANGLES, Hump, angles_about, inflow_at_angle
from propmap.theory.velocities import AzimuthNodes, floored_norm

CLOSER = (0.012, 0.003)
"""Halves of the ranges [rad] about the best place so far that are looked at next."""

Top = tuple[Array, Array, Array]
"""v_i [m/s] and height [m^3/s^2] of a hump's top or shoulder, and whether it is a top; (S, B)."""


def hump_by_slopes(ask: InflowQuestion, stall: Array, azimuth: AzimuthNodes) -> Hump:
    """The residual's hump about the angle ``stall`` (B,); see ``stall_hump.hump_before_stall``."""

    def sample(v: Array) -> tuple[Array, Array]:
        known = jnp.isfinite(v)
        pair = residual_slope(ask, jnp.where(known, v, 0.0), azimuth)
        value, slope = (jnp.where(known, a, jnp.nan) for a in pair)
        return value, slope

    v = lax.map(functools.partial(inflow_at_angle, ask), angles_about(stall, HUMP_ANGLES))
    value, slope = lax.map(sample, v)
    at, height, top = _first_top(v, value, slope)
    depth = jnp.where((v < at) & jnp.isfinite(value), value, jnp.inf)
    valley = jnp.argmin(depth, axis=0)
    speed = floored_norm(ask.at.omega * ask.at.radius, ask.at.v_inplane)

    def closer(best: Top, half: Array) -> tuple[Top, None]:
        v = best[0] + half * speed * jnp.asarray([1.0, 0.0, -1.0])[:, None, None]
        return _first_top(v, *lax.map(sample, v)), None

    (at, height, top), _ = lax.scan(closer, (at, height, top), jnp.asarray(CLOSER))
    folded = top & (height > 0.0) & (jnp.min(depth, axis=0) < 0.0)
    return Hump(
        height, jnp.where(jnp.isfinite(at), at, 0.0), jnp.asarray(HUMP_ANGLES)[valley], folded
    )


def _first_top(v: Array, value: Array, slope: Array) -> Top:
    """v_i and height of the hump's top or else of the shoulder, and whether it is a top; (S, B).

    v, value, slope : (K, S, B), with v falling.
    """
    run = v[:-1] - v[1:]
    # Along t, from 0 at entry k to 1 at k + 1, the value climbs by a + (b + c t) t.
    a, end = -slope[:-1] * run, -slope[1:] * run
    climb = value[1:] - value[:-1]
    c = 3.0 * (a + end - 2.0 * climb)
    b = end - a - c
    lowest = jnp.clip(jnp.where(c > 0.0, -0.5 * b / jnp.where(c > 0.0, c, 1.0), 1.0), 0.0, 1.0)
    lowest = jnp.where((c <= 0.0) & (a < end), 0.0, lowest)
    least = a + (b + c * lowest) * lowest
    falls = (a > 0.0) & (least < 0.0)
    some = jnp.any(falls, axis=0)
    # The zero between 0 and ``lowest``.
    root = jnp.sqrt(jnp.maximum(b * b - 4.0 * a * c, 0.0))
    zero = 2.0 * a / jnp.where(root > b, root - b, jnp.inf)
    gentlest = jnp.nan_to_num(least / run, nan=jnp.inf)
    k = jnp.where(some, jnp.argmax(falls, axis=0), jnp.argmin(gentlest, axis=0))[None]
    t = jnp.where(falls, jnp.clip(zero, 0.0, 1.0), lowest)
    height = value[:-1] + t * (a + t * (0.5 * b + t * c / 3.0))
    at = v[:-1] - t * run
    at, height = (jnp.take_along_axis(x, k, axis=0)[0] for x in (at, height))
    return at, height, some
