"""Blade geometry as CSV with the unit in each column's name."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from propmap.errors import InputError, quoted
from propmap.io.blade_table import (
    INCH,
    build_propeller,
    check_fractions,
    check_radius,
    parse_blades,
    parse_number,
    parse_rows,
    usable_radius,
)
from propmap.io.csv_dialect import read_csv_table
from propmap.io.text_file import read_lines
from propmap.model.blade_check import twist_from_degrees
from propmap.model.propeller import Propeller
from propmap.typing import Floats

LENGTH_UNITS = {"m": 1.0, "mm": 1e-3, "in": INCH}
STATION_COLUMNS = ("radius_m", "radius_mm", "radius_in", "r_over_R")
CHORD_COLUMNS = ("chord_m", "chord_mm", "chord_in", "c_over_R")
TWIST_COLUMNS = ("twist_deg", "twist_rad")
QUANTITIES = {"station": STATION_COLUMNS, "chord": CHORD_COLUMNS, "twist": TWIST_COLUMNS}
COMMENT_KEYS = ("name", "blades", "radius_m", "source", "citation")


def read_propeller_csv(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """A propeller from a CSV file with one row per station, from root to tip.

    One column each of radius_m, radius_mm, radius_in or r_over_R; chord_m, chord_mm, chord_in
    or c_over_R; twist_deg or twist_rad; in any dialect of ``propmap.io.csv_dialect``.  Lines that
    start with # are comments, in which ``# blades: 3``, ``# radius_m: 0.1``, ``# name:``,
    ``# source:`` and ``# citation:`` count.

    Parameters
    ----------
    path : path
        Of the file.
    blades : int, optional
        Replaces the file's.
    radius : float, optional
        Tip radius [m], needed for r_over_R where the file gives none.

    Raises
    ------
    InputError
        Naming the line or the column.
    """
    where = os.fspath(path)
    known = [name for several in QUANTITIES.values() for name in several]
    file = read_csv_table(read_lines(path), known, where, comments=True)
    if file is None:
        remedy = "name the columns, for example radius_m,chord_m,twist_deg"
        raise InputError("found comments only", remedy, where)
    stated = _comments(file.comments)
    columns = _choose_columns(file.header, f"{where}: line {file.line}")
    if not file.rows:
        raise InputError(
            "found a header and no rows", "give one row per station of the blade", where
        )
    wanted = tuple(columns.values())
    labels, table = parse_rows(file.rows, file.header, wanted, where)
    if "radius_m" in stated:
        place = f"{where}: # radius_m"
        in_file = usable_radius(parse_number(stated["radius_m"], "the radius", place), place)
        if radius is not None:
            check_radius(in_file, radius, place)
        radius = in_file
    station, chord = _lengths(columns, table, radius, labels, where)
    if radius is not None:
        check_radius(float(station[-1]), radius, f"{where}: {labels[-1]}")
    twist = table[:, 2]
    if columns["twist"] == "twist_deg":
        twist = twist_from_degrees(twist, f"{where}: twist_deg")
    if blades is None and "blades" in stated:
        blades = parse_blades(stated["blades"], f"{where}: # blades")
    return build_propeller(
        where,
        labels,
        stated.get("name", Path(where).stem),
        blades,
        station,
        chord,
        twist,
        source=stated.get("source", f"file {Path(where).name}"),
        citation=stated.get("citation", ""),
    )


def _comments(lines: Sequence[str]) -> dict[str, str]:
    """What the comments state, first statement first."""
    stated: dict[str, str] = {}
    for line in lines:
        key, _, value = line.lstrip().removeprefix("#").partition(":")
        if key.strip().lower() in COMMENT_KEYS and value.strip():
            stated.setdefault(key.strip().lower(), value.strip())
    return stated


def _choose_columns(header: Sequence[str], where: str) -> dict[str, str]:
    """Which column gives station, chord and twist."""
    known = [name for names in QUANTITIES.values() for name in names]
    for cell in header:
        if cell not in known:
            raise InputError(
                f"found column {quoted(cell)}, expected one of {', '.join(known)}",
                "rename, comment or remove it",
                where,
            )
    chosen: dict[str, str] = {}
    for quantity, names in QUANTITIES.items():
        found = [cell for cell in header if cell in names]
        if not found:
            raise InputError(
                f"no column gives the {quantity}",
                f"add {', '.join(names[:-1])} or {names[-1]}",
                where,
            )
        if len(found) > 1:
            raise InputError(
                f"{' and '.join(found)} both give the {quantity}", "keep one of them", where
            )
        chosen[quantity] = found[0]
    return chosen


def _lengths(
    columns: dict[str, str],
    table: Floats,
    radius: float | None,
    labels: Sequence[str],
    where: str,
) -> tuple[Floats, Floats]:
    """Station and chord [m]."""
    if columns["station"] == "r_over_R":
        tip = usable_radius(radius, where)
        check_fractions(table[:, 0], where, labels)
        station = table[:, 0] * tip
    else:
        station = table[:, 0] * LENGTH_UNITS[columns["station"].removeprefix("radius_")]
        tip = float(station[-1])
    if columns["chord"] == "c_over_R":
        # A figure too large for a float becomes inf, which the check of the blade reports.
        with np.errstate(over="ignore"):
            return station, table[:, 1] * tip
    return station, table[:, 1] * LENGTH_UNITS[columns["chord"].removeprefix("chord_")]
