"""Where along the blade the inflow jumps from one branch of (11) to another.

Over v_i, the residual of (11) has a hump just before stall: coming from above, the attached
root lies on the far side of it.  Along the blade the hump sinks, and where its top passes
zero, at a fold, the attached root ends and the largest root drops to the stalled branch.
The fold moves with the operating point; radial nodes that stay put flip one by one, and the
loads jump.  So folds are looked for, and radial panels are split there.

The same happens with the signs exchanged at negative stall, in climb too fast for the pitch.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from propmap.theory.inflow import InflowQuestion, residual, residual_slope
from propmap.theory.parameters import Array
from propmap.theory.section_law import angle_of_attack, attached_share
from propmap.theory.velocities import AzimuthNodes, floored_norm

SPLITS = 2
"""Branch jumps followed at once: stall at mid-blade and, on blades whose twist falls off
towards the root, a second one further in."""

GRID = 24
"""Radii at which the hump is looked for."""

FOLD_STEPS = 12
"""Newton steps on a fold."""

DEFAULT_EDGES = (0.25, 0.6)
"""Shares of the span at which panels meet where there is nothing to follow."""

_HUMP = np.array([-0.16, -0.11, -0.075, -0.05, -0.025, 0.0, 0.03])
"""[rad] from the stall angle, where the hump may be."""

AskAt = Callable[[Array], InflowQuestion]
"""Equation (11) at radii of shape (S, B) [m]."""


class Crossing(NamedTuple):
    """Where the hump passes zero, to within the grid; all (SPLITS, B).

    radius [m] and inflow [m/s] by interpolation; spacing : of the grid [m], zero where
    there is no crossing and radius is one of ``DEFAULT_EDGES``.
    """

    radius: Array
    inflow: Array
    spacing: Array


class Fold(NamedTuple):
    """Folds, all (SPLITS, B): radius [m], inflow [m/s], and whether one was found."""

    radius: Array
    inflow: Array
    found: Array


def mean_attached_share(ask: InflowQuestion, inflow: Array) -> Array:
    """1 - sigma [-] at the angle of attack without the in-plane velocity; shape of inflow."""
    at = ask.at
    u_t, u_p = at.omega * at.radius, at.v_axial + inflow
    across, along = at.sine * u_t - at.cosine * u_p, at.cosine * u_t + at.sine * u_p
    alpha = angle_of_attack(along, across, floored_norm(u_t, u_p))
    return attached_share(alpha, at.section)


def inflow_at_angle(ask: InflowQuestion, alpha: Array) -> Array:
    """v_i [m/s] at which the angle of attack from zero lift is alpha [rad], V sin(beta) aside.

    (S, B); infinite where no inflow makes it so.
    """
    at = ask.at
    sine, cosine = jnp.sin(alpha), jnp.cos(alpha)
    rise, run = at.sine * cosine - at.cosine * sine, at.cosine * cosine + at.sine * sine
    u_t = floored_norm(at.omega * at.radius, at.v_inplane / np.sqrt(2.0))
    possible = run > 0.05
    v = u_t * rise / jnp.where(possible, run, 1.0) - at.v_axial
    return jnp.where(possible, v, jnp.inf)


def _hump(ask: InflowQuestion, stall: Array, azimuth: AzimuthNodes) -> tuple[Array, Array]:
    """Height of the residual's hump and v_i there, about the angle ``stall``; (S, B)."""
    angles = stall + jnp.asarray(_HUMP)

    def look(k: Array, best: tuple[Array, Array]) -> tuple[Array, Array]:
        v = inflow_at_angle(ask, angles[k])
        known = jnp.isfinite(v)
        v = jnp.where(known, v, 0.0)
        value = jnp.where(known, residual(ask, v, azimuth), -jnp.inf)
        higher = value > best[0]
        return jnp.where(higher, value, best[0]), jnp.where(higher, v, best[1])

    shape = jnp.broadcast_shapes(ask.at.radius.shape, ask.at.omega.shape)
    lowest = jnp.full(shape, -jnp.inf)
    return lax.fori_loop(0, len(_HUMP), look, (lowest, jnp.zeros(shape)))


