"""A mission: what its legs take, and the battery's charge along them."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.aircraft.trim import FLOWN, STATUSES, Aircraft, SteadyStates
from propmap.errors import InputError
from propmap.io.csv import read_csv_table, read_lines
from propmap.io.geometry import parse_number
from propmap.typing import Floats

COLUMNS = ("speed_mps", "climb_mps", "duration_s")
EMPTY, NOT_REACHED = "battery_empty", "not_reached"
WORDS = {EMPTY: "the battery is empty", NOT_REACHED: "after a leg that cannot be flown", **STATUSES}
"""Statuses of legs in words."""

MOMENTS = 13  # moments of each leg, at which its course is known


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


class Course(NamedTuple):
    """A mission over time, at m moments of n legs; NaN from the first that cannot be flown.

    Attributes
    ----------
    time : ndarray, shape (n, m)
        From the beginning of the mission [s]; a leg's first is the last of that before.
    charge, voltage : ndarray, shape (n, m)
        State of charge, and voltage at the battery's terminals [V].
    """

    time: Floats
    charge: Floats
    voltage: Floats


@dataclass(frozen=True, eq=False)
class Flown:
    """A mission as an aircraft flies it; every array is (n,).

    Attributes
    ----------
    states : SteadyStates
        Steady states of the legs.
    energy : ndarray
        Electrical energy at the battery's terminals, without a motor that of the shafts [J].
    course : Course
        State of charge over time; NaN without a battery.
    status : ndarray of str
        One of ``WORDS``.
    """

    states: SteadyStates
    energy: Floats
    course: Course
    status: NDArray[np.str_]

    @property
    def charge(self) -> Floats:
        """State of charge at the end of each leg, NaN from the first that cannot be flown."""
        return self.course.charge[:, -1]

    @property
    def lasted(self) -> NDArray[np.bool_]:
        """Which legs could be flown to their end."""
        return np.isin(self.status, FLOWN)

    def status_in_words(self, leg: int) -> str:
        """Return the status of the ``leg`` number 0, 1, ... in words."""
        return WORDS[str(self.status[leg])]


def fly(aircraft: Aircraft, mission: Mission) -> Flown:
    """Fly a mission, the changes from leg to leg left out.

    The usable share of the battery's charge is what a mission may use, and no leg may need more
    voltage or current than the battery has at its end.

    Parameters
    ----------
    aircraft, mission : Aircraft, Mission
        What flies what.

    Returns
    -------
    Flown
        One flight of n legs.
    """
    states = aircraft.steady(mission.speed, mission.climb, margin=False)
    battery, n = aircraft.vehicle.powertrain.battery, len(states)
    status = states.status.astype("<U20")
    ends = np.cumsum(mission.duration)
    moments = np.linspace(0.0, 1.0, MOMENTS)
    time = (ends - mission.duration)[:, None] + mission.duration[:, None] * moments
    charge, voltage = np.full((2, n, MOMENTS), math.nan)
    if battery is not None:
        now = aircraft.charge
        least = now - battery.usable_share
        needed = np.max(states.throttle * states.battery_voltage[:, None], axis=1)
        for k in range(n):
            power = float(states.electrical_power[k])
            if not math.isfinite(now) or not math.isfinite(power):
                break
            along = battery.charges(power, mission.duration[k] * moments, now)
            there = battery.voltage(np.full(MOMENTS, power), along)
            used = battery.share_used(np.full(MOMENTS, power), along)
            ends_by = {
                EMPTY: ~(along >= least - 1e-12),
                "voltage_limit": there < needed[k],
                "battery_limit": used > 1.0,
            }
            over = np.any(list(ends_by.values()), axis=0)
            if over.any():
                first = int(np.argmax(over))
                status[k] = next(name for name, where in ends_by.items() if where[first])
                along[first:] = there[first:] = math.nan
            charge[k], voltage[k], now = along, there, float(along[-1])
    lost = np.flatnonzero(~np.isin(status, FLOWN))
    if lost.size:
        status[lost[0] + 1 :] = NOT_REACHED
    return Flown(states, states.power * mission.duration, Course(time, charge, voltage), status)


def read_mission(path: str | os.PathLike[str]) -> Mission:
    """Read legs from a CSV file with the columns ``speed_mps``, ``climb_mps``, ``duration_s``.

    Parameters
    ----------
    path : path
        Path of the file, in any dialect of ``propmap.io.csv``.

    Returns
    -------
    Mission
        Mission of the legs, in order.

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
            found = f"line 1: column {name} is missing or occurs twice"
            raise InputError(found, f"the first line must name {', '.join(COLUMNS)}", where)
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
