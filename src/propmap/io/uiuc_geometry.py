"""Blade geometry as the UIUC Propeller Database publishes it: ``r/R c/R beta``."""

from __future__ import annotations

import os
from pathlib import Path

from propmap.errors import InputError, quoted
from propmap.io.blade_table import (
    build_propeller,
    check_fractions,
    parse_rows,
    usable_radius,
)
from propmap.io.text_file import read_lines
from propmap.model.blade_check import twist_from_degrees
from propmap.model.propeller import Propeller

HEADER = ["r/R", "c/R", "beta"]

CITATION = (
    "Brandt, Deters, Ananda, Dantsker, Selig, UIUC Propeller Database, vols 1-3, "
    "University of Illinois"
)


def read_uiuc_geometry(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """A propeller from a UIUC geometry file: r/R, c/R and beta in degrees.

    Nothing is extended: the last row must be the tip, r/R = 1.

    Parameters
    ----------
    path : path
        Of the file.
    blades : int, optional
        By default 2, as for nearly all of that database.
    radius : float
        Tip radius [m], which these files do not hold.

    Raises
    ------
    InputError
        Naming the line.
    """
    where = os.fspath(path)
    lines = read_lines(path)
    start = next(i for i, line in enumerate(lines) if line.strip())
    if lines[start].split() != HEADER:
        raise InputError(
            f"line {start + 1}: the header is {quoted(lines[start].strip())}, "
            "expected 'r/R c/R beta'",
            "give the *_geom.txt file of the database",
            where,
        )
    tip = usable_radius(radius, where)
    rows = [
        (n, line.split()) for n, line in enumerate(lines[start + 1 :], start + 2) if line.strip()
    ]
    if not rows:
        raise InputError(
            "found a header and no rows", "give one row per station of the blade", where
        )
    labels, table = parse_rows(rows, HEADER, HEADER, where)
    check_fractions(table[:, 0], where, labels)
    return build_propeller(
        where,
        labels,
        Path(where).stem,
        2 if blades is None else blades,
        table[:, 0] * tip,
        table[:, 1] * tip,
        twist_from_degrees(table[:, 2], where),
        source=f"UIUC geometry file {Path(where).name}",
        citation=CITATION,
    )
