"""Where along the blade the inflow jumps from one branch of (11) to another.

Over v_i, the residual of (11) has a maximum near stall, the hump.  The attached root is at a larger
v_i than its top.  Along the blade the hump's height changes; the radius at which it passes zero is
a fold: there the attached root vanishes, and the largest root jumps to the stalled branch.  The
fold moves with the operating point.  Past fixed radial nodes it would move one by one, and each
time the loads would jump.  So folds are looked for, and radial panels meet there.

The same happens with opposite signs at negative stall, in climb too fast for the pitch.  The sign
of the angle of attack without inflow, at 0.6 of the span, tells at which stall to look.
"""

from __future__ import annotations

from propmap.arrays.materialize import materialize
from propmap.arrays.namespace import Array, entry, xp
from propmap.arrays.precision import precision_of
from propmap.physics.velocities import AzimuthNodes
from propmap.solve.folds import Crossing, ProblemAt
from propmap.solve.hump import (
    Hump,
    hump_before_stall,
    stall_side,
)
from propmap.solve.hump_by_slopes import hump_by_slopes
from propmap.solve.islands import Sight, find_zeros, look_closer, nearest_extreme
from propmap.solve.problem import residual

GRID = 20
"""Number of evenly spaced radii at which the hump is computed."""

DEFAULT_EDGES = (0.25, 0.6)
"""Shares of the span at which the three panels meet where there is no fold."""


def _at_extremes(t: Array, height: Array) -> tuple[Array, Array, Array]:
    """Move samples (S, B) that are local extremes to the extremes of parabolas.

    So a stretch of attached flow shorter than the spacing may still give two zeros.  The third
    result is whether a sample is such an extreme.
    """
    left, right = height[1:-1] - height[:-2], height[2:] - height[1:-1]
    extreme = left * right < 0.0
    bend = xp.where(extreme, left - right, 1.0)
    shift = xp.where(extreme, 0.5 * (left + right) / bend, 0.0)
    top = height[1:-1] + xp.where(extreme, 0.125 * (left + right) ** 2 / bend, 0.0)
    moved = t[1:-1] + shift * (t[2:] - t[:-2]) * 0.5
    return (
        xp.concatenate([t[:1], moved, t[-1:]]),
        xp.concatenate([height[:1], top, height[-1:]]),
        xp.pad(extreme, ((1, 1), (0, 0))),
    )


def _even_zeros(radius: Array, hump: Hump, count: int) -> tuple[Array, Array, Array]:
    """The first ``count`` zeros of the hump's height, from evenly spaced radii; all (count, B).

    Whether there is one, its radius [m] and the inflow [m/s] there.
    """
    root, span = radius[0], radius[-1] - radius[0]
    t = (radius - root) / span
    place, height, extreme = _at_extremes(t * xp.ones_like(hump.height), hump.height)
    v = hump.inflow
    changes = xp.sign(height[:-1]) * xp.sign(height[1:]) < 0.0
    gap = xp.where(changes, height[:-1] - height[1:], 1.0)
    share = xp.where(changes, height[:-1] / gap, 0.5)
    # Next to an extreme the height is like a parabola, elsewhere like a line.
    share = xp.where(extreme[:-1], xp.sqrt(share), share)
    share = xp.where(extreme[1:] & ~extreme[:-1], 1.0 - xp.sqrt(1.0 - share), share)
    at = root + span * (place[:-1] + share * xp.diff(place, axis=0))
    inflow = v[:-1] + share * xp.diff(v, axis=0)
    picked = []
    for _ in range(count):
        k = xp.argmax(changes, axis=0)
        picked.append([entry(a, k) for a in (changes, at, inflow)])
        changes = changes & (xp.arange(changes.shape[0])[:, None] != k)
    some, y, v_i = (xp.stack(parts) for parts in zip(*picked, strict=True))
    return some, y, v_i


