"""Load files of the UIUC propeller database in their own text format."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from propmap.arrays.types import Floats
from propmap.errors import InputError, quoted
from propmap.io.blade_table import parse_number
from propmap.io.text_file import read_lines

FLIGHT, STATIC = ("J", "CT", "CP"), ("RPM", "CT", "CP")
_RPM_IN_NAME = re.compile(r"_(\d{3,5})\.txt$", re.IGNORECASE)


class Coefficients(NamedTuple):
    """Rows of one file, all (n,): rpm, advance ratio J = V/(n D), thrust coefficient
    C_T = T/(rho n^2 D^4) and power coefficient C_P = P/(rho n^3 D^5) [-]."""

    rpm: Floats
    advance: Floats
    thrust: Floats
    power: Floats


def looks_like_uiuc_loads(path: Path) -> bool:
    """Whether the first line is a header of such a file."""
    if path.suffix.lower() != ".txt":
        return False
    return tuple(_words(read_lines(path, "load file")[0])[:3]) in (FLIGHT, STATIC)


def read_uiuc_loads(path: Path, rpm: float | None = None) -> Coefficients:
    """Rows under ``J CT CP [eta]`` (one rotational speed) or ``RPM CT CP`` (static).

    rpm : of a file with J; by default the number at the end of its name, as in
    apcsf_10x7_kt0828_3008.txt.
    Raises ``InputError`` naming the file and the line.
    """
    where = str(path)
    lines = [
        (number, _words(line))
        for number, line in enumerate(read_lines(path, "load file"), start=1)
        if line.strip()
    ]
    header = tuple(lines[0][1][:3])
    if header not in (FLIGHT, STATIC):
        raise InputError(
            f"line 1: found {quoted(' '.join(lines[0][1]))}",
            "the header must be J CT CP (eta) or RPM CT CP",
            where,
        )
    if len(lines) == 1:
        raise InputError("there is no row below the header", "give the whole file", where)
    rows = []
    for number, words in lines[1:]:
        place = f"{where}, line {number}"
        if len(words) < 3:
            raise InputError(
                f"found {len(words)} numbers, expected 3", "give one row a line", place
            )
        rows.append(
            [parse_number(word, name, place) for word, name in zip(words, header, strict=False)]
        )
    first, thrust, power = np.array(rows).T[:3]
    if header == STATIC:
        return Coefficients(first, np.zeros_like(first), thrust, power)
    if rpm is None:
        found = _RPM_IN_NAME.search(path.name)
        if found is None:
            raise InputError(
                "the rotational speed is not in the file's name",
                "name the file as in apcsf_10x7_kt0828_3008.txt, which is 3008 rpm",
                where,
            )
        rpm = float(found.group(1))
    return Coefficients(np.full_like(first, rpm), first, thrust, power)


def _words(line: str) -> list[str]:
    return line.split()
