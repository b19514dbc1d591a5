"""Blade geometry as APC publishes it: ``*-PERF.PE0`` text files."""

from __future__ import annotations

import os
from collections.abc import Sequence

from propmap.errors import InputError, quoted
from propmap.io.blade_table import (
    GIVE_BLADES,
    INCH,
    build_propeller,
    check_radius,
    parse_blades,
    parse_number,
    parse_rows,
)
from propmap.io.text_file import read_lines
from propmap.model.blade_check import check_root_cutout, twist_from_degrees
from propmap.model.propeller import Propeller

UNITS = {"STATION": "(IN)", "CHORD": "(IN)", "TWIST": "(DEG)"}

CITATION = "Landing Products Inc. (APC Propellers), propeller performance data files"

# The trailer gives lengths in inches to two decimals.
TRAILER_TOLERANCE = 0.0051 * INCH


def read_apc_pe0(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """A propeller from an APC PE0 file.

    TWIST is the angle of the line from leading to trailing edge.  The blade is loaded from the
    first station, or from the hub transition (HUBTRA) where that lies further out.

    Parameters
    ----------
    path : path
        Of the file.
    blades : int, optional
        Replaces BLADES of the file.
    radius : float, optional
        Tip radius [m], which must agree with the file.

    Raises
    ------
    InputError
        For a file that is none, or describes no blade.
    """
    where = os.fspath(path)
    lines = read_lines(path)
    header = _header_line(lines, where)
    names = _column_names(lines, header, where)
    labels, table = parse_rows(_rows(lines, header), names, tuple(UNITS), where)
    trailer = _trailer(lines[header:])
    if blades is None:
        if "BLADES" not in trailer:
            raise InputError("found no line 'BLADES:'", GIVE_BLADES, where)
        blades = parse_blades(trailer["BLADES"], f"{where}: BLADES")
    station, chord = table[:, 0] * INCH, table[:, 1] * INCH
    twist = twist_from_degrees(table[:, 2], where)
    title = lines[0].split()[0] if lines[0].split() else "propeller"
    result = build_propeller(
        where,
        labels,
        f"apc-{title.lower()}",
        blades,
        station,
        chord,
        twist,
        source=f"APC PE0 file {title}",
        citation=CITATION,
    )
    _check_tip(trailer, result, where)
    if radius is not None:
        check_radius(result.radius, radius, where)
    return _with_hub_transition(trailer, result, where)


def _header_line(lines: Sequence[str], where: str) -> int:
    for number, line in enumerate(lines):
        if line.split()[:2] == ["STATION", "CHORD"]:
            return number
    raise InputError(
        "found no table with the header 'STATION CHORD ...'",
        "give a PE0 file as APC publishes it",
        where,
    )


def _column_names(lines: Sequence[str], header: int, where: str) -> list[str]:
    """Of all columns, once the units of station, chord and twist on the next line are right."""
    names = lines[header].split()
    units = lines[header + 1].split() if header + 1 < len(lines) else []
    for name, unit in UNITS.items():
        if name not in names:
            raise InputError(
                f"line {header + 1}: no column {name}", "give the complete PE0 file", where
            )
        index = names.index(name)
        found = units[index] if index < len(units) else ""
        if found != unit:
            raise InputError(
                f"line {header + 2}: the unit of {name} is {quoted(found)}, expected {unit}",
                "convert the column, or write the geometry as CSV",
                where,
            )
    return names


def _rows(lines: Sequence[str], header: int) -> list[tuple[int, list[str]]]:
    """Numbers and cells of the lines below the units, up to the first that is no row."""
    rows: list[tuple[int, list[str]]] = []
    for number, line in enumerate(lines[header + 2 :], header + 3):
        cells = line.split()
        if cells and not cells[0].endswith(":"):
            rows.append((number, cells))
        elif cells or rows:
            break
    return rows


def _trailer(lines: Sequence[str]) -> dict[str, str]:
    """The figures behind RADIUS:, HUBTRA: and BLADES: as text."""
    found: dict[str, str] = {}
    for line in lines:
        key, colon, rest = line.partition(":")
        if colon and key.strip() in {"RADIUS", "HUBTRA", "BLADES"} and rest.split():
            found.setdefault(key.strip(), rest.split()[0])
    return found


def _check_tip(trailer: dict[str, str], result: Propeller, where: str) -> None:
    """A table that stops short of RADIUS was cut off."""
    if "RADIUS" in trailer:
        place = f"{where}: RADIUS"
        stated = parse_number(trailer["RADIUS"], "the radius", place) * INCH
        check_radius(result.radius, stated, place, TRAILER_TOLERANCE)


def _with_hub_transition(trailer: dict[str, str], result: Propeller, where: str) -> Propeller:
    if "HUBTRA" not in trailer:
        return result
    place = f"{where}: HUBTRA"
    hub = parse_number(trailer["HUBTRA"], "the hub transition", place) * INCH
    if hub <= result.root + TRAILER_TOLERANCE:
        return result
    return result.with_root_cutout(check_root_cutout(hub, result.station, place))
