"""Operating points of steady flight given directly: CSV with speed, attitude and rpm."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np

from propmap.errors import InputError
from propmap.io.blade_table import parse_number
from propmap.io.csv_dialect import header_names, read_csv_table
from propmap.io.text_file import read_lines
from propmap.vehicle.log import FlightLog, in_vehicle_frame
from propmap.vehicle.powertrain import RPM
from propmap.vehicle.vehicle import Vehicle

REQUIRED = ("speed_mps", "pitch_deg")
OPTIONAL = ("roll_deg", "climb_mps", "yaw_rate_dps")
RPM_COLUMN = re.compile(r"rpm_[1-9][0-9]*")

STEEPEST = 85.0
"""Pitch and roll [deg], beyond which a table of steady flight is a slip."""


def read_level_table(path: str | os.PathLike[str], vehicle: Vehicle) -> FlightLog:
    """Operating points from a CSV file with a header line and one row per point.

    Columns are ``speed_mps`` (horizontal speed through the air towards where the nose points,
    >= 0), ``pitch_deg`` (positive when the top of the vehicle leans into the flight direction, nose
    down), ``rpm_1`` ... ``rpm_n`` (of the vehicle's rotors in their order, mechanical, >= 0), and,
    0 where missing, ``roll_deg`` (about the vehicle's x axis, after the pitch; positive right side
    down), ``climb_mps`` (up positive), ``yaw_rate_dps`` (about the vertical, positive to the left).
    Other columns are ignored.  Any dialect of ``propmap.io.csv_dialect`` is read.

    Parameters
    ----------
    path : path
        Of the file.
    vehicle : Vehicle
        Says how many rotors there are.

    Returns
    -------
    FlightLog
        With the times 0, 1, 2 ...; its ``specific_force`` is NaN.

    Raises
    ------
    InputError
        Naming the file, the line and the column.
    """
    where = os.fspath(path)
    rotors = len(vehicle.mounts)
    known = (*REQUIRED, *OPTIONAL, *_speeds(rotors))
    file = read_csv_table(read_lines(path, "table of operating points"), known, where)
    header = file.header if file else []
    names = _columns(header, rotors, where)
    if file is None or not file.rows:
        raise InputError("there is no row below the header", "add a row per point", where)
    table = np.array([_row(cells, line, header, names, where) for line, cells in file.rows])
    columns = dict(zip(names, table.T, strict=True))
    zero = np.zeros(len(table))
    pitch = np.radians(columns["pitch_deg"])
    roll = np.radians(columns.get("roll_deg", zero))
    up = in_vehicle_frame(0.0, 0.0, 1.0, pitch, roll)
    climb = columns.get("climb_mps", zero)
    return FlightLog(
        source=where,
        time=np.arange(len(table), dtype=np.float64),
        velocity=in_vehicle_frame(columns["speed_mps"], 0.0, climb, pitch, roll),
        rates=np.radians(columns.get("yaw_rate_dps", zero))[:, None] * up,
        up=up,
        specific_force=np.full((len(table), 3), np.nan),
        rotor_speed=table[:, -rotors:] * RPM,
    )


def is_level_table(path: Path) -> bool:
    """Whether the first line of the file at ``path`` names the columns of such a table."""
    if path.suffix.lower() != ".csv" or not path.is_file():
        return False
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        line = file.readline()
    needed = ("pitch_deg", "rpm_1")
    return set(needed) <= set(header_names(line, needed))


def _speeds(rotors: int) -> list[str]:
    return [f"rpm_{k}" for k in range(1, rotors + 1)]


def _columns(header: list[str], rotors: int, where: str) -> list[str]:
    """The columns to read: those of REQUIRED and OPTIONAL, then the rotors'."""
    speeds = _speeds(rotors)
    found = sum(RPM_COLUMN.fullmatch(name) is not None for name in header)
    for name in REQUIRED:
        if name not in header:
            raise InputError(
                f"line 1: column {name} is missing",
                f"the first line must name {', '.join([*REQUIRED, *speeds])}",
                where,
            )
    if found != rotors or not set(speeds) <= set(header):
        raise InputError(
            f"line 1: {found} columns rpm_1, rpm_2 ..., the vehicle has {rotors} rotors",
            f"name {', '.join(speeds)}",
            where,
        )
    names = [*REQUIRED, *(name for name in OPTIONAL if name in header), *speeds]
    repeated = [name for name in names if header.count(name) > 1]
    if repeated:
        raise InputError(f"line 1: column {repeated[0]} occurs twice", "keep one of them", where)
    return names


def _row(
    cells: list[str], line: int, header: list[str], names: list[str], where: str
) -> list[float]:
    values = []
    for name in names:
        place = header.index(name)
        at = f"{where}, line {line}, column {name}"
        value = parse_number(cells[place] if place < len(cells) else "", name, at)
        if value < 0.0 and (name == "speed_mps" or name.startswith("rpm")):
            remedy = "give 0 or more; the nose points into the flight direction, spins are known"
            raise InputError(f"{value:g} is negative", remedy, at)
        if name in ("pitch_deg", "roll_deg") and abs(value) > STEEPEST:
            remedy = f"give degrees from -{STEEPEST:g} to {STEEPEST:g}, 0 in hover"
            raise InputError(f"{value:g} is too steep for steady flight", remedy, at)
        values.append(value)
    return values
