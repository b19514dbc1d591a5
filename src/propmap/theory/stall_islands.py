"""Where attached stretches of the blade begin and end in descent, however short they are.

In descent the hump of ``stall_hump`` may rise above zero on several stretches of the blade,
which merge, or shrink to nothing, within a few per mille of speed.  Radii at even spacing miss
the short ones, and the thrust steps when one is lost.  So the look along the blade goes on
where it matters: at the zeros of the hump's height, and at extremes that may hide two zeros
between neighbouring radii.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import jax.numpy as jnp
from jax import lax

from propmap.theory.parameters import Array

ROUNDS = 8
"""Rounds of further radii."""

EXTREMES = 3
"""Extremes that are followed, those nearest to zero."""

APART = 1e-6
"""Distance, relative to the radius, from one already known within which a further radius tells
nothing: differences over less are rounding errors."""


class Sight(NamedTuple):
    """What is known of the hump along the blade, by rising radius; all (T, B).

    radius [m], infinite where an entry is unused; height [m^3/s^2] of the hump, NaN where
    unknown; inflow [m/s] there.
    """

    radius: Array
    height: Array
    inflow: Array


class Zero(NamedTuple):
    """Where the height passes zero, (B,): whether it does, radius [m], inflow [m/s], and whether
    the radius is known by now."""

    some: Array
    radius: Array
    inflow: Array
    known: Array


def look_closer(even: Sight, look: Callable[[Array], Sight], zeros: int) -> Sight:
    """The sight at even spacing with further radii about zeros and extremes of the height.

    look : gives the sight at radii (E, B), in any order.
    zeros : how many are followed, the first from the root.
    """
    more = zeros + EXTREMES
    unused = jnp.full((ROUNDS * more, even.radius.shape[1]), jnp.inf)
    begin = Sight(
        *(
            jnp.concatenate([a, b])
            for a, b in zip(even, (unused, jnp.nan * unused, 0.0 / unused), strict=True)
        )
    )
    size = begin.radius.shape[0]

    def closer(_: int, sight: Sight) -> Sight:
        wanted = [jnp.where(z.some & ~z.known, z.radius, jnp.inf) for z in find_zeros(sight, zeros)]
        radius = jnp.stack([*wanted, *_hidden_extremes(sight)])
        used = jnp.isfinite(radius)
        seen = look(jnp.where(used, radius, even.radius[:1]))
        seen = Sight(radius, jnp.where(used, seen.height, jnp.nan), seen.inflow)
        both = [jnp.concatenate([a, b]) for a, b in zip(sight, seen, strict=True)]
        order = jnp.argsort(both[0], axis=0)[:size]
        return Sight(*(jnp.take_along_axis(a, order, axis=0) for a in both))

    return lax.fori_loop(0, ROUNDS, closer, begin)


def find_zeros(sight: Sight, count: int) -> list[Zero]:
    """The first ``count`` zeros of the height, by a parabola through three radii each."""
    h = sight.height
    changes = ((h[:-1] < 0.0) != (h[1:] < 0.0)) & jnp.isfinite(h[:-1] + h[1:])
    found = []
    for _ in range(count):
        k = jnp.argmax(changes, axis=0)[None]
        some = jnp.take_along_axis(changes, k, axis=0)[0]
        before, after = _entry(sight, k), _entry(sight, k + 1)
        left, right = _entry(sight, k - 1), _entry(sight, k + 2)
        width = after.radius - before.radius
        # The third radius: the nearer one of the two neighbours.
        nearer = before.radius - left.radius < right.radius - after.radius
        nearer = (nearer & jnp.isfinite(left.height)) | ~jnp.isfinite(right.height)
        third = Sight(*(jnp.where(nearer, a, b) for a, b in zip(left, right, strict=True)))
        rise = after.height - before.height
        reach = (third.radius - before.radius) / width
        bend = ((third.height - before.height) / reach - rise) / (reach - 1.0)
        bend = jnp.where(jnp.isfinite(bend), bend, 0.0)
        # before + (rise - bend) t + bend t^2 has one zero between 0 and 1.
        slope = rise - bend
        root = jnp.sqrt(jnp.maximum(slope * slope - 4.0 * bend * before.height, 0.0))
        share = -2.0 * before.height / (slope + jnp.sign(rise) * root)
        share = jnp.clip(jnp.where(jnp.isfinite(share), share, 0.5), 0.0, 1.0)
        found.append(
            Zero(
                some,
                before.radius + share * jnp.where(some, width, 0.0),
                before.inflow + share * (after.inflow - before.inflow),
                jnp.minimum(share, 1.0 - share) * width < APART * before.radius,
            )
        )
        changes = changes & (jnp.arange(changes.shape[0])[:, None] != k)
    return found


def _entry(sight: Sight, k: Array) -> Sight:
    """Entry k (1, B) of the sight, (B,); unknown outside."""
    last = sight.radius.shape[0] - 1
    inside = ((k >= 0) & (k <= last))[0]
    y, h, v = (jnp.take_along_axis(a, jnp.clip(k, 0, last), axis=0)[0] for a in sight)
    return Sight(y, jnp.where(inside, h, jnp.nan), v)


def _hidden_extremes(sight: Sight) -> list[Array]:
    """Radii (B,) [m] of extremes that may hide two zeros, by parabolas; infinite if unused.

    They are the maxima below zero and the minima above it.
    """
    y, h, _ = sight
    left, right = h[1:-1] - h[:-2], h[2:] - h[1:-1]
    hidden = (left * right <= 0.0) & ((right - left) * h[1:-1] > 0.0)
    back, ahead = y[1:-1] - y[:-2], y[2:] - y[1:-1]
    hidden = hidden & jnp.isfinite(ahead)
    bend = (right / ahead - left / back) / (back + ahead)
    slope = left / back + bend * back
    shift = jnp.where(hidden, -0.5 * slope / jnp.where(bend == 0.0, jnp.inf, bend), 0.0)
    shift = jnp.clip(shift, -0.9 * back, 0.9 * ahead)
    hidden = hidden & (jnp.abs(shift) > APART * y[1:-1])
    distance = jnp.where(hidden, jnp.abs(h[1:-1]), jnp.inf)
    found = []
    for _ in range(EXTREMES):
        k = jnp.argmin(distance, axis=0)[None]
        some, at = (jnp.take_along_axis(a, k, axis=0)[0] for a in (hidden, y[1:-1] + shift))
        found.append(jnp.where(some, at, jnp.inf))
        chosen = jnp.arange(hidden.shape[0])[:, None] == k
        distance, hidden = jnp.where(chosen, jnp.inf, distance), hidden & ~chosen
    return found
