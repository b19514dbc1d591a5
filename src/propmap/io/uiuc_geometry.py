"""Blade geometry as the UIUC Propeller Database publishes it: ``r/R c/R beta``."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from propmap.errors import InputError, quoted
from propmap.io.blade_table import (
    build_propeller,
    check_fractions,
    parse_number,
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

    blades : 2 where none is given, as for nearly all of that database.
    radius : tip radius [m], which these files do not hold.
    Nothing is extended: the last row must be the tip, r/R = 1.  Raises ``InputError``.
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
    labels: list[str] = []
    rows: list[list[float]] = []
    for number, line in enumerate(lines[start + 1 :], start + 2):
        cells = line.split()
        if not cells:
            continue
        if len(cells) != len(HEADER):
            raise InputError(
                f"line {number}: found {len(cells)} figures, expected {len(HEADER)}",
                "complete the row or remove it",
                where,
            )
        place = f"{where}: line {number}"
        labels.append(f"line {number}")
        rows.append(
            [parse_number(cell, name, place) for cell, name in zip(cells, HEADER, strict=True)]
        )
    if not rows:
        raise InputError(
            "found a header and no rows", "give one row per station of the blade", where
        )
    table = np.array(rows, dtype=np.float64)
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