def _spare_edges(some: Array, share: Array, first: Array) -> Array:
    """Shares of the span (E, B) for all edges, those without a fold included.

    Edges where ``some`` (E, B) have a fold, at ``share`` (E, B).  Of the others the first is at
    ``first`` (B,), unless that is infinite; each further one halves the panel of largest area.
    """
    place = xp.where(some, share, 1.0)
    unused = xp.isfinite(first)
    # The two halves of a panel are equal but for rounding errors: the outer one is chosen.
    outer = 1e-6 * xp.arange(some.shape[0] + 1)[:, None]
    for j in range(some.shape[0]):
        area = xp.sort(xp.pad(place, ((1, 1), (0, 0)), constant_values=(0.0, 1.0)), axis=0) ** 2
        k = xp.argmax(xp.diff(area, axis=0) + outer, axis=0)
        low, high = entry(area, k), entry(area[1:], k)
        free = xp.where(unused, first, xp.sqrt(0.5 * (low + high)))
        unused = unused & some[j]
        here = xp.arange(some.shape[0])[:, None] == j
        place = xp.where(here & ~some, free, place)
    return place


def hump_crossings(
    problem_at: ProblemAt, root: Array, tip: Array, edges: int, azimuth: AzimuthNodes
) -> tuple[Crossing, Array]:
    """The first radii at which the hump's height is zero; whether several roots were found, (B,).

    Parameters
    ----------
    problem_at : callable
        Equation (11) at radii (S, B) [m].
    root, tip : Array
        Ends of the blade [m].
    edges : int
        2, or 4 where flow may be attached on two separate stretches.
    azimuth : AzimuthNodes
        Azimuths to average over.
    """
    radius = root + (tip - root) * xp.linspace(0.0, 1.0 - 1e-6, GRID)[:, None]
    # Both in one look-up of the blade's shape.
    outer = (root + 0.6 * (tip - root))[None, None]
    both = problem_at(xp.concatenate([radius, outer]))
    problem, beside = both.stations(slice(GRID)), both.stations(slice(GRID, None))
    side = stall_side(beside)
    islands = edges > len(DEFAULT_EDGES)
    find_hump = hump_by_slopes if islands else hump_before_stall
    hump = materialize(lambda: find_hump(problem, side, azimuth), root)
    several = xp.any(hump.folded, axis=0)

    def sight_of(radii: Array, found: Hump) -> Sight:
        # At the top the residual's slope by v_i is zero, so that v_i may be kept.
        step = -precision_of(radii).difference * radii
        along = residual(problem_at(radii + step), found.inflow, azimuth)
        slope = (along - residual(problem_at(radii), found.inflow, azimuth)) / step
        return Sight(radii * xp.ones_like(slope), found.height, found.inflow, slope)

    def look(radii: Array) -> Sight:
        return sight_of(radii, find_hump(problem_at(radii), side, azimuth))

    spacing = (tip - root) / GRID
    if islands:
        sight = look_closer(sight_of(radius, hump), look, edges)
        some, y, v, known, _ = find_zeros(sight, edges)
        # At most half way to the next zero, so that the search for one does not end at the other.
        gap = xp.where(some[:-1] & some[1:], xp.diff(y, axis=0), xp.inf)
        gap = xp.pad(gap, ((1, 1), (0, 0)), constant_values=xp.inf)
        spacing = xp.minimum(spacing, 0.25 * xp.minimum(gap[:-1], gap[1:]))
        spacing = xp.where(known, xp.minimum(spacing, 1e-4 * y), spacing)
        spare = (nearest_extreme(sight) - root) / (tip - root)
        home = root + (tip - root) * _spare_edges(some, (y - root) / (tip - root), spare)
    else:
        some, y, v = materialize(lambda: _even_zeros(radius, hump, edges), root)
        home = root + (tip - root) * xp.asarray(DEFAULT_EDGES)[:, None]
    near = Crossing(xp.where(some, y, home), xp.where(some, v, 0.0), xp.where(some, spacing, 0.0))
    return near, several
