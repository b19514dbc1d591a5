"""Static tests as thrust stands write them: CSV with rpm and loads, or a UIUC file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from propmap.errors import InputError
from propmap.fit.tunnel import TunnelData, read_tunnel
from propmap.io.csv import RPM, read_columns, read_lines
from propmap.io.uiuc import looks_like_uiuc_loads
from propmap.model.model import Air, Propeller
from propmap.typing import Floats

GRAM_FORCE = 9.80665e-3
"""[N]."""


class Column(NamedTuple):
    """What a column holds: a load, and its size in N or N m; a power is torque times Omega."""

    load: str
    unit: float
    is_power: bool = False


COLUMNS = {
    "thrust_N": Column("thrust", 1.0),
    "thrust_g": Column("thrust", GRAM_FORCE),
    "thrust_kg": Column("thrust", 1000.0 * GRAM_FORCE),
    "torque_Nm": Column("torque", 1.0),
    "torque_Ncm": Column("torque", 0.01),
    "torque_mNm": Column("torque", 0.001),
    "power_W": Column("torque", 1.0, is_power=True),
}
"""Columns of loads; power is that of the shaft."""

SPEED = "speed_mps"


def read_static(files: Sequence[Path], propeller: Propeller, air: Air) -> list[TunnelData]:
    """Loads at rest, one set per file; coefficients become loads with this propeller and air.

    Raises
    ------
    InputError
        Naming the file and what is wrong in it; also where the air moves.
    """
    return [_read(path, propeller, air) for path in files]


def _read(path: Path, propeller: Propeller, air: Air) -> TunnelData:
    if path.is_file() and looks_like_uiuc_loads(path):
        found = read_tunnel([str(path)], propeller, air)
        _check_rest(found.speed, path)
        return found
    columns = read_columns(path, ("rpm",), (*COLUMNS, SPEED), "CSV file of a static test")
    _check_rest(np.nan_to_num(columns.pop(SPEED, np.zeros(1))), path)
    omega = columns.pop("rpm") * RPM
    loads: dict[str, Floats] = {}
    for name, values in columns.items():
        column = COLUMNS[name]
        if column.load in loads:
            raise InputError(
                f"line 1: {column.load} is given twice, the second time as {name}",
                "keep one of the columns",
                str(path),
            )
        if column.is_power:
            values = np.divide(values, omega, out=np.full_like(omega, np.nan), where=omega > 0.0)
        loads[column.load] = values * column.unit
    if not loads:
        raise InputError(
            "line 1: there is no column with a load",
            f"add one of {', '.join(COLUMNS)}; power is that of the shaft",
            str(path),
        )
    still = np.zeros_like(omega)
    return TunnelData(path.name, omega, still, still, loads)


def _check_rest(speed: Floats, path: Path) -> None:
    if np.any(speed != 0.0):
        raise InputError(
            f"the air moves in some rows, by up to {np.max(speed):g} m/s",
            "fit such data with propmap fit tunnel",
            str(path),
        )


def has_power(path: Path) -> bool:
    """Whether a CSV file that was read gives the power in place of the torque."""
    return not looks_like_uiuc_loads(path) and "power_W" in "".join(read_lines(path, "CSV file"))
