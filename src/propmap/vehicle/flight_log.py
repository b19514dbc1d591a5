"""A flight as arrays on one clock, in the vehicle's frame: x forward, y left, z up."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from propmap.arrays.types import Floats

GRAVITY = 9.80665
"""[m/s^2], the standard value."""


@dataclass(frozen=True, eq=False)
class FlightLog:
    """Samples of a flight, or operating points averaged from one; n of them.

    source : where they come from, for messages and reports.
    time : (n,) [s], rising.
    velocity : (n, 3) [m/s], of the centre of mass through the air, in the vehicle's frame.
    rates : (n, 3) [rad/s], angular velocity in the vehicle's frame.
    up : (n, 3) [-], the direction opposite to gravity, in the vehicle's frame.
    specific_force : (n, 3) [m/s^2], what an accelerometer at the centre of mass reads, +g
        along ``up`` in hover; NaN where it was not measured.
    rotor_speed : (n, rotors) [rad/s] >= 0.
    """

    source: str
    time: Floats
    velocity: Floats
    rates: Floats
    up: Floats
    specific_force: Floats
    rotor_speed: Floats

    def __len__(self) -> int:
        return int(self.time.size)

    def picked(self, which: Any) -> FlightLog:
        """Some of the samples; which : a mask or indices."""
        arrays = {f.name: getattr(self, f.name)[which] for f in fields(self) if f.name != "source"}
        return replace(self, **arrays)

    @property
    def speed(self) -> Floats:
        """Speed through the air [m/s]; (n,)."""
        return np.asarray(np.linalg.norm(self.velocity, axis=1))

    @property
    def climb_rate(self) -> Floats:
        """Vertical velocity, up positive [m/s]; (n,)."""
        return np.asarray(np.sum(self.velocity * self.up, axis=1))


def joined(logs: list[FlightLog]) -> FlightLog:
    """Several logs of one vehicle as one, in the order given; their clocks are kept."""
    arrays = {
        f.name: np.concatenate([getattr(log, f.name) for log in logs])
        for f in fields(FlightLog)
        if f.name != "source"
    }
    return FlightLog(source=", ".join(log.source for log in logs), **arrays)
