"""Bounds and stall angles of a tabulated section law, from its cubics."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from propmap.physics.sections.law import LawBounds
from propmap.typing import Floats

ATTACHED = 0.9
"""Share of the lift at stall, of either sign, up to which a section counts as attached."""

STALL_WIDTH = 0.014
"""Assumed width of stall in a table [rad]; a sharper stall shows as a large tail of the loads."""


class _Largest(NamedTuple):
    """Largest absolute values over the cubics of one coefficient, (R, K) unless said otherwise."""

    value: Floats
    slope: Floats
    bend: Floats  # second derivatives at both ends of an interval, signed, (R, K, 2)
    by_log_re: float  # bound of |C_l| + |C_l'| + |C_ll|, see ``LawBounds``


def _largest(knots: Floats, log_re: Floats, cubics: Floats) -> _Largest:
    """``_Largest`` of the cubics (R, K, 4)."""
    h = np.diff(knots)[:, None]
    c0, c1, c2, c3 = (cubics[..., n, None] for n in range(4))
    ends = np.concatenate([0.0 * h, h], axis=1)
    # The slope is largest at an end or where the second derivative is zero.
    turn = np.clip(-c2 / np.where(c3 == 0.0, np.inf, 3.0 * c3), 0.0, h)
    places = np.concatenate([np.broadcast_to(ends, (*c0.shape[:-1], 2)), turn], axis=-1)
    slope = np.abs(c1 + places * (2.0 * c2 + 3.0 * places * c3)).max(axis=-1)
    value = np.abs(c0 + ends * (c1 + ends * (c2 + ends * c3))).max(axis=-1)
    along = 0.0
    if len(log_re) > 1:
        # With a chord of slope s a monotone cubic has |f'| <= 3 s and |f''| <= 12 s / width.
        width = np.diff(log_re)[:, None]
        chord = np.abs(np.diff(cubics[..., 0], axis=0)) / width
        tilt = np.abs(np.diff(cubics[..., 1], axis=0)) / width
        along = float(3.0 * chord.max() + 3.0 * tilt.max() + 12.0 * (chord / width).max())
    return _Largest(value, slope, 2.0 * c2 + 6.0 * ends * c3, along)


def table_bounds(
    knots: Floats, log_re: Floats, cubics: Floats, lift: Floats, stall: Floats
) -> LawBounds:
    """Bounds from the cubics (4, R, K, 4) of C_L, dC_L/d ln Re, C_D and dC_D/d ln Re."""
    of_lift, lift_more, of_drag, drag_more = (_largest(knots, log_re, c) for c in cubics)
    # Between two Reynolds numbers each slope by ln Re adds at most 4/27 of itself times the gap.
    reach = 0.3 * np.diff(log_re).max(initial=0.0)

    def largest(name: str, one: _Largest, more: _Largest) -> float:
        return float(np.abs(getattr(one, name)).max() + reach * np.abs(getattr(more, name)).max())

    lift_bend = largest("bend", of_lift, lift_more) + of_lift.by_log_re
    drag, drag_slope, drag_bend = (
        largest(name, of_drag, drag_more) for name in ("value", "slope", "bend")
    )
    low, high = _attached_range(knots, lift, stall)
    inside = (knots[1:] > low) & (knots[:-1] < high)
    upwards = max(float(of_lift.bend[:, inside].max(initial=0.0)), 0.0)
    upwards += reach * float(np.abs(lift_more.bend).max()) + of_lift.by_log_re
    limits = {
        "lift": largest("value", of_lift, lift_more),
        "lift_bend": lift_bend,
        "foot_bend": lift_bend,
        # Never zero, which would say that C_L is concave: no table is exactly so.
        "attached_bend": upwards + 1e-9,
        "drag_bend": 3.0 * drag + drag_bend + 2.0 * drag_slope + 3.0 * of_drag.by_log_re,
        "friction": 0.0,
        "attached_from": low,
        "attached_to": high,
        "attached_slope": float(np.mean([np.interp(high, knots, row) for row in lift])) / high,
        "least_stall_angle": stall[0].min(),
        "stall_width": STALL_WIDTH,
    }
    scalars: Any = {name: np.float64(value) for name, value in limits.items()}
    return LawBounds(**scalars)


def stall_angles(knots: Floats, lift: Floats) -> Floats:
    """Angles [rad] of the first peak of lift above and below zero lift, at each Re; (2, R).

    The largest lift may be elsewhere: at low Reynolds numbers it may be that at 45 deg.
    """
    found = np.empty((2, len(lift)))
    middle = int(np.searchsorted(knots, 0.0))
    for r, row in enumerate(lift):
        up, down = row[middle:], -row[:middle][::-1]
        found[0, r] = knots[middle + _first_peak(up)]
        found[1, r] = knots[middle - 1 - _first_peak(down)]
    return found


def _first_peak(lift: Floats) -> int:
    """Index at which lift (K,) first falls from a positive value; the last one if it never does."""
    falls = np.flatnonzero((lift[:-1] > 0.0) & (np.diff(lift) < 0.0))
    return int(falls[0]) if falls.size else len(lift) - 1


def _attached_range(knots: Floats, lift: Floats, stall: Floats) -> tuple[float, float]:
    """Angles from zero lift between which flow is attached at every Reynolds number [rad]."""
    low, high = -np.pi, np.pi
    for row, (up, down) in zip(lift, stall.T, strict=True):
        rising, falling = (knots >= 0.0) & (knots <= up), (knots <= 0.0) & (knots >= down)
        top, bottom = row[knots == up][0], row[knots == down][0]
        high = min(high, float(np.interp(ATTACHED * top, row[rising], knots[rising])))
        low = max(low, float(np.interp(ATTACHED * bottom, row[falling], knots[falling])))
    return low, high
