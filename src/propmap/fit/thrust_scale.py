"""A flight's thrust scale: what its own hover says of battery, mass and motor-speed scale.

In hover a rotor's thrust goes as the square of its speed.  How much thrust a flight measures there
per square of its rotor speeds, over what the flights of a fit measure, is no matter of the model:
it is a scale of that flight's rotor speeds or forces, ``thrust_scale[FLIGHT]``, by which all its
rotor loads are multiplied.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from propmap.fit.parameters import Prior, of_flight
from propmap.vehicle.flight_log import GRAVITY, FlightLog
from propmap.vehicle.vehicle import Vehicle

SLOW, LEVEL_RATE, QUIET = 1.0, 0.5, 0.15
"""A sample hovers below this speed [m/s] and rate [rad/s], its specific force within this share of
gravity."""

LEAST_HOVER = 0.5
"""Duration of hover [s] that a scale needs."""

NAME = "thrust_scale"

OVER_FLIGHTS, IN_HOVER = 0.02, 0.01
"""Standard deviation of flights' scales beforehand, without and with a hover of their own.
Batteries, payloads and temperatures differ by so much; and by a hundredth do half seconds of one
flight's hover, at its start and at its end: 0.7 and 1.2 % in the two of examples/neurobem."""

RANGE = (0.9, 1.1)
"""Of a scale; outside, the mass or the unit of the rotor speeds is wrong, and none is applied."""


@dataclass(frozen=True)
class HoverScale:
    """Thrust scales of the flights of a log, from where each of them hovers.

    Attributes
    ----------
    flights : tuple of str
        Names of the flights, by number.
    measured : mapping of int to float
        Thrust over the sum of the squares of the rotor speeds [N s^2], by number of each flight
        that hovers for long enough.
    reference : float or None
        The same of the flights of a fit [N s^2]; None where none of them hovers.
    """

    flights: tuple[str, ...]
    measured: Mapping[int, float]
    reference: float | None

    @classmethod
    def of(cls, vehicle: Vehicle, log: FlightLog, reference: float | None = None) -> HoverScale:
        """Find where the flights hover.

        Parameters
        ----------
        vehicle, log : Vehicle, FlightLog
            What flew, and one or several of its flights.
        reference : float, optional
            Of the flights of a fit; by default the mean of these flights.
        """
        total = np.sum([mount.axis for mount in vehicle.mounts], axis=0)
        axis = total / max(float(np.linalg.norm(total)), 1e-9)
        still = (log.speed < SLOW) & (np.linalg.norm(log.rates, axis=1) < LEVEL_RATE)
        off = np.linalg.norm(log.specific_force - GRAVITY * log.up, axis=1)
        still &= off < QUIET * GRAVITY
        measured = {}
        for number in np.unique(log.flight):
            mine = log.flight == number
            steps = np.diff(log.time[mine])
            step = float(np.median(steps)) if steps.size else 0.0
            hovers = still & mine
            squares = float(np.sum(np.square(log.rotor_speed[hovers])))
            if np.count_nonzero(hovers) * step >= LEAST_HOVER and squares > 0.0:
                thrust = vehicle.mass * float(np.sum(log.specific_force[hovers] @ axis))
                measured[int(number)] = thrust / squares
        if reference is None and measured:
            reference = float(np.mean(list(measured.values())))
        return cls(log.flights, measured, reference)

    @property
    def scales(self) -> dict[str, float]:
        """By the flight's parameter, where it is within ``RANGE`` [-]."""
        if not self.reference:
            return {}
        found = {
            of_flight(NAME, self.flights[number]): one / self.reference
            for number, one in self.measured.items()
        }
        return {n: scale for n, scale in found.items() if RANGE[0] <= scale <= RANGE[1]}

    @property
    def telling(self) -> dict[str, float]:
        """Those that differ from 1 by more than a hover may by itself."""
        return {name: one for name, one in self.scales.items() if abs(one - 1.0) > 2.0 * IN_HOVER}

    @property
    def priors(self) -> dict[str, Prior]:
        """What is known of the scale of each flight before a fit; nothing of one flight alone.

        The scale of a flight is beside the others': alone, it is not told from the blade.
        """
        if len(self.flights) < 2:
            return {}
        names = [of_flight(NAME, flight) for flight in self.flights]
        known = {name: Prior(scale, IN_HOVER) for name, scale in self.scales.items()}
        return {name: known.get(name, Prior(1.0, OVER_FLIGHTS)) for name in names}

    def reference_at(self, values: Mapping[str, float]) -> float | None:
        """What a flight with the scale 1 measures in hover [N s^2], by the scales that a fit found.

        Parameters
        ----------
        values : mapping of str to float
            Parameters by name.
        """
        each = [
            one / values.get(of_flight(NAME, self.flights[number]), 1.0)
            for number, one in self.measured.items()
        ]
        return float(np.mean(each)) if each else None
