from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import propmap
from propmap.aircraft.trim import Aircraft, SteadyStates
from propmap.units import GRAVITY, RPM
from propmap.vehicle.powertrain import Battery, Motor, Powertrain, SpeedController
from propmap.vehicle.vehicle import Body, Mount, Vehicle

from ..vehicle.wrench_by_hand import by_hand

ARM = 0.16
POWERTRAIN = Powertrain(
    Motor(920.0 * RPM, 0.12, (0.6,), (10.0,), 20.0),
    SpeedController(0.01),
    Battery(4, 5.0 * 3600.0, 0.02, 0.8, 80.0, 5.0),
)


def quadcopter(**changes: object) -> Vehicle:
    corners = ((1, 1, "cw"), (-1, 1, "ccw"), (-1, -1, "cw"), (1, -1, "ccw"))
    mounts = tuple(Mount((x * ARM, y * ARM, 0.02), spin=spin) for x, y, spin in corners)
    parts: dict[str, object] = {
        "name": "quadcopter",
        "mass": 1.2,
        "propeller": propmap.propeller("apc-8x6e"),
        "mounts": mounts,
        "body": Body((0.015, 0.015, 0.03)),
        "powertrain": POWERTRAIN,
    }
    return Vehicle(**(parts | changes))  # type: ignore[arg-type]


def rotor_of(vehicle: Vehicle) -> propmap.Rotor:
    law, corrections = propmap.airfoil("apc-8x6e-2019"), propmap.model_corrections("recommended")
    model = propmap.Model(vehicle.propeller, law, vehicle.air, corrections)
    return propmap.Rotor(model)


def aircraft_of(vehicle: Vehicle, **limits: float) -> Aircraft:
    return Aircraft(vehicle, rotor_of(vehicle), **limits)


def unbalanced(
    vehicle: Vehicle, states: SteadyStates, k: int, flight: tuple[float, float, float]
) -> np.ndarray:
    """Return force and moment [m] over the weight in the body frame, added up by hand.

    The flight has a speed, a climb rate and a turn rate.
    """
    speed, climb, turn = flight
    # About the left by the pitch, nose down; then about the own x axis, right side down.
    attitude = [states.pitch[k], states.roll[k]]
    to_body = Rotation.from_euler("YX", attitude).as_matrix().T
    velocity, rates = to_body @ [speed, 0.0, climb], to_body @ [0.0, 0.0, turn]
    omega, still = states.rotor_speed[k], np.zeros(3)
    force, moment, _ = by_hand(rotor_of(vehicle), vehicle, omega, velocity, rates, still)
    inertial = vehicle.mass * (to_body @ [0.0, speed * turn, GRAVITY])
    return np.concatenate([force - inertial, moment]) / (vehicle.mass * GRAVITY)


@pytest.fixture(scope="session")
def vehicle() -> Vehicle:
    return quadcopter()


@pytest.fixture(scope="session")
def aircraft(vehicle: Vehicle) -> Aircraft:
    return aircraft_of(vehicle)
