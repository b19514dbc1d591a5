"""Readers of section tables in formats of other programs, and extrapolation of polars."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from propmap.errors import InputError, located, quoted
from propmap.io import formats
from propmap.io.columns import Header
from propmap.io.csv import SEPARATORS, columns_in, is_comment, read_csv_table, read_lines
from propmap.io.formats import Format, format_of, not_read
from propmap.io.geometry import parse_number
from propmap.model.airfoil import SectionTable
from propmap.typing import Floats

# --- Formats of section tables: AeroDyn, XFOIL, QBlade, CACTUS, CCBlade and CSV ------------------

Lines = list[tuple[int, str]]  # lines that are not empty, with their numbers from 1
Row = tuple[int, float, float, float]  # line number, angle of attack [deg], C_L, C_D

ONE_EACH = "give a folder with one polar per file, or CSV with the columns alpha_deg,re,cl,cd"
CSV_COLUMNS = ("alpha_deg", "re", "cl", "cd")
CSV = Format("CSV", "", formats.POLAR)
CCBLADE = Format("CCBlade", "", formats.POLAR)


def section_format(lines: Lines) -> Format | None:
    """Return the format of the lines of a file, a key of ``READERS``, or None."""
    texts = [line for _, line in lines]
    found = format_of(texts)
    if found in (None, formats.QBLADE, formats.XFOIL) and (
        _csv_header(lines) is not None or found is None
    ):
        found = CSV if _csv_header(lines) is not None else CCBLADE if _is_ccblade(texts) else None
    return found if found in READERS else None


def _aerodyn(lines: Lines) -> Iterator[tuple[float, list[Row]]]:
    """Read v13 and v14: each table has Re in millions, parameters, and rows up to EOT."""
    start = next(k for k, (_, line) in enumerate(lines) if "airfoil tables" in line.lower())
    count = _whole(lines[start])
    rest = iter(lines[start + 1 :])
    for number in range(1, count + 1):
        first = next(rest, None)
        if first is None:
            raise InputError(f"table {number} of {count} is missing", "give the whole file")
        reynolds = 1e6 * parse_number(first[1].split()[0], "Re", f"line {first[0]}")
        rows: list[Row] = []
        for line in rest:
            if line[1].strip().upper().startswith("EOT"):
                break
            if _is_row(line[1]):
                rows.append(_row(line, most=4 if count > 1 else None))
            elif rows:
                found = f"found {quoted(line[1].strip())} between rows"
                raise InputError(found, "end a table with EOT", f"line {line[0]}")
        yield reynolds, rows
    if beyond := [n for n, line in rest if _is_row(line)]:
        found = f"found a row after table {count}, the last table that the file states"
        raise InputError(found, "correct the number of tables", f"line {beyond[0]}")


def _aerodyn_15(lines: Lines) -> Iterator[tuple[float, list[Row]]]:
    """Read v15: lines of a value and a keyword; NumAlf is the number of rows that follow."""
    plain = [(n, line.partition("!")[0]) for n, line in lines]
    rest = iter([(n, line) for n, line in plain if line.strip()])
    reynolds = None
    for line in rest:
        words = line[1].split()
        keyword = words[1] if len(words) > 1 else ""
        if keyword == "Re":
            reynolds = 1e6 * parse_number(line[1].split()[0], "Re", f"line {line[0]}")
        elif keyword == "NumAlf":
            if reynolds is None:
                raise InputError("no Re before NumAlf", "give Re in millions", f"line {line[0]}")
            count = _whole(line)
            rows = [_row(row) for _, row in zip(range(count), rest, strict=False)]
            if len(rows) < count:
                found = f"found {len(rows)} rows, NumAlf is {count}"
                raise InputError(found, "give the whole file")
            yield reynolds, rows
            reynolds = None


def _xfoil(lines: Lines) -> Iterator[tuple[float, list[Row]]]:
    """Read one polar with rows in any order."""
    sign = re.compile(formats.XFOIL.sign, re.IGNORECASE)
    heads = [k for k, (_, line) in enumerate(lines) if sign.match(line)]
    head = heads[0]
    if len(heads) > 1 or len(re.findall(r"\bCL\b", lines[head][1], re.IGNORECASE)) > 1:
        raise InputError("found a second polar", ONE_EACH, f"line {lines[heads[-1]][0]}")
    rows = [line for line in lines[head + 1 :] if set(line[1].strip()) - set("- ")]
    yield _reynolds(lines[:head]), [_row(line) for line in rows]


def _qblade(lines: Lines) -> Iterator[tuple[float, list[Row]]]:
    """Read the polars of all Reynolds numbers.  A row contains the angle, then three coefficients
    for each Reynolds number (C_L, C_D, C_m), or six if the polars are decomposed."""
    start = next((k for k, (_, line) in enumerate(lines) if _is_row(line)), len(lines))
    head = [line.partition(" - ")[0].split() for _, line in lines[:start]]
    listed = next((words for words in head if "REYNOLDS" in words), [])
    numbers = [parse_number(word, "Re") for word in listed if word != "REYNOLDS"] or [0.0]
    each = 6 if ["1", "ISDECOMPOSED"] in head else 3
    rows = [(n, line.split()) for n, line in lines[start:]]
    for n, words in rows:
        if len(words) != 1 + each * len(numbers):
            found = f"found {len(words)} numbers, expected the angle and {each} coefficients "
            found += f"for each of {len(numbers)} Reynolds numbers"
            raise InputError(found, ONE_EACH, f"line {n}")
    for k, reynolds in enumerate(numbers):
        yield reynolds, [_row((n, " ".join([w[0], *w[1 + each * k :]]))) for n, w in rows]


def _reynolds(lines: Lines) -> float:
    """Return the Reynolds number above the rows of a polar; 0 if it is missing."""
    text = "\n".join(line for _, line in lines)
    if found := re.search(r"\bRe\s*=\s*(\d[\d.]*)(?:\s*e\s*([+-]?\d{1,2})\b)?", text):
        return parse_number(found[1], "Re") * 10.0 ** int(found[2] or 0)
    found = re.search(r"reynolds number\W+(\d[\d.e+]*)", text, re.IGNORECASE)
    return 0.0 if found is None else parse_number(found[1], "Reynolds number")


def _cactus(lines: Lines) -> Iterator[tuple[float, list[Row]]]:
    """Read tables, each with a line with the Reynolds number, parameters, and rows."""
    starts = [k for k, (_, line) in enumerate(lines) if line.lower().startswith("reynolds number:")]
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        n, line = lines[start]
        reynolds = parse_number(line.partition(":")[2], "Reynolds number", f"line {n}")
        body = [one for one in lines[start + 1 : end] if ":" not in one[1]]
        yield reynolds, [_row(one) for one in body if one[1][:1] not in "Aa"]


def _csv_header(lines: Lines) -> int | None:
    """Return the index of the header of angle, C_L and C_D, below the preamble of airfoiltools."""
    for k, (_, line) in enumerate(lines[: formats.HEAD]):
        if not is_comment(line) and any(mark in line for mark in SEPARATORS):
            taken = Header(columns_in(line, CSV_COLUMNS), CSV_COLUMNS).taken
            if {"alpha_deg", "cl", "cd"} <= set(taken):
                return k
    return None


def _csv(lines: Lines) -> Iterator[tuple[float, list[Row]]]:
    """Read columns by name; rows with the same Reynolds number are one table."""
    start = _csv_header(lines)
    assert start is not None  # section_format has found the header
    numbered = dict(lines[start:])
    every = [numbered.get(n, "") for n in range(1, lines[-1][0] + 1)]
    file = read_csv_table(every, columns_in(lines[start][1], CSV_COLUMNS), comments=True)
    assert file is not None
    found = Header(file.header, CSV_COLUMNS)
    taken = {name: one for name in CSV_COLUMNS if (one := found.one_of(name)) is not None}
    if missing := {"alpha_deg", "cl", "cd"} - taken.keys():
        fault = f"column {sorted(missing)[0]} is missing; {found.listed()}"
        raise InputError(fault, "correct the header or the units below it", f"line {file.line}")
    above = _reynolds(lines[:start])
    tables: dict[float, list[Row]] = {}
    for number, cells in file.rows:
        place = f"line {number}"
        if len(cells) < len(file.header):
            count = f"found {len(cells)} fields, expected {len(file.header)}"
            raise InputError(count, "complete the row", place)
        row = {n: parse_number(cells[t.place], n, place) * t.factor for n, t in taken.items()}
        tables.setdefault(row.get("re", above), []).append(
            (number, row["alpha_deg"], row["cl"], row["cd"])
        )
    yield from tables.items()


def _is_ccblade(texts: Sequence[str]) -> bool:
    """Return whether a title, a Reynolds and a Mach number precede rows of three numbers."""
    counts = [len(text.split()) for text in texts[1:5]]
    return counts in ([1, 1, 3, 3], [1, 1, 4, 4]) and all(map(_is_row, texts[3:5]))


def _ccblade(lines: Lines) -> Iterator[tuple[float, list[Row]]]:
    """Read one polar with angles in radians, or in degrees if the angles are too large."""
    rows = [_row(line) for line in lines[3:]]
    turn = 1.0 if max(abs(row[1]) for row in rows) > 2.0 * np.pi else np.degrees(1.0)
    reynolds = parse_number(lines[1][1], "Re", f"line {lines[1][0]}")
    yield reynolds, [(n, angle * turn, lift, drag) for n, angle, lift, drag in rows]


READERS: dict[Format, Callable[[Lines], Iterator[tuple[float, list[Row]]]]] = {
    formats.AERODYN: _aerodyn,
    formats.AERODYN_15: _aerodyn_15,
    formats.QBLADE: _qblade,
    formats.XFOIL: _xfoil,
    formats.CACTUS: _cactus,
    CCBLADE: _ccblade,
    CSV: _csv,
}
"""Readers by format; each yields the Reynolds number and the rows of every table."""


def lines_of(path: Path) -> Lines:
    """Return the nonempty lines of a file."""
    return [(n, t) for n, t in enumerate(read_lines(path, "section table"), start=1) if t.strip()]


def _row(line: tuple[int, str], most: int | None = None) -> Row:
    words, place = line[1].split(), f"line {line[0]}"
    if len(words) < 3 or (most and len(words) > most):
        found = f"found {len(words)} numbers, expected angle, C_L, C_D and possibly C_m"
        raise InputError(found, "write one row per line, and tables below each other", place)
    names = ("the angle", "C_L", "C_D")
    angle, lift, drag = (parse_number(w, n, place) for w, n in zip(words, names, strict=False))
    return line[0], angle, lift, drag


def _is_row(line: str) -> bool:
    """Return whether a line of AeroDyn is a row: three or more numbers and nothing else."""
    words = line.split()
    return len(words) >= 3 and all(re.fullmatch(r"[-+.\deEdD]+", word) for word in words)


def _whole(line: tuple[int, str]) -> int:
    word = line[1].split()[0]
    if not word.isdigit() or int(word) < 1:
        found = f"found {quoted(word)}, expected a count"
        raise InputError(found, "give 1 or more", f"line {line[0]}")
    return int(word)


# --- Section tables from files, and the combination of polars to one table -----------------------

FORMATS = (
    "give an AeroDyn airfoil file, a polar of XFOIL or a folder of them, a QBlade .plr file, "
    "a CACTUS table, a polar of CCBlade or airfoiltools, or CSV with the columns alpha_deg,cl,cd "
    "and re"
)
ONE_POLAR = (formats.XFOIL, formats.QBLADE, CCBLADE)  # formats of polars in a folder
RADIANS = 3.2  # limit of angles: polars in radians do not exceed it, polars in degrees do
LEAST_REYNOLDS = 100.0  # smaller values are in thousands
LARGEST_REYNOLDS = 1e9  # larger values were multiplied by their unit twice
ASSUMED_REYNOLDS = 1e6  # for a single table without Reynolds number; loads do not depend on it
SAME_LIFT, SAME_DRAG = 0.01, 0.1  # largest C_L and relative C_D difference of repeated rows


def read_section_table(path: str | os.PathLike[str]) -> SectionTable:
    """Read a section table from a file, or a folder with one polar per Reynolds number.

    The format is recognized by content.  Polars that end a little past stall are extrapolated to
    +-180 degrees by Viterna's method; ``source`` of the table records this.

    Parameters
    ----------
    path : str or path
        AeroDyn airfoil file (v13 to v15, all its tables), XFOIL polar or folder, QBlade .plr file
        (all its polars), CACTUS table (for example those of Sheldahl and Klimas), a polar of
        CCBlade (angles in radians) or airfoiltools, or CSV with the columns alpha_deg, cl, cd and
        possibly re.

    Raises
    ------
    InputError
        For a file that cannot be read, with its name and the line.
    """
    place = Path(path)
    files = sorted(p for p in place.iterdir() if p.is_file()) if place.is_dir() else [place]
    kinds, polars = set(), []
    for file in files:
        lines = lines_of(file)
        kind = section_format(lines)
        if kind is None or (place.is_dir() and kind not in ONE_POLAR):
            wanted = "give a folder with only polars" if place.is_dir() else FORMATS
            texts = [line for _, line in lines]
            raise not_read(texts, "section table that propmap reads", wanted, str(file))
        kinds.add(kind.name)
        with located(str(file)):
            polars += [(str(file), reynolds, rows) for reynolds, rows in READERS[kind](lines)]
    if not polars:
        raise InputError("there is no table", FORMATS, str(place))
    return _table(place, " and ".join(sorted(kinds)), polars)


def looks_like_section_table(path: Path) -> bool:
    """Return whether a path is a folder, or a file that ``read_section_table`` can read."""
    return path.is_dir() or section_format(lines_of(path)) is not None


def _table(place: Path, kind: str, found: Sequence[tuple[str, float, list[Row]]]) -> SectionTable:
    polars: list[Polar] = []
    remarks: list[str] = []
    for where, given, rows in found:
        reynolds = given
        if reynolds <= 0.0 and len(found) == 1:
            reynolds = ASSUMED_REYNOLDS
            remarks.append("Reynolds number not stated")
        with located(where):
            if not LEAST_REYNOLDS <= reynolds <= LARGEST_REYNOLDS:
                remedy = "give the Reynolds number of each table: in millions in AeroDyn files, "
                remedy += "without a factor in all other files"
                raise InputError(f"a Reynolds number is {reynolds:g}", remedy)
            if reynolds in [polar.reynolds for polar in polars]:
                raise InputError(f"Re = {reynolds:g} occurs twice", "keep one of the tables")
            polar, added = all_round(_polar(reynolds, rows))
        polars.append(polar)
        remarks += [added] if added and added not in remarks else []
    polars.sort(key=lambda polar: polar.reynolds)
    reynolds_numbers = np.array([polar.reynolds for polar in polars])
    angle, lift, drag = at_common_angles(polars)
    source = f"{place.name} ({kind})" + "".join(f", {remark}" for remark in remarks)
    with located(str(place)):
        return SectionTable(angle, reynolds_numbers, lift, drag, name=place.stem, source=source)


def _polar(reynolds: float, rows: list[Row]) -> Polar:
    """Return the rows as a polar, sorted and without repeated angles."""
    kept: list[Row] = []
    for row in sorted(rows, key=lambda row: row[1]):
        line, angle, lift, drag = row
        with located(f"line {line}"):
            if kept and angle == kept[-1][1]:
                if (
                    abs(lift - kept[-1][2]) > SAME_LIFT
                    or abs(drag - kept[-1][3]) > SAME_DRAG * drag
                ):
                    found = f"{angle:g} deg occurs twice, in line {kept[-1][0]} with other values"
                    raise InputError(found, "keep one of the rows")
                continue
            if abs(angle) > 180.01:  # 3.1416 rad is 180.0004 deg
                raise InputError(f"the angle is {angle:g}", "give degrees within +-180")
            if drag < 0.0:
                raise InputError(f"the drag coefficient is {drag:g}", "correct or remove the row")
        kept.append(row)
    if len(kept) < 8:
        found = f"the table of Re = {reynolds:g} has {len(kept)} rows, expected at least 8"
        raise InputError(found, "give more angles")
    _, angles, lifts, drags = np.array(kept).T
    if max(abs(angles)) < RADIANS:
        found = f"the largest angle is {max(abs(angles)):.4g} deg, so the angles may be in radians"
        raise InputError(found, "give the angles in degrees, or name the column alpha_rad")
    return Polar(reynolds, np.radians(angles), lifts, drags)


# --- Extrapolation of polars to all angles, and interpolation of polars at common angles ---------

ASPECT_RATIO = 10.0  # of a propeller blade, for the drag of a plate across the flow (Viterna)

BACKWARDS = 0.7
"""Lift in reverse flow over the lift in forward flow of the same section."""

STILL_RISING = 0.5
"""Slope of the lift at the last angle over the steepest slope: with a larger ratio the polar ends
before stall."""

STEP = np.radians(5.0)
CLOSED = np.radians(330.0)  # a polar over a larger range lacks only its ends
SAME_ANGLE = np.radians(0.05)  # angles of polars with a smaller difference count as equal


class Polar(NamedTuple):
    """C_L and C_D [-] (K,) at one Reynolds number, for increasing angles from the chord line."""

    reynolds: float
    angle: Floats  # [rad]
    lift: Floats
    drag: Floats


def all_round(polar: Polar) -> tuple[Polar, str]:
    """Return a polar extrapolated to -180 to 180 degrees, and a remark on the added part.

    Past stall, C_L and C_D follow Viterna and Corrigan ("Fixed Pitch Rotor Performance of Large
    Horizontal Axis Wind Turbines", NASA CP-2230, 1981): values of a finite plate, matched to the
    last row of the polar.  Beyond +-90 degrees, in reverse flow, the lift is 0.7 times the plate
    value.  Negative angles mirror these values.  From the mirrored last row to the first row, both
    coefficients are linear.  Raise ``InputError`` for a polar that ends before stall, or far past
    stall but not at 180 degrees.
    """
    ends = polar.angle[[0, -1]]
    if ends[1] - ends[0] >= CLOSED:
        return _closed(polar), ""
    low, high = np.degrees(ends).tolist()
    range_ = f"angles run from {low:g} to {high:g} deg"
    if not (-90.0 < low < high < 90.0 and high > 0.0):
        found = f"{range_}, expected -180 to 180, or a range around 0 that ends just past stall"
        raise InputError(found, "complete the table, or remove rows far past stall")
    slope = np.diff(polar.lift) / np.diff(polar.angle)
    if polar.lift[-1] <= 0.0 or slope[-1] > STILL_RISING * slope.max():
        found = f"{range_} and the lift still rises at the last angle: the polar has no stall"
        raise InputError(found, "extend the polar to larger angles")
    return _extended(polar), f"continued from {low:g} and {high:g} deg by Viterna's method"


def _closed(polar: Polar) -> Polar:
    """Return the polar with equal rows at -180 and 180 degrees."""
    inner = np.abs(polar.angle) < np.pi - SAME_ANGLE
    turn = [polar.angle, polar.angle + 2.0 * np.pi]

    def ends(values: Floats) -> Floats:
        at = float(np.interp(np.pi, np.concatenate(turn), np.tile(values, 2)))
        return np.array([at, *values[inner], at])

    angle = np.array([-np.pi, *polar.angle[inner], np.pi])
    return Polar(polar.reynolds, angle, ends(polar.lift), ends(polar.drag))


def _extended(polar: Polar) -> Polar:
    first, last = float(polar.angle[0]), float(polar.angle[-1])
    largest = max(1.11 + 0.018 * ASPECT_RATIO, float(polar.drag.max()))
    sine, cosine = np.sin(last), np.cos(last)
    a2 = (polar.lift[-1] - largest * sine * cosine) * sine / cosine**2
    b2 = (polar.drag[-1] - largest * sine**2) / cosine

    def plate(angle: Floats) -> tuple[Floats, Floats]:
        s, c = np.sin(angle), np.cos(angle)
        return largest * s * c + a2 * c**2 / s, largest * s**2 + b2 * c

    # Lift of a section in reverse flow; near 180 degrees it is linear in the angle.
    from_behind = BACKWARDS * float(polar.lift[-1])
    past = np.arange(1.0, np.ceil(2.0 * np.pi / STEP)) * STEP
    ahead = past[(past > last + 0.2 * STEP) & (past < 0.5 * np.pi + 1e-9)]
    behind = past[(past > 0.5 * np.pi + 1e-9) & (past < np.pi - last)]
    edge = past[(past > np.pi - last) & (past < np.pi - 1e-9)]
    lift_a, drag_a = plate(ahead)
    lift_b, drag_b = plate(np.pi - behind)
    drag_e = plate(np.pi - edge)[1]
    upper = np.concatenate([ahead, behind, edge])
    lift = np.concatenate([lift_a, -BACKWARDS * lift_b, from_behind * (edge - np.pi) / last])
    drag = np.concatenate([drag_a, drag_b, drag_e])
    # The lower side mirrors the upper side; one straight line joins the lower side to the polar.
    mirrored = np.concatenate([[last], ahead]) > -first + 0.2 * STEP
    lower = np.concatenate([[last], ahead])[mirrored]
    lift_l = -BACKWARDS * np.concatenate([polar.lift[-1:], lift_a])[mirrored]
    drag_l = np.concatenate([polar.drag[-1:], drag_a])[mirrored]
    back = np.concatenate([behind, edge])
    lift_k = np.concatenate([BACKWARDS * lift_b, -from_behind * (edge - np.pi) / last])
    drag_k = np.concatenate([drag_b, drag_e])
    end = plate(np.array([1e-6]))[1]
    angles = [[-np.pi], -back[::-1], -lower[::-1], polar.angle, upper, [np.pi]]
    lifts = [[0.0], lift_k[::-1], lift_l[::-1], polar.lift, lift, [0.0]]
    drags = [end, drag_k[::-1], drag_l[::-1], polar.drag, drag, end]
    least = np.maximum(np.concatenate(drags), polar.drag.min())
    return Polar(polar.reynolds, np.concatenate(angles), np.concatenate(lifts), least)


def at_common_angles(polars: Sequence[Polar]) -> tuple[Floats, Floats, Floats]:
    """Return common angles (K,) of full polars, and C_L and C_D (R, K), interpolated linearly."""
    angles = np.unique(np.concatenate([polar.angle for polar in polars]))
    kept = [float(angles[0])]
    for angle in angles[1:-1]:
        if angle - kept[-1] >= SAME_ANGLE and np.pi - angle >= SAME_ANGLE:
            kept.append(float(angle))
    angle = polars[0].angle if len(polars) == 1 else np.array([*kept, np.pi])
    lift = np.stack([np.interp(angle, polar.angle, polar.lift) for polar in polars])
    return angle, lift, np.stack([np.interp(angle, polar.angle, polar.drag) for polar in polars])
