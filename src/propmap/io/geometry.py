"""Blade geometry from files in CSV, TOML, the UIUC database's format and APC's."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

from propmap.errors import InputError, located, quoted
from propmap.io.csv import header_names, is_comment, read_csv_table, read_lines
from propmap.model.model import Propeller
from propmap.model.plausibility import (
    check_blade,
    check_blades,
    twist_from_degrees,
)
from propmap.typing import Floats
from propmap.units import INCH

# -------------------------------------------------------------------------------------------------
# A blade as rows of a file, on the way to a ``Propeller``.

RADIUS_TOLERANCE = 1e-3  # share of the radius within which two statements of it agree

GIVE_BLADES = "pass --blades 2 (in Python: blades=2)"
GIVE_RADIUS = "pass --radius 0.1 (in Python: radius=0.1), in metres"


def parse_number(text: str, field: str, where: str = "") -> float:
    """Read a finite number written as plain decimal text."""
    stripped = text.strip()
    try:
        # float() also takes 1_000, which in a data file is a mistake.
        value = float(stripped) if "_" not in stripped else math.nan
    except ValueError:
        value = math.nan
    if math.isfinite(value):
        return value
    remedy = "use a decimal point" if "," in stripped else "remove the row or correct it"
    found = quoted(stripped) if stripped else "nothing"
    raise InputError(f"{field} is {found}, expected a finite number", remedy, where)


def parse_blades(text: str) -> int:
    """Read a number of blades written as text."""
    stripped = text.strip()
    count: object = int(stripped) if stripped.isascii() and stripped.isdigit() else stripped
    return check_blades(count)


_TOLD = re.compile(
    r"\d *[x\u00d7*] *\d[\d.,]* *[x\u00d7*] *([2-9])(?!\.?\d)|(?<!\d)([2-9])[ _-]?blade"
)
_HEAD = 10  # lines of a file among which its title is


def blades_in_title(file: str | os.PathLike[str], lines: Sequence[str]) -> int | None:
    """Read the number of blades that a file's name, or a title in its ``lines``, tells, such as
    "HQ 5x4.3x3"; None where neither does."""
    found = _TOLD.search("\n".join([Path(file).name, *lines[:_HEAD]]).lower())
    return int(found[1] or found[2]) if found else None


def parse_rows(
    rows: Iterable[tuple[int, Sequence[str]]], header: Sequence[str], columns: Sequence[str]
) -> tuple[list[str], Floats]:
    """Read the wanted ``columns`` of numbered rows (n, columns), with n labels such as "line 7"."""
    labels: list[str] = []
    table: list[list[float]] = []
    for number, cells in rows:
        labels.append(f"line {number}")
        with located(labels[-1]):
            if len(cells) != len(header):
                found = f"found {len(cells)} figures, expected {len(header)}"
                raise InputError(found, "complete the row or remove it")
            table.append([parse_number(cells[header.index(name)], name) for name in columns])
    if not table:
        raise InputError("found a header and no rows", "give one row per station of the blade")
    return labels, np.array(table, dtype=np.float64)


def check_radius(own: float, given: float | None, tolerance: float | None = None) -> None:
    """Raise ``InputError`` unless ``given`` [m] repeats the geometry's own radius, to 0.1 %."""
    limit = RADIUS_TOLERANCE * own if tolerance is None else tolerance
    if given is not None and not abs(given - own) <= limit:
        found = f"the radius is {own:.6g} m by its last station, but {given:g} m was given"
        raise InputError(found, "leave the radius out or correct it")


def usable_radius(radius: float | None) -> float:
    """Check the tip radius [m] that scales a file in fractions of it."""
    if radius is None:
        raise InputError("the file gives fractions of the radius only", GIVE_RADIUS)
    if not (isinstance(radius, int | float) and 0.0 < radius < math.inf):
        found = f"the radius is {quoted(radius)} m, expected a length above 0"
        raise InputError(found, GIVE_RADIUS)
    return float(radius)


def check_fractions(fraction: Floats, labels: Sequence[str]) -> None:
    """Raise ``InputError`` unless fractions of the radius, shape (n,), end at the tip, 1.0."""
    high = int(np.argmax(fraction))
    if fraction[high] > 1.0:
        raise InputError(
            f"{labels[high]}: r/R is {fraction[high]:g}, expected at most 1"
            + ("; it looks like per cent" if fraction[high] == 100.0 else ""),
            "divide by the tip radius, or name the column after its unit",
        )
    if fraction[-1] < 1.0 - 1e-6:
        found = f"{labels[-1]}: the last r/R is {fraction[-1]:g}, expected 1 (the tip)"
        raise InputError(found, "add the tip station with its chord, or sort the rows by station")


