"""Target ``c``: a C99 header with the table, its query, gradient and inverse.

The header keeps the coefficients as the file does, in single precision at both ends of omega, and
extrapolates to no ghost values: their share is in the weights of the outermost intervals.  So a
point costs the memory of its sixteen knots alone.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propmap.export.folder import Files
from propmap.export.note import note
from propmap.export.provenance import identifier
from propmap.export.template import rendered
from propmap.loads import LOADS
from propmap.table.interpolation import (
    TableContent,
    cell_codes,
    interval_polynomials,
    on_planes,
    pad,
)
from propmap.table.query import END_SLACK, SLACK, LoadTable
from propmap.typing import Floats

MOST_BUCKETS = 1024

LINE = 96


def files(table: LoadTable) -> Files:
    """The header and its note."""
    return {f"{identifier(table)}.h": header(table), "README-c.txt": note(table, "c")}


def header(table: LoadTable) -> str:
    """The text of the header."""
    content, order = table.content, list(LOADS)
    root = float(content.omega[0]) ** -0.5
    codes = cell_codes(content)
    box = list(table.envelope.values())
    rows, columns, odd = _weights(content)
    row_bucket, row_per_bucket = _buckets(content.advance)
    column_bucket, column_per_bucket = _buckets(content.beta)
    return rendered(
        "table.h",
        table,
        content=content,
        kilobytes=round(table_bytes(content, 8) / 1000.0),
        box=box,
        end_slack=END_SLACK,
        slack=[SLACK * (high - low) for low, high in box],
        root=root,
        per_root=1.0 / (float(content.omega[1]) ** -0.5 - root),
        row_per_width=1.0 / np.diff(content.advance),
        column_per_width=1.0 / np.diff(content.beta),
        row_per_bucket=row_per_bucket,
        column_per_bucket=column_per_bucket,
        row_bucket=row_bucket,
        column_bucket=column_bucket,
        row_weights=rows,
        column_weights=columns,
        odd_weights=odd,
        cells=codes,
        data=_data(content),
        thrust=order.index("thrust"),
        torque=order.index("torque"),
        numbers=numbers,
        rows_of_numbers=rows_of_numbers,
    )


def table_bytes(content: TableContent, real: int) -> int:
    """Bytes of the header's tables, where its numbers have ``real`` bytes each.

    Parameters
    ----------
    content : TableContent
        Of the table.
    real : int
        8 or 4, in double or single precision; coefficients have 4 in both.
    """
    cells = (content.advance.size - 1) + (content.beta.size - 1)
    return content.coefficients.size * 4 + 16 * cells * real + content.cells.size


def _weights(content: TableContent) -> tuple[Floats, Floats, Floats]:
    """Weight polynomials (n - 1, 16) of the rows, of the columns, and (2, 16) of odd loads.

    The latter are those of the first and the last column interval.
    """
    ends = on_planes(content.beta)
    even, odd = (
        _folded(content.beta, *(np.array(parity) if on else None for on in ends))
        for parity in (1.0, -1.0)
    )
    return _folded(content.advance, None, None), even, odd[[0, -1]]


def _folded(knots: Floats, low: Floats | None, high: Floats | None) -> Floats:
    """Weight polynomials (n - 1, 16), powers first, of the values at the knots alone.

    ``low`` and ``high`` are parities at the ends, as for ``pad``.  A ghost value is a sum over
    the three knots at its end of the axis; its weight is spread over these.
    """
    weights = interval_polynomials(knots)
    ghosts = pad(knots, np.eye(knots.size), low, high)
    weights[0, 1:] += ghosts[0, :3, None] * weights[0, 0]
    weights[-1, :3] += ghosts[-1, -3:, None] * weights[-1, 3]
    weights[0, 0] = weights[-1, 3] = 0.0
    return weights.transpose(0, 2, 1).reshape(-1, 16)


def _buckets(knots: Floats) -> tuple[NDArray[np.intp], float]:
    """The interval in which each of many equal buckets begins, and buckets per unit.

    A hundredth of a bucket early, so that no rounding leads beyond the interval looked for.
    """
    count = min(MOST_BUCKETS, 4 * knots.size)
    width = float(knots[-1] - knots[0]) / count
    begin = knots[0] + width * (np.arange(count) - 0.01)
    return np.searchsorted(knots[1:-1], begin, side="right"), 1.0 / width


def _data(content: TableContent) -> str:
    """The coefficients, a line per knot, with as many digits as single precision has."""
    count = content.coefficients[:, :, 0, 0].size
    knots = content.coefficients.transpose(2, 3, 0, 1)
    knots = knots.reshape(*knots.shape[:2], count)
    rows = []
    for row in knots.astype(np.float32):
        lines = (", ".join(map(_single, knot)) for knot in row)
        rows.append("{\n" + ",\n".join(f"{{{line}}}" for line in lines) + "}")
    return ",\n".join(rows)


def _single(value: np.float32) -> str:
    return "NAN" if np.isnan(value) else f"{value!s}f"


def numbers(values: ArrayLike) -> str:
    """The ``values`` with commas, in lines of some length."""
    words = map(repr, np.asarray(values).tolist())
    return textwrap.fill(", ".join(words), LINE, break_long_words=False, break_on_hyphens=False)


def rows_of_numbers(rows: Iterable[ArrayLike]) -> str:
    """The same of an array with two axes, ``rows`` in braces."""
    return ",\n".join("{\n" + numbers(row) + "}" for row in rows)


def blocks_of_numbers(blocks: Iterable[Any]) -> str:
    """The same of an array with three axes or more."""
    return ",\n".join(
        "{\n" + (rows_of_numbers if np.ndim(block) == 2 else blocks_of_numbers)(block) + "}"
        for block in blocks
    )


def blocks_of_singles(blocks: Iterable[Iterable[Iterable[np.float32]]]) -> str:
    """The same of an array with three axes in single precision."""
    rows = (
        ",\n".join("{" + ", ".join(map(_single, row)) + "}" for row in block) for block in blocks
    )
    return ",\n".join("{\n" + block + "}" for block in rows)
