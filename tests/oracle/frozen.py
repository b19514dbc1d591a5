"""The frozen tables of reference loads that the regular tests compare the package with."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import NamedTuple

TABLE = Path(__file__).with_name("reference_loads.csv")
EXTENDED_TABLE = Path(__file__).with_name("reference_loads_extended.csv")


class ReferenceLoads(NamedTuple):
    """Loads of the reference propeller at one point, with one section of Table I; SI but rpm."""

    set: str  # name of the section parameters, or of the extension
    rpm: float
    v_axial: float  # [m/s]
    v_inplane: float  # [m/s]
    thrust: float  # [N]
    drag: float  # [N]
    torque: float  # [N m]
    roll_moment: float  # [N m]
    static_thrust: float  # [N], in hover at the same rpm
    static_torque: float  # [N m], in hover at the same rpm


COLUMNS = ReferenceLoads._fields


def frozen_loads(table: Path = TABLE) -> list[ReferenceLoads]:
    """All rows of a frozen table, in the order in which they were computed."""
    with table.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    if tuple(header) != COLUMNS:
        raise ValueError(f"unexpected columns in {table.name}: run make_reference again")
    return [ReferenceLoads(row[0], *map(float, row[1:])) for row in rows]
