"""A vehicle's rotors at rest, with the errors of their loads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.aircraft.steady import Aircraft
from propmap.export.load_errors import load_errors, rotor_sources
from propmap.typing import Floats


@dataclass(frozen=True, eq=False)
class StaticLoads:
    """Of the mean rotor at rest.

    Attributes
    ----------
    thrust, torque : float
        [N], [N m].
    errors : ndarray, shape (E, 2)
        What each of E independent causes, at one standard deviation, adds to them.
    """

    thrust: float
    torque: float
    errors: Floats

    def std_of(self, by_thrust: float, by_torque: float) -> float | None:
        """The standard deviation of what has these derivatives; None where none is known."""
        if not self.errors.size:
            return None
        return float(np.linalg.norm(self.errors @ [by_thrust, by_torque]))


def static_loads(aircraft: Aircraft, omega: float) -> StaticLoads:
    """Loads at rest of the rotors of an ``aircraft`` at ``omega`` [rad/s], and their errors."""
    count, parts = len(aircraft.vehicle.mounts), []
    for source, mine in rotor_sources(aircraft.vehicle, aircraft.loads):
        found = load_errors(source, np.array([omega]), np.zeros((1, 3)))
        share = mine.size / count
        parts.append((share * found.loads[[0, 2], 0], share * found.errors[:, [0, 2], 0]))
    loads, errors = (np.sum(each, axis=0) for each in zip(*parts, strict=True))
    return StaticLoads(float(loads[0]), float(loads[1]), errors)
