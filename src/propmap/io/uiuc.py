"""Measured loads of the UIUC propeller database, in its own text format."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from propmap.errors import InputError, located, quoted
from propmap.io.csv import read_lines
from propmap.io.geometry import parse_rows
from propmap.typing import Floats

FLIGHT, STATIC = ("J", "CT", "CP"), ("RPM", "CT", "CP")
_RPM_IN_NAME = re.compile(r"_(\d{3,5})\.txt$", re.IGNORECASE)


class Coefficients(NamedTuple):
    """Rows (n,) of one file."""

    rpm: Floats  # [1/min]
    advance: Floats  # J = V/(n D) [-]
    thrust: Floats  # C_T = T/(rho n^2 D^4) [-]
    power: Floats  # C_P = P/(rho n^3 D^5) [-]


def looks_like_uiuc_loads(path: Path) -> bool:
    """Whether the first line of the file at ``path`` is a header of such a file."""
    if path.suffix.lower() != ".txt":
        return False
    return tuple(read_lines(path, "load file")[0].split()[:3]) in (FLIGHT, STATIC)


def read_uiuc_loads(path: Path) -> Coefficients:
    """Read rows under ``J CT CP [eta]`` (one rotational speed) or ``RPM CT CP`` (static).

    The name of a file with J ends with the rotational speed, as in apcsf_10x7_kt0828_3008.txt.
    """
    where = str(path)
    lines = enumerate(read_lines(path, "load file"), start=1)
    (_, names), *rows = [(number, line.split()) for number, line in lines if line.strip()]
    header = tuple(names[:3])
    if header not in (FLIGHT, STATIC):
        found = f"line 1: found {quoted(' '.join(names))}"
        raise InputError(found, "the header must be J CT CP (eta) or RPM CT CP", where)
    if not rows:
        raise InputError("there is no row below the header", "give the whole file", where)
    # Some rows lack the efficiency, which is not read.
    with located(where):
        _, table = parse_rows([(number, cells[:3]) for number, cells in rows], header, header)
    first, thrust, power = table.T
    if header == STATIC:
        return Coefficients(first, np.zeros_like(first), thrust, power)
    rpm = _RPM_IN_NAME.search(path.name)
    if rpm is None:
        found = "the rotational speed is not in the file's name"
        remedy = "name the file as in apcsf_10x7_kt0828_3008.txt, which is 3008 rpm"
        raise InputError(found, remedy, where)
    return Coefficients(np.full_like(first, float(rpm[1])), first, thrust, power)
