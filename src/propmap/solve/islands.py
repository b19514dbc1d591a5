"""Islands: stretches of attached flow on the blade in fast descent, and where they begin and end.

In fast descent the hump of ``solve.hump`` may be above zero on several stretches of the blade,
which merge or vanish within a few per mille of speed.  Evenly spaced radii miss short ones, and
the thrust jumps when one is missed.  So the hump is computed at further radii: at the zeros of its
height, and at extremes, about which two zeros may lie between neighbouring radii.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from propmap.arrays.loops import repeat
from propmap.arrays.namespace import Array, entry, xp
from propmap.arrays.precision import precision_of

ROUNDS = 8
"""Rounds of further radii."""

EXTREMES = 3
"""Number of extremes looked at in each round, those nearest to zero."""

CLOSE = 1e-4
"""Distance from a known zero, relative to its radius, of the radius added on its far side."""

LOPSIDED, BEYOND = 0.15, 3.0
"""If a zero is expected within the share LOPSIDED of its bracket from one end, the next radius is
BEYOND times as far from that end.  Otherwise interpolation of a curved height may approach the
zero from one side only, and leave a wide bracket in which another zero may be missed."""

UNSURE = 10.0
"""An extreme farther from zero than this many times the change of height between it and the nearer
radius, by the slope there, is not looked at again."""


class Sight(NamedTuple):
    """The hump at the radii looked at so far, by rising radius; all (T, B).

    radius [m], infinite where an entry is unused; height [m^3/s^2] of the hump, NaN where
    unknown; inflow [m/s] there; slope [m^2/s^2] of the height along the blade.
    """

    radius: Array
    height: Array
    inflow: Array
    slope: Array


class Zeros(NamedTuple):
    """Zeros of the height, all (E, B): whether there is one; radius [m]; inflow [m/s]; whether the
    radius is known well enough; the next radius to look at [m], infinite if there is none."""

    some: Array
    radius: Array
    inflow: Array
    known: Array
    further: Array


def look_closer(even: Sight, look: Callable[[Array], Sight], zeros: int) -> Sight:
    """Add radii about zeros and extremes of the height to those at even spacing.

    Parameters
    ----------
    even : Sight
        At even spacing.
    look : callable
        Gives the sight at radii (E, B), in any order.
    zeros : int
        How many zeros are looked for, from the root outwards.
    """
    more = zeros + EXTREMES
    unused = xp.full((ROUNDS * more, even.radius.shape[1]), xp.inf)
    blank = (unused, xp.nan * unused, 0.0 / unused, 0.0 / unused)
    begin = Sight(*(xp.concatenate([a, b]) for a, b in zip(even, blank, strict=True)))
    size = begin.radius.shape[0]

    def closer(sight: Sight) -> Sight:
        radius = xp.stack([*find_zeros(sight, zeros).further, *_hidden_extremes(sight)])
        used = xp.isfinite(radius)
        seen = look(xp.where(used, radius, even.radius[:1]))
        seen = seen._replace(radius=radius, height=xp.where(used, seen.height, xp.nan))
        both = [xp.concatenate([a, b]) for a, b in zip(sight, seen, strict=True)]
        order = xp.argsort(both[0], axis=0)[:size]
        return Sight(*(xp.take_along_axis(a, order, axis=0) for a in both))

    return repeat(ROUNDS, closer, begin)


def find_zeros(sight: Sight, count: int) -> Zeros:
    """The first ``count`` zeros of the height, by a parabola through three radii each."""
    h = sight.height
    changes = ((h[:-1] < 0.0) != (h[1:] < 0.0)) & xp.isfinite(h[:-1] + h[1:])
    number = xp.cumsum(changes, axis=0) * changes
    which = [number == j for j in range(1, count + 1)]
    some = xp.stack([xp.any(one, axis=0) for one in which])
    k = xp.stack([xp.argmax(one, axis=0) for one in which])
    before, after = _entries(sight, k), _entries(sight, k + 1)
    left, right = _entries(sight, k - 1), _entries(sight, k + 2)
    width = after.radius - before.radius
    # The third radius of the parabola: the nearer neighbour of the bracket.
    nearer = before.radius - left.radius < right.radius - after.radius
    nearer = (nearer & xp.isfinite(left.height)) | ~xp.isfinite(right.height)
    third = Sight(*(xp.where(nearer, a, b) for a, b in zip(left, right, strict=True)))
    rise = after.height - before.height
    reach = (third.radius - before.radius) / width
    bend = ((third.height - before.height) / reach - rise) / (reach - 1.0)
    bend = xp.where(xp.isfinite(bend), bend, 0.0)
    # before + (rise - bend) t + bend t^2 has one zero between 0 and 1.
    slope = rise - bend
    root = xp.sqrt(xp.maximum(slope * slope - 4.0 * bend * before.height, 0.0))
    share = -2.0 * before.height / (slope + xp.sign(rise) * root)
    share = xp.clip(xp.where(xp.isfinite(share), share, 0.5), 0.0, 1.0)
    width = xp.where(some, width, 0.0)
    radius = before.radius + share * width
    inflow = before.inflow + share * (after.inflow - before.inflow)
    known = xp.minimum(share, 1.0 - share) * width < 0.1 * CLOSE * before.radius
    # Beside a known zero, a radius on its far side makes the bracket narrow.
    across = xp.where(share < 0.5, CLOSE, -CLOSE) * radius
    past = xp.where(share < LOPSIDED, BEYOND * share, share)
    past = xp.where(share > 1.0 - LOPSIDED, 1.0 - BEYOND * (1.0 - share), past)
    further = xp.where(known, radius + across, before.radius + past * width)
    left_over = some & (~known | (width > 2.0 * CLOSE * radius))
    return Zeros(some, radius, inflow, known, xp.where(left_over, further, xp.inf))


def _entries(sight: Sight, k: Array) -> Sight:
    """Entries k (E, B) of the sight, (E, B); heights of entries that do not exist are NaN."""
    last = sight.radius.shape[0] - 1
    inside = (k >= 0) & (k <= last)
    found = Sight(*(xp.take_along_axis(a, xp.clip(k, 0, last), axis=0) for a in sight))
    return found._replace(height=xp.where(inside, found.height, xp.nan))


class _Extremes(NamedTuple):
    """The minimum above zero, or maximum below zero, of the height between each two radii, all
    (T - 1, B): radius [m]; distance from zero, infinite if there is none; unsure, whether two zeros
    may be about it."""

    radius: Array
    distance: Array
    unsure: Array


def _extremes(sight: Sight) -> _Extremes:
    """Maxima below zero and minima above it of the cubics through heights and slopes."""
    y, h, _, slope = sight
    width = y[1:] - y[:-1]
    start, end, rise = slope[:-1] * width, slope[1:] * width, h[1:] - h[:-1]
    above = h[1:] > 0.0
    some = ((h[:-1] > 0.0) == above) & xp.isfinite(h[:-1] + h[1:])
    # The cubic's derivative is start + 2 b t + 3 c t^2; a minimum is its zero with +root.
    c, b = start + end - 2.0 * rise, 3.0 * rise - 2.0 * start - end
    square = b * b - 3.0 * c * start
    root = xp.sqrt(xp.maximum(square, 0.0))
    root = xp.where(above, root, -root)
    same = b * root > 0.0
    share = xp.where(same, -start, root - b) / xp.where(
        some, xp.where(same, b + root, 3.0 * c), 1.0
    )
    some = some & (square > 0.0) & (share > 0.0) & (share < 1.0)
    share = xp.where(some, share, 0.5)
    height = h[:-1] + share * (start + share * (b + share * c))
    # Over shorter distances differences are rounding errors.
    apart = xp.minimum(share, 1.0 - share) * width > precision_of(y).difference * y[:-1]
    climb = xp.where(share < 0.5, share * start, (1.0 - share) * end)
    distance = xp.where(some, xp.where(above, height, -height), xp.inf)
    at = y[:-1] + share * xp.where(some, width, 0.0)
    return _Extremes(at, distance, some & apart & (xp.abs(height) < UNSURE * xp.abs(climb)))


def _hidden_extremes(sight: Sight) -> list[Array]:
    """Radii (B,) [m] of extremes about which two zeros may be; infinite if unused."""
    at, distance, unsure = _extremes(sight)
    distance = xp.where(unsure, distance, xp.inf)
    found = []
    for _ in range(EXTREMES):
        k = xp.argmin(distance, axis=0)
        far, place = entry(distance, k), entry(at, k)
        found.append(xp.where(xp.isfinite(far), place, xp.inf))
        distance = xp.where(xp.arange(at.shape[0])[:, None] == k, xp.inf, distance)
    return found


def nearest_extreme(sight: Sight) -> Array:
    """Radius (B,) [m] of the extreme nearest to zero, where two zeros are about to appear or have
    just vanished; infinite if there is none."""
    at, distance, _ = _extremes(sight)
    k = xp.argmin(distance, axis=0)
    far, place = entry(distance, k), entry(at, k)
    return xp.where(xp.isfinite(far), place, xp.inf)
