"""CSV as text."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from propmap.io.operating_points import OperatingPoints

if TYPE_CHECKING:
    from propmap.results import Loads
    from propmap.typing import Floats

FURTHER = ("mean_inflow", "reverse_flow", "roots")
"""Fields of ``Loads`` that `propmap sweep` tells beside the columns of `propmap predict`."""


def csv_text(columns: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> str:
    """CSV with a header line; None becomes an empty field, a float all its digits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([row[name] for name in columns] for row in rows)
    return text.getvalue()


def loads_csv(points: OperatingPoints, loads: Loads, spread: Mapping[str, Floats]) -> str:
    """The CSV of `propmap sweep`.

    Parameters
    ----------
    points : OperatingPoints
        Where.
    loads : Loads
        At these points.
    spread : mapping of str to ndarray, shape (n,)
        Their standard deviations by column, see ``operating_points.std_columns``; may be empty.
    """
    further = {**{name: getattr(loads, name) for name in FURTHER}, **spread}
    return csv_text([*points.columns, *further], points.rows(loads, further))
