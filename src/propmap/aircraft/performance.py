"""What a power curve says: hover, least power, best range, top speed and what limits it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from propmap.aircraft.steady import VORTEX_RING, Aircraft, SteadyStates
from propmap.arrays.types import Floats
from propmap.errors import InputError

BEYOND = 1.25
"""Ratio of the speeds at which the top speed is looked for beyond those that were asked for."""

FASTEST = 150.0
"""[m/s] up to which it is looked for."""

FINER, ROUNDS = 8, 3
"""The interval with the top speed is cut into so many, so many times."""


@dataclass(frozen=True, eq=False)
class NamedState:
    """One steady state that has a name.

    Attributes
    ----------
    speed : float
        Through the air [m/s].
    ground_speed : float
        [m/s].
    power, electrical_power : float
        Electrical if known, else of the shafts; electrical, NaN if not known [W].
    endurance, distance : float
        Time and distance over ground on one battery [s], [m]; NaN without a battery.
    """

    speed: float
    ground_speed: float
    power: float
    electrical_power: float
    endurance: float
    distance: float


@dataclass(frozen=True, eq=False)
class Performance:
    """What an aircraft does in level flight.

    Attributes
    ----------
    states : SteadyStates
        At the n speeds asked for.
    endurance, distance : ndarray, shape (n,)
        On one battery [s], and over ground [m]; NaN without a battery.
    hover, least_power, best_range, fastest : NamedState or None
        At rest, at the speed of least power and longest time, at that of the most distance over
        ground (without a battery: per energy), at the top speed; None where there is none.
    limit : str
        Status of states just above the top speed; empty where none was found up to ``FASTEST``.
    wind : float
        Headwind [m/s].
    """

    states: SteadyStates
    endurance: Floats
    distance: Floats
    hover: NamedState | None
    least_power: NamedState | None
    best_range: NamedState | None
    fastest: NamedState | None
    limit: str
    wind: float


def endurance(aircraft: Aircraft, states: SteadyStates) -> Floats:
    """Time of flight in each state on one battery [s], (n,); NaN without a battery."""
    battery = aircraft.vehicle.powertrain.battery
    if battery is None:
        return np.full(len(states), math.nan)
    needed = np.max(states.throttle * states.battery_voltage[:, None], axis=1)
    return battery.endurance(states.electrical_power, needed, aircraft.limits.charge)


def performance(
    aircraft: Aircraft, states: SteadyStates, *, climb: float = 0.0, wind: float = 0.0
) -> Performance:
    """Find the states that have a name.

    Parameters
    ----------
    aircraft : Aircraft
        What flies.
    states : SteadyStates
        At two or more rising speeds, all at one climb rate, from ``aircraft.steady``.
    climb : float
        That climb rate [m/s].
    wind : float
        Headwind [m/s]; it changes distances alone.

    Raises
    ------
    InputError
        For speeds that do not rise.
    """
    speed = states.speed
    if speed.size < 2 or not (np.diff(speed) > 0.0).all():
        raise InputError("the speeds must rise", "give two or more, each once")
    fastest, limit = _fastest(aircraft, states, climb)
    ok = np.isfinite(states.power)
    least = best = math.nan
    if ok.sum() >= 2:
        power = states.power[ok]
        least = _lowest(speed[ok], power)
        # Distance per energy; where the wind is faster there is none.
        ahead = speed[ok] - wind
        if (ahead > 0.0).sum() >= 2:
            best = _lowest(speed[ok][ahead > 0.0], power[ahead > 0.0] / ahead[ahead > 0.0])
    wanted = np.array([0.0, least, best, fastest])
    asked = np.isfinite(wanted)
    named: list[NamedState | None] = [None] * len(wanted)
    if asked.any():
        found = aircraft.steady(wanted[asked], climb, margin=False)
        time = endurance(aircraft, found)
        for place, k in enumerate(np.flatnonzero(asked)):
            if found.found[place]:
                named[k] = _named(found, place, float(time[place]), wind)
    times = endurance(aircraft, states)
    ground = speed - wind
    return Performance(states, times, times * ground, *named, limit=limit, wind=wind)


def _named(states: SteadyStates, k: int, time: float, wind: float) -> NamedState:
    v = float(states.speed[k])
    return NamedState(
        speed=v,
        ground_speed=v - wind,
        power=float(states.power[k]),
        electrical_power=float(states.electrical_power[k]),
        endurance=time,
        distance=time * (v - wind),
    )


def _lowest(x: Floats, y: Floats) -> float:
    """Where y is least, by the parabola through the least sample and its neighbours."""
    k = int(np.argmin(y))
    if k in (0, x.size - 1):
        return float(x[k])
    # Divided differences, as the speeds need not be evenly spaced.
    a, b, c = x[k - 1 : k + 2]
    first = (y[k] - y[k - 1]) / (b - a)
    second = ((y[k + 1] - y[k]) / (c - b) - first) / (c - a)
    return float(np.clip(0.5 * (a + b) - 0.5 * first / second, a, c)) if second > 0.0 else float(b)


def _fastest(aircraft: Aircraft, states: SteadyStates, climb: float) -> tuple[float, str]:
    """The top speed [m/s], NaN where there is none, and what limits it."""
    low, high, why = _last_and_next(states)
    while math.isnan(high):
        start = max(low, 1.0)
        if start >= FASTEST:
            return math.nan, ""
        further = start * BEYOND ** np.arange(1.0, 6.0)
        found = aircraft.steady(np.append(low, further), climb, margin=False)
        low, high, why = _last_and_next(found)
    if math.isnan(low):
        return math.nan, why
    for _ in range(ROUNDS):
        between = np.linspace(low, high, FINER + 1)
        found = aircraft.steady(between, climb, margin=False)
        low, high, why = _last_and_next(found)
        if math.isnan(high):
            break
    return low, why


def _last_and_next(states: SteadyStates) -> tuple[float, float, str]:
    """The last speed that is flown, the next that is not, and why not; NaN where there is none."""
    flown = np.flatnonzero(np.isin(states.status, ("ok", VORTEX_RING)))
    if not flown.size:
        return math.nan, float(states.speed[0]), str(states.status[0])
    last = int(flown[-1])
    if last == len(states) - 1:
        return float(states.speed[last]), math.nan, ""
    return float(states.speed[last]), float(states.speed[last + 1]), str(states.status[last + 1])


def rows_of(states: SteadyStates) -> list[dict[str, Any]]:
    """The states as plain rows in the units of files: m/s, degrees, rpm, W, A; None for NaN."""
    rpm, degrees = 30.0 / math.pi, 180.0 / math.pi
    columns: dict[str, Floats] = {
        "speed_mps": states.speed,
        "climb_mps": states.climb,
        "bank_deg": states.bank * degrees,
        "pitch_deg": states.pitch * degrees,
        "roll_deg": states.roll * degrees,
    }
    for k in range(states.rotor_speed.shape[1]):
        columns[f"rpm_{k + 1}"] = states.rotor_speed[:, k] * rpm
    for k in range(states.rotor_speed.shape[1]):
        columns[f"thrust_{k + 1}_N"] = states.thrust[:, k]
    columns |= {
        "shaft_power_W": states.shaft_power,
        "electrical_power_W": states.electrical_power,
        "motor_current_A": states.motor_current.max(axis=1),
        "throttle": states.throttle.max(axis=1),
        "battery_current_A": states.battery_current,
        "battery_voltage_V": states.battery_voltage,
        "thrust_margin": states.thrust_margin,
    }
    lists = {name: values.tolist() for name, values in columns.items()}
    return [
        {name: value if math.isfinite(value) else None for name, value in zip(lists, row, strict=True)}
        | {"status": status}
        for *row, status in zip(*lists.values(), states.status.tolist(), strict=True)
    ]
