"""A flight made by hand that holds together: position, attitude, gyro, accelerometer, rotors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from propmap.typing import Floats
from propmap.units import GRAVITY

from .synthetic import K_THRUST, vehicle_text

MASS = 0.772
INERTIA = np.array([0.0025, 0.0021, 0.0043])
HUBS = np.array([[-0.075, -0.1], [0.075, -0.1], [-0.075, 0.1], [0.075, 0.1]])
"""Hubs of the vehicle of examples/neurobem."""

DRAG = 0.3
"""Over mass and velocity [1/s]."""

FINE = 10
"""Steps of the differences per sample."""

VECTORS = {
    "velocity": ("vx", "vy", "vz"),
    "rates": ("p", "q", "r"),
    "specific_force": ("ax", "ay", "az"),
    "position": ("px", "py", "pz"),
}
QUATERNION = ("qw", "qx", "qy", "qz")
ROTORS = ("m1", "m2", "m3", "m4")


def agile(rate: float = 100.0, duration: float = 14.0, seed: int = 3) -> dict[str, Floats]:
    """Two seconds of hover, then curves in all directions; columns by name, with sensor noise."""
    # Beyond both ends, where differences are one-sided.
    time = np.arange(-1.0 / rate, duration + 1.0 / rate, 1.0 / (rate * FINE))
    grown = np.clip((time - 2.0) / 2.0, 0.0, 1.0)
    # Moments take four derivatives of a position.
    grown = grown**5 * np.polyval([70.0, -315.0, 540.0, -420.0, 126.0], grown)
    shape = np.stack([3.0 * np.sin(1.6 * time), 2.0 * np.sin(2.1 * time + 0.5)], axis=1)
    position = np.column_stack([shape, 0.8 * np.sin(1.3 * time)]) * grown[:, None]
    velocity = np.gradient(position, time, axis=0)
    felt = np.gradient(velocity, time, axis=0) + np.array([0.0, 0.0, GRAVITY])
    pushed = felt + DRAG * velocity
    heading = 1.0 + 0.8 * grown * np.sin(0.7 * time)
    up = pushed / np.linalg.norm(pushed, axis=1, keepdims=True)
    left = np.cross(up, np.stack([np.cos(heading), np.sin(heading), 0.0 * time], axis=1))
    left /= np.linalg.norm(left, axis=1, keepdims=True)
    turn = Rotation.from_matrix(np.stack([np.cross(left, up), left, up], axis=2))
    rates = np.empty_like(position)
    rates[1:-1] = (turn[:-2].inv() * turn[2:]).as_rotvec() / (time[2:] - time[:-2])[:, None]
    rates[0], rates[-1] = rates[1], rates[-2]
    moment = INERTIA * np.gradient(rates, time, axis=0) + np.cross(rates, INERTIA * rates)
    thrust = MASS * np.linalg.norm(pushed, axis=1)
    allocation = np.linalg.pinv(np.stack([np.ones(4), HUBS[:, 1], -HUBS[:, 0]]))
    each = np.column_stack([thrust, moment[:, :2]]) @ allocation.T
    noise = np.random.default_rng(seed)
    table = {
        "velocity": turn.apply(velocity, inverse=True),
        "rates": rates,
        "specific_force": turn.apply(felt, inverse=True),
        "position": position,
    }
    spread = {"velocity": 0.02, "rates": 0.02, "specific_force": 0.1, "position": 0.0}
    kept = slice(FINE, -FINE, FINE)
    columns = {"t": time[kept]}
    for name, names in VECTORS.items():
        values = table[name][kept]
        values = values + spread[name] * noise.standard_normal(values.shape)
        columns |= dict(zip(names, values.T, strict=True))
    columns |= dict(zip(QUATERNION, turn.as_quat(scalar_first=True)[kept].T, strict=True))
    speeds = np.sqrt(each[kept] / K_THRUST) * (1.0 + 0.003 * noise.standard_normal((1, 4)))
    return columns | dict(zip(ROTORS, speeds.T, strict=True))


def log_table() -> str:
    """The ``[log]`` table that names these columns."""
    vectors = [f"{key} = {list(names)}" for key, names in list(VECTORS.items())[:3]]
    texts = (
        *('body_frame = "flu"', 'world_frame = "enu"', 'velocity_in = "body"'),
        'rotor_unit = "rad/s"',
        *("[log.columns]", 'time = "t"', *vectors, f"rotor_speed = {list(ROTORS)}"),
        *(f'{name} = "{name}"' for name in QUATERNION),
    )
    return "\n".join(["[log]", *texts, ""])


def write(columns: dict[str, Floats], path: Path) -> None:
    """Write the columns as CSV."""
    names = ",".join(columns)
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, "%.9g", delimiter=",", header=names, comments="")


def vehicle() -> str:
    """The text of the vehicle file for these logs."""
    return vehicle_text(log_table())
