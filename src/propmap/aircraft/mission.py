"""Missions: energy of the legs, and charge of the battery over time."""

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
WORDS = {EMPTY: "the battery is empty", NOT_REACHED: "after an impossible leg", **STATUSES}
"""Descriptions of the statuses of legs."""

MOMENTS = 13  # number of times per leg in ``Course``


@dataclass(frozen=True, eq=False)
class Mission:
    """Legs flown one after the other; every array is (n,).

    Attributes
    ----------
    speed, climb : ndarray
        Horizontal airspeed and climb rate [m/s].
    duration : ndarray
        Duration of each leg [s].
    source : str
        Name of the mission in messages.
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
    """Battery over a mission, at m times in each of n legs; NaN after the last possible time.

    Attributes
    ----------
    time : ndarray, shape (n, m)
        Time from the start of the mission [s].  The first time of each leg is the end of the
        previous leg.
    charge, voltage : ndarray, shape (n, m)
        State of charge [-], and voltage at the terminals of the battery [V].
    """

    time: Floats
    charge: Floats
    voltage: Floats


@dataclass(frozen=True, eq=False)
class Flown:
    """Result of a mission of an aircraft; every array is (n,).

    Attributes
    ----------
    states : SteadyStates
        Steady states of the legs.
    energy : ndarray
        Electrical energy at the terminals of the battery; shaft energy without a motor [J].
    course : Course
        Battery over time; NaN without a battery.
    status : ndarray of str
        Status of each leg: "battery_empty", "not_reached" after an impossible leg, or a status of
        ``SteadyStates``.  ``status_in_words`` describes it.
    """

    states: SteadyStates
    energy: Floats
    course: Course
    status: NDArray[np.str_]

    @property
    def charge(self) -> Floats:
        """State of charge at the end of each leg; NaN from the first impossible leg."""
        return self.course.charge[:, -1]

    @property
    def lasted(self) -> NDArray[np.bool_]:
        """Whether each leg can be flown to its end."""
        return np.isin(self.status, FLOWN)

    def status_in_words(self, leg: int) -> str:
        """Return the status of the leg with index ``leg`` (from 0) in words."""
        return WORDS[str(self.status[leg])]


def fly(aircraft: Aircraft, mission: Mission) -> Flown:
    """Compute states, energy and charge of a mission, without transitions between legs.

    A mission may use the usable share of the battery.  During a leg, the needed voltage and current
    must stay within the limits of the battery.

    Parameters
    ----------
    aircraft, mission : Aircraft, Mission
        Aircraft and its mission.

    Returns
    -------
    Flown
        Result for the n legs.
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
            power = np.full(MOMENTS, states.electrical_power[k])
            if not math.isfinite(now) or not math.isfinite(power[0]):
                break
            full = np.full(MOMENTS, now)
            along = battery.charge_after(power, mission.duration[k] * moments, full)
            there = battery.voltage(power, along)
            used = battery.share_used(power, along)
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
    """Read a mission from a CSV file with columns ``speed_mps``, ``climb_mps``, ``duration_s``.

    Parameters
    ----------
    path : path
        Path of the file, in any dialect of ``propmap.io.csv``.

    Returns
    -------
    Mission
        Legs in the order of the file.

    Raises
    ------
    InputError
        For an invalid file, with file, line and column.
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
