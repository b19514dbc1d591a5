from __future__ import annotations

import numpy as np
import pytest

import propmap
from propmap.flight.simulate import trim
from propmap.vehicle.log import FlightLog
from propmap.vehicle.vehicle import Mount, Vehicle

SPEEDS = np.linspace(0.5, 14.5, 12)
ARM = 0.12


@pytest.fixture(scope="session")
def airfoil() -> propmap.Airfoil:
    return propmap.airfoil("paper-apc")


@pytest.fixture(scope="session")
def vehicle() -> Vehicle:
    """A quadrotor on the propeller of the paper, heavy enough that the blades are loaded."""
    corners = ((1, 1, "cw"), (-1, 1, "ccw"), (-1, -1, "cw"), (1, -1, "ccw"))
    mounts = tuple(Mount((x * ARM, y * ARM, 0.0), spin=spin) for x, y, spin in corners)
    return Vehicle("quadrotor", 1.0, propmap.propeller("apc-8x6e"), mounts)


@pytest.fixture(scope="session")
def points(vehicle: Vehicle, airfoil: propmap.Airfoil) -> FlightLog:
    return trim(vehicle, airfoil, SPEEDS)
