"""Flights in wind: a quadrotor with a velocity controller in gusts, and logs with sensor noise.

The forces are those of ``VehicleForces``, at rotor speeds and attitudes that follow the commands of
the controller with a lag.  All flights of a batch are integrated at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
from scipy.spatial.transform import Rotation
from scipy.special import ndtri
from scipy.stats.qmc import LatinHypercube

import propmap
from propmap.fit.files import DataSource, FitFile
from propmap.flight.simulate import log_map
from propmap.hover import HoverModel
from propmap.model.airfoil import parameter_set
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import FlightLog
from tests.fit.fit_records import load, parameter, record

from .synthetic import NEUROBEM

VEHICLE = read_vehicle(NEUROBEM).vehicle
LAW = parameter_set("paper-apc").with_corrections(["pitt-peters", "installed:factor=4.4"])
"""The factor on the rotor drag is that of a fit to the flight 171908."""
STEP, EVERY = 0.01, 2
"""Time step [s], and steps per sample of the log."""

LAG, GAIN, STEEPEST = 0.06, 1.5, 0.9
"""Lag of attitude and rotor speeds [s], gain of the velocity [1/s], tangent of the largest tilt."""

MODEL_ERROR, CORRELATED = 0.02, 0.4
"""Error of the force along each axis, as a share of the weight, and its correlation time [s]."""

LEFT = 1.08 * MODEL_ERROR
"""Error of the low-passed force with the true constants, with noise of the accelerometer."""

TRIM, SCALE, DRAG = 0.01, 0.02, 0.12
"""Standard deviations over flights of the accelerometer's tilts [rad], of the thrust scale, and of
a factor on the force along x and y."""

PATHS = {"hover": (0.0, 0.0, 0.3), "cruise": (7.0, 0.1, 0.3), "aggressive": (5.0, 1.3, 0.6)}
"""Speed [m/s] and frequency [rad/s] of the path, and rate of the heading [rad/s]."""


QUICK = ("--method", "balance", "--starts", "1", "--samples", "300")
"""Options of fits to one flight on each path."""

CUTOFF = 6.0
"""Low-pass of the flights [Hz]."""


def fit_of(law: propmap.Airfoil = LAW, **changed: object) -> FitFile:
    """A fit with the true constants, whose error is that of the simulation."""
    weight = VEHICLE.mass * GRAVITY
    one = load("force_x", LEFT * weight, weight, LEFT * weight)
    one = msgspec.structs.replace(one, relative_rms=LEFT)
    entries = {
        "kind": "flight",
        "parameters": [
            parameter("c_l1", law.c_l1, 0.5, 12.0),
            parameter("thrust_scale[1]", 1.0, 0.8, 1.25),
        ],
        "covariance": np.diag([0.05**2, 0.01**2]),
        "loads": [msgspec.structs.replace(one, name=f"force_{axis}") for axis in "xyz"],
        "settings": {"low_pass": CUTOFF},
        # The true constants are free of the differences between few flights.
        "data": [DataSource("many.csv", "abc")] * 1000,
    }
    return FitFile(law, None, record(**entries | changed))


@dataclass(frozen=True, eq=False)
class Windy:
    """A log with the velocity over the ground, and the wind at its samples (n, 3) [m/s]."""

    log: FlightLog
    wind: Floats


def write(log: FlightLog, path: Path) -> None:
    """Write a log as CSV with heading, for the table of ``propmap.flight.simulate.log_table``."""
    names = [name for part in log_map(4).columns.values() for name in part]
    axes = np.stack([log.east, np.cross(log.up, log.east), log.up], axis=1)
    yaw, pitch, roll = Rotation.from_matrix(axes).as_euler("ZYX").T
    parts = [
        log.time,
        log.velocity,
        log.rates,
        log.specific_force,
        roll,
        pitch,
        yaw,
        log.rotor_speed,
    ]
    table = np.column_stack(parts)
    np.savetxt(path, table, "%.9g", delimiter=",", header=",".join(names), comments="")


def gusts(count: int, steps: int, deviation: float, rng: np.random.Generator) -> Floats:
    """Gusts (count, steps, 3) with this standard deviation, half of it vertically [m/s]; they are
    correlated for 5 s, 2 s vertically."""
    kept = np.exp(-STEP / np.array([5.0, 5.0, 2.0]))
    size = deviation * np.array([1.0, 1.0, 0.5])
    found = np.empty((count, steps, 3))
    found[:, 0] = size * rng.standard_normal((count, 3))
    for k in range(1, steps):
        more = rng.standard_normal((count, 3))
        found[:, k] = kept * found[:, k - 1] + size * np.sqrt(1.0 - kept**2) * more
    return found


def flights(
    path: str,
    wind: Floats,
    deviation: float = 0.0,
    seconds: float = 40.0,
    seed: int = 0,
    *,
    differing: bool = True,
    heading: float = 0.0,
) -> list[Windy]:
    """Fly a path of ``PATHS`` in mean winds (m, 3) [m/s], east, north, up, with gusts.

    Flights that are ``differing`` have their own trim, thrust scale and drag.
    """
    rng = np.random.default_rng(seed)
    count, steps = len(wind), round(seconds / STEP)
    air = wind[:, None] + gusts(count, steps, deviation, rng)
    forces = propmap.VehicleForces(VEHICLE, Rotor(Model(VEHICLE.propeller, LAW, VEHICLE.air)))
    rotor = Rotor(Model(VEHICLE.propeller, LAW, VEHICLE.air))
    per_square = 4.0 * HoverModel.from_rotor(rotor).k_thrust
    # One draw in each of ``count`` intervals of equal probability: coverage varies less by chance.
    drawn = differing * ndtri(LatinHypercube(4, rng=rng).random(count))
    scale, tilt = 1.0 + SCALE * drawn[:, :1], TRIM * drawn[:, 1:3]
    scale = scale * (1.0 + DRAG * drawn[:, 3:] * [1.0, 1.0, 0.0])
    speed, frequency, yawing = PATHS[path]
    velocity, error = np.zeros((count, 3)), np.zeros((count, 3))
    push = np.tile([0.0, 0.0, GRAVITY], (count, 1))  # lagged command of the specific force
    integral, phase = np.zeros((count, 3)), rng.uniform(0.0, 6.0, (count, 1))
    kept = np.exp(-STEP / CORRELATED)
    rows = []
    turn_before = None
    for k in range(steps):
        time = k * STEP
        angle = frequency * time + phase[:, 0]
        wanted = speed * np.stack([np.cos(angle), np.sin(1.3 * angle), 0.2 * np.sin(2 * angle)], 1)
        wanted *= min(time / 3.0, 1.0)
        off = wanted - velocity
        integral += STEP * off
        command = GAIN * off + 0.5 * integral + [0.0, 0.0, GRAVITY]
        command[:, 2] = np.clip(command[:, 2], 0.5 * GRAVITY, 1.8 * GRAVITY)
        side = np.linalg.norm(command[:, :2], axis=1, keepdims=True)
        command[:, :2] *= np.minimum(1.0, STEEPEST * command[:, 2:] / np.maximum(side, 1e-9))
        push += STEP / LAG * (command - push)
        up = push / np.linalg.norm(push, axis=1, keepdims=True)
        course = heading + yawing * time
        left = np.cross(up, [np.cos(course), np.sin(course), 0.0])
        left /= np.linalg.norm(left, axis=1, keepdims=True)
        axes = np.stack([np.cross(left, up), left, up], axis=2)  # columns: body axes in the world
        turn = Rotation.from_matrix(axes)
        rates = np.zeros((count, 3))
        if turn_before is not None:
            rates = (turn_before.inv() * turn).as_rotvec() / STEP
        turn_before = turn
        lift = VEHICLE.mass * np.linalg.norm(push, axis=1)
        omega = np.tile(np.sqrt(lift / per_square)[:, None], (1, 4))
        body = [turn.apply(one, inverse=True) for one in (velocity, air[:, k])]
        found = forces.wrench(omega, body[0], rates, body[1])
        noise = rng.standard_normal((count, 3))
        error = kept * error + MODEL_ERROR * GRAVITY * np.sqrt(1.0 - kept**2) * noise
        felt = scale * found.force / VEHICLE.mass + error
        if k % EVERY == 0:
            q, zero = tilt, np.zeros(count)
            # An accelerometer tilted by small angles q reads a - q x a.
            read = felt - np.cross(np.stack([q[:, 0], q[:, 1], zero], axis=1), felt)
            rows.append((body[0], rates, axes, read, omega, air[:, k].copy()))
        velocity = velocity + STEP * (turn.apply(felt) - [0.0, 0.0, GRAVITY])
    every = [np.stack(each, axis=1) for each in zip(*rows, strict=True)]
    times: Floats = STEP * EVERY * np.arange(len(rows), dtype=np.float64)

    def noisy(values: Floats, size: float) -> Floats:
        return values + size * rng.standard_normal(values.shape)

    logs = []
    for ground, rates, axes, read, omega, through in zip(*every, strict=True):
        log = FlightLog(
            source=f"{path} in wind",
            time=times,
            velocity=noisy(ground, 0.03),
            rates=noisy(rates, 0.02),
            up=axes[:, 2],
            east=axes[:, 0],
            specific_force=noisy(read, 0.2),
            rotor_speed=omega * noisy(np.ones_like(omega), 0.003),
        )
        logs.append(Windy(log, through))
    return logs
