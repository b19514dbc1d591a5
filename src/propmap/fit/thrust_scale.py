"""A flight's thrust scale: what its own hover says of battery, mass and motor-speed scale.

In hover a rotor's thrust goes as the square of its speed.  How much thrust a flight measures there
per square of its rotor speeds, over what the flights of a fit measure, is no matter of the model:
it is a scale of that flight's rotor speeds or forces, and all its rotor loads are multiplied by it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from propmap.arrays.types import Floats
from propmap.vehicle.flight_log import GRAVITY, FlightLog
from propmap.vehicle.vehicle import Vehicle

SLOW, LEVEL_RATE, QUIET = 1.0, 0.5, 0.15
"""A sample hovers below this speed [m/s] and rate [rad/s], its specific force within this share of
gravity."""

LEAST_HOVER = 0.5
"""Duration of hover [s] that a scale needs."""

RANGE = (0.9, 1.1)
"""Of a scale; outside, the mass or the unit of the rotor speeds is wrong, and none is applied."""


@dataclass(frozen=True)
class HoverScale:
    """Thrust scales of the flights of a log, from where each of them hovers.

    Attributes
    ----------
    measured : mapping of int to float
        Thrust over the sum of the squares of the rotor speeds [N s^2], by number of each flight
        that hovers for long enough.
    reference : float or None
        The same of the flights of a fit [N s^2]; None where none of them hovers.
    """

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
        return cls(measured, reference)

    @property
    def scales(self) -> dict[int, float]:
        """By number of flight, where it is within ``RANGE`` [-]."""
        if not self.reference:
            return {}
        found = {number: one / self.reference for number, one in self.measured.items()}
        return {n: scale for n, scale in found.items() if RANGE[0] <= scale <= RANGE[1]}

    def factors(self, log: FlightLog) -> Floats:
        """The scale of each sample of ``log``, 1 where its flight has none; (n,) [-]."""
        scales = self.scales
        return np.array([scales.get(int(number), 1.0) for number in log.flight])

    def told(self) -> list[str]:
        """A sentence on the scales; none where there is none, or one flight alone."""
        scales = {n: scale for n, scale in self.scales.items() if abs(scale - 1.0) > 1e-9}
        if not scales:
            return []
        each = ", ".join(f"flight {number + 1}: {scale:.3f}" for number, scale in scales.items())
        return [f"thrust scaled to what each flight measures in its own hover ({each})"]
