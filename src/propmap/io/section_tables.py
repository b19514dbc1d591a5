"""Section tables from files of other programs, and what makes one table of their polars."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from propmap.errors import InputError
from propmap.io.section_extension import Polar, all_round, at_common_angles
from propmap.io.section_formats import CSV_COLUMNS, READERS, Row, lines_of, section_format
from propmap.model.section_table import SectionTable

FORMATS = (
    "give an AeroDyn airfoil file, a polar of XFOIL or a folder of them, a CACTUS table, "
    f"or CSV with the columns {','.join(CSV_COLUMNS)}"
)
ASSUMED_REYNOLDS = 1e6
"""Of a file with one table that states none; loads do not depend on it."""

ALIKE = 0.01
"""Difference of C_L up to which a repeated angle, as XFOIL writes it, is one row."""


def read_section_table(path: str | os.PathLike[str]) -> SectionTable:
    """A section table from a file, or from a folder with one XFOIL polar per Reynolds number.

    The format is told by the content.  Polars that end a little past stall are continued to +-180
    degrees by Viterna's method, which the table's ``source`` says.

    Parameters
    ----------
    path : str or path
        AeroDyn airfoil file (v13 to v15, all its tables), XFOIL polar or folder, CACTUS table as of
        Sheldahl and Klimas, or CSV with the columns alpha_deg, re, cl, cd.

    Raises
    ------
    InputError
        Naming the file and the line.
    """
    place = Path(path)
    files = sorted(p for p in place.iterdir() if p.is_file()) if place.is_dir() else [place]
    kinds, polars = set(), []
    for file in files:
        lines = lines_of(file)
        kind = section_format(lines)
        if kind is None or (place.is_dir() and kind != "XFOIL"):
            wanted = "give polars of XFOIL alone in a folder" if place.is_dir() else FORMATS
            raise InputError("the file is no section table that propmap reads", wanted, str(file))
        kinds.add(kind)
        polars += [
            (str(file), reynolds, rows) for reynolds, rows in READERS[kind](lines, str(file))
        ]
    if not polars:
        raise InputError("there is no table", FORMATS, str(place))
    return _table(place, " and ".join(sorted(kinds)), polars)


def looks_like_section_table(path: Path) -> bool:
    """Whether a path is a folder, or a file that ``read_section_table`` takes."""
    return path.is_dir() or section_format(lines_of(path)) is not None


def _table(place: Path, kind: str, found: Sequence[tuple[str, float, list[Row]]]) -> SectionTable:
    polars: list[Polar] = []
    remarks = []
    for where, reynolds, rows in found:
        if reynolds <= 0.0 and len(found) == 1:
            reynolds = ASSUMED_REYNOLDS
            remarks.append("Reynolds number not stated")
        if not reynolds > 0.0:
            raise InputError(
                f"a Reynolds number is {reynolds:g}", "state one above 0 for every table", where
            )
        if reynolds in [polar.reynolds for polar in polars]:
            raise InputError(f"Re = {reynolds:g} occurs twice", "keep one of the tables", where)
        polar, added = all_round(_polar(reynolds, rows, where), where)
        polars.append(polar)
        remarks += [added] if added and added not in remarks else []
    polars.sort(key=lambda polar: polar.reynolds)
    angle, lift, drag = at_common_angles(polars)
    source = f"{place.name} ({kind})" + "".join(f", {remark}" for remark in remarks)
    try:
        return SectionTable(
            angle,
            np.array([polar.reynolds for polar in polars]),
            lift,
            drag,
            name=place.stem,
            source=source,
        )
    except InputError as error:
        raise InputError(error.found, error.remedy, str(place)) from None


def _polar(reynolds: float, rows: list[Row], where: str) -> Polar:
    """Rows in the order of their angles, each once."""
    kept: list[Row] = []
    for row in sorted(rows, key=lambda row: row[1]):
        if kept and row[1] == kept[-1][1]:
            if abs(row[2] - kept[-1][2]) > ALIKE:
                raise InputError(
                    f"{row[1]:g} deg occurs twice, in line {kept[-1][0]} with another lift",
                    "keep one of the rows",
                    f"{where}, line {row[0]}",
                )
            continue
        if abs(row[1]) > 180.0 + 1e-9:
            raise InputError(
                f"the angle is {row[1]:g}", "give degrees within +-180", f"{where}, line {row[0]}"
            )
        if row[3] < 0.0:
            raise InputError(
                f"the drag coefficient is {row[3]:g}",
                "correct or remove the row",
                f"{where}, line {row[0]}",
            )
        kept.append(row)
    if len(kept) < 8:
        raise InputError(
            f"the table of Re = {reynolds:g} has {len(kept)} rows, expected 8 at least",
            "give more angles",
            where,
        )
    _, angle, lift, drag = np.array(kept).T
    return Polar(reynolds, np.radians(angle), lift, drag)
