"""A section law from a table: C_L and C_D at angles all round and at Reynolds numbers."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from propmap.arrays.namespace import Array, by_numpy, xp
from propmap.arrays.types import Floats
from propmap.physics.geometry import pchip_slopes
from propmap.physics.sections.law import Coefficients, LawBounds, SectionFlow

ATTACHED = 0.9
"""Share of the largest lift, of either sign, up to which a section counts as attached."""

STALL_WIDTH = 0.01
"""[rad] over which a table's lift is taken to break down; what is sharper shows in the loads."""


class _Cubics(NamedTuple):
    """Cubics in the angle, per interval of the table."""

    lift: Array
    lift_by_log_re: Array
    drag: Array
    drag_by_log_re: Array


class TabulatedLaw(NamedTuple):
    """C_L and C_D by monotone cubics (PCHIP) in the angle and in ln Re, once differentiable.

    At the table's angles the values at its Reynolds numbers, and their slopes by ln Re, are
    joined by PCHIP in the angle; between two Reynolds numbers by the cubic with these values and
    slopes.  Outside the table's Reynolds numbers the nearest one holds: the slopes are zero there.

    Attributes
    ----------
    knots : Array
        Angles from zero lift [rad], rising from -pi to pi, (K + 1,).
    first : Array
        For each of equal steps of the angle, narrower than any two knots, the interval in which it
        begins, integers.
    rows : Array
        Coefficients of the cubics of C_L, dC_L/d ln Re, C_D, dC_D/d ln Re, lowest power first,
        for each Reynolds number and interval, (R K, 16).
    log_re : Array
        ln Re of the table, rising, (R,).
    zero_lift_angle : Array
        Angle of attack of zero lift [rad] at the middle one of the Reynolds numbers.
    drag_factor : Array
        Multiplies the rotor drag (14) [-].
    stall : Array
        Angles from zero lift about which lift breaks down [rad], at positive and at negative
        angles, for each Reynolds number, (2, R).
    limits : LawBounds
        Its bounds, from the cubics.
    """

    knots: Array
    first: Array
    rows: Array
    log_re: Array
    zero_lift_angle: Array
    drag_factor: Array
    stall: Array
    limits: LawBounds

    @property
    def parameters(self) -> tuple[str, ...]:
        """By what loads can be differentiated."""
        return ("zero_lift_angle", "drag_factor")

    def plus(self, **changes: Array) -> TabulatedLaw:
        """The law with ``changes`` added to its parameters of these names."""
        return self._replace(**{name: getattr(self, name) + d for name, d in changes.items()})

    def coefficients(self, flow: SectionFlow) -> Coefficients:
        """C_L and C_D at the angle and Reynolds number of a ``flow``, with derivatives."""
        intervals, count = self.knots.shape[0] - 1, self.first.shape[0]
        step = xp.clip((flow.angle + np.pi) * (count / (2.0 * np.pi)), 0, count - 1)
        k = self.first[xp.nan_to_num(step).astype(int)]
        k = k + (flow.angle >= self.knots[k + 1]) * (k < intervals - 1)
        along = flow.angle - self.knots[k]
        if self.log_re.shape[0] == 1:
            lift, _, drag, _ = _cubics(self.rows[k], along)
            return Coefficients(lift[0], drag[0], lift[1], drag[1], 0.0, 0.0)
        r, width, t = self._among_reynolds(flow.reynolds)
        below = _cubics(self.rows[r * intervals + k], along)
        above = _cubics(self.rows[(r + 1) * intervals + k], along)
        lift, drag = (_between(t, width, *below[n : n + 2], *above[n : n + 2]) for n in (0, 2))
        return Coefficients(
            lift=lift[0],
            drag=drag[0],
            lift_slope=lift[1],
            drag_slope=drag[1],
            lift_by_log_re=lift[2],
            drag_by_log_re=drag[2],
        )

    def attached_share(self, angle: Array) -> Array:
        """1 where ``angle`` [rad] is in the attached range, and falling beyond it."""
        law = self.limits
        beyond = xp.maximum(angle - law.attached_to, law.attached_from - angle)
        return xp.where(beyond > 0.0, 1.0 / (1.0 + (beyond / law.stall_width) ** 2), 1.0)

    def _among_reynolds(self, reynolds: Array) -> tuple[Array, Array, Array]:
        """Which interval of ln Re, how wide it is, and where in it, from 0 to 1."""
        log_re = xp.clip(xp.log(reynolds), self.log_re[0], self.log_re[-1])
        r = xp.sum(log_re[..., None] >= self.log_re[1:-1], axis=-1)
        width = self.log_re[r + 1] - self.log_re[r]
        return r, width, (log_re - self.log_re[r]) / width

    def stall_angle(self, reynolds: Array, side: Array) -> Array:
        """That of the nearest Reynolds numbers [rad], on a ``side``; see ``SectionLaw``."""
        up, down = self.stall
        if self.log_re.shape[0] == 1:
            return xp.where(side > 0.0, up[0], down[0]) + 0.0 * reynolds
        r, _, t = self._among_reynolds(reynolds)
        above, below = (one[r] + t * (one[r + 1] - one[r]) for one in (up, down))
        return xp.where(side > 0.0, above, below)

    def bounds(self) -> LawBounds:
        """Bounds found from the cubics when the law was made."""
        return self.limits


