"""All loads of the UIUC propeller database in one CSV file, propeller by propeller."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.io.blade_table import parse_blades, parse_number
from propmap.io.csv_dialect import read_csv_table
from propmap.io.text_file import read_lines
from propmap.typing import Floats

COLUMNS = ("PropName", "BladeName", "Family", "B", "J", "N", "CT", "CP")


class MeasuredPropeller(NamedTuple):
    """One propeller of the database; n rows.

    Attributes
    ----------
    name, blade, family : str
        As the database has them: of the propeller, of its blade, of its maker's series.
    blades : int
        Number of blades.
    rpm, advance : ndarray, shape (n,)
        Rotational speed [1/min] and J = V/(n D) [-], 0 at rest.
    thrust, power : ndarray, shape (n,)
        C_T = T/(rho n^2 D^4) and C_P = P/(rho n^3 D^5) [-].
    run : ndarray, shape (n,)
        Number of the run: rows in turn at one rotational speed, or at rest.
    """

    name: str
    blade: str
    family: str
    blades: int
    rpm: Floats
    advance: Floats
    thrust: Floats
    power: Floats
    run: NDArray[np.intp]


def read_uiuc_database(path: Path) -> list[MeasuredPropeller]:
    """The propellers of the database's table of loads, in the order of the file.

    Parameters
    ----------
    path : Path
        A CSV file with the columns PropName, BladeName, Family, B, J, N, CT and CP, in any dialect
        of ``propmap.io.csv_dialect``.

    Raises
    ------
    InputError
        For a missing file or column, and naming the line for what is not a number.
    """
    where = str(path)
    file = read_csv_table(read_lines(path, "table of loads"), COLUMNS[3:], where)
    header = file.header if file else []
    missing = [name for name in COLUMNS if name not in header]
    if file is None or missing:
        raise InputError(
            f"there is no column {missing[0]}",
            f"give the database's loads as CSV with {', '.join(COLUMNS)}",
            where,
        )
    found: dict[str, list[tuple[int, Mapping[str, str]]]] = {}
    for line, cells in file.rows:
        row = dict(itertools.zip_longest(header, cells, fillvalue=""))
        found.setdefault(row["PropName"], []).append((line, row))
    return [_propeller(name, rows, where) for name, rows in found.items()]


def _propeller(
    name: str, rows: list[tuple[int, Mapping[str, str]]], where: str
) -> MeasuredPropeller:
    def column(field: str) -> Floats:
        return np.array(
            [parse_number(row[field], f"line {line}: {field}", where) for line, row in rows]
        )

    _, first = rows[0]
    rpm, advance = column("N"), column("J")
    # At rest every row has its own rotational speed; together they are one test.
    speed = np.where(advance == 0.0, 0.0, rpm)
    run = list(itertools.accumulate(speed[1:] != speed[:-1], initial=0))
    return MeasuredPropeller(
        name,
        first["BladeName"],
        first["Family"],
        parse_blades(first["B"], where),
        *(rpm, advance, column("CT"), column("CP")),
        np.array(run),
    )
