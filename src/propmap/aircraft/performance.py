"""What a power curve says: hover, least power, best range, top speed and what limits it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from propmap.aircraft.steady import VORTEX_RING, Aircraft, SteadyStates
from propmap.arrays.types import Floats
from propmap.errors import InputError

BEYOND = 1.25
"""Ratio of the speeds at which the top speed is looked for beyond those that were asked for."""

FASTEST = 150.0
"""[m/s] up to which it is looked for."""

FINER, ROUNDS = 8, 2
"""The interval with the top speed is cut into so many, so many times; then shares of the limit are
interpolated."""

WITHIN = 0.999
"""Share of the last interval, so that rounding does not put the top speed beyond the limit."""

FURTHER = 16
"""Speeds between the last that was asked for and the top speed at which power is looked at."""


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
    power = states.power
    if fastest > speed[-1]:
        further = np.linspace(speed[-1], fastest, FURTHER + 1)[1:]
        beyond = aircraft.steady(further, climb, margin=False)
        speed, power = np.append(speed, further), np.append(power, beyond.power)
    ok = np.isfinite(power)
    # Distance per energy; where the wind is faster there is none.
    ahead = ok & (speed > wind)
    least = _lowest(speed[ok], power[ok])
    best = _lowest(speed[ahead], power[ahead] / (speed[ahead] - wind))
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
    ground = states.speed - wind
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
    if not x.size:
        return math.nan
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
    while True:
        low, high, why = _last_and_next(states)
        if not math.isnan(high):
            break
        if low >= FASTEST:
            return math.nan, ""
        further = max(low, 1.0) * BEYOND ** np.arange(1.0, 3.0)
        states = aircraft.steady(np.append(low, further), climb, margin=False)
    for _ in range(ROUNDS):
        if math.isnan(low) or math.isnan(high):
            return low, why
        states = aircraft.steady(np.linspace(low, high, FINER + 1), climb, margin=False)
        low, high, why = _last_and_next(states)
    return _met(states, low, why), why


def _met(states: SteadyStates, low: float, why: str) -> float:
    """Where the share of the limit reaches 1, just after the state at speed ``low`` [m/s]."""
    k = int(np.searchsorted(states.speed, low))
    if why not in states.used or k + 1 >= len(states):
        return low
    before, after = states.used[why][k : k + 2]
    step = (1.0 - before) / (after - before) * (states.speed[k + 1] - low)
    return float(low + WITHIN * step) if step >= 0.0 else low


def _last_and_next(states: SteadyStates) -> tuple[float, float, str]:
    """The last speed that is flown, the next that is not, and why not; NaN where there is none."""
    flown = np.flatnonzero(np.isin(states.status, ("ok", VORTEX_RING)))
    if not flown.size:
        return math.nan, float(states.speed[0]), str(states.status[0])
    last = int(flown[-1])
    if last == len(states) - 1:
        return float(states.speed[last]), math.nan, ""
    return float(states.speed[last]), float(states.speed[last + 1]), str(states.status[last + 1])
