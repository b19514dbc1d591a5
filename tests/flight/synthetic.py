"""A flight made by hand: hover, then circles at rising speeds, flown nose first."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np

from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.files import VehicleFile, read_vehicle
from propmap.vehicle.log import FlightLog

ROOT = Path(__file__).parents[2]
NEUROBEM = ROOT / "examples" / "neurobem" / "vehicle.toml"
FLIGHTS = ROOT.parent / "shared" / "data" / "flight"

SPEEDS = (0.0, 3.0, 6.0, 9.0)
RADIUS = 12.0
"""[m] of the circles."""

HOLD, CHANGE = 4.0, 2.0
"""[s] at each speed, and from one to the next."""

K_THRUST = 1.5e-6
"""[N s^2] of the NeuroBEM propeller, from its flights in hover."""

LEAN = 0.004
"""Drag over weight per square of the speed [s^2/m^2]."""


def profile(time: Floats) -> tuple[Floats, Floats]:
    """Speed [m/s] and acceleration along the path [m/s^2] at the times; (n,)."""
    speed, acceleration = np.zeros_like(time), np.zeros_like(time)
    for k, (slow, fast) in enumerate(itertools.pairwise(SPEEDS)):
        share = np.clip((time - (k + 1) * HOLD - k * CHANGE) / CHANGE, 0.0, 1.0)
        speed += (fast - slow) * (1.0 - np.cos(np.pi * share)) / 2.0
        acceleration += (fast - slow) * np.sin(np.pi * share) * np.pi / (2.0 * CHANGE)
    return speed, acceleration


def flight(rate: float = 100.0) -> FlightLog:
    """The flight of the NeuroBEM quadrotor, ``rate`` samples per second."""
    duration = len(SPEEDS) * HOLD + (len(SPEEDS) - 1) * CHANGE
    time = np.arange(0.0, duration, 1.0 / rate)
    speed, along = profile(time)
    turn = speed / RADIUS
    # Along the path, to the left and up: what an accelerometer would read.
    path_force = np.stack([along, speed * turn, np.full_like(time, GRAVITY)], axis=1)
    thrust = path_force + np.stack([LEAN * speed**2 * GRAVITY, 0 * time, 0 * time], axis=1)
    z = thrust / np.linalg.norm(thrust, axis=1, keepdims=True)
    y = np.cross(z, np.array([1.0, 0.0, 0.0]))
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    body = np.stack([np.cross(y, z), y, z], axis=1)  # rows: body axes along the path's
    up = body[:, :, 2]
    total = np.linalg.norm(thrust, axis=1)
    speeds = np.sqrt(0.772 * total / (4.0 * K_THRUST))
    return FlightLog(
        source="synthetic",
        time=time,
        velocity=body[:, :, 0] * speed[:, None],
        rates=up * turn[:, None],
        up=up,
        specific_force=np.einsum("nij,nj->ni", body, path_force),
        # The rotors differ, so that an order mixed up shows.
        rotor_speed=speeds[:, None] * np.array([0.98, 0.99, 1.01, 1.02]),
    )


def vehicle_text(log_table: str) -> str:
    """The NeuroBEM vehicle with another ``[log]`` table and the geometry's absolute path."""
    text = NEUROBEM.read_text(encoding="utf-8").partition("[log]")[0]
    geometry = str(NEUROBEM.parent / "propeller.csv")
    return text.replace('"propeller.csv"', f"'{geometry}'") + log_table


def vehicle_with(log_table: str, folder: Path) -> VehicleFile:
    """Write a file in the folder, and read it."""
    path = folder / "vehicle.toml"
    path.write_text(vehicle_text(log_table), encoding="utf-8")
    return read_vehicle(path)