def hump_crossings(ask_at: AskAt, root: Array, tip: Array, azimuth: AzimuthNodes) -> Crossing:
    """The first ``SPLITS`` radii at which a hump passes zero; differentiable."""
    t = jnp.linspace(0.0, 1.0 - 1e-6, GRID)[:, None]
    radius = root + (tip - root) * t
    ask = ask_at(radius)
    stall = ask.at.section.alpha_0
    found = []
    for angle in (stall, -stall):
        height, v = _hump(ask, angle, azimuth)
        usable = jnp.isfinite(height[:-1]) & jnp.isfinite(height[1:])
        changes = usable & (jnp.sign(height[:-1]) != jnp.sign(height[1:]))
        gap = jnp.where(changes, height[:-1] - height[1:], 1.0)
        share = jnp.where(changes, height[:-1] / gap, 0.0)
        found.append(
            (
                changes,
                radius[:-1] + share * jnp.diff(radius, axis=0),
                v[:-1] + share * jnp.diff(v, axis=0),
            )
        )
    changes, at_radius, at_inflow = (jnp.concatenate(parts) for parts in zip(*found, strict=True))
    picked = []
    for default in DEFAULT_EDGES:
        k = jnp.argmax(changes, axis=0)[None]
        some = jnp.take_along_axis(changes, k, axis=0)
        y = jnp.take_along_axis(at_radius, k, axis=0)
        v = jnp.take_along_axis(at_inflow, k, axis=0)
        spacing = jnp.where(some, (tip - root) / GRID, 0.0)
        picked.append(
            (jnp.where(some, y, root + default * (tip - root)), jnp.where(some, v, 0.0), spacing)
        )
        changes = changes & (jnp.arange(changes.shape[0])[:, None] != k)
    return Crossing(*(jnp.concatenate(parts) for parts in zip(*picked, strict=True)))


def find_folds(near: Crossing, ask_at: AskAt, azimuth: AzimuthNodes) -> Fold:
    """Solve residual = slope = 0 from each crossing.

    Newton in (radius, v_i) with the second derivatives from differences of the slope, which
    spares the compilation of second-order blade elements and still ends at the exact fold.
    """
    at = ask_at(near.radius).at
    scale = jnp.abs(at.omega * near.radius) + jnp.abs(at.v_axial) + 1e-30
    dv, dy = 1e-6 * scale, -1e-6 * near.radius

    def newton(_: int, state: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        y, v, _ = state
        ys, vs = jnp.concatenate([y, y, y + dy]), jnp.concatenate([v, v + dv, v])
        pair = residual_slope(ask_at(ys), vs, azimuth)
        g, slope = (a.reshape(3, SPLITS, -1) for a in pair)
        g_y, g_vy = (g[2] - g[0]) / dy, (slope[2] - slope[0]) / dy
        g_vv = (slope[1] - slope[0]) / dv
        det = slope[0] * g_vy - g_y * g_vv
        det = jnp.where(det == 0.0, jnp.inf, det)
        step_v = (g[0] * g_vy - slope[0] * g_y) / det
        step_y = (slope[0] * slope[0] - g[0] * g_vv) / det
        done = (jnp.abs(step_v) < 1e-7 * scale) & (jnp.abs(step_y) < 1e-9 * y) & (g_vv < 0.0)
        step_v = jnp.clip(step_v, -0.05 * scale, 0.05 * scale)
        step_y = jnp.clip(step_y, -near.spacing, near.spacing)
        return y - step_y, v - step_v, done

    begin = (near.radius, near.inflow, jnp.zeros(near.radius.shape, bool))
    radius, v, done = lax.fori_loop(0, FOLD_STEPS, newton, begin)
    found = done & (jnp.abs(radius - near.radius) < 2.0 * near.spacing)
    return Fold(jnp.where(found, radius, near.radius), jnp.where(found, v, 0.0), found)


def follow(fold: Fold, ask_at: AskAt, azimuth: AzimuthNodes) -> Array:
    """The folds' radii [m], made to move with what ``ask_at`` depends on; (SPLITS, B).

    At a fold the slope with respect to v_i vanishes, so the residual stays zero if
    d(radius) = -(d residual) / (d residual/d radius).
    """
    anchor, v = lax.stop_gradient((fold.radius, fold.inflow))

    def at_fold(radius: Array) -> Array:
        return residual(ask_at(radius), v, azimuth)

    value, along = jax.jvp(at_fold, (anchor,), (jnp.ones_like(anchor),))
    along = lax.stop_gradient(jnp.where(fold.found & (along != 0.0), along, jnp.inf))
    return anchor - (value - lax.stop_gradient(value)) / along
