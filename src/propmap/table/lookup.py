"""Coefficients of a table, and their slopes, at an advance ratio and an angle."""

from __future__ import annotations

from bisect import bisect_right
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.loads import LOADS
from propmap.table.axis import interval_polynomials, locate
from propmap.table.content import TableContent
from propmap.typing import Floats

STATUSES = ("ok", "vortex_ring", "unresolved", "clamped", "no_value", "outside")
"""What a code stands for, from harmless to fatal; where several apply, the last is given."""

OK, VORTEX_RING, UNRESOLVED, CLAMPED, NO_VALUE, OUTSIDE = range(len(STATUSES))

WIDTH = 2 * len(LOADS)
"""Values per knot: each load over Omega^2, and their slopes with Omega^(-1/2)."""


def cell_codes(content: TableContent) -> NDArray[np.uint8]:
    """``OK``, ``VORTEX_RING`` or ``UNRESOLVED`` for each cell (n - 1, m - 1)."""
    return np.array([OK, VORTEX_RING, UNRESOLVED, UNRESOLVED], np.uint8)[content.cells]


class Lookup:
    """A table's coefficients, laid out for speed.

    The four values along beta of one row of knots follow each other in memory, so that one
    interpolation gathers four runs of 4 x ``WIDTH`` numbers.
    """

    def __init__(self, content: TableContent) -> None:
        self.padded = content.padded()
        self.row = self.padded.shape[1]
        self._rows = self.padded.reshape(self.padded.shape[0], -1)
        runs = (self.padded.size // WIDTH - 3, 4 * WIDTH)
        step = self.padded.itemsize
        self._runs = np.lib.stride_tricks.as_strided(
            self.padded, runs, (WIDTH * step, step), writeable=False
        )
        self._advance, self._beta = content.advance, content.beta
        self._powers = [
            np.ascontiguousarray(interval_polynomials(knots).transpose(2, 0, 1))
            for knots in (content.advance, content.beta)
        ]
        # Plain Python numbers are several times as fast as NumPy's for a single point.
        self._advance_list, self._beta_list = content.advance.tolist(), content.beta.tolist()
        self._inner = self._advance_list[1:-1], self._beta_list[1:-1]
        self._weights = [interval_polynomials(k).tolist() for k in (content.advance, content.beta)]
        self._codes = cell_codes(content)
        self._codes_list: list[list[int]] = self._codes.tolist()

    def point(
        self, advance: float, beta: float, square: float, friction: float
    ) -> tuple[list[float], int]:
        """The loads and the cell's code at one point of the table.

        ``square`` is Omega^2, ``friction`` that times the change of Omega^(-1/2) from the least.
        """
        i = bisect_right(self._inner[0], advance)
        j = bisect_right(self._inner[1], beta)
        x0, y0 = self._advance_list[i], self._beta_list[j]
        t = (advance - x0) / (self._advance_list[i + 1] - x0)
        u = (beta - y0) / (self._beta_list[j + 1] - y0)
        (a0, a1, a2, a3), (b0, b1, b2, b3), (c0, c1, c2, c3), (d0, d1, d2, d3) = self._weights[0][i]
        across = np.array(
            (
                a0 + t * (a1 + t * (a2 + t * a3)),
                b0 + t * (b1 + t * (b2 + t * b3)),
                c0 + t * (c1 + t * (c2 + t * c3)),
                d0 + t * (d1 + t * (d2 + t * d3)),
            )
        )
        (a0, a1, a2, a3), (b0, b1, b2, b3), (c0, c1, c2, c3), (d0, d1, d2, d3) = self._weights[1][j]
        a = a0 + u * (a1 + u * (a2 + u * a3))
        b = b0 + u * (b1 + u * (b2 + u * b3))
        c = c0 + u * (c1 + u * (c2 + u * c3))
        d = d0 + u * (d1 + u * (d2 + u * d3))
        s, f = square, friction
        along = np.array((s * a, f * a, s * b, f * b, s * c, f * c, s * d, f * d))
        block = self._rows[i : i + 4, WIDTH * j : WIDTH * j + 4 * WIDTH]
        loads = along.dot(across.dot(block).reshape(8, -1))
        return loads.tolist(), self._codes_list[i][j]

    def points(self, advance: Floats, beta: Floats) -> tuple[Floats, NDArray[np.uint8]]:
        """The values (n, ``WIDTH``) and the cells' codes (n,) at n points of the table."""
        i, t = locate(self._advance, advance)
        j, u = locate(self._beta, beta)
        rows = self._gather(i, j)
        across = self._at(0, i, t)[:, None, :]
        along = self._at(1, j, u)[:, None, :]
        values = np.matmul(along, np.matmul(across, rows).reshape(-1, 4, WIDTH))
        return values[:, 0], self._codes[i, j]

    def slopes(self, advance: Floats, beta: Floats) -> Floats:
        """Values and derivatives (n, 2, 2, ``WIDTH``).

        [:, 0, 0] the values, [:, 1, 0] their derivatives with the advance ratio, [:, 0, 1] with
        beta, [:, 1, 1] with both.
        """
        i, t = locate(self._advance, advance)
        j, u = locate(self._beta, beta)
        width = self._advance[i + 1] - self._advance[i], self._beta[j + 1] - self._beta[j]
        across = np.stack([self._at(0, i, t), self._slope(0, i, t, width[0])], axis=1)
        along = np.stack([self._at(1, j, u), self._slope(1, j, u, width[1])], axis=1)
        partly = np.matmul(across, self._gather(i, j)).reshape(-1, 2, 4, WIDTH)
        return np.asarray(np.matmul(along[:, None], partly))

    def _gather(self, i: NDArray[np.intp], j: NDArray[np.intp]) -> Floats:
        first = i * self.row + j
        return self._runs[first[:, None] + np.arange(0, 4 * self.row, self.row)]

    def _at(self, axis: int, interval: NDArray[np.intp], share: Floats) -> Floats:
        c0, c1, c2, c3 = (power[interval] for power in self._powers[axis])
        t = share[:, None]
        return np.asarray(c0 + t * (c1 + t * (c2 + t * c3)))

    def _slope(self, axis: int, interval: NDArray[np.intp], share: Floats, width: Any) -> Floats:
        _, c1, c2, c3 = (power[interval] for power in self._powers[axis])
        t = share[:, None]
        return np.asarray((c1 + t * (2.0 * c2 + t * 3.0 * c3)) / width[:, None])
