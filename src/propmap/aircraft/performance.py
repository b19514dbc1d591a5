"""Performance from a power curve: hover, least power, best range, endurance, top speed, limits."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from propmap.aircraft.sensitivity import Responses, StateChange, spread
from propmap.aircraft.trim import OUTSIDE_TABLE, Aircraft, SteadyStates
from propmap.errors import InputError
from propmap.io.csv import numbers_of
from propmap.typing import Floats
from propmap.units import RPM

TOP = 3  # index of the top speed among the named states
SPEEDS, BETWEEN = 41, 13  # number of speeds from rest to the top speed, and around each minimum


@dataclass(frozen=True, eq=False)
class NamedState:
    """One of the named steady states, such as hover.

    Attributes
    ----------
    speed : float
        Airspeed [m/s].
    ground_speed : float
        Speed over ground [m/s].
    power : float
        Electrical power, or shaft power if the vehicle has no motor [W].
    electrical_power : float
        Electrical power [W]; NaN if the vehicle has no motor.
    endurance, distance : float
        Time and distance over ground on one battery [s], [m]; NaN without a battery.
    speed_std, power_std, endurance_std : float
        Standard deviations of the airspeed (only for the top speed) [m/s], and of power [W] and
        endurance [s] at this airspeed.  NaN if not requested or not known.
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
    """Performance of an aircraft at one climb rate.

    Attributes
    ----------
    states : SteadyStates
        States at the n requested speeds.
    endurance, distance : ndarray, shape (n,)
        Time [s] and distance over ground [m] on one battery; NaN without a battery.
    hover, least_power, best_range, fastest : NamedState or None
        State at rest, at the speed of least power, at the speed of the largest distance on one
        battery (without a battery: of least energy per distance over ground), and at the top speed;
        None for a state that does not exist or is above the highest computed speed.
    limit : str
        Status of states just above the top speed.  Empty if the search reaches no limit up to
        150 m/s; "unknown" without a known limit of the motors.
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

    @property
    def named(self) -> list[tuple[str, str, NamedState | None]]:
        """Key, description and state of each named state."""
        return [
            ("hover", "hover", self.hover),
            ("least_power", "least power, longest time", self.least_power),
            ("best_range", "best range", self.best_range),
            ("fastest", "top speed", self.fastest),
        ]


def endurance(aircraft: Aircraft, states: SteadyStates, more_power: Floats | float = 0.0) -> Floats:
    """Return the flight time on one battery in each state.

    Parameters
    ----------
    aircraft, states : Aircraft, SteadyStates
        Aircraft and n of its states.
    more_power : ndarray, shape (n,), or float
        Additional electrical power [W].

    Returns
    -------
    ndarray, shape (n,)
        Flight time [s]; NaN without a battery.
    """
    battery = aircraft.vehicle.powertrain.battery
    if battery is None:
        return np.full(len(states), math.nan)
    needed = np.max(states.throttle * states.battery_voltage[:, None], axis=1)
    power = states.electrical_power + more_power
    return battery.endurance(power, needed, aircraft.charge)


def performance(
    aircraft: Aircraft,
    states: SteadyStates,
    *,
    climb: float = 0.0,
    wind: float = 0.0,
    bands: bool = False,
) -> Performance:
    """Return endurance and range at each speed, and the named states.

    The named states are hover, least power, best range and top speed.

    Parameters
    ----------
    aircraft : Aircraft
        Aircraft of the states.
    states : SteadyStates
        States at two or more increasing speeds and one climb rate, from ``aircraft.steady``.
    climb : float
        Climb rate of the states [m/s].
    wind : float
        Headwind [m/s]; it changes only distances.
    bands : bool
        Whether to compute standard deviations of the named states.

    Raises
    ------
    InputError
        For speeds that do not increase, and for a wind that is not finite.
    """
    speed = states.speed
    if speed.size < 2 or not (np.diff(speed) > 0.0).all():
        raise InputError("the speeds must increase", "give two or more speeds, each once")
    if not math.isfinite(wind):
        raise InputError(f"the wind is {wind}", "give a headwind in m/s, negative for a tailwind")
    end, limit, known = searched(aircraft, states, climb)
    fastest = math.nan if limit == UNKNOWN else end
    last = speed[-1] if math.isnan(end) else end
    grid = np.linspace(0.0, last, SPEEDS)
    curve = aircraft.steady(grid, climb, margin=False, near=known)
    at_rest = str(curve.status[0])
    curves = curve.power, _costs_of_distance(aircraft, curve, wind)
    places = [_around(grid, y) for y in curves if np.isfinite(y).any()]
    if places:
        # More speeds around both minima are needed, because power jumps where a wing stalls.
        finer = np.setdiff1d(np.concatenate(places), grid)
        curve = curve.and_also(aircraft.steady(finer, climb, margin=False, near=curve))
    curves = curve.power, _costs_of_distance(aircraft, curve, wind)
    least, best = (_lowest(curve.speed, y, limit in (UNKNOWN, OUTSIDE_TABLE)) for y in curves)
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
                v, lasts = float(found.speed[place]), float(time[place])
                powers = float(found.power[place]), float(found.electrical_power[place])
                named[k] = NamedState(v, v - wind, *powers, lasts, lasts * (v - wind), **std)
    times = endurance(aircraft, states)
    ground = states.speed - wind
    hover, least_power, best_range, top = named
    return Performance(
        states, times, times * ground, hover, least_power, best_range, top, limit, at_rest, wind
    )


def _deviations(aircraft: Aircraft, states: SteadyStates, limit: str) -> dict[str, Floats]:
    """Return standard deviations for ``NamedState``.

    ``speed_std`` is valid only for the state at the ``limit``.
    """
    sure = spread(aircraft, states)
    if sure is None:
        return {}
    found = {"power_std": sure.power}
    more, less = (endurance(aircraft, states, sign * sure.power) for sign in (1.0, -1.0))
    found["endurance_std"] = 0.5 * (less - more)
    if limit in sure.used:
        # Standard deviation of the share of the limit, divided by its slope with respect to speed.
        slope = Responses(aircraft, states).to_flight("speed").used[limit]
        found["speed_std"] = np.divide(
            sure.used[limit], np.abs(slope), out=np.full_like(slope, math.nan), where=slope != 0.0
        )
    return found


def _costs_of_distance(aircraft: Aircraft, states: SteadyStates, wind: float) -> Floats:
    """Return a cost (n,) that is least at the speed of best range; NaN up to the wind speed.

    With a battery, it is the negative distance on one battery.  The energy per distance ignores
    that, in fast flight, the voltage becomes too low before the battery is empty.  Without a
    battery, the cost is the energy per distance over ground.
    """
    ground = np.where(states.speed > wind, states.speed - wind, np.nan)
    if aircraft.vehicle.powertrain.battery is None:
        return states.power / ground
    distance = endurance(aircraft, states) * ground
    return np.where(np.isfinite(distance), -distance, np.nan)


def _around(x: Floats, y: Floats) -> Floats:
    """Return points between the two neighbors of the point with the least ``y``."""
    k = int(np.nanargmin(y))
    return np.linspace(x[max(k - 1, 0)], x[min(k + 1, x.size - 1)], BETWEEN)


def _lowest(x: Floats, y: Floats, open_end: bool) -> float:
    """Return the place of the minimum of y, from the parabola through the least sample and its
    neighbors; NaN if all y are NaN, or if the last is the least and y may decrease beyond it
    (``open_end``)."""
    x, y = x[np.isfinite(y)], y[np.isfinite(y)]
    if not x.size:
        return math.nan
    k = int(np.argmin(y))
    if k in (0, x.size - 1):
        return math.nan if k > 0 and open_end else float(x[k])
    # Divided differences, as the speeds need not be evenly spaced.
    a, b, c = x[k - 1 : k + 2]
    first = (y[k] - y[k - 1]) / (b - a)
    second = ((y[k + 1] - y[k]) / (c - b) - first) / (c - a)
    return float(np.clip(0.5 * (a + b) - 0.5 * first / second, a, c)) if second > 0.0 else float(b)


# --- The top speed of an aircraft, and its limit -------------------------------------------------

SLOWER = 9  # number of lower speeds that the search tries if no requested speed is possible
BEYOND = 1.3  # ratio of successive speeds of the search above the requested speeds

UNKNOWN = "unknown"  # limit of the top speed if no limit of the motors is known
FASTEST = 150.0  # largest speed of the search [m/s]
SEARCH_STEPS = 40  # most steps of a search for the top speed
CLOSE, NARROW = 2e-3, 0.1
"""Final width of the search interval as a share of its speed, and distance of new speeds from the
expected top speed, as a share of the interval."""

WITHIN = 0.999
"""Position of the returned speed in the interval from the last possible speed to the interpolated
top speed; below 1, so that rounding does not exceed the limit."""


def top_speed(aircraft: Aircraft, states: SteadyStates, climb: float) -> tuple[float, str]:
    """Return the top speed and its limit.

    Parameters
    ----------
    aircraft : Aircraft
        Aircraft of the states.
    states : SteadyStates
        States at two or more increasing speeds and one climb rate.
    climb : float
        Climb rate of the states [m/s].

    Returns
    -------
    speed : float
        Top speed [m/s]; NaN if there is none or if it is unknown.
    limit : str
        Status of the states above the top speed, as ``Performance.limit``.
    """
    end, limit, _ = searched(aircraft, states, climb)
    return math.nan if limit == UNKNOWN else end, limit


def searched(
    aircraft: Aircraft, states: SteadyStates, climb: float
) -> tuple[float, str, SteadyStates]:
    """Return the largest speed, its limit, and ``states`` with all states of the search added."""
    first = float(states.speed[0])
    if first > 0.0 and not states.found.any():
        slower = np.linspace(0.0, first, SLOWER, endpoint=False)
        states = states.and_also(aircraft.steady(slower, climb, margin=False, near=states))
    low, high, why = _last_and_next(states)
    for _ in range(SEARCH_STEPS):
        if math.isnan(low):
            return math.nan, why, states
        if math.isnan(high):
            if low >= FASTEST:
                return math.nan, "" if aircraft.limited else UNKNOWN, states
            further = np.array([max(low, 1.0) * BEYOND])
        elif high - low <= CLOSE * high:
            break
        else:
            met = _met(states, low, high, why)
            further = met + NARROW * (high - low) * np.array([-1.0, 0.0, 1.0])
            if math.isnan(met):
                further = low + (high - low) * np.array([0.25, 0.5, 0.75])
            further = further[(further > low) & (further < high)]
        # Include ``low``: states that were not found then start again from its solution.
        speeds = np.array([low, *further])
        states = states.and_also(aircraft.steady(speeds, climb, margin=False, near=states))
        low, high, why = _last_and_next(states)
    met = _met(states, low, high, why)
    end = low if math.isnan(met) else low + WITHIN * (met - low)
    return end, why if aircraft.limited else UNKNOWN, states


def _met(states: SteadyStates, low: float, high: float, why: str) -> float:
    """Return the speed from ``low`` to ``high`` at which the share of a limit is 1, or NaN."""
    if why not in states.used:
        return math.nan
    k = int(np.argmin(np.abs(states.speed - low)))
    before, after = np.log(np.maximum(states.used[why][k : k + 2], 1e-9))
    step = -before / (after - before)
    return low + step * (high - low) if 0.0 <= step <= 1.0 else math.nan


def _last_and_next(states: SteadyStates) -> tuple[float, float, str]:
    """Return the last possible speed, the next impossible speed, and its status; NaN if none."""
    flown = np.flatnonzero(states.found)
    if not flown.size:
        return math.nan, float(states.speed[0]), str(states.status[0])
    last = int(flown[-1])
    if last == len(states) - 1:
        return float(states.speed[last]), math.nan, ""
    return float(states.speed[last]), float(states.speed[last + 1]), str(states.status[last + 1])


# --- Steady states in the units of files and pictures: m/s, degrees, rpm, N, W, A, V -------------


class StateColumn(NamedTuple):
    """Quantity of n states: ``values`` (n,), or (n, k) for k rotors, with unit and meaning."""

    values: Floats
    unit: str
    meaning: str


def columns(states: SteadyStates, sure: StateChange | None = None) -> dict[str, StateColumn]:
    """Return all quantities by their names in files, with the standard deviations ``sure``."""
    degrees = np.degrees
    table: tuple[tuple[str, Floats, str, str], ...] = (
        ("speed_mps", states.speed, "m/s", "horizontal airspeed"),
        ("climb_mps", states.climb, "m/s", "climb rate"),
        ("bank_deg", degrees(states.bank), "degree", "bank of the turn, positive to the right"),
        ("pitch_deg", degrees(states.pitch), "degree", "pitch, positive nose down"),
        ("roll_deg", degrees(states.roll), "degree", "roll, positive right side down"),
        ("rpm", states.rotor_speed / RPM, "1/min", "rotational speed"),
        ("thrust_N", states.thrust, "N", "thrust"),
        ("torque_Nm", states.torque, "N m", "shaft torque"),
        ("shaft_power_W", states.shaft_power, "W", "power of all shafts"),
        ("electrical_power_W", states.electrical_power, "W", "power from the battery"),
        ("motor_current_A", states.motor_current, "A", "current of a motor"),
        ("throttle", states.throttle, "1", "share of the battery's voltage"),
        ("battery_current_A", states.battery_current, "A", "current of the battery"),
        ("battery_voltage_V", states.battery_voltage, "V", "voltage under load"),
        ("thrust_margin", states.thrust_margin, "1",
         "maximum thrust divided by required thrust"),
        ("residual", states.residual, "1", "unbalanced share of the weight"),
    )  # fmt: skip
    found = {name: StateColumn(values, unit, words) for name, values, unit, words in table}
    if sure is None:
        return found
    std = "standard deviation of the "
    return found | {
        "pitch_std_deg": StateColumn(np.degrees(sure.pitch), "degree", std + "pitch"),
        "rpm_std": StateColumn(sure.rotor_speed / RPM, "1/min", std + "rotational speed"),
        "shaft_power_std_W": StateColumn(sure.shaft_power, "W", std + "shaft power"),
        "electrical_power_std_W": StateColumn(sure.electrical_power, "W", std + "electrical power"),
    }


def rows(states: SteadyStates, sure: StateChange | None = None) -> list[dict[str, Any]]:
    """Return a mapping of ``columns`` per state, with rpm_1, rpm_2 ... for rotors; None for NaN."""
    flat: dict[str, list[Any]] = {}
    for name, column in columns(states, sure).items():
        if column.values.ndim == 1:
            flat[name] = numbers_of(column.values)
            continue
        # The column thrust_N of the first rotor is thrust_1_N.
        head, _, unit = name.rpartition("_") if "_" in name else (name, "", "")
        for k, values in enumerate(column.values.T, start=1):
            flat["_".join(filter(None, (head, str(k), unit)))] = numbers_of(values)
    flat["status"] = states.status.tolist()
    return [dict(zip(flat, row, strict=True)) for row in zip(*flat.values(), strict=True)]