def _cubics(rows: Array, along: Array) -> _Cubics:
    """Values and slopes by the angle, ``along`` [rad] past the interval's start."""
    c = xp.moveaxis(rows, -1, 0)

    def at(n: int) -> Array:
        value = c[n] + along * (c[n + 1] + along * (c[n + 2] + along * c[n + 3]))
        slope = c[n + 1] + along * (2.0 * c[n + 2] + along * 3.0 * c[n + 3])
        return xp.stack([value, slope])

    return _Cubics(at(0), at(4), at(8), at(12))


def _between(t: Array, width: Array, f0: Array, m0: Array, f1: Array, m1: Array) -> Array:
    """The cubic in ln Re: its value, slope by the angle, and slope by ln Re; t from 0 to 1."""
    rise = f1 - f0
    a, b = width * m0, width * m1
    c2, c3 = 3.0 * rise - 2.0 * a - b, a + b - 2.0 * rise
    here = f0 + t * (a + t * (c2 + t * c3))
    by_log_re = (a[0] + t * (2.0 * c2[0] + t * 3.0 * c3[0])) / width
    return xp.stack([here[0], here[1], by_log_re])


def tabulated_law(
    angle: Floats,
    reynolds: Floats,
    lift: Floats,
    drag: Floats,
    *,
    drag_factor: float = 1.0,
) -> TabulatedLaw:
    """A law from a table.

    Parameters
    ----------
    angle : ndarray
        Angles of attack from the chord line [rad], rising from -pi to pi, (K + 1,).
    reynolds : ndarray
        Reynolds numbers, rising, (R,).
    lift, drag : ndarray
        C_L and C_D [-], (R, K + 1); the same at -pi and pi.
    drag_factor : float
        Multiplies the rotor drag (14).
    """
    with by_numpy():
        middle = lift[len(reynolds) // 2]
        zero = _zero_lift_angle(angle, middle)
        # The table turned so that it begins at -pi from zero lift.
        turned = _turned(angle, np.concatenate([lift, drag]), zero)
        knots, lift, drag = turned[0], turned[1 : 1 + len(reynolds)], turned[1 + len(reynolds) :]
        log_re = np.log(np.asarray(reynolds, dtype=np.float64))
        by_log_re = [_slopes_along_re(log_re, values) for values in (lift, drag)]
        tables = np.stack([lift, by_log_re[0], drag, by_log_re[1]])
        cubics = np.stack([[_pchip(knots, row) for row in values] for values in tables])
        count = int(np.ceil(2.0 * np.pi / (0.999 * np.diff(knots).min())))
        starts = -np.pi + 2.0 * np.pi * np.arange(count) / count
        first = np.clip(np.searchsorted(knots, starts, side="right") - 1, 0, len(knots) - 2)
        # (4, R, K, 4) to rows (R K, 16).
        rows = cubics.transpose(1, 2, 0, 3).reshape(-1, 16)
        stall = _stall_angles(knots, lift)
        limits = _bounds(knots, log_re, cubics, lift, stall)
        scalars = (np.float64(zero), np.float64(drag_factor))
        arrays: Any = (knots, first, rows, log_re, *scalars, stall, limits)
        return TabulatedLaw(*arrays)


def _zero_lift_angle(angle: Floats, lift: Floats) -> float:
    """Where the lift passes zero, rising, nearest to zero angle [rad]."""
    k = np.flatnonzero((lift[:-1] <= 0.0) & (lift[1:] > 0.0))
    share = -lift[k] / (lift[k + 1] - lift[k])
    zeros = angle[k] + share * (angle[k + 1] - angle[k])
    return float(zeros[np.argmin(np.abs(zeros))])


def _turned(angle: Floats, values: Floats, zero: float) -> Floats:
    """Angles from ``zero`` between -pi and pi, and the periodic ``values`` there, stacked."""
    inner = (angle[:-1] - zero + np.pi) % (2.0 * np.pi) - np.pi
    order = np.argsort(inner)
    x, y = inner[order], values[:, :-1][:, order]
    if x[0] > -np.pi:
        gap = x[0] + 2.0 * np.pi - x[-1]
        share = (np.pi - x[-1]) / gap
        end = y[:, -1:] + share * (y[:, :1] - y[:, -1:])
        x, y = np.concatenate([[-np.pi], x, [np.pi]]), np.concatenate([end, y, end], axis=1)
    else:
        x, y = np.concatenate([x, [np.pi]]), np.concatenate([y, y[:, :1]], axis=1)
    return np.concatenate([x[None], y])


def _slopes_along_re(log_re: Floats, values: Floats) -> Floats:
    """Slopes by ln Re (R, K), zero at both ends."""
    slopes = np.zeros_like(values)
    if len(log_re) > 2:
        slopes[1:-1] = np.stack([pchip_slopes(log_re, column) for column in values.T], axis=1)[1:-1]
    return slopes


def _pchip(x: Floats, y: Floats) -> Floats:
    """Cubics of each interval in the distance from its start, lowest power first, (K, 4)."""
    h, slope = np.diff(x), pchip_slopes(x, y)
    rise = np.diff(y) / h
    m0, m1 = slope[:-1], slope[1:]
    c2, c3 = (3.0 * rise - 2.0 * m0 - m1) / h, (m0 + m1 - 2.0 * rise) / h**2
    return np.stack([y[:-1], m0, c2, c3], axis=1)


class _Largest(NamedTuple):
    """Sizes over the cubics of one coefficient, (R, K) each, and what Re adds to bends."""

    value: Floats
    slope: Floats
    bend: Floats  # at both ends of an interval, signed, (R, K, 2)
    by_log_re: float  # |C_l| + |C_l'| + |C_ll|


def _largest(knots: Floats, log_re: Floats, cubics: Floats) -> _Largest:
    """Of the cubics (R, K, 4)."""
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
        # A monotone cubic is at most 3 times as steep as its chord, and bends by 12 chords/width.
        width = np.diff(log_re)[:, None]
        chord = np.abs(np.diff(cubics[..., 0], axis=0)) / width
        tilt = np.abs(np.diff(cubics[..., 1], axis=0)) / width
        along = float(3.0 * chord.max() + 3.0 * tilt.max() + 12.0 * (chord / width).max())
    return _Largest(value, slope, 2.0 * c2 + 6.0 * ends * c3, along)


def _bounds(
    knots: Floats, log_re: Floats, cubics: Floats, lift: Floats, stall: Floats
) -> LawBounds:
    """Bounds from the cubics (4, R, K, 4) of C_L, its slope by ln Re, C_D and its slope."""
    of_lift, lift_more, of_drag, drag_more = (_largest(knots, log_re, c) for c in cubics)
    # What slopes by ln Re add between two Reynolds numbers: at most 4/27 of each, times the gap.
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
        # A table is never quite concave; zero would say that it is.
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


def _stall_angles(knots: Floats, lift: Floats) -> Floats:
    """Angle from zero lift of each table's first peak of lift, upwards and downwards [rad]; (2, R).

    Not of the largest lift: at low Reynolds numbers a plate at 45 deg may have more.
    """
    found = np.empty((2, len(lift)))
    middle = int(np.searchsorted(knots, 0.0))
    for r, row in enumerate(lift):
        up, down = row[middle:], -row[:middle][::-1]
        found[0, r] = knots[middle + _first_peak(up)]
        found[1, r] = knots[middle - 1 - _first_peak(down)]
    return found


def _first_peak(lift: Floats) -> int:
    """Where lift (K,) first falls from a positive value; the last entry if it does not."""
    falls = np.flatnonzero((lift[:-1] > 0.0) & (np.diff(lift) < 0.0))
    return int(falls[0]) if falls.size else len(lift) - 1


def _attached_range(knots: Floats, lift: Floats, stall: Floats) -> tuple[float, float]:
    """Between which angles from zero lift all tables are attached [rad]."""
    low, high = -np.pi, np.pi
    for row, (up, down) in zip(lift, stall.T, strict=True):
        rising, falling = (knots >= 0.0) & (knots <= up), (knots <= 0.0) & (knots >= down)
        top, bottom = row[knots == up][0], row[knots == down][0]
        high = min(high, float(np.interp(ATTACHED * top, row[rising], knots[rising])))
        low = max(low, float(np.interp(ATTACHED * bottom, row[falling], knots[falling])))
    return low, high
