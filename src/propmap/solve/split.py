"""Where along the blade the inflow jumps from one branch of (11) to another.

Over v_i, the residual of (11) has a hump just before stall: coming from above, the attached
root lies on the far side of it.  Along the blade the hump sinks, and where its top passes
zero, at a fold, the attached root ends and the largest root drops to the stalled branch.
The fold moves with the operating point; radial nodes that stay put flip one by one, and the
loads jump.  So folds are looked for, and radial panels are split there.

The same happens with the signs exchanged at negative stall, in climb too fast for the pitch.
Which of the two stalls a blade is near is told by the sign of its angle of attack at
three fifths of its span without any inflow.
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
"""Radii at which the hump is looked for."""

DEFAULT_EDGES = (0.25, 0.6)
"""Shares of the span at which panels meet where there is nothing to follow, for two edges."""


def _at_extremes(t: Array, height: Array) -> tuple[Array, Array, Array]:
    """Move the samples (S, B) that are local extremes to the extremes of parabolas.

    So an attached stretch that is shorter than the spacing still shows as two crossings.
    Also whether a sample is such an extreme.
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
    """The first ``count`` zeros of the hump's height at even spacing, all (count, B).

    Whether there is one, its radius [m] and the inflow [m/s] there.
    """
    root, span = radius[0], radius[-1] - radius[0]
    t = (radius - root) / span
    place, height, extreme = _at_extremes(t * xp.ones_like(hump.height), hump.height)
    v = hump.inflow
    changes = xp.sign(height[:-1]) * xp.sign(height[1:]) < 0.0
    gap = xp.where(changes, height[:-1] - height[1:], 1.0)
    share = xp.where(changes, height[:-1] / gap, 0.5)
    # From an extreme the hump falls off like a parabola, elsewhere like a line.
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
    """Shares of the span (E, B) for the edges that have nothing to follow.

    ``some`` (E, B) have, at ``share`` (E, B).  ``first`` (B,) is for the first spare edge, or
    infinite; each other one halves the widest panel so far, by area.
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
    """The first radii at which the hump passes zero; and whether (11) was seen to have several
    roots, (B,).

    Parameters
    ----------
    problem_at : callable
        Equation (11) at radii (S, B) [m].
    root, tip : Array
        Ends of the blade [m].
    edges : int
        2, or 4 where attached flow may be left on two stretches.
    azimuth : AzimuthNodes
        Nodes to average over.
    """
    radius = root + (tip - root) * xp.linspace(0.0, 1.0 - 1e-6, GRID)[:, None]
    # One look-up of the blade's shape for both.
    outer = (root + 0.6 * (tip - root))[None, None]
    both = problem_at(xp.concatenate([radius, outer]))
    problem, beside = both.stations(slice(GRID)), both.stations(slice(GRID, None))
    side = stall_side(beside)
    islands = edges > len(DEFAULT_EDGES)
    find_hump = hump_by_slopes if islands else hump_before_stall
    hump = materialize(lambda: find_hump(problem, side, azimuth), root)
    several = xp.any(hump.folded, axis=0)

    def sight_of(radii: Array, found: Hump) -> Sight:
        # At the hump's top, by the envelope theorem, only the radius itself counts.
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
        # Half way to the next zero at most, lest the search for one ends at the other.
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
