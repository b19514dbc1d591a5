"""Numbers as CSV files, six digits."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from typing import Any

DIGITS = 6
"""Significant ones: what the loads are computed to, and no more than repeats."""

ZERO = 1e-9
"""Below which a number is rounding, in SI units or degrees."""


def csv_of_rows(heads: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """Rows under headings with units, as CSV; NaN and None become empty fields."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows([_cell(value) for value in row] for row in rows)
    return text.getvalue()


def _cell(value: Any) -> Any:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if not isinstance(value, float):
        return value
    # What is left of a number that ought to be zero differs from machine to machine.
    return f"{0.0 if abs(value) < ZERO else value:.{DIGITS}g}"
