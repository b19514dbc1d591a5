"""Readers of load coefficients: measured loads of the UIUC database, and APC's PERFILES."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from propmap.errors import InputError, located, quoted
from propmap.io.csv import is_comment, read_lines
from propmap.io.formats import PERFILES, UIUC_LOADS, format_of
from propmap.io.geometry import parse_rows
from propmap.typing import Floats

FLIGHT, STATIC = ("J", "CT", "CP"), ("RPM", "CT", "CP")
_RPM_IN_NAME = re.compile(r"_(\d{3,5})\.txt$", re.IGNORECASE)
_RPM_OF_BLOCK = re.compile(r"PROP\s+RPM\s*=\s*(\d+)")


class Coefficients(NamedTuple):
    """The rows (n,) of one file."""

    rpm: Floats  # [1/min]
    advance: Floats  # J = V/(n D) [-]
    thrust: Floats  # C_T = T/(rho n^2 D^4) [-]
    power: Floats  # C_P = P/(rho n^3 D^5) [-]
    remarks: tuple[str, ...] = ()


def looks_like_coefficients(path: Path) -> bool:
    """Return whether ``read_coefficients`` can read the file at ``path``."""
    return format_of(read_lines(path, "load table", latin=True)) in (UIUC_LOADS, PERFILES)


def read_coefficients(path: Path) -> Coefficients:
    """Read a PERFILE, or a UIUC file with columns separated by blanks or commas.

    Its header is ``J CT CP [eta]``, with the rpm in the file name, or ``RPM CT CP`` (static)."""
    lines = read_lines(path, "load table")
    with located(str(path)):
        return _perfile(lines) if format_of(lines) is PERFILES else _uiuc(path, lines)


def _uiuc(path: Path, lines: list[str]) -> Coefficients:
    body = [(n, text) for n, text in enumerate(lines, start=1) if text.strip()]
    (first, names), *rows = [
        (n, text.replace(",", " ").split()) for n, text in body if not is_comment(text)
    ]
    header = tuple(name.upper() for name in names[:3])
    if header not in (FLIGHT, STATIC):
        found = f"line {first}: found {quoted(' '.join(names))}"
        raise InputError(found, "the header must be J CT CP (eta) or RPM CT CP")
    if not rows:
        raise InputError("there is no row below the header", "give the whole file")
    # The fourth column, the efficiency, is missing in some rows.
    _, table = parse_rows([(number, cells[:3]) for number, cells in rows], header, header)
    values, thrust, power = table.T
    if header == STATIC:
        return Coefficients(values, np.zeros_like(values), thrust, power)
    rpm = _RPM_IN_NAME.search(path.name)
    if rpm is None:
        found = "the rotational speed is not in the file's name"
        remedy = "name the file as in apcsf_10x7_kt0828_3008.txt, for 3008 rpm"
        raise InputError(found, remedy)
    return Coefficients(np.full_like(values, float(rpm[1])), values, thrust, power)


def _perfile(lines: list[str]) -> Coefficients:
    """Read the blocks of a PERFILE, one per rotational speed, each with a header."""
    rpm, rows = 0.0, []
    places: list[int] = []
    for number, line in enumerate(lines, start=1):
        cells = line.split()
        if block := _RPM_OF_BLOCK.search(line):
            rpm, places = float(block[1]), []
        elif rpm and cells[:1] == ["V"]:
            known = [cell.upper() for cell in cells]
            if not set(FLIGHT) <= set(known):
                found = f"line {number}: no columns J, Ct and Cp"
                raise InputError(found, "give the file as APC publishes it")
            places = [known.index(name) for name in FLIGHT]
        elif places and cells and re.fullmatch(r"[-+.\d]+", cells[0]):
            picked = [cells[k] if k < len(cells) else "" for k in places]
            _, values = parse_rows([(number, picked)], FLIGHT, FLIGHT)
            rows.append((rpm, *values[0]))
    if not rows:
        raise InputError("there is no row of loads", "give the file as APC publishes it")
    speed, advance, thrust, power = np.array(rows).T
    return Coefficients(speed, advance, thrust, power, ("computed by APC, not measured",))
