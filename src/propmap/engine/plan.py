"""How many nodes each operating point gets, so that all meet one accuracy at least cost.

The nodes of a first evaluation follow from the advance ratio and a forecast of stall.  Whether they
were enough is read off the result, and a point for which they were not is evaluated again.
`make convergence` checks the outcome against twice the nodes of "fine".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.engine.accuracy import Accuracy
from propmap.physics.vortex_ring import WINDMILL_BELOW
from propmap.solve.resolution import Resolution

FOLLOW_BELOW = 0.24
"""Advance ratio V sin(beta)/(Omega R) above which stall is spread over azimuth so widely
that following it along the blade gains nothing."""

FOLLOW_DESCENT_BELOW = 0.45
"""The same in descent, where attached stretches end abruptly up to faster in-plane flow."""

ISLAND_PANELS = 5
"""Panels on the windmill branch, where attached flow may be left on two stretches of the blade."""

REVERSED_ABOVE = 0.3
"""Advance ratio above which the reversed flow on the retreating side asks for as many nodes as
spread stall does."""


@dataclass(frozen=True)
class Job:
    """Operating points that are evaluated alike.

    Attributes
    ----------
    points : ndarray, shape (n,)
        Indices into the batch, those with most azimuths first, then by climb, down and up by turns.
    panels : tuple of int
        Radial nodes per panel.
    azimuths : ndarray, shape (n,)
        Azimuth nodes over a full turn; 1 for axial flow.
    most_azimuths : int
        The largest number of them in any such job, for which programs are made.
    """

    points: NDArray[np.intp]
    panels: tuple[int, ...]
    azimuths: NDArray[np.int64]
    most_azimuths: int


class Outlook(NamedTuple):
    """What decides how stall is followed; all (N,).

    Attributes
    ----------
    advance, climb : ndarray
        V sin(beta)/(Omega R) and V cos(beta)/(Omega R) [-], infinite at rest.
    stalls : ndarray of bool
        Where some of the blade may stall.
    islands : ndarray of bool
        ``may_leave_islands``: two stretches of attached flow have four edges to follow.
    """

    advance: Floats
    climb: Floats
    stalls: NDArray[np.bool_]
    islands: NDArray[np.bool_]

    def part(self, points: NDArray[np.bool_]) -> Outlook:
        """The outlook on some of the points, of which stall is now known."""
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
        Whether all get the nodes that any may need and stall is followed everywhere: one program
        for all but islands, at a higher cost per point.
    axial_apart : bool
        Whether axial flow, which needs a single azimuth, gets jobs of its own.
    descent : bool
        Whether the programs are those that also serve descent.
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
    # As one number: NumPy is slow to find the distinct rows of a table.
    sizes = (2, 2, int(stations.max(initial=0)) + 1, 2)
    apart = (azimuths == 1) & axial_apart
    each = (apart * 1, follow * 1, stations, (follow & islands) * 1)
    kinds = np.ravel_multi_index(each, sizes)
    # Blocks of points that are alike in climb too: there slow roots are at the same stations.  Down
    # and up by turns, for the blocks in which one number of azimuths follows another.
    rising = np.searchsorted([count for _, count in setting.azimuths], azimuths) % 2
    most_first = np.lexsort((np.where(rising, climb, -climb), -azimuths))
    for kind in np.unique(kinds):
        _, followed, nodes, four = (int(k) for k in np.unravel_index(kind, sizes))
        mine = most_first[kinds[most_first] == kind]
        panels = _island_panels(nodes) if four else _panels(nodes, bool(followed))
        highest = np.inf
        if followed and not alike:
            highest = FOLLOW_DESCENT_BELOW if descent else FOLLOW_BELOW
        elif not followed and not spread[mine[0]]:
            highest = REVERSED_ABOVE
        most = int(setting.azimuths_at(highest))
        jobs.append(Job(points[mine], panels, azimuths[mine], most))
    return jobs


def plan_again(
    setting: Accuracy, times: int, outlook: Outlook, points: NDArray[np.intp]
) -> list[Job]:
    """Jobs for points whose loads had too large a tail, stall being followed everywhere.

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
    """The panels that serve every point, but for islands."""
    return _panels(max(setting.stalled, setting.fast), True)


def may_leave_islands(v_axial: Floats, v_hover: Floats | float) -> NDArray[np.bool_]:
    """Where attached flow may be left on two stretches of the blade, (N,): the windmill branch.

    In slower descent the vortex ring's inflow rules, or the in-plane flow keeps the blade attached.

    Parameters
    ----------
    v_axial, v_hover : ndarray, shape (N,)
        V cos(beta) and static inflow (12) [m/s].
    """
    return np.asarray(v_axial < np.minimum(WINDMILL_BELOW * v_hover, 0.0))