def build_propeller(
    labels: Sequence[str],
    name: str,
    blades: int | None,
    blade: tuple[Floats, Floats, Floats],
    source: str,
    citation: str = "",
) -> Propeller:
    """Make a ``Propeller`` of station, chord and twist; faults name the labels of its lines."""
    check_blade(*blade, labels)
    if blades is None:
        raise InputError("the file gives no number of blades", GIVE_BLADES)
    return Propeller(name, check_blades(blades), *blade, None, source, citation)


# -------------------------------------------------------------------------------------------------
# Blade geometry in propmap's own format, one TOML file per propeller.

SCHEMA = 1


def read_propeller_toml(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """Read a propeller from a file in the format of the catalogue."""
    # Imported here, as it loads msgspec, which the propellers of the catalogue do without.
    from propmap.io.toml import PropellerFile, read_toml

    file = read_toml(path, PropellerFile, SCHEMA, "geometry file")
    with located(os.fspath(path)):
        station, chord, twist = map(np.array, (file.station_m, file.chord_m, file.twist_rad))
        labels = [f"entry {i}" for i in range(station.size)]
        count = check_blades(file.blades if blades is None else blades)
        blade = station, chord, twist
        result = build_propeller(labels, file.name, count, blade, file.source, file.citation)
        check_radius(result.radius, file.radius_m)
        check_radius(result.radius, radius)
        if file.root_cutout_m is None:
            return result
        with located("root_cutout_m"):
            return result.with_root_cutout(file.root_cutout_m)


def propeller_toml(blade: Propeller) -> str:
    """Write the text of a file that ``read_propeller_toml`` reads as this ``blade``."""
    import tomli_w

    fields = {
        "schema": SCHEMA,
        "name": blade.name,
        "blades": blade.blades,
        "radius_m": blade.radius,
        "station_m": blade.station.tolist(),
        "chord_m": blade.chord.tolist(),
        "twist_rad": blade.twist.tolist(),
        "root_cutout_m": blade.root_cutout,
        "source": blade.source or None,
        "citation": blade.citation or None,
    }
    return tomli_w.dumps({key: value for key, value in fields.items() if value is not None})


# -------------------------------------------------------------------------------------------------
# Blade geometry as CSV with the unit in each column's name.

LENGTH_UNITS = {"m": 1.0, "mm": 1e-3, "in": INCH}
STATION_COLUMNS = ("radius_m", "radius_mm", "radius_in", "r_over_R")
CHORD_COLUMNS = ("chord_m", "chord_mm", "chord_in", "c_over_R")
TWIST_COLUMNS = ("twist_deg", "twist_rad")
QUANTITIES = {"station": STATION_COLUMNS, "chord": CHORD_COLUMNS, "twist": TWIST_COLUMNS}
KNOWN = [name for several in QUANTITIES.values() for name in several]
COMMENT_KEYS = ("name", "blades", "radius_m", "source", "citation")


def read_propeller_csv(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """Read a propeller from a CSV file with one row per station, from root to tip.

    One column each of radius_m, radius_mm, radius_in or r_over_R; chord_m, chord_mm, chord_in or
    c_over_R; twist_deg or twist_rad; in any dialect of ``propmap.io.csv``. Lines that start with #
    are comments, in which ``# blades: 3``, ``# radius_m: 0.1``, ``# name:``, ``# source:`` and ``#
    citation:`` count. A title such as "HQ 5x4.3x3" tells the number of blades where nothing else
    does.
    """
    where, lines = os.fspath(path), read_lines(path)
    file = read_csv_table(lines, KNOWN, where, comments=True)
    with located(where):
        if file is None:
            remedy = "name the columns, for example radius_m,chord_m,twist_deg"
            raise InputError("found comments only", remedy)
        stated: dict[str, str] = {}
        for line in file.comments:
            key, _, value = line.lstrip().removeprefix("#").partition(":")
            if key.strip().lower() in COMMENT_KEYS and value.strip():
                stated.setdefault(key.strip().lower(), value.strip())
        with located(f"line {file.line}"):
            columns = _choose_columns(file.header)
        labels, table = parse_rows(file.rows, file.header, tuple(columns.values()))
        if "radius_m" in stated:
            with located("# radius_m"):
                in_file = usable_radius(parse_number(stated["radius_m"], "the radius"))
                check_radius(in_file, radius)
                radius = in_file
        station, chord = _lengths(columns, table, radius, labels)
        with located(labels[-1]):
            check_radius(float(station[-1]), radius)
        twist = table[:, 2]
        if columns["twist"] == "twist_deg":
            with located("twist_deg"):
                twist = twist_from_degrees(twist)
        if blades is None and "blades" in stated:
            with located("# blades"):
                blades = parse_blades(stated["blades"])
        elif blades is None:
            blades = blades_in_title(where, lines)
        name, source = stated.get("name", Path(where).stem), f"file {Path(where).name}"
        texts = stated.get("source", source), stated.get("citation", "")
        return build_propeller(labels, name, blades, (station, chord, twist), *texts)


def _choose_columns(header: Sequence[str]) -> dict[str, str]:
    """Choose the columns that give station, chord and twist."""
    for cell in header:
        if cell not in KNOWN:
            found = f"found column {quoted(cell)}, expected one of {', '.join(KNOWN)}"
            raise InputError(found, "rename, comment or remove it")
    chosen: dict[str, str] = {}
    for quantity, names in QUANTITIES.items():
        given = [cell for cell in header if cell in names]
        if not given:
            remedy = f"add {', '.join(names[:-1])} or {names[-1]}"
            raise InputError(f"no column gives the {quantity}", remedy)
        if len(given) > 1:
            raise InputError(f"{' and '.join(given)} both give the {quantity}", "keep one of them")
        chosen[quantity] = given[0]
    return chosen


def _lengths(
    columns: dict[str, str], table: Floats, radius: float | None, labels: Sequence[str]
) -> tuple[Floats, Floats]:
    """Convert the columns of station and chord to m."""
    if columns["station"] == "r_over_R":
        tip = usable_radius(radius)
        check_fractions(table[:, 0], labels)
        station = table[:, 0] * tip
    else:
        station = table[:, 0] * LENGTH_UNITS[columns["station"].removeprefix("radius_")]
        tip = float(station[-1])
    if columns["chord"] == "c_over_R":
        # A figure too large for a float becomes inf, which the check of the blade reports.
        with np.errstate(over="ignore"):
            return station, table[:, 1] * tip
    return station, table[:, 1] * LENGTH_UNITS[columns["chord"].removeprefix("chord_")]


# -------------------------------------------------------------------------------------------------
# Blade geometry as the UIUC Propeller Database publishes it: ``r/R c/R beta``.

HEADER = ["r/R", "c/R", "beta"]

UIUC_CITATION = (
    "Brandt, Deters, Ananda, Dantsker, Selig, UIUC Propeller Database, vols 1-3, "
    "University of Illinois"
)


def read_uiuc_geometry(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """Read a propeller from a UIUC geometry file: r/R, c/R and beta in degrees.

    The files hold neither radius nor blades, which are 2 for nearly all of that database, unless
    the file's name tells another number. Nothing is extended: the last row must be the tip,
    r/R = 1.
    """
    lines, file = read_lines(path), Path(path)
    with located(os.fspath(path)):
        start = next(i for i, line in enumerate(lines) if line.strip())
        if lines[start].split() != HEADER:
            raise InputError(
                f"line {start + 1}: the header is {quoted(lines[start].strip())}, "
                "expected 'r/R c/R beta'",
                "give the *_geom.txt file of the database",
            )
        tip, below = usable_radius(radius), enumerate(lines[start + 1 :], start + 2)
        rows = [(number, line.split()) for number, line in below if line.strip()]
        labels, table = parse_rows(rows, HEADER, HEADER)
        check_fractions(table[:, 0], labels)
        blade = table[:, 0] * tip, table[:, 1] * tip, twist_from_degrees(table[:, 2])
        count = (blades_in_title(file, lines) or 2) if blades is None else blades
        source = f"UIUC geometry file {file.name}"
        return build_propeller(labels, file.stem, count, blade, source, UIUC_CITATION)


# -------------------------------------------------------------------------------------------------
# Blade geometry as APC publishes it: ``*-PERF.PE0`` text files.

UNITS = {"STATION": "(IN)", "CHORD": "(IN)", "TWIST": "(DEG)"}

APC_CITATION = "Landing Products Inc. (APC Propellers), propeller performance data files"

# The trailer gives lengths in inches to two decimals.
TRAILER_TOLERANCE = 0.0051 * INCH


def read_apc_pe0(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """Read a propeller from an APC PE0 file.

    TWIST is the angle of the line from leading to trailing edge. The blade is loaded from the first
    station, or from the hub transition (HUBTRA) where that lies further out.
    """
    lines = read_lines(path)
    with located(os.fspath(path)):
        header = next((k for k, text in enumerate(lines) if _is_header(text)), None)
        if header is None:
            found = "found no table with the header 'STATION CHORD ...'"
            raise InputError(found, "give a PE0 file as APC publishes it")
        names = lines[header].split()
        units = lines[header + 1].split() if header + 1 < len(lines) else []
        for name, unit in UNITS.items():
            if name not in names:
                found = f"line {header + 1}: no column {name}"
                raise InputError(found, "give the complete PE0 file")
            index = names.index(name)
            if units[index : index + 1] != [unit]:
                found = quoted(units[index] if index < len(units) else "")
                found = f"line {header + 2}: the unit of {name} is {found}, expected {unit}"
                raise InputError(found, "convert the column, or write the geometry as CSV")
        rows: list[tuple[int, list[str]]] = []
        for number, line in enumerate(lines[header + 2 :], header + 3):
            cells = line.split()
            if cells and not cells[0].endswith(":"):
                rows.append((number, cells))
            elif cells or rows:
                break
        labels, table = parse_rows(rows, names, tuple(UNITS))
        trailer: dict[str, str] = {}
        for line in lines[header:]:
            key, colon, rest = line.partition(":")
            if colon and key.strip() in {"RADIUS", "HUBTRA", "BLADES"} and rest.split():
                trailer.setdefault(key.strip(), rest.split()[0])
        if blades is None:
            if "BLADES" not in trailer:
                raise InputError("found no line 'BLADES:'", GIVE_BLADES)
            with located("BLADES"):
                blades = parse_blades(trailer["BLADES"])
        blade = table[:, 0] * INCH, table[:, 1] * INCH, twist_from_degrees(table[:, 2])
        title = lines[0].split()[0] if lines[0].split() else "propeller"
        texts = f"APC PE0 file {title}", APC_CITATION
        result = build_propeller(labels, f"apc-{title.lower()}", blades, blade, *texts)
        if "RADIUS" in trailer:
            with located("RADIUS"):  # a table that stops short of it was cut off
                stated = parse_number(trailer["RADIUS"], "the radius") * INCH
                check_radius(result.radius, stated, TRAILER_TOLERANCE)
        check_radius(result.radius, radius)
        if "HUBTRA" not in trailer:
            return result
        with located("HUBTRA"):
            hub = parse_number(trailer["HUBTRA"], "the hub transition") * INCH
            inside = hub <= result.root + TRAILER_TOLERANCE
            return result if inside else result.with_root_cutout(hub)


def _is_header(line: str) -> bool:
    return line.split()[:2] == ["STATION", "CHORD"]


# -------------------------------------------------------------------------------------------------
# Any geometry file: which format it is in, read from its content.


READERS: dict[str, Callable[..., Propeller]] = {
    "apc-pe0": read_apc_pe0,
    "uiuc": read_uiuc_geometry,
    "csv": read_propeller_csv,
    "toml": read_propeller_toml,
}


def read_geometry_file(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """Read a propeller from a file in any format that propmap knows, by its content."""
    where = os.fspath(path)
    kind = recognise(read_lines(path), where)
    return READERS[kind](path, blades=blades, radius=radius)


def recognise(lines: Sequence[str], where: str) -> str:
    """Recognise the format of a file, one of ``READERS``, from its lines."""
    body = [line for line in lines if line.strip() and not is_comment(line)]
    first = body[0] if body else ""
    if any(_is_header(line) or "AIRFOIL SUMMARY DATA" in line for line in body):
        return "apc-pe0"
    if first.split()[:2] == HEADER[:2]:
        return "uiuc"
    if any(line.partition("=")[0].strip() == "schema" for line in body):
        return "toml"
    # A column may be named after a blade quantity with a unit that is wrong.
    stems = {name.split("_")[0].lower() for name in KNOWN}
    cells = header_names(first, KNOWN)
    if len(cells) > 1 and any(cell.split("_")[0] in stems for cell in cells):
        return "csv"
    raise InputError(
        f"begins with {quoted(first.strip())}, which is no propeller geometry that propmap knows",
        "give an APC PE0 file, a UIUC geometry file (r/R c/R beta), a catalogue TOML file, "
        "or a CSV file with columns such as radius_m,chord_m,twist_deg",
        where,
    )
