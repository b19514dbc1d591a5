"""Propellers of the UIUC database: their rows, blades, and corrections of wrong labels.

Eight runs of the NR640 are filed under a wrong number of blades, three or four.  Within the scatter
of repeated runs, seven have the loads of two blades, and one has the loads of four.  Thrust and
power for the filed number of blades differ from these loads by 33 to 100 %.  Each wrong number is
the first digit of the rotational speed of the run.  With the filed numbers, runs at the same
rotational speed differ by a quarter; with the corrected numbers, they agree.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap import catalogue
from propmap.catalogue.designation import Designation, designation
from propmap.catalogue.expected import MeanBlade
from propmap.errors import InputError
from propmap.io.csv import read_csv_table, read_lines
from propmap.io.geometry import parse_blades, parse_number
from propmap.model.propeller import Propeller
from propmap.typing import Floats

MISFILED = {  # correct number of blades by name in the database and rotational speed [1/min]
    ("nr640 5x3.16 - 4", 4031.0): 2,
    ("nr640 5x4.29 - 4", 4027.0): 2,
    ("nr640 9x5.68 - 3", 3023.0): 2,
    ("nr640 9x5.68 - 3", 3024.0): 4,
    ("nr640 9x5.68 - 4", 4035.0): 2,
    ("nr640 9x7.72 - 3", 3020.0): 2,
    ("nr640 9x7.72 - 4", 4051.0): 2,
    ("nr640 9x7.72 - 4", 4058.0): 2,
}
LOST_POINTS = {  # correct labels of blades whose labels lack a decimal point
    "ancf 12.0x65.0": "ancf 12.0x6.5",
    "ancf 13.0x65.0": "ancf 13.0x6.5",
    "ancf 125.0x6.0": "ancf 12.5x6.0",
    "ancf 125.0x75.0": "ancf 12.5x7.5",
    "ancf 125.0x9.0": "ancf 12.5x9.0",
}
SPECIMENS = ("", "-b", "-c")  # endings of catalogue names if several specimens were measured
MAKERS_FILES = {"apce": "apc-{}e", "apcsf": "apc-{}sf", "apcsp": "apc-{}"}
"""Catalogue names of blades from manufacturers' files, by family."""


COLUMNS = ("PropName", "BladeName", "Family", "B", "J", "N", "CT", "CP")


class MeasuredPropeller(NamedTuple):
    """The n rows of one propeller of the database."""

    name: str  # PropName in the database
    blade: str  # BladeName in the database
    family: str  # code of the manufacturer's series, Family in the database
    blades: int
    rpm: Floats  # (n,) [1/min]
    advance: Floats  # (n,): J = V/(n D) [-], 0 at rest
    thrust: Floats  # (n,): C_T = T/(rho n^2 D^4) [-]
    power: Floats  # (n,): C_P = P/(rho n^3 D^5) [-]
    run: NDArray[np.intp]  # (n,): number of the run: consecutive rows at one rpm, or at rest


def read_uiuc_database(path: Path) -> list[MeasuredPropeller]:
    """Read the propellers of the database's table of loads, in the order of the file.

    The table is a CSV file with the columns ``COLUMNS``, in any dialect of ``propmap.io.csv``.
    Raises ``InputError`` for a missing file or column.  For a cell that is not a number, the error
    names the line.
    """
    where = str(path)
    file = read_csv_table(read_lines(path, "table of loads"), COLUMNS[3:], where)
    header = file.header if file else []
    missing = [name for name in COLUMNS if name not in header]
    if file is None or missing:
        raise InputError(
            f"there is no column {missing[0]}",
            f"give the database's loads as CSV with {', '.join(COLUMNS)}",
            where,
        )
    found: dict[str, list[tuple[int, Mapping[str, str]]]] = {}
    for line, cells in file.rows:
        row = dict(itertools.zip_longest(header, cells, fillvalue=""))
        found.setdefault(row["PropName"], []).append((line, row))
    return [_propeller(name, rows, where) for name, rows in found.items()]


