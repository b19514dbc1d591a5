"""CSV files with a column per quantity: operating points and measured loads."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from propmap.errors import InputError, quoted
from propmap.io.csv_dialect import read_csv_table
from propmap.io.operating_points import FURTHER, REMEDIES, OperatingPoints
from propmap.io.text_file import read_lines
from propmap.loads import LOADS
from propmap.typing import Floats

POINT_COLUMNS = {"rpm": "rpm", "speed_mps": "speed", "beta_deg": "beta"}
QUANTITIES = POINT_COLUMNS | {column: name for name, column in FURTHER.items()}
LOAD_COLUMNS = {load.column: name for name, load in LOADS.items()}
"""Names of loads by their column."""


@dataclass(frozen=True)
class PointsFile:
    """Operating points (n,) and the further columns asked for that the file has, each (n,).

    An empty field of a further column is NaN.
    """

    points: OperatingPoints
    further: dict[str, Floats]


def read_points(path: Path, further: Iterable[str] = ()) -> PointsFile:
    """Operating points from a CSV file with a header.

    Parameters
    ----------
    path : Path
        Of a file with the columns rpm, speed_mps and beta_deg, and height_m if there is ground, in
        any order, in any dialect of ``propmap.io.csv_dialect``.
    further : sequence of str
        Columns to read as well, where the file has them; others are left.

    Raises
    ------
    InputError
        Naming the file, the line and the column.
    """
    wanted = (*FURTHER.values(), *further)
    columns = read_columns(path, POINT_COLUMNS, wanted, "list of operating points")
    rpm, speed, beta = (columns.pop(name) for name in POINT_COLUMNS)
    more = {name: columns.pop(column) for name, column in FURTHER.items() if column in columns}
    return PointsFile(OperatingPoints(rpm, speed, beta, more), columns)


def read_columns(
    path: Path, needed: Collection[str], further: Iterable[str], what: str
) -> dict[str, Floats]:
    """Columns (n,) of a CSV file with a header, by their names.

    Parameters
    ----------
    path : Path
        Of a file in any dialect of ``propmap.io.csv_dialect``.
    needed, further : collection and iterable of str
        Columns that the file must have, and those to read where it has them, with NaN for an empty
        field unless it is of an operating point.
    what : str
        What the file should be, for messages.

    Raises
    ------
    InputError
        Naming the file, the line and the column.
    """
    where, further = str(path), tuple(further)
    lines = read_lines(path, what)
    file = read_csv_table(lines, [*needed, *further], where)
    header = file.header if file else []
    missing = [name for name in needed if name not in header]
    if missing:
        raise InputError(
            f"line 1: column {missing[0]} is missing",
            f"the first line must name {', '.join(needed)}",
            where,
        )
    if file is None or not file.rows:
        raise InputError("there is no row below the header", "add a row per point", where)
    _check_units(header, further, where)
    wanted = [*needed, *(name for name in further if name in header)]
    repeated = [name for name in wanted if header.count(name) > 1]
    if repeated:
        raise InputError(f"line 1: column {repeated[0]} occurs twice", "keep one of them", where)
    columns: dict[str, list[float]] = {name: [] for name in wanted}
    places = {name: header.index(name) for name in wanted}
    for line, row in file.rows:
        for name, place in places.items():
            cell = row[place] if place < len(row) else ""
            columns[name].append(_value(cell, name, f"{where}, line {line}, column {name}"))
    return {name: np.array(values) for name, values in columns.items()}


def _check_units(header: Collection[str], columns: Collection[str], where: str) -> None:
    """Raise ``InputError`` for a load that is there, but in none of the units of ``columns``."""
    for load in LOADS:
        same = [name for name in columns if name.rpartition("_")[0] == load]
        if not same or set(same) & set(header):
            continue
        for name in header:
            if name.lower().replace(" ", "_").startswith(load):
                raise InputError(
                    f"line 1: column {quoted(name)} is in no unit that is known",
                    f"name it {' or '.join(same)}, after its unit, or leave it out",
                    where,
                )


def _value(cell: str, column: str, where: str) -> float:
    quantity = QUANTITIES.get(column)
    if quantity is None and not cell:
        return math.nan
    remedy = REMEDIES[quantity] if quantity else "give a finite number or leave the field empty"
    try:
        value = float(cell)
    except ValueError:
        found = f"{quoted(cell)} is not a number" if cell else "the field is empty"
        raise InputError(found, remedy, where) from None
    if not math.isfinite(value):
        raise InputError(f"{cell} is not a finite number", remedy, where)
    if value < 0.0 and quantity in ("rpm", "speed", *FURTHER):
        raise InputError(f"{cell} is negative", remedy, where)
    return value
