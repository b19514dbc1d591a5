"""A report: one HTML page from a template, every figure as SVG, the numbers as CSV.

The words and the order of a page are in its template ``page.html.j2``, beside the code that
computes its numbers; all templates extend ``layout.html.j2`` of this folder.
"""

from __future__ import annotations

import base64
import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from matplotlib.figure import Figure

import propmap
from propmap.report.folder import PAGE
from propmap.report.style import as_svg

MINUS, MISSING = "\N{MINUS SIGN}", "\N{EN DASH}"
"""In front of a negative number, and where there is none."""

DIGITS = 6
"""Of the numbers in CSV files: the accuracy of the loads."""

ZERO = 1e-9
"""Smaller numbers, in SI units or degrees, are rounding errors, which differ between machines."""


def report_files(
    template: str, figures: Mapping[str, Figure], sheets: Mapping[str, str], **values: Any
) -> dict[str, str | bytes]:
    """All files of a report by name.

    Parameters
    ----------
    template : str
        Path of the page's template in the package.
    figures : mapping of str to Figure
        By name; the page holds them, and each is a file with the ending ``.svg`` as well.
    sheets : mapping of str to str
        Contents of CSV files, by name without the ending.
    **values
        What the template uses.
    """
    images = {name: as_svg(figure) for name, figure in figures.items()}
    inside = {name: base64.b64encode(image).decode("ascii") for name, image in images.items()}
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parents[1]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "number": number,
        "fixed": lambda value, digits=0: f"{value:.{digits}f}",
        "percent": percent,
        "sentence": sentence,
    }
    environment.globals |= {"columns": _columns, "version": propmap.__version__}
    html = environment.get_template(template).render(images=inside, **values)
    return {
        PAGE: html,
        **{f"{name}.svg": image for name, image in images.items()},
        **{f"{name}.csv": text for name, text in sheets.items()},
    }


def number(value: float | None, digits: int = 3) -> str:
    """A number to so many significant digits, without an exponent where that can be read."""
    if value is None or value != value:
        return MISSING
    text = f"{value:.{digits}g}"
    if "e" in text and 1e-5 < abs(value) < 1e7:
        rounded = float(text)
        text = f"{rounded:.0f}" if abs(value) >= 1.0 else f"{rounded:.{digits + 4}f}".rstrip("0")
    return text.replace("-", MINUS)


def percent(share: float) -> str:
    """A share in per cent to two digits, without a line break."""
    return f"{number(100.0 * share, 2)}\N{NO-BREAK SPACE}%"


def sentence(text: str) -> str:
    """With a capital letter and a full stop."""
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")


def csv_of_rows(heads: str, rows: Iterable[Sequence[Any]]) -> str:
    """Rows as CSV under heads with units, separated by spaces; NaN and None are empty fields."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heads.split())
    writer.writerows([_field(value) for value in row] for row in rows)
    return text.getvalue()


def csv_of_columns(groups: Iterable[Mapping[str, Any]]) -> str:
    """Columns by head with unit as CSV; the groups of rows follow each other.

    Values are array_like; in each group they are broadcast against each other.
    """
    heads = ""
    rows: list[Sequence[Any]] = []
    for group in groups:
        heads = " ".join(group)
        columns = np.broadcast_arrays(*(np.asarray(v, dtype=object) for v in group.values()))
        rows += zip(*(column.ravel().tolist() for column in columns), strict=True)
    return csv_of_rows(heads, rows)


def _field(value: Any) -> Any:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if not isinstance(value, float):
        return value
    return f"{0.0 if abs(value) < ZERO else value:.{DIGITS}g}"


def _columns(heads: str, rows: Iterable[Sequence[Any]]) -> list[tuple[str, str, bool, list[str]]]:
    """Name, unit, whether it holds numbers, and cells of each column of a table.

    ``heads`` such as "load | rms error [N]"; a cell is a text, or a number to be set to three
    digits.
    """
    columns = []
    for head, *values in zip(heads.split("|"), *rows, strict=True):
        name, _, unit = head.strip().removesuffix("]").partition(" [")
        cells = [value if isinstance(value, str) else _shown(value) for value in values]
        columns.append((name, unit, bool(unit) or all(map(_is_number, cells)), cells))
    return columns


def _shown(value: float | None) -> str:
    return str(value) if isinstance(value, int) else number(value)


def _is_number(text: str) -> bool:
    bare = text.replace(MINUS, "").replace(MISSING, "").replace("%", "").replace(" ", "")
    return bare == "" or bare.replace(".", "", 1).isdigit()