def _propeller(
    name: str, rows: list[tuple[int, Mapping[str, str]]], where: str
) -> MeasuredPropeller:
    def column(field: str) -> Floats:
        return np.array(
            [parse_number(row[field], f"line {line}: {field}", where) for line, row in rows]
        )

    _, first = rows[0]
    rpm, advance = column("N"), column("J")
    # Static rows differ in rotational speed but form one test.
    speed = np.where(advance == 0.0, 0.0, rpm)
    run = list(itertools.accumulate(speed[1:] != speed[:-1], initial=0))
    return MeasuredPropeller(
        name,
        first["BladeName"],
        first["Family"],
        parse_blades(first["B"]),
        *(rpm, advance, column("CT"), column("CP")),
        np.array(run),
    )


def refiled(every: Sequence[MeasuredPropeller]) -> list[MeasuredPropeller]:
    """Return the propellers with corrected labels: ``LOST_POINTS`` and ``MISFILED``.

    Propellers whose runs all move to another propeller are omitted.
    """
    labeled = []
    for one in every:
        blade = LOST_POINTS.get(one.blade, one.blade)
        labeled.append(one._replace(name=one.name.replace(one.blade, blade), blade=blade))
    parts: dict[str, list[tuple[MeasuredPropeller, NDArray[np.bool_]]]] = {}
    for one in labeled:
        others = [_run(one, rpm) for name, rpm in MISFILED if name == one.name]
        own = ~np.any(others, axis=0) if others else np.ones(one.rpm.size, bool)
        parts[one.name] = [(one, own)]
    for one in labeled:
        for (name, rpm), blades in MISFILED.items():
            if name == one.name and _run(one, rpm).any():
                right = parts.setdefault(f"{one.blade} - {blades}", [])
                right.append((one._replace(blades=blades), _run(one, rpm)))
    joined = [_joined(name, some) for name, some in parts.items()]
    return [one for one in joined if one.rpm.size > 0]


def _run(one: MeasuredPropeller, rpm: float) -> NDArray[np.bool_]:
    return (np.round(one.rpm) == rpm) & (one.advance > 0.0)


def _joined(
    name: str, parts: Sequence[tuple[MeasuredPropeller, NDArray[np.bool_]]]
) -> MeasuredPropeller:
    first = parts[0][0]
    if len(parts) == 1 and parts[0][1].all():
        return first

    columns: dict[str, Any] = {
        field: np.concatenate([getattr(one, field)[which] for one, which in parts])
        for field in ("rpm", "advance", "thrust", "power")
    }
    runs = [one.run[which] + 1000 * k for k, (one, which) in enumerate(parts)]
    return first._replace(
        name=name,
        blades=parts[-1][0].blades,
        run=np.concatenate(runs),
        **columns,
    )


def with_rows(tested: MeasuredPropeller, which: NDArray[np.bool_]) -> MeasuredPropeller:
    """Return the propeller with the rows ``which`` (n,) only."""
    fields = ("rpm", "advance", "thrust", "power", "run")
    return tested._replace(**{name: getattr(tested, name)[which] for name in fields})


def blade_names(tested: MeasuredPropeller) -> list[str]:
    """Return the names of the catalogue blades that fit a propeller, measured blades first."""
    family, size = family_and_size(tested)
    possible = [f"uiuc-{family}-{size}{end}" for end in SPECIMENS]
    known = catalogue.names()
    return [name for name in (*possible, makers_name(tested)) if name in known]


def makers_name(tested: MeasuredPropeller) -> str:
    """Return the catalogue name of the manufacturer's file; "" for families without files.

    The catalogue may lack the file.
    """
    family, size = family_and_size(tested)
    return MAKERS_FILES.get(family, "").format(size)


def mean_propeller(tested: MeasuredPropeller, shape: MeanBlade) -> Propeller:
    """Return the propeller that was ``tested``, with a mean blade of this ``shape``."""
    label = label_of(tested)
    return shape.propeller(tested.name, label.diameter, label.pitch, tested.blades)


def label_of(tested: MeasuredPropeller) -> Designation:
    """Return diameter and pitch from the name of a propeller's blade."""
    found = designation(" ".join(family_and_size(tested)))
    assert found is not None  # `family_and_size` has read the numbers
    return found


def family_and_size(tested: MeasuredPropeller) -> tuple[str, str]:
    """Return family and size in the spelling of catalogue names, such as "apce" and "8x6"."""
    family, _, size = tested.blade.partition(" ")
    try:
        return family, "x".join(f"{float(part):g}" for part in size.split("x"))
    except ValueError:
        raise InputError(
            f"the blade's name is {tested.blade!r}", "expected one as in 'apce 8.0x6.0'"
        ) from None
