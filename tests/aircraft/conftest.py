from __future__ import annotations

import pytest

import propmap
from propmap.aircraft.trim import Aircraft
from propmap.units import RPM
from propmap.vehicle.powertrain import Battery, Motor, Powertrain, SpeedController
from propmap.vehicle.vehicle import Body, Mount, Vehicle

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


@pytest.fixture(scope="session")
def vehicle() -> Vehicle:
    return quadcopter()


@pytest.fixture(scope="session")
def aircraft(vehicle: Vehicle) -> Aircraft:
    return aircraft_of(vehicle)
