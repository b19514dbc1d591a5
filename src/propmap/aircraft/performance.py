"""What a power curve says: hover, least power, best range, top speed and what limits it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.aircraft.deviations import spread
from propmap.aircraft.response import Responses
from propmap.aircraft.steady import Aircraft
from propmap.aircraft.steady_states import SteadyStates
from propmap.aircraft.top_speed import searched
from propmap.errors import InputError
from propmap.typing import Floats

TOP = 3
"""Number of the top speed among the states with a name."""

SPEEDS, BETWEEN = 41, 13
"""At which power is looked at, from rest to the top speed; and between the neighbours of the least
of these."""


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
    speed_std, power_std, endurance_std : float
        Standard deviations [m/s], [W], [s]: of a top speed, and of power and time at this speed.
        NaN where they were not asked for or are not known.
    """

    speed: float
    ground_speed: float
    power: float
    electrical_power: float
    endurance: float
    distance: float
    speed_std: float = math.nan
    power_std: float = math.nan
    endurance_std: float = math.nan


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
    at_rest : str
        Status in hover.
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
    at_rest: str
    wind: float


def endurance(aircraft: Aircraft, states: SteadyStates, more_power: Floats | float = 0.0) -> Floats:
    """Time of flight in each state on one battery [s], (n,); NaN without a battery.

    Parameters
    ----------
    aircraft, states : Aircraft, SteadyStates
        What flies, and how.
    more_power : ndarray, shape (n,), or float
        By which the electrical power is larger [W].
    """
    battery = aircraft.vehicle.powertrain.battery
    if battery is None:
        return np.full(len(states), math.nan)
    needed = np.max(states.throttle * states.battery_voltage[:, None], axis=1)
    power = states.electrical_power + more_power
    return battery.endurance(power, needed, aircraft.limits.charge)


def performance(
    aircraft: Aircraft,
    states: SteadyStates,
    *,
    climb: float = 0.0,
    wind: float = 0.0,
    bands: bool = False,
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
    bands : bool
        Whether standard deviations of the named states are wanted.

    Raises
    ------
    InputError
        For speeds that do not rise, and a wind that is no number.
    """
    speed = states.speed
    if speed.size < 2 or not (np.diff(speed) > 0.0).all():
        raise InputError("the speeds must rise", "give two or more, each once")
    if not math.isfinite(wind):
        raise InputError(f"the wind is {wind}", "give a headwind in m/s, negative from behind")
    fastest, limit, known = searched(aircraft, states, climb)
    last = speed[-1] if math.isnan(fastest) else fastest
    grid = np.linspace(0.0, last, SPEEDS)
    curve = aircraft.steady(grid, climb, margin=False, near=known)
    power, at_rest = curve.power, str(curve.status[0])
    ok = np.isfinite(power)
    # Distance per energy; where the wind is faster there is none.
    ahead = ok & (grid > wind)
    if ahead.any():
        # Once more about both of the least, since a wing that stalls makes the power jump.
        places = (
            _around(grid, np.flatnonzero(ok), power),
            _around(grid, np.flatnonzero(ahead), power / np.where(ahead, grid - wind, 1.0)),
        )
        finer = np.setdiff1d(np.concatenate(places), grid)
        between = aircraft.steady(finer, climb, margin=False, near=curve).power
        order = np.argsort(np.concatenate([grid, finer]))
        grid, power = (np.concatenate(each)[order] for each in ((grid, finer), (power, between)))
        ok = np.isfinite(power)
        ahead = ok & (grid > wind)
    least = _lowest(grid[ok], power[ok])
    best = _lowest(grid[ahead], power[ahead] / (grid[ahead] - wind))
    wanted = np.array([0.0, least, best, fastest])
    asked = np.isfinite(wanted)
    named: list[NamedState | None] = [None] * len(wanted)
    if asked.any():
        found = aircraft.steady(wanted[asked], climb, margin=False, near=curve)
        time = endurance(aircraft, found)
        sure = _deviations(aircraft, found, limit) if bands else {}
        for place, k in enumerate(np.flatnonzero(asked)):
            if found.found[place]:
                std = {name: float(values[place]) for name, values in sure.items()}
                if k != TOP:
                    std.pop("speed_std", None)
                named[k] = _named(found, place, float(time[place]), wind, std)
    times = endurance(aircraft, states)
    ground = states.speed - wind
    hover, least_power, best_range, top = named
    return Performance(
        states, times, times * ground, hover, least_power, best_range, top, limit, at_rest, wind
    )


def _deviations(aircraft: Aircraft, states: SteadyStates, limit: str) -> dict[str, Floats]:
    """Fields of ``NamedState`` for each state; the speed's as if it were at the ``limit``."""
    sure = spread(aircraft, states)
    if sure is None:
        return {}
    found = {"power_std": sure.power}
    more, less = (endurance(aircraft, states, sign * sure.power) for sign in (1.0, -1.0))
    found["endurance_std"] = 0.5 * (less - more)
    if limit in sure.used:
        # Where a share of the limit is 1: what it errs by over its slope by the speed.
        slope = Responses(aircraft, states).to_flight("speed").used[limit]
        found["speed_std"] = np.divide(
            sure.used[limit], np.abs(slope), out=np.full_like(slope, math.nan), where=slope != 0.0
        )
    return found


def _named(
    states: SteadyStates, k: int, time: float, wind: float, std: dict[str, float]
) -> NamedState:
    v = float(states.speed[k])
    return NamedState(
        speed=v,
        ground_speed=v - wind,
        power=float(states.power[k]),
        electrical_power=float(states.electrical_power[k]),
        endurance=time,
        distance=time * (v - wind),
        **std,
    )


def _around(x: Floats, places: NDArray[np.intp], y: Floats) -> Floats:
    """Values between the neighbours of that of the ``places`` in ``x`` where ``y`` is least."""
    k = places[np.argmin(y[places])]
    return np.linspace(x[max(k - 1, 0)], x[min(k + 1, x.size - 1)], BETWEEN)


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
