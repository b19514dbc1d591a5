"""The top speed of an aircraft, and the limit that it meets there."""

from __future__ import annotations

import math

import numpy as np

from propmap.aircraft.steady import Aircraft
from propmap.aircraft.steady_states import SteadyStates

BEYOND = 1.3
"""Ratio of the speeds at which the top speed is looked for beyond those that were asked for."""

FASTEST = 150.0
"""[m/s] up to which it is looked for."""

STEPS = 40
"""Of a search for the top speed, at most."""

CLOSE, NARROW = 2e-3, 0.1
"""The interval with the top speed is narrowed until it is so small a share of it, each time to so
much about where the share of the limit is likely to reach 1."""

WITHIN = 0.999
"""Share of the last interval, so that rounding does not put the top speed beyond the limit."""


def top_speed(aircraft: Aircraft, states: SteadyStates, climb: float) -> tuple[float, str]:
    """The top speed [m/s], NaN where there is none, and the status beyond it.

    Parameters
    ----------
    aircraft : Aircraft
        What flies.
    states : SteadyStates
        At two or more rising speeds, all at one climb rate.
    climb : float
        That climb rate [m/s].
    """
    return searched(aircraft, states, climb)[:2]


def searched(
    aircraft: Aircraft, states: SteadyStates, climb: float
) -> tuple[float, str, SteadyStates]:
    """The same, and the ``states`` with those that the search has come by."""
    low, high, why = _last_and_next(states)
    for _ in range(STEPS):
        if math.isnan(low):
            return math.nan, why, states
        if math.isnan(high):
            if low >= FASTEST:
                return math.nan, "", states
            further = np.array([max(low, 1.0) * BEYOND])
        elif high - low <= CLOSE * high:
            break
        else:
            met = _met(states, low, high, why)
            further = met + NARROW * (high - low) * np.array([-1.0, 0.0, 1.0])
            if math.isnan(met):
                further = low + (high - low) * np.array([0.25, 0.5, 0.75])
            further = further[(further > low) & (further < high)]
        # Those that are not found at once begin anew at the last that was.
        speeds = np.array([low, *further])
        states = states.and_also(aircraft.steady(speeds, climb, margin=False, near=states))
        low, high, why = _last_and_next(states)
    met = _met(states, low, high, why)
    return (low if math.isnan(met) else low + WITHIN * (met - low)), why, states


def _met(states: SteadyStates, low: float, high: float, why: str) -> float:
    """Where the share of a limit reaches 1 between two neighbouring speeds; NaN if not known."""
    if why not in states.used:
        return math.nan
    k = int(np.argmin(np.abs(states.speed - low)))
    before, after = np.log(np.maximum(states.used[why][k : k + 2], 1e-9))
    step = -before / (after - before)
    return low + step * (high - low) if 0.0 <= step <= 1.0 else math.nan


def _last_and_next(states: SteadyStates) -> tuple[float, float, str]:
    """The last speed that is flown, the next that is not, and why not; NaN where there is none."""
    flown = np.flatnonzero(states.found)
    if not flown.size:
        return math.nan, float(states.speed[0]), str(states.status[0])
    last = int(flown[-1])
    if last == len(states) - 1:
        return float(states.speed[last]), math.nan, ""
    return float(states.speed[last]), float(states.speed[last + 1]), str(states.status[last + 1])
