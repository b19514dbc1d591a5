"""Target ``c``: a C99 header with the table, its query, gradient and inverse.

The header keeps the coefficients as the file does, in single precision at both ends of omega, and
extrapolates to no ghost values: their share is in the weights of the outermost intervals.  So a
point costs the memory of its sixteen knots alone.
"""

from __future__ import annotations

import importlib.resources
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.export.folder import Files
from propmap.export.note import note
from propmap.export.provenance import c_comment, identifier, provenance
from propmap.table.axis import interval_polynomials, pad
from propmap.table.content import TableContent
from propmap.table.inverse import END_SLACK
from propmap.table.lookup import cell_codes
from propmap.table.query import SLACK, LoadTable

MOST_BUCKETS = 1024

LINE = 96


def files(table: LoadTable) -> Files:
    """The header and its note."""
    name = identifier(table)
    paragraphs = [
        f"{name}.h holds the map itself, in C99, without heap and without any data that change; "
        "what it offers stands at its top. It computes in double precision, or in single where "
        f"{name.upper()}_FLOAT is defined before it is included.",
        "In double precision it agrees with propmap.table to 1e-12 of the static loads, in "
        "single precision to 1e-5; next to the border between two cells, single precision may "
        "find the status of the other one.",
    ]
    return {f"{name}.h": header(table), "README-c.txt": note(table, "c", paragraphs)}


def header(table: LoadTable) -> str:
    """The text of the header."""
    content = table.content
    name = identifier(table)
    root = float(content.omega[0]) ** -0.5
    per_root = 1.0 / (float(content.omega[1]) ** -0.5 - root)
    codes = cell_codes(content)
    box = list(table.envelope.values())
    rows, columns, odd = _weights(content)
    row_bucket, row_per_bucket = _buckets(content.advance)
    column_bucket, column_per_bucket = _buckets(content.beta)
    size = content.coefficients.size * 4 + (rows.size + columns.size) * 8 + codes.size
    parts = {
        "kilobytes": str(round(size / 1000.0)),
        "rows": str(content.advance.size),
        "columns": str(content.beta.size),
        "radius": repr(content.radius),
        "box": ",\n".join(f"    {{{low!r}, {high!r}}}" for low, high in box),
        "end_slack": repr(END_SLACK),
        "slack": ", ".join(repr(SLACK * (high - low)) for low, high in box),
        "scale": ", ".join(map(repr, content.scale.tolist())),
        "root": repr(root),
        "per_root": repr(per_root),
        "row_knots": _lines(map(repr, content.advance.tolist())),
        "column_knots": _lines(map(repr, content.beta.tolist())),
        "row_per_width": _lines(map(repr, (1.0 / np.diff(content.advance)).tolist())),
        "column_per_width": _lines(map(repr, (1.0 / np.diff(content.beta)).tolist())),
        "row_buckets": str(row_bucket.size),
        "column_buckets": str(column_bucket.size),
        "row_per_bucket": repr(row_per_bucket),
        "column_per_bucket": repr(column_per_bucket),
        "row_bucket": _lines(map(str, row_bucket.tolist())),
        "column_bucket": _lines(map(str, column_bucket.tolist())),
        "row_weights": _groups(rows),
        "column_weights": _groups(columns),
        "odd_weights": _groups(odd),
        "cells": ",\n".join("{\n" + _lines(map(str, row)) + "}" for row in codes.tolist()),
        "data": _data(content),
        "title": f"Loads of the propeller {name}, a table of propmap.",
        # Last: what the user wrote is in it.
        "comment": c_comment(provenance(table)),
    }
    text = importlib.resources.files("propmap.export").joinpath("c_header.h.in").read_text("utf-8")
    text = text.replace("@p@", name).replace("@P@", name.upper())
    for key, value in parts.items():
        text = text.replace(f"@{key}@", value)
    return text


def _weights(content: TableContent) -> tuple[Floats, Floats, Floats]:
    """Weight polynomials (n - 1, 16) of the rows, of the columns, and (2, 16) of odd loads.

    The latter are those of the first and the last column interval.
    """
    ends = [
        abs(end - axis) < 1e-9 for end, axis in ((content.beta[0], 0.0), (content.beta[-1], np.pi))
    ]
    even, odd = (
        _folded(content.beta, *(np.array(parity) if end else None for end in ends))
        for parity in (1.0, -1.0)
    )
    return _folded(content.advance, None, None), even, odd[[0, -1]]


def _folded(knots: Floats, low: Floats | None, high: Floats | None) -> Floats:
    """Weight polynomials (n - 1, 16), powers first, of the values at the knots alone.

    low, high : parities at the ends, as for ``pad``.  A ghost value is a sum over the three
    knots at its end of the axis; its weight is spread over these.
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
    knots = content.coefficients.transpose(2, 3, 0, 1).reshape(
        content.advance.size, content.beta.size, 8
    )
    rows = []
    for row in knots.astype(np.float32):
        lines = (", ".join(map(_single, knot)) for knot in row)
        rows.append("{\n" + ",\n".join(f"{{{line}}}" for line in lines) + "}")
    return ",\n".join(rows)


def _single(value: np.float32) -> str:
    text = str(value)
    if text == "nan":
        return "NAN"
    return f"{text}f"


def _groups(weights: Floats) -> str:
    return ",\n".join("{\n" + _lines(map(repr, row)) + "}" for row in weights.tolist())


def _lines(words: Iterable[str]) -> str:
    """Words with commas, in lines of some length."""
    lines, line = [], ""
    for word in words:
        if line and len(line) + len(word) > LINE:
            lines.append(line)
            line = ""
        line += f" {word}," if line else f"{word},"
    return "\n".join([*lines, line.rstrip(",")])
