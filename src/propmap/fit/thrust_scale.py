"""A flight's thrust scale: what its own hover says of battery, mass and motor-speed scale."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.vehicle.flight_log import GRAVITY, FlightLog

SLOW, LEVEL_RATE, QUIET = 1.0, 0.5, 0.15
"""A sample hovers below this speed [m/s] and rate [rad/s], its specific force within this share of
gravity."""

LEAST_HOVER = 0.5
"""Duration of hover [s] that a scale needs."""

RANGE = (0.8, 1.25)
"""Of a scale; outside, the mass or the unit of the rotor speeds is wrong, and none is applied."""


@dataclass(frozen=True, eq=False)
class Hover:
    """Which of n samples hover, for each flight that hovers for long enough.

    Attributes
    ----------
    flight : ndarray, shape (n,)
        Number of the flight of each sample.
    masks : mapping of int to ndarray, shape (n,)
        By number of flight.
    """

    flight: Floats
    masks: dict[int, NDArray[np.bool_]]


def hover_of(log: FlightLog) -> Hover:
    """Where the flights of a log hover.

    Parameters
    ----------
    log : FlightLog
        n samples of one or several flights.
    """
    still = (log.speed < SLOW) & (np.linalg.norm(log.rates, axis=1) < LEVEL_RATE)
    still &= np.linalg.norm(log.specific_force - GRAVITY * log.up, axis=1) < QUIET * GRAVITY
    masks = {}
    for number in np.unique(log.flight):
        mine = log.flight == number
        steps = np.diff(log.time[mine])
        step = float(np.median(steps)) if steps.size else 0.0
        if np.count_nonzero(still & mine) * step >= LEAST_HOVER:
            masks[int(number)] = still & mine
    return Hover(log.flight, masks)


def thrust_scales(
    hover: Hover, measured: Floats, rotors: Floats, others: Floats, axis: Floats
) -> dict[int, float]:
    """Measured over modelled thrust in each flight's hover [-].

    Parameters
    ----------
    hover : Hover
        Where each flight hovers.
    measured, rotors, others : ndarray, shape (n, 3)
        Mass times specific force; forces of the rotors; all others [N].
    axis : ndarray, shape (3,)
        Mean direction of the rotors' axes.

    Returns
    -------
    dict of int to float
        By number of flight; only within ``RANGE``.
    """
    found = {}
    for number, mask in hover.masks.items():
        lifted = float(np.sum((measured - others)[mask] @ axis))
        thrust = float(np.sum(rotors[mask] @ axis))
        scale = lifted / thrust if thrust > 0.0 else np.nan
        if RANGE[0] <= scale <= RANGE[1]:
            found[number] = scale
    return found


def scales_told(scales: Mapping[int, float]) -> list[str]:
    """A sentence on the ``scales`` of the flights, by number; none where there is none."""
    if not scales:
        return []
    each = ", ".join(f"flight {number + 1}: {scale:.3f}" for number, scale in scales.items())
    return [f"thrust scaled to what each flight measures in its own hover ({each})"]
