"""A mission: what its legs take, and the battery's charge along them."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.aircraft.steady import Aircraft, SteadyStates
from propmap.arrays.types import Floats
from propmap.errors import InputError
from propmap.io.blade_table import parse_number
from propmap.io.csv_dialect import read_csv_table
from propmap.io.text_file import read_lines

COLUMNS = ("speed_mps", "climb_mps", "duration_s")
EMPTY = "battery_empty"
"""Status of a leg that the battery does not last for."""


@dataclass(frozen=True, eq=False)
class Mission:
    """Legs flown one after the other; every array is (n,).

    Attributes
    ----------
    speed, climb : ndarray
        Through the air [m/s].
    duration : ndarray
        [s].
    source : str
        Where they are from.
    """

    speed: Floats
    climb: Floats
    duration: Floats
    source: str = "the mission"

    def __post_init__(self) -> None:
        if not (self.duration > 0.0).all() or not self.duration.size:
            raise InputError("a leg has no duration", "give seconds, above 0", self.source)
        if (self.speed < 0.0).any():
            raise InputError("a speed is negative", "give 0 or more m/s", self.source)


@dataclass(frozen=True, eq=False)
class Flown:
    """A mission as an aircraft flies it; every array is (n,).

    Attributes
    ----------
    states : SteadyStates
        Of the legs.
    energy : ndarray
        Electrical energy at the battery's terminals, without a motor that of the shafts [J].
    charge : ndarray
        State of charge at the end of each leg, NaN from the first that cannot be flown and without
        a battery.
    status : ndarray of str
        Of ``steady.STATUSES``, or "battery_empty".
    """

    states: SteadyStates
    energy: Floats
    charge: Floats
    status: NDArray[np.str_]


def fly(aircraft: Aircraft, mission: Mission) -> Flown:
    """Fly a mission, the changes from leg to leg left out.

    The usable share of the battery's charge is what a mission may use.

    Parameters
    ----------
    aircraft, mission : Aircraft, Mission
        What flies what.
    """
    states = aircraft.steady(mission.speed, mission.climb, margin=False)
    battery = aircraft.vehicle.powertrain.battery
    charge, status = np.full(len(states), math.nan), states.status.astype("<U20")
    now = aircraft.limits.charge
    least = now - battery.usable_share if battery else 0.0
    for k in range(len(states) if battery else 0):
        assert battery is not None
        power, duration = states.electrical_power[k], float(mission.duration[k])
        if not math.isfinite(now) or not math.isfinite(power):
            now = math.nan
            continue
        now = float(battery.charge_after(np.array(power), duration, np.array(now)))
        if not now >= least - 1e-12:
            status[k], now = EMPTY, math.nan
        charge[k] = now
    return Flown(states, states.power * mission.duration, charge, status)


def read_mission(path: str | os.PathLike[str]) -> Mission:
    """Legs from a CSV file with the columns ``speed_mps``, ``climb_mps``, ``duration_s``.

    Parameters
    ----------
    path : path
        Of the file, in any dialect of ``propmap.io.csv_dialect``.

    Raises
    ------
    InputError
        Naming the file, the line and the column.
    """
    where = os.fspath(path)
    file = read_csv_table(read_lines(path, "mission"), COLUMNS, where)
    header = file.header if file else []
    for name in COLUMNS:
        if header.count(name) != 1:
            raise InputError(
                f"line 1: column {name} is missing or occurs twice",
                f"the first line must name {', '.join(COLUMNS)}",
                where,
            )
    if file is None or not file.rows:
        raise InputError("there is no row below the header", "add a row per leg", where)
    rows = []
    for line, cells in file.rows:
        row = []
        for name in COLUMNS:
            at = f"{where}, line {line}, column {name}"
            place = header.index(name)
            value = parse_number(cells[place] if place < len(cells) else "", name, at)
            if (value < 0.0 and name == "speed_mps") or (value <= 0.0 and name == "duration_s"):
                raise InputError(f"{name} is {value:g}", "give a positive number", at)
            row.append(value)
        rows.append(row)
    speed, climb, duration = np.array(rows).T
    return Mission(speed, climb, duration, where)
