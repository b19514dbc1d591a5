"""A section law from a table of C_L and C_D over +-180 deg and Reynolds numbers."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from propmap.arrays.namespace import Array, by_numpy, xp
from propmap.physics.geometry import pchip_slopes
from propmap.physics.sections.law import Coefficients, LawBounds, SectionFlow
from propmap.physics.sections.table_bounds import stall_angles, table_bounds
from propmap.typing import Floats


class _Cubics(NamedTuple):
    """Values and slopes of the four cubics of an interval."""

    lift: Array
    lift_by_log_re: Array
    drag: Array
    drag_by_log_re: Array


class TabulatedLaw(NamedTuple):
    """C_L and C_D by monotone cubics (PCHIP) in the angle and in ln Re, once differentiable.

    At each Reynolds number of the table PCHIP in the angle gives the coefficients and their slopes
    by ln Re.  Between two Reynolds numbers the cubic with these values and slopes is taken.
    Outside the table's range the nearest Reynolds number holds; slopes by ln Re are zero there.

    Attributes
    ----------
    knots : Array
        Angles from zero lift [rad], rising from -pi to pi, (K + 1,).
    first : Array
        Look-up of the interval: the circle is divided into equal steps, shorter than any interval;
        for each the index of the interval in which it begins.
    rows : Array
        Coefficients of the cubics of C_L, dC_L/d ln Re, C_D, dC_D/d ln Re, lowest power first,
        for each Reynolds number and interval, (R K, 16).
    log_re : Array
        ln Re of the table, rising, (R,).
    zero_lift_angle : Array
        Angle of attack of zero lift [rad], at the middle one of the Reynolds numbers.
    drag_factor : Array
        Multiplies the rotor drag (14) [-].
    stall : Array
        Stall angles from zero lift [rad], the positive and the negative one at each Reynolds
        number, (2, R).
    limits : LawBounds
        Bounds on the law, from the cubics.
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
        """Names of the parameters with respect to which loads can be differentiated."""
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

    def zero_lift_at(self, reynolds: Array) -> Array:  # noqa: ARG002 - as every law
        """``zero_lift_angle`` [rad], at any ``reynolds``."""
        return self.zero_lift_angle

    @property
    def least_drag_angle(self) -> Array | None:
        """None: the table has its drag over the same angle as its lift."""
        return None

    def attached_share(self, angle: Array) -> Array:
        """1 where ``angle`` [rad] is in the attached range; it falls off outside."""
        law = self.limits
        beyond = xp.maximum(angle - law.attached_to, law.attached_from - angle)
        return xp.where(beyond > 0.0, 1.0 / (1.0 + (beyond / law.stall_width) ** 2), 1.0)

    def _among_reynolds(self, reynolds: Array) -> tuple[Array, Array, Array]:
        """Interval of ln Re, its width, and the place in it from 0 to 1."""
        log_re = xp.clip(xp.log(reynolds), self.log_re[0], self.log_re[-1])
        r = xp.sum(log_re[..., None] >= self.log_re[1:-1], axis=-1)
        width = self.log_re[r + 1] - self.log_re[r]
        return r, width, (log_re - self.log_re[r]) / width

    def stall_angle(self, reynolds: Array, side: Array) -> Array:
        """Stall angle [rad] on a ``side``, linear in ln ``reynolds``; see ``SectionLaw``."""
        up, down = self.stall
        if self.log_re.shape[0] == 1:
            return xp.where(side > 0.0, up[0], down[0]) + 0.0 * reynolds
        r, _, t = self._among_reynolds(reynolds)
        above, below = (one[r] + t * (one[r + 1] - one[r]) for one in (up, down))
        return xp.where(side > 0.0, above, below)

    def bounds(self) -> LawBounds:
        """Bounds on the coefficients, found when the law was made."""
        return self.limits


def _cubics(rows: Array, along: Array) -> _Cubics:
    """Values and slopes by the angle at ``along`` [rad] from the interval's start."""
    c = xp.moveaxis(rows, -1, 0)

    def at(n: int) -> Array:
        value = c[n] + along * (c[n + 1] + along * (c[n + 2] + along * c[n + 3]))
        slope = c[n + 1] + along * (2.0 * c[n + 2] + along * 3.0 * c[n + 3])
        return xp.stack([value, slope])

    return _Cubics(at(0), at(4), at(8), at(12))


def _between(t: Array, width: Array, f0: Array, m0: Array, f1: Array, m1: Array) -> Array:
    """The cubic in ln Re at t from 0 to 1: value, slope by the angle, slope by ln Re."""
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
        C_L and C_D [-], (R, K + 1); equal at -pi and pi.
    drag_factor : float
        Multiplies the rotor drag (14).
    """
    with by_numpy():
        middle = lift[len(reynolds) // 2]
        zero = _zero_lift_angle(angle, middle)
        # Measure angles from zero lift, and let the table begin at -pi from there.
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
        stall = stall_angles(knots, lift)
        limits = table_bounds(knots, log_re, cubics, lift, stall)
        scalars = (np.float64(zero), np.float64(drag_factor))
        arrays: Any = (knots, first, rows, log_re, *scalars, stall, limits)
        return TabulatedLaw(*arrays)


def _zero_lift_angle(angle: Floats, lift: Floats) -> float:
    """The angle [rad] at which lift rises through zero; of several, the one nearest to zero."""
    k = np.flatnonzero((lift[:-1] <= 0.0) & (lift[1:] > 0.0))
    share = -lift[k] / (lift[k + 1] - lift[k])
    zeros = angle[k] + share * (angle[k + 1] - angle[k])
    return float(zeros[np.argmin(np.abs(zeros))])


def _turned(angle: Floats, values: Floats, zero: float) -> Floats:
    """Angles from ``zero``, rising from -pi to pi, and the periodic ``values`` there, stacked."""
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
    """Slopes by ln Re (R, K), zero at the lowest and the highest Reynolds number."""
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
