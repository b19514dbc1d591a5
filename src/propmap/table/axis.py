"""One axis of a table: cubic interpolation between knots at any distances, C1.

Between two knots runs the cubic Hermite polynomial whose slopes are those of the parabola
through each knot and its neighbours, so that four values decide: those at the interval's ends
and one further on either side.  At the ends of the axis a ghost value stands in for the fourth.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propmap.typing import Floats


def interval_polynomials(knots: Floats) -> Floats:
    """Coefficients (n - 1, 4, 4) of the four weights in each interval between n >= 3 knots.

    The weight of the k-th of the four values in interval i, at the share t of its width, is the
    sum over m of coefficients[i, k, m] t^m.
    """
    wide = with_ghosts(knots)
    before, width, after = wide[1:-2] - wide[:-3], wide[2:-1] - wide[1:-2], wide[3:] - wide[2:-1]
    zero = np.zeros_like(width)
    # Slopes of the parabolas at both ends, times the width, as weights of the four values.
    left = _parabola_slope(before, width)
    right = _parabola_slope(width, after)
    first = width * np.stack([*left, zero])
    second = width * np.stack([zero, *right])
    start = np.stack([zero, zero + 1.0, zero, zero])
    rise = np.stack([zero, zero - 1.0, zero + 1.0, zero])
    powers = [start, first, 3.0 * rise - 2.0 * first - second, first + second - 2.0 * rise]
    return np.ascontiguousarray(np.stack(powers).transpose(2, 1, 0))


def with_ghosts(knots: Floats) -> Floats:
    """The knots and one more on either side, as far out as the next one is inside; (n + 2,)."""
    return np.concatenate(
        [[2.0 * knots[0] - knots[1]], knots, [2.0 * knots[-1] - knots[-2]]], dtype=np.float64
    )


def on_planes(beta: Floats) -> tuple[bool, bool]:
    """Whether the first and the last angle [rad] are on the axis, where loads are even or odd."""
    return bool(abs(beta[0]) < 1e-9), bool(abs(beta[-1] - np.pi) < 1e-9)


def pad(knots: Floats, values: Floats, low: Floats | None, high: Floats | None) -> Floats:
    """Values (n, ...) with a ghost value on either side; (n + 2, ...).

    Where the axis ends on a plane of symmetry, ``low`` and ``high`` are the parity of the values,
    1 for even and -1 for odd; where they are None the ghost is on the parabola of the last three.
    """
    wide = with_ghosts(knots)
    ghosts = []
    for parity, ends, ghost in ((low, slice(0, 3), wide[0]), (high, slice(-1, -4, -1), wide[-1])):
        x, y = knots[ends], values[ends]
        if parity is None:
            ghosts.append(np.tensordot(_parabola(x, ghost), y, 1))
        else:
            ghosts.append(parity * y[1])
    return np.concatenate([ghosts[0][None], values, ghosts[1][None]])


def locate(knots: Floats, x: Floats) -> tuple[NDArray[np.intp], Floats]:
    """Interval (n,) that holds each x, and the share of its width that lies below x."""
    i = np.searchsorted(knots[1:-1], x, side="right")
    return i, (x - knots[i]) / (knots[i + 1] - knots[i])


def interpolate(knots: Floats, padded: Floats, x: Floats) -> Floats:
    """Values (m, ...) at x (m,) of padded values (n + 2, ...), along the first axis."""
    i, t = locate(knots, x)
    weights = np.einsum("akm,am->ak", interval_polynomials(knots)[i], t[:, None] ** np.arange(4))
    rows = padded[i[:, None] + np.arange(4)]
    return np.asarray(np.einsum("ak,ak...->a...", weights, rows))


def _parabola_slope(before: Floats, after: Floats) -> tuple[Floats, Floats, Floats]:
    """Weights of three values in the slope at the middle one, at these distances."""
    both = before + after
    return -after / (before * both), (after - before) / (before * after), before / (after * both)


def _parabola(x: Floats, at: float) -> Floats:
    a, b, c = x.tolist()
    return np.array(
        [
            (at - b) * (at - c) / ((a - b) * (a - c)),
            (at - a) * (at - c) / ((b - a) * (b - c)),
            (at - a) * (at - b) / ((c - a) * (c - b)),
        ]
    )
