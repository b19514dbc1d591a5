"""Measured loads of the UIUC propeller database: its text format, and all of it in one CSV file."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError, located, quoted
from propmap.io.csv import read_csv_table, read_lines
from propmap.io.geometry import parse_blades, parse_number, parse_rows
from propmap.typing import Floats

# -------------------------------------------------------------------------------------------------
# All loads of the UIUC propeller database in one CSV file, propeller by propeller.

COLUMNS = ("PropName", "BladeName", "Family", "B", "J", "N", "CT", "CP")


class MeasuredPropeller(NamedTuple):
    """One propeller of the database, with n rows."""

    name: str  # as the database has it, and so
    blade: str  # of its blade
    family: str  # of its maker's series
    blades: int
    rpm: Floats  # [1/min]
    advance: Floats  # J = V/(n D) [-], 0 at rest
    thrust: Floats  # C_T = T/(rho n^2 D^4) [-]
    power: Floats  # C_P = P/(rho n^3 D^5) [-]
    run: NDArray[np.intp]  # number of the run: rows in turn at one rotational speed, or at rest


def read_uiuc_database(path: Path) -> list[MeasuredPropeller]:
    """Read the propellers of the database's table of loads, a CSV file with ``COLUMNS``, in its
    order."""
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
        parse_blades(first["B"]),
        *(rpm, advance, column("CT"), column("CP")),
        np.array(run),
    )


# -------------------------------------------------------------------------------------------------
# Load files of the UIUC propeller database in their own text format.

FLIGHT, STATIC = ("J", "CT", "CP"), ("RPM", "CT", "CP")
_RPM_IN_NAME = re.compile(r"_(\d{3,5})\.txt$", re.IGNORECASE)


class Coefficients(NamedTuple):
    """Rows (n,) of one file."""

    rpm: Floats  # [1/min]
    advance: Floats  # J = V/(n D) [-]
    thrust: Floats  # C_T = T/(rho n^2 D^4) [-]
    power: Floats  # C_P = P/(rho n^3 D^5) [-]


def looks_like_uiuc_loads(path: Path) -> bool:
    """Whether the first line of the file at ``path`` is a header of such a file."""
    if path.suffix.lower() != ".txt":
        return False
    return tuple(read_lines(path, "load file")[0].split()[:3]) in (FLIGHT, STATIC)


def read_uiuc_loads(path: Path) -> Coefficients:
    """Read rows under ``J CT CP [eta]`` (one rotational speed) or ``RPM CT CP`` (static).

    The name of a file with J ends with the rotational speed, as in apcsf_10x7_kt0828_3008.txt.
    """
    where = str(path)
    lines = enumerate(read_lines(path, "load file"), start=1)
    (_, names), *rows = [(number, line.split()) for number, line in lines if line.strip()]
    header = tuple(names[:3])
    if header not in (FLIGHT, STATIC):
        found = f"line 1: found {quoted(' '.join(names))}"
        raise InputError(found, "the header must be J CT CP (eta) or RPM CT CP", where)
    if not rows:
        raise InputError("there is no row below the header", "give the whole file", where)
    # Some rows lack the efficiency, which is not read.
    with located(where):
        _, table = parse_rows([(number, cells[:3]) for number, cells in rows], header, header)
    first, thrust, power = table.T
    if header == STATIC:
        return Coefficients(first, np.zeros_like(first), thrust, power)
    rpm = _RPM_IN_NAME.search(path.name)
    if rpm is None:
        found = "the rotational speed is not in the file's name"
        remedy = "name the file as in apcsf_10x7_kt0828_3008.txt, which is 3008 rpm"
        raise InputError(found, remedy, where)
    return Coefficients(np.full_like(first, float(rpm[1])), first, thrust, power)
