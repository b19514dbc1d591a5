"""Choice of nodes for each operating point, so that all have the accuracy asked for at least cost.

The nodes of a first evaluation follow from the advance ratio and a forecast of stall.  Its result
tells whether they were enough; if not, the point is evaluated again with more.  `make convergence`
compares the loads with those from twice the nodes of "fine".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.engine.accuracy import Accuracy
from propmap.physics.vortex_ring import WINDMILL_BELOW
from propmap.solve.resolution import Resolution
from propmap.typing import Floats

FOLLOW_BELOW = 0.24
"""Advance ratio V sin(beta)/(Omega R) above which the radius of stall varies so much over azimuth
that panels which follow it gain nothing."""

FOLLOW_DESCENT_BELOW = 0.45
"""The same in descent, where attached flow ends abruptly up to larger advance ratios."""

ISLAND_PANELS = 5
"""Panels on the windmill branch, where flow may be attached on two stretches of the blade."""

REVERSED_ABOVE = 0.3
"""Advance ratio above which reverse flow on the retreating side needs as many nodes as stall that
is not followed."""


@dataclass(frozen=True)
class Job:
    """Operating points that are evaluated with the same panels.

    Attributes
    ----------
    points : ndarray, shape (n,)
        Indices into the batch, those with most azimuths first, then sorted by climb.
    panels : tuple of int
        Radial nodes per panel.
    azimuths : ndarray, shape (n,)
        Azimuth nodes over a full turn; 1 for axial flow.
    most_azimuths : int
        Largest number of them in any job with these panels, for which programs are compiled.
    """

    points: NDArray[np.intp]
    panels: tuple[int, ...]
    azimuths: NDArray[np.int64]
    most_azimuths: int


class Outlook(NamedTuple):
    """What decides on the nodes of operating points; all (N,).

    Attributes
    ----------
    advance, climb : ndarray
        V sin(beta)/(Omega R) and V cos(beta)/(Omega R) [-], infinite at rest.
    stalls : ndarray of bool
        Where some of the blade may stall.
    islands : ndarray of bool
        ``may_leave_islands``; two stretches of attached flow have four edges to follow.
    """

    advance: Floats
    climb: Floats
    stalls: NDArray[np.bool_]
    islands: NDArray[np.bool_]

    def part(self, points: NDArray[np.bool_]) -> Outlook:
        """The outlook on some of the points, all of which are now taken to stall."""
        stalls = np.ones(int(points.sum()), bool)
        return Outlook(self.advance[points], self.climb[points], stalls, self.islands[points])


def plan(
    setting: Accuracy,
    outlook: Outlook,
    points: NDArray[np.intp],
    *,
    alike: bool = False,
    axial_apart: bool = True,
    descent: bool = True,
    again_alike: bool = False,
) -> list[Job]:
    """Sort points into jobs for a first evaluation.

    Parameters
    ----------
    setting : Accuracy
        Nodes by advance ratio.
    outlook : Outlook
        Of these N points.
    points : ndarray, shape (N,)
        Their indices in the batch.
    alike : bool
        Whether all points get the nodes that any of them may need, and stall is followed
        everywhere: then there is one program (two with islands), at a higher cost per point.
    axial_apart : bool
        Whether axial flow, for which one azimuth suffices, gets separate jobs.
    descent : bool
        Whether the programs are those that also serve descent.
    again_alike : bool
        Whether panels that follow stall get the programs of the first further evaluation.
    """
    advance, climb, stalls, islands = outlook
    azimuths = np.where(advance == 0.0, 1, setting.azimuths_at(advance))
    follow = stalls & (advance <= np.where(climb < 0.0, FOLLOW_DESCENT_BELOW, FOLLOW_BELOW))
    spread = (stalls & ~follow) | (advance > REVERSED_ABOVE)
    stations = np.where(follow, setting.stalled, np.where(spread, setting.fast, setting.free))
    if alike:
        follow = np.ones_like(follow)
        stations = np.full_like(stations, sum(alike_panels(setting)))
    jobs = []
    # Each kind of job as one number: NumPy is slow to find the distinct rows of a matrix.
    sizes = (2, 2, int(stations.max(initial=0)) + 1, 2)
    apart = (azimuths == 1) & axial_apart
    each = (apart * 1, follow * 1, stations, (follow & islands) * 1)
    kinds = np.ravel_multi_index(each, sizes)
    # Sort by climb too: at similar climb, slow roots are at the same stations.  It falls and rises
    # in turn, so that it is similar within a block in which the number of azimuths changes.
    rising = np.searchsorted([count for _, count in setting.azimuths], azimuths) % 2
    most_first = np.lexsort((np.where(rising, climb, -climb), -azimuths))
    for kind in np.unique(kinds):
        _, followed, nodes, four = (int(k) for k in np.unravel_index(kind, sizes))
        mine = most_first[kinds[most_first] == kind]
        panels = _island_panels(nodes) if four else _panels(nodes, bool(followed))
        highest = np.inf
        if followed and not (alike or again_alike):
            highest = FOLLOW_DESCENT_BELOW if descent else FOLLOW_BELOW
        elif not followed and not spread[mine[0]]:
            highest = REVERSED_ABOVE
        most = int(setting.azimuths_at(highest))
        jobs.append(Job(points[mine], panels, azimuths[mine], most))
    return jobs


def plan_again(
    setting: Accuracy, times: int, outlook: Outlook, points: NDArray[np.intp]
) -> list[Job]:
    """Jobs for points whose loads had too large a tail; stall is followed in all of them.

    Parameters
    ----------
    setting, outlook, points
        As in ``plan``.
    times : int
        1 for the first further evaluation, with ``setting.finer[0]``, and so on.
    """
    nodes, _ = setting.finer[times - 1]
    azimuths = np.where(outlook.advance == 0.0, 1, setting.azimuths_again(outlook.advance, times))
    most = int(setting.azimuths_again(np.array([np.inf]), times)[0])
    jobs = []
    for panels, mine in (
        (_panels(nodes, True), np.flatnonzero(~outlook.islands)),
        (_island_panels(nodes), np.flatnonzero(outlook.islands)),
    ):
        mine = mine[np.argsort(-azimuths[mine], kind="stable")]
        if mine.size:
            jobs.append(Job(points[mine], panels, azimuths[mine], most))
    return jobs


def _panels(nodes: int, followed: bool) -> tuple[int, ...]:
    return Resolution(stations=nodes, follow_stall=followed).panels


def _island_panels(nodes: int) -> tuple[int, ...]:
    return (nodes // ISLAND_PANELS + 2,) * ISLAND_PANELS


def alike_panels(setting: Accuracy) -> tuple[int, ...]:
    """The panels for all points without islands."""
    return _panels(max(setting.stalled, setting.fast), True)


def may_leave_islands(v_axial: Floats, v_hover: Floats | float) -> NDArray[np.bool_]:
    """Where flow may be attached on two stretches of the blade, (N,): on the windmill branch.

    In slower descent the vortex ring's inflow is used, or in-plane flow keeps the blade attached.

    Parameters
    ----------
    v_axial, v_hover : ndarray, shape (N,)
        V cos(beta) and static inflow (12) [m/s].
    """
    return np.asarray(v_axial < np.minimum(WINDMILL_BELOW * v_hover, 0.0))
