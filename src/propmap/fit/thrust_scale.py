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
class HoverScale:
    """Thrust scales of the flights of a log of n samples, from where each of them hovers.

    Attributes
    ----------
    flight : ndarray, shape (n,)
        Number of the flight of each sample.
    measured : ndarray, shape (n,)
        Mass times specific force along the rotors' mean axis [N].
    axis : ndarray, shape (3,)
        That axis, of length 1.
    hovers : mapping of int to ndarray, shape (n,)
        Which samples hover, by number of each flight that does so for long enough.
    """

    flight: Floats
    measured: Floats
    axis: Floats
    hovers: Mapping[int, NDArray[np.bool_]]

    @classmethod
    def of(cls, log: FlightLog, mass: float, axes: Floats) -> HoverScale:
        """Find where the flights hover.

        Parameters
        ----------
        log : FlightLog
            n samples of one or several flights.
        mass : float
            Of the vehicle [kg].
        axes : ndarray, shape (m, 3)
            Of its rotors.
        """
        total = np.sum(axes, axis=0)
        axis = total / max(float(np.linalg.norm(total)), 1e-9)
        still = (log.speed < SLOW) & (np.linalg.norm(log.rates, axis=1) < LEVEL_RATE)
        off = np.linalg.norm(log.specific_force - GRAVITY * log.up, axis=1)
        still &= off < QUIET * GRAVITY
        hovers = {}
        for number in np.unique(log.flight):
            mine = log.flight == number
            steps = np.diff(log.time[mine])
            step = float(np.median(steps)) if steps.size else 0.0
            if np.count_nonzero(still & mine) * step >= LEAST_HOVER:
                hovers[int(number)] = still & mine
        return cls(log.flight, mass * log.specific_force @ axis, axis, hovers)

    def scales(self, rotors: Floats, others: Floats) -> dict[int, float]:
        """Measured over modelled thrust in each flight's hover [-], where it is within ``RANGE``.

        Parameters
        ----------
        rotors, others : ndarray, shape (n, 3)
            Forces of the rotors, and all others [N].
        """
        found = {}
        for number, mask in self.hovers.items():
            lifted = float(np.sum(self.measured[mask] - others[mask] @ self.axis))
            thrust = float(np.sum(rotors[mask] @ self.axis))
            scale = lifted / thrust if thrust > 0.0 else np.nan
            if RANGE[0] <= scale <= RANGE[1]:
                found[number] = scale
        return found

    def applied(
        self, rotors: Floats, by_rotors: Floats, others: Floats, by_others: Floats
    ) -> tuple[Floats, Floats]:
        """The rotors' forces times the scales, and their derivatives.

        Parameters
        ----------
        rotors, others : ndarray, shape (n, 3)
            As for ``scales``.
        by_rotors, by_others : ndarray, shape (P, n, 3)
            Their derivatives by P parameters, on all of which a scale depends.
        """
        force, slopes = rotors.copy(), by_rotors.copy()
        for number, scale in self.scales(rotors, others).items():
            mine, mask = self.flight == number, self.hovers[number]
            thrust = float(np.sum(rotors[mask] @ self.axis))
            lost = np.sum((by_others + scale * by_rotors)[:, mask] @ self.axis, axis=1)
            force[mine] *= scale
            slopes[:, mine] *= scale
            slopes[:, mine] -= (lost / thrust)[:, None, None] * rotors[mine]
        return force, slopes


def scales_told(scales: Mapping[int, float]) -> list[str]:
    """A sentence on the ``scales`` of the flights, by number; none where there is none."""
    if not scales:
        return []
    each = ", ".join(f"flight {number + 1}: {scale:.3f}" for number, scale in scales.items())
    return [f"thrust scaled to what each flight measures in its own hover ({each})"]
