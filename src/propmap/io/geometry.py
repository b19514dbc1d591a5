"""Readers of blade geometry: CSV, TOML, and formats of UIUC, APC, QPROP, XROTOR and OpenVSP."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

from propmap.errors import InputError, located, quoted
from propmap.io import formats
from propmap.io.columns import QUANTITIES, Header, Taken
from propmap.io.csv import columns_in, is_comment, read_csv_table, read_lines
from propmap.io.formats import Format, format_of, not_read
from propmap.model.propeller import Propeller, check_blade, check_blades, twist_from_degrees
from propmap.typing import Floats
from propmap.units import INCH

# --- Common steps of all readers -----------------------------------------------------------------

RADIUS_TOLERANCE = 1e-3  # allowed difference of two values of the radius, as a share

GIVE_BLADES = "pass --blades 2 (in Python blades=2, in a vehicle file blades = 2 under [propeller])"
GIVE_RADIUS = (
    "pass --radius 0.1, in meters (in Python and in a vehicle file's [propeller]: radius = 0.1)"
)


def parse_number(text: str, field: str, where: str = "") -> float:
    """Return a finite number from plain decimal text."""
    stripped = text.strip()
    try:
        # float() also accepts 1_000, which is a mistake in a data file.
        value = float(stripped) if "_" not in stripped else math.nan
    except ValueError:
        value = math.nan
    if math.isfinite(value):
        return value
    remedy = "use a decimal point" if "," in stripped else "remove the row or correct it"
    found = quoted(stripped) if stripped else "nothing"
    raise InputError(f"{field} is {found}, expected a finite number", remedy, where)


def parse_blades(text: str) -> int:
    """Return a number of blades from text."""
    stripped = text.strip()
    count: object = int(stripped) if stripped.isascii() and stripped.isdigit() else stripped
    return check_blades(count)


COUNTS = {"two": 2, "dual": 2, "bi": 2, "three": 3, "tri": 3, "triple": 3}
COUNTS |= {"four": 4, "quad": 4, "five": 5, "six": 6}
COUNTED = rf"\b({'|'.join(COUNTS)})[ _-]?(?=blade)"
_TOLD = re.compile(
    r"\d *[x\u00d7*] *\d[\d.,]* *[x\u00d7*] *([2-9])(?!\.?\d)"
    r"|(?<![\d.])([2-9])[ _-]?(?:blade|b(?![a-z0-9]))"
    rf"|{COUNTED}"
)
_HEAD = 10  # number of lines of a file in which the title is searched


def blades_in_title(file: str | os.PathLike[str], lines: Sequence[str]) -> int | None:
    """Return the number of blades from a file name or title such as "HQ 5x4.3x3", or None."""
    found = _TOLD.search("\n".join([Path(file).name.replace("_", " "), *lines[:_HEAD]]).lower())
    words = next(filter(None, found.groups()), None) if found else None
    return None if words is None else COUNTS.get(words) or int(words)


def _stated_blades(lines: Sequence[str]) -> int | None:
    """Return the number of blades from a comment such as "# blades: 3", or None."""
    sign = re.compile(r"\s*#\s*(?:number of )?blades?\s*[:=]\s*(\d+)\s*$", re.IGNORECASE)
    found = next(filter(None, map(sign.match, lines[:_HEAD])), None)
    return check_blades(int(found[1])) if found else None


def parse_rows(
    rows: Iterable[tuple[int, Sequence[str]]], header: Sequence[str], columns: Sequence[str]
) -> tuple[list[str], Floats]:
    """Return n labels such as "line 7", and the wanted ``columns`` of the rows (n, columns)."""
    labels: list[str] = []
    table: list[list[float]] = []
    for number, cells in rows:
        labels.append(f"line {number}")
        with located(labels[-1]):
            if len(cells) != len(header):
                found = f"found {len(cells)} values, expected {len(header)}"
                raise InputError(found, "complete the row or remove it")
            table.append([parse_number(cells[header.index(name)], name) for name in columns])
    if not table:
        raise InputError("found a header and no rows", "give one row per station of the blade")
    return labels, np.array(table, dtype=np.float64)


def check_radius(own: float, given: float | None, tolerance: float | None = None) -> None:
    """Raise ``InputError`` unless ``given`` [m] agrees with the radius of the file, to 0.1 %."""
    limit = RADIUS_TOLERANCE * own if tolerance is None else tolerance
    if given is not None and not abs(given - own) <= limit:
        found = f"the radius is {own:.6g} m at the last station, but {given:g} m was given"
        raise InputError(found, "omit the radius or correct it")


def usable_radius(radius: float | None) -> float:
    """Return the checked tip radius [m] for a file with fractions of the radius."""
    if radius is None:
        raise InputError("the file contains only fractions of the radius", GIVE_RADIUS)
    if not (isinstance(radius, int | float) and 0.0 < radius < math.inf):
        found = f"the radius is {quoted(radius)} m, expected a length above 0"
        raise InputError(found, GIVE_RADIUS)
    return float(radius)


def check_fractions(fraction: Floats, labels: Sequence[str]) -> None:
    """Raise ``InputError`` unless fractions of the radius, shape (n,), end at the tip, 1.0."""
    high = int(np.argmax(fraction))
    if fraction[high] > 1.0:
        found = f"{labels[high]}: r/R is {fraction[high]:g}, expected at most 1"
        found += "; it looks like percent" if fraction[high] == 100.0 else ""
        raise InputError(found, "divide by the tip radius, or add the unit to the column name")
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
    """Return a checked ``Propeller``; ``blade`` is station, chord and twist, with row labels."""
    check_blade(*blade, labels)
    if blades is None:
        raise InputError("the file contains no number of blades", GIVE_BLADES)
    return Propeller(name, check_blades(blades), *blade, None, source, citation)


# --- TOML files in the format of propmap, one per propeller --------------------------------------

BLADE_SCHEMA = 1


def read_propeller_toml(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """Read a propeller from a TOML file in the format of the catalogue."""
    # Imported here because it loads msgspec, which the bundled propellers do not need.
    from propmap.io.toml import PropellerFile, read_toml

    file = read_toml(path, PropellerFile, BLADE_SCHEMA, "geometry")
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
    """Return the text of a TOML file for ``read_propeller_toml``."""
    import tomli_w

    fields = {
        "schema": BLADE_SCHEMA,
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


# --- CSV files with units in the column names ----------------------------------------------------

STATION, CHORD = ("radius_m", "r_over_R"), ("chord_m", "c_over_R")
TWIST = ("twist_deg",)
KNOWN = (*STATION, *CHORD, *TWIST)
COMMENT_KEYS = ("name", "blades", "radius_m", "source", "citation")


def read_propeller_csv(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """Read a propeller from a CSV file with one row per station, from root to tip.

    The columns are radius_m or r_over_R, chord_m or c_over_R, and twist_deg, in any unit and
    spelling of ``propmap.io.columns`` and any dialect of ``propmap.io.csv``; other columns are not
    used.  Lines that start with # are comments; ``# blades: 3``, ``# radius_m: 0.1``,
    ``# name:``, ``# source:`` and ``# citation:`` are evaluated.  Without a number of blades, a
    title such as "HQ 5x4.3x3" supplies it.
    """
    where, lines = os.fspath(path), read_lines(path)
    file = read_csv_table(lines, _columns_in(lines), where, comments=True)
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
            columns = _choose_columns(Header(file.header, KNOWN))
        labels, table = parse_rows(file.rows, file.header, [one.name for one in columns.values()])
        if "radius_m" in stated:
            with located("# radius_m"):
                in_file = usable_radius(parse_number(stated["radius_m"], "the radius"))
                check_radius(in_file, radius)
                radius = in_file
        station, chord, twist = _in_si(columns, table, radius, labels)
        with located(labels[-1]):
            check_radius(float(station[-1]), radius)
        if blades is None and "blades" in stated:
            with located("# blades"):
                blades = parse_blades(stated["blades"])
        elif blades is None:
            blades = blades_in_title(where, lines)
        name, source = stated.get("name", Path(where).stem), f"file {Path(where).name}"
        texts = stated.get("source", source), stated.get("citation", "")
        return build_propeller(labels, name, blades, (station, chord, twist), *texts)


def _columns_in(lines: Sequence[str]) -> list[str]:
    """Return the names in the header that are columns of a blade."""
    first = next((line for line in lines if line.strip() and not is_comment(line)), "")
    return columns_in(first, KNOWN)


def _choose_columns(header: Header) -> dict[str, Taken]:
    """Return the columns of station, chord and twist, by column of ``KNOWN``."""
    found = {columns: header.one_of(*columns) for columns in (STATION, CHORD, TWIST)}
    chosen: dict[str, Taken] = {}
    for columns, one in found.items():
        if one is None:
            missing = f"no column contains {QUANTITIES[columns[0]].words}"
            remedy = f"add {' or '.join(columns)}"
            raise InputError(f"{missing}; {header.listed()}", remedy)
        chosen[next(name for name in columns if one in header.taken.get(name, ()))] = one
    return chosen


def _in_si(
    columns: dict[str, Taken], table: Floats, radius: float | None, labels: Sequence[str]
) -> tuple[Floats, Floats, Floats]:
    """Return station, chord and twist (n,) in [m], [m], [rad]."""
    # A product too large for a float becomes inf, which the check of the blade reports.
    with np.errstate(over="ignore"):
        station, chord, twist = table.T * [[one.factor] for one in columns.values()]
        if "r_over_R" in columns:
            tip = usable_radius(radius)
            check_fractions(station, labels)
            station = station * tip
        if "c_over_R" in columns:
            chord = chord * station[-1]
    if columns["twist_deg"].factor != 1.0:
        return station, chord, table[:, 2]
    with located(columns["twist_deg"].name):
        return station, chord, twist_from_degrees(twist)


# --- Files of the UIUC Propeller Database: ``r/R c/R beta`` --------------------------------------

HEADER = ["r/R", "c/R", "beta"]

UIUC_CITATION = (
    "Brandt, Deters, Ananda, Dantsker, Selig, UIUC Propeller Database, vols 1-3, "
    "University of Illinois"
)


def read_uiuc_geometry(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """Read a propeller from a UIUC geometry file: r/R, c/R and beta in degrees.

    The files contain neither radius nor number of blades.  The reader uses a number in the name or
    title of the file; without one, it assumes 2 blades for a file of the database.  For a file that
    does not seem to be from the database, ``blades`` is required.  Blanks or commas separate the
    columns; lines that start with # are comments.  The last row must be the tip, r/R = 1.
    """
    lines, file = read_lines(path), Path(path)
    with located(os.fspath(path)):
        numbered = [(number, line) for number, line in enumerate(lines, start=1) if line.strip()]
        body = [(n, re.sub("[,;]", " ", t).split()) for n, t in numbered if not is_comment(t)]
        if not body or body[0][1] != HEADER:
            number, names = body[0] if body else (1, [])
            found = f"line {number}: the header is {quoted(' '.join(names))}"
            remedy = "give the *_geom.txt file of the database"
            raise InputError(f"{found}, expected 'r/R c/R beta'", remedy)
        tip, rows = usable_radius(radius), body[1:]
        labels, table = parse_rows(rows, HEADER, HEADER)
        check_fractions(table[:, 0], labels)
        blade = table[:, 0] * tip, table[:, 1] * tip, twist_from_degrees(table[:, 2])
        stated = _stated_blades(lines) or blades_in_title(file, lines)
        # A mention of the database, or a name in the style of its files.
        like = re.search(r"uiuc|_geom\b|\d+x\d", "\n".join([file.name, *lines[:_HEAD]]), re.I)
        count = (stated or (2 if like else None)) if blades is None else blades
        source = f"UIUC geometry file {file.name}"
        return build_propeller(labels, file.stem, count, blade, source, UIUC_CITATION)


# --- Files of APC: ``*-PERF.PE0`` ----------------------------------------------------------------

UNITS = {"STATION": "(IN)", "CHORD": "(IN)", "TWIST": "(DEG)"}

APC_CITATION = "Landing Products Inc. (APC Propellers), propeller performance data files"

# The trailer has lengths in inches with two decimals.
TRAILER_TOLERANCE = 0.0051 * INCH


def read_apc_pe0(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """Read a propeller from an APC PE0 file.

    TWIST is the angle of the line from leading to trailing edge.  The blade has loads from the
    first station, or from the hub transition (HUBTRA) if it is farther out.
    """
    lines = read_lines(path)
    with located(os.fspath(path)):
        begin = ["STATION", "CHORD"]
        header = next((k for k, text in enumerate(lines) if text.split()[:2] == begin), None)
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
            with located("RADIUS"):  # a table that ends before this radius is incomplete
                stated = parse_number(trailer["RADIUS"], "the radius") * INCH
                check_radius(result.radius, stated, TRAILER_TOLERANCE)
        check_radius(result.radius, radius)
        if "HUBTRA" not in trailer:
            return result
        with located("HUBTRA"):
            hub = parse_number(trailer["HUBTRA"], "the hub transition") * INCH
            inside = hub <= result.root + TRAILER_TOLERANCE
            return result if inside else result.with_root_cutout(hub)


# --- Files of QPROP, XROTOR and OpenVSP, without their section laws ------------------------------

NEAR_TIP = 0.97  # share of the radius from which a blade is extrapolated linearly to its tip
LAW_NOT_READ = (
    "its section law is not read: propmap chooses section constants as for any other blade; "
    "--airfoil selects others"
)
Numbered = list[tuple[int, list[float]]]  # rows of numbers with their line numbers
Written = tuple[str, float, Numbered, float | None]  # title, blades, rows and tip, in [m] and [deg]


def _qprop(lines: Sequence[str]) -> Written:
    """Read rows of r, chord, beta, and apply the factors and offsets."""
    first = next((k for k, line in enumerate(lines) if line.strip()[:1] not in ("", "!", "#")), 0)
    rows = _numbers(lines[first + 1 :], first + 2)
    # Nblades [R], CL0 CL_a, CLmin CLmax, CD0 CD2u CD2l CLCD0, REref REexp, factors, offsets
    head, body = rows[:7], rows[7:]
    if not body or any(len(row) < 3 for _, row in (*head[5:], *body)):
        found = "expected 7 lines of parameters above rows of r, chord, beta"
        raise InputError(found, "give a file that QPROP can read")
    count, factor, offset = head[0][1], np.array(head[5][1][:3]), np.array(head[6][1][:3])
    table = [(n, (np.array(row[:3]) * factor + offset).tolist()) for n, row in body]
    # The radius is in meters in some files, in the unit of the rows in others.
    tips = [count[1] * factor[0] + offset[0], count[1]] if len(count) > 1 else [None]
    last = table[-1][1][0]
    tip = next((one for one in tips if one and NEAR_TIP * one < last <= one * 1.001), tips[0])
    return lines[first].strip(), count[0], table, tip


def _xrotor(lines: Sequence[str]) -> Written:
    """Read rows of r/R, C/R, Beta0deg, and the radius."""
    tip = _below(lines, r"!\s*Rad\s+Vel", "the radius")[0][1][0]
    (_, counts), *rows = _below(lines, r"!.*(stations|Nblds)", "the stations")
    if not rows:
        raise InputError("there are no stations", "give the file as XROTOR writes it")
    return lines[1].strip(), counts[-1], _scaled(rows, counts[0], tip), tip


def _bem(lines: Sequence[str]) -> Written:
    """Read rows of radius/R, chord/R, twist, and the diameter, which is assumed to be in meters."""
    stated: dict[str, float] = {}
    for number, line in enumerate(lines, start=1):
        key, colon, value = line.partition(":")
        key = key.strip().replace("Num_Blades", "Num_Blade")  # the spelling of some scripts
        if colon and key in ("Num_Sections", "Num_Blade", "Diameter"):
            stated[key] = parse_number(value, key, f"line {number}")
    rows = _below(lines, r"\s*Radius/R\s*,\s*Chord/R\s*,\s*Twist \(deg\)", "the stations")
    if len(stated) < 3:
        found = "Num_Sections, Num_Blade or Diameter is missing"
        raise InputError(found, "give the file as OpenVSP writes it")
    sections, count, diameter = (stated[k] for k in ("Num_Sections", "Num_Blade", "Diameter"))
    return "", count, _scaled(rows, sections, 0.5 * diameter), 0.5 * diameter


PROGRAMS = {formats.QPROP: _qprop, formats.XROTOR: _xrotor, formats.BEM: _bem}


def read_of_program(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """Read a propeller from a file of QPROP, XROTOR or OpenVSP.

    If the rows end just before the tip, the blade is extrapolated.
    """
    lines, file = read_lines(path), Path(path)
    with located(os.fspath(path)):
        title, count, rows, tip = PROGRAMS[format_of(lines)](lines)  # type: ignore[index]
        labels, table = [f"line {n}" for n, _ in rows], np.array([row for _, row in rows])
        last = table[-1, 0]
        if tip is not None and len(table) > 1 and NEAR_TIP * tip < last < tip * (1.0 - 1e-6):
            share = (tip - table[-2, 0]) / (last - table[-2, 0])
            added = np.maximum(table[-2] + share * (table[-1] - table[-2]), (0.0, 0.0, -90.0))
            labels, table = [*labels, "the tip"], np.vstack([table, added])
        if tip is not None:
            check_radius(float(table[-1, 0]), tip)
        blade = table[:, 0], table[:, 1], twist_from_degrees(table[:, 2])
        own = (int(count) if count.is_integer() else count) if blades is None else blades
        made = build_propeller(labels, title or file.stem, own, blade, f"file {file.name}")  # type: ignore[arg-type]
        check_radius(made.radius, radius)
        return made


def _numbers(lines: Sequence[str], first: int) -> Numbered:
    """Return lines of numbers, separated by blanks or commas, up to the first other line."""
    rows: Numbered = []
    for number, line in enumerate(lines, start=first):
        cells = re.split("[!#]", line)[0].replace(",", " ").split()
        if cells:
            try:
                rows.append((number, [parse_number(cell, "a value") for cell in cells]))
            except InputError:
                break
    return rows


def _below(lines: Sequence[str], sign: str, what: str) -> Numbered:
    """Return the rows of numbers below the line that matches a ``sign``."""
    for k, line in enumerate(lines):
        rows = _numbers(lines[k + 1 :], k + 2) if re.match(sign, line, re.IGNORECASE) else []
        if rows:
            return rows
    raise InputError(f"found no {what}", "give the whole file")


def _scaled(rows: Numbered, count: float, tip: float) -> Numbered:
    """Return ``count`` rows with station and chord, over the radius, multiplied by ``tip`` [m]."""
    table = [(n, [row[0] * tip, row[1] * tip, row[2]]) for n, row in rows if len(row) > 2]
    if not 1 <= count <= len(table):
        found = f"found {len(table)} stations, expected {count:g}"
        raise InputError(found, "give the whole file")
    return table[: int(count)]


READERS: dict[Format | None, Callable[..., Propeller]] = {
    formats.PE0: read_apc_pe0,
    formats.UIUC_GEOMETRY: read_uiuc_geometry,
    **dict.fromkeys(PROGRAMS, read_of_program),
    formats.TOML: read_propeller_toml,
    None: read_propeller_csv,
}


def read_geometry_file(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """Read a propeller from a file in any supported format, which is recognized by content."""
    where, lines = os.fspath(path), read_lines(path)
    kind = format_of(lines)
    if kind not in READERS or (kind is None and len(_columns_in(lines)) < 1):
        wanted = "give an APC PE0 file, a UIUC geometry file (r/R c/R beta), one of QPROP, XROTOR "
        wanted += "or OpenVSP (.bem), a catalogue TOML file, or a CSV file with columns such as "
        wanted += "radius_m,chord_m,twist_deg"
        raise not_read(lines, "propeller geometry that propmap reads", wanted, where)
    return READERS[kind](path, blades=blades, radius=radius)


def how_read(file: str | os.PathLike[str], blades: int | None) -> list[str]:
    """Return remarks on recognized, unused and assumed content of a geometry file.

    ``blades`` is the number of blades that the user gave.
    """
    lines = read_lines(file)
    kind = format_of(lines)
    if kind in PROGRAMS:
        meters = "; its diameter is assumed to be in meters" if kind is formats.BEM else ""
        return [f"this is {kind.name}: {LAW_NOT_READ}{meters}"]
    stated = _stated_blades(lines) or blades_in_title(file, lines)
    if kind is formats.UIUC_GEOMETRY and blades is None and not stated:
        return ["2 blades assumed, as for most of the UIUC database; --blades sets the number"]
    if kind is None and (table := read_csv_table(lines, _columns_in(lines), comments=True)):
        header = Header(table.header, KNOWN)
        return header.remarks(_choose_columns(header))
    return []
