"""How many nodes each operating point gets, so that all meet one accuracy at least cost.

The counts were chosen by a convergence study; `make convergence` checks them at 9000 random points
(2000-10000 rpm, 0-20 m/s, 0-180 deg, all three sets of Table I) against twice the nodes of "fine".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.errors import InputError
from propmap.physics.vortex_ring import WINDMILL_BELOW
from propmap.solve.resolution import Resolution

Singles = NDArray[np.float32]

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

FORECAST_TOGETHER = 1024
"""Points whose stall is forecast at once: more, and NumPy waits for memory."""

STALL_MARGIN = (2.9, 12.0)
"""Distance from the stall angle, in units of 1/M, within which stall is expected: in axial flow,
and by how much it grows with the advance ratio, since the forecast errs more in fast flow.  Of
18 000 random points of the three sets of Table I fewer than one in a thousand stalls unforeseen."""


@dataclass(frozen=True)
class Accuracy:
    """One setting: advance ratios up to which a number of azimuth nodes serves, and stations.

    azimuths : pairs (largest advance ratio, nodes over a full turn).
    free, stalled, fast : radial nodes where nothing stalls, where the panels follow stall,
    and where stall is spread over azimuth or the flow is reversed.
    """

    azimuths: tuple[tuple[float, int], ...]
    free: int
    stalled: int
    fast: int

    def azimuths_at(self, advance: Floats | float) -> NDArray[np.int64]:
        """Azimuth nodes over a full turn; ``advance`` : V sin(beta)/(Omega R) > 0 [-], any shape,
        which the result has too."""
        limits, counts = (np.array(column) for column in zip(*self.azimuths, strict=True))
        found: NDArray[np.int64] = counts[np.searchsorted(limits, advance)]
        return found

    @property
    def most_azimuths(self) -> int:
        """Largest number of azimuth nodes that may occur."""
        return self.azimuths[-1][1]


ACCURACIES = {
    "standard": Accuracy(
        (
            (0.03, 8),
            (0.06, 12),
            (0.12, 16),
            (0.18, 24),
            (0.3, 32),
            (0.5, 64),
            (1.0, 96),
            (np.inf, 128),
        ),
        free=24,
        stalled=48,
        fast=64,
    ),
    "fine": Accuracy(
        ((0.1, 32), (0.15, 48), (0.3, 96), (0.5, 192), (1.0, 256), (np.inf, 384)),
        free=96,
        stalled=160,
        fast=160,
    ),
}
"""``standard``: 0.1 % of static thrust and torque; ``fine``: 0.01 %."""


def accuracy(name: str) -> Accuracy:
    """The setting of that name; ``InputError`` where there is none."""
    if name not in ACCURACIES:
        raise InputError(f"accuracy is {name!r}: it must be one of {', '.join(ACCURACIES)}")
    return ACCURACIES[name]


@dataclass(frozen=True)
class Job:
    """Operating points that are evaluated alike.

    points : indices into the batch (n,), those with most azimuths first, then by climb, down and up
    by turns.  panels : radial nodes per panel.  azimuths : of each point, nodes over a full turn
    (n,), 1 for axial flow.  most_azimuths : the largest number of them in any such job, for which
    programs are made.
    """

    points: NDArray[np.intp]
    panels: tuple[int, ...]
    azimuths: NDArray[np.int64]
    most_azimuths: int


class Outlook(NamedTuple):
    """What decides how stall is followed, all (N,).

    advance, climb : V sin(beta)/(Omega R) and V cos(beta)/(Omega R) [-], infinite at rest.
    stalls : where some of the blade may stall.  islands : ``may_leave_islands``: two stretches of
    attached flow have four edges to follow.
    """

    advance: Floats
    climb: Floats
    stalls: NDArray[np.bool_]
    islands: NDArray[np.bool_]

    def stalling(self, points: NDArray[np.bool_]) -> Outlook:
        """The outlook on some of the points, stall now being known."""
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
    """Sort points into jobs.

    setting : nodes by advance ratio.  outlook : of these points, all (N,).  points : their
    indices in the batch (N,).  alike : whether all get the nodes that any may need and stall is
    followed everywhere: one program for all but islands, at a higher cost per point.
    axial_apart : whether axial flow, which needs a single azimuth, gets jobs of its own.
    descent : whether the programs are those that also serve descent.
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
        panels = Resolution(stations=nodes, follow_stall=bool(followed)).panels
        if four:
            panels = (nodes // ISLAND_PANELS + 2,) * ISLAND_PANELS
        highest = np.inf
        if followed and not alike:
            highest = FOLLOW_DESCENT_BELOW if descent else FOLLOW_BELOW
        elif not followed and not spread[mine[0]]:
            highest = REVERSED_ABOVE
        most = int(setting.azimuths_at(highest))
        jobs.append(Job(points[mine], panels, azimuths[mine], most))
    return jobs


def alike_panels(setting: Accuracy) -> tuple[int, ...]:
    """The panels that serve every point, but for islands."""
    return Resolution(stations=max(setting.stalled, setting.fast)).panels


def may_leave_islands(v_axial: Floats, v_hover: Floats | float) -> NDArray[np.bool_]:
    """Where attached flow may be left on two stretches of the blade, (N,): the windmill branch.

    v_axial = V cos(beta), v_hover : static inflow (12), (N,) [m/s].  In slower descent the
    vortex ring's inflow rules, or the in-plane flow keeps the blade attached.
    """
    return np.asarray(v_axial < np.minimum(WINDMILL_BELOW * v_hover, 0.0))


def may_stall(
    radius: Floats,
    solidity_slope: Floats,
    pitch: Floats,
    stall: tuple[float, float],
    omega: Floats,
    v_axial: Floats,
    v_inplane: Floats,
) -> NDArray[np.bool_]:
    """A forecast of where some of the blade stalls, from attached lift alone; (N,).

    radius, pitch (from the zero-lift line) : (S,) [m], [rad].
    solidity_slope : N_b c c_l1 / (8 pi y) (S,) [-].  stall : alpha_0 [rad] and M [1/rad].
    A wrong forecast costs time or is found out from the result, never accuracy.
    """
    forecast = np.empty(omega.size, bool)
    for start in range(0, omega.size, FORECAST_TOGETHER):
        part = slice(start, start + FORECAST_TOGETHER)
        flow = (omega[part], v_axial[part], v_inplane[part])
        advance = flow[2] / np.maximum(flow[0] * radius[-1], 1e-9)
        margin = (STALL_MARGIN[0] + STALL_MARGIN[1] * advance) / stall[1]
        limit = np.clip(stall[0] - margin, 0.0, np.pi)
        # Half as many bits take half of the time.
        asked = (limit, radius, solidity_slope, pitch, *flow)
        exceeds = _exceeds(*(values.astype(np.float32) for values in asked))
        forecast[part] = exceeds | (flow[1] < 0.0)
    return forecast


def _exceeds(
    limit: Singles,
    radius: Singles,
    solidity_slope: Singles,
    pitch: Singles,
    omega: Singles,
    v_axial: Singles,
    v_inplane: Singles,
) -> NDArray[np.bool_]:
    """Whether somewhere along the blade the angle of attack from zero lift, of either sign, is
    larger than ``limit`` (N,) [rad], between 0 and pi."""
    r, k, theta = radius[:, None], solidity_slope[:, None], pitch[:, None]
    turning = omega * r
    edgewise = v_inplane**2
    speed = np.sqrt(turning**2 + 0.5 * edgewise)
    pull = k * speed
    push = pull * (speed * theta - v_axial)
    least_wake = 0.5 * np.sqrt(np.maximum(k * theta, 0.0)) * turning
    through = np.zeros_like(turning) + v_axial
    for _ in range(4):
        # k U_T (U_T theta - through) = v_i W: blade elements and momentum, small angles.
        wake = np.maximum(np.sqrt(edgewise + through**2) + 1e-9, least_wake)
        through = v_axial + push / (wake + pull)
    # The cosine of an angle from 0 to pi falls with it: no arctangent, which is half of the time.
    along = np.cos(theta) * turning + np.sin(theta) * through
    past = along <= np.cos(limit) * np.sqrt(turning**2 + through**2)
    return np.asarray(past.any(axis=0))
