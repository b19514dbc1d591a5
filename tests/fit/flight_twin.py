"""Two flights of a quadrotor with six axes, made of known parameters: what a fit has to find."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

import propmap
from propmap.fit.flight import ForceModel, balance_rows
from propmap.fit.least_squares import Rows
from propmap.fit.moments import measured_moment
from propmap.fit.parameters import FIRST_GUESS, PER_FLIGHT, SECTION, Choice, Prior
from propmap.model.airfoil import parameter_set
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.log import FlightLog, joined, low_passed
from propmap.vehicle.vehicle import Mount, Vehicle

LAW = parameter_set("paper-apc")
ARM = 0.15
HUBS = ((ARM, ARM, "cw"), (ARM, -ARM, "ccw"), (-ARM, ARM, "ccw"), (-ARM, -ARM, "cw"))
VEHICLE = Vehicle(
    "twin",
    0.826,  # what four rotors carry at 560 rad/s
    propmap.propeller("apc-8x6e"),
    tuple(Mount((x, y, 0.02), spin=spin) for x, y, spin in HUBS),
    inertia=(4e-3, 5e-3, 8e-3),
)
DURATION, RATE = 30.0, 100.0
FLIGHTS = ("1", "2")
SCALES = tuple(f"thrust_scale[{flight}]" for flight in FLIGHTS)

TRUTH: dict[str, float] = {
    "c_l1": LAW.c_l1,
    "c_d0": 0.015,
    "mount_area": 0.003,
    "plate_area": 0.01,
    "sensor_x": -0.02,
    "sensor_y": 0.03,
    "sensor_z": 0.015,
    "center_x": 0.004,
    "center_y": -0.003,
    "center_z": 0.006,
    "rotor_inertia": 1e-5,
    "moment_scale_xy": 0.7,
    "moment_scale_z": 0.8,
    "wake_ahead": 1.8,
    "wake_beside": 0.6,
    "wake_downwash": 0.7,
    "wake_share": 1.2,
    "clock_offset[1]": 0.004,
    "clock_offset[2]": -0.002,
    "thrust_scale[1]": 1.02,
    "thrust_scale[2]": 0.99,
}
"""Values of all that is free."""

BEFOREHAND: dict[str, float] = {
    "plate_area": 0.02,
    "mount_area": 0.005,
    "rotor_inertia": 1e-5,
    "moment_scale_xy": 0.3,
    "moment_scale_z": 0.3,
    **dict.fromkeys(("sensor_x", "sensor_y", "sensor_z"), 0.05),
    **dict.fromkeys(("center_x", "center_y", "center_z"), 0.01),
    **dict.fromkeys(("clock_offset[1]", "clock_offset[2]"), 0.01),
    **dict.fromkeys(("wake_ahead", "wake_beside", "wake_downwash"), 1.0),
    "wake_share": 0.5,
    **dict.fromkeys(SCALES, PER_FLIGHT["thrust_scale"]),
}
"""Deviation of what is known of each before a fit."""

FREE = tuple(TRUTH)
FIXED: dict[str, float] = {name: getattr(LAW, name) for name in SECTION if name not in FREE}


def manoeuvre(seed: int, samples: int) -> FlightLog:
    """A climb with quick turns after a hover, all signals smooth, as fast as 12 m/s.

    It stays out of descent, where loads have kinks.  Accelerations are filled in later.
    """
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, DURATION, 1.0 / RATE)
    moving = np.clip(0.5 * time - 1.0, 0.0, 1.0)[:, None]

    def waves(size: float, columns: int = 3) -> Floats:
        rate, phase = rng.uniform(0.5, 4.0, (3, 1, columns)), rng.uniform(0.0, 6.0, (3, 1, columns))
        return np.asarray(size * moving * np.sum(np.sin(rate * time[:, None] + phase), axis=0))

    velocity = waves(3.0) * [1.0, 1.0, 0.3] + 3.0 * moving * [0.0, 0.0, 1.0]
    up = np.array([0.0, 0.0, 1.0]) + waves(0.1)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    rotors = 560.0 + 12.0 * waves(1.0, 4)
    log = FlightLog("twin", time, velocity, waves(1.5), up, GRAVITY * up, rotors)
    log = low_passed(log, 0.0)
    return log.picked(np.linspace(0, len(log) - 1, samples).astype(int))


@dataclass(frozen=True)
class Noise:
    """Standard deviations of the errors of one axis, over the scale of the rows [-]."""

    white: float = 0.005
    alike: float = 0.01
    lasting: float = 0.3  # time constant of the correlation of the errors ``alike`` [s]


class Twin:
    """Rows of six axes of two flights with ``samples`` each."""

    def __init__(self, samples: int = 80) -> None:
        log = joined([manoeuvre(seed, samples) for seed in range(len(FLIGHTS))], FLIGHTS)
        jerk = np.stack([20.0 * np.cos(log.time + k) for k in range(3)], axis=1)
        log = replace(log, specific_force_rate=jerk)
        # Turning as the moments say, and an accelerometer that feels what the forces do.
        model = ForceModel(VEHICLE, log, LAW)
        moment = model.at(FIRST_GUESS | FIXED | TRUTH, ()).moment
        assert VEHICLE.inertia is not None
        inertia = np.array(VEHICLE.inertia)
        turning = (moment - np.cross(log.rates, inertia * log.rates)) / inertia
        self.log = replace(log, angular_acceleration=turning)
        np.testing.assert_allclose(measured_moment(VEHICLE, self.log), moment, atol=1e-12)
        self.model = ForceModel(VEHICLE, self.log, LAW)
        self.rows = balance_rows(self.model, Choice(FREE, FIXED))

    def measured(self, truth: Mapping[str, float]) -> Floats:
        """What the rows would be without noise; (M,)."""
        return self.rows.picked(self.model.at(FIRST_GUESS | FIXED | dict(truth), ()).loads)

    def noise(self, rng: np.random.Generator, size: Noise) -> Floats:
        """Errors of the rows, those of an axis alike for a while; (M,)."""
        log, axes = self.log, len(self.rows.names)
        each = size.white * rng.standard_normal((len(log), axes))
        for number in range(len(log.flights)):
            mine = np.flatnonzero(log.flight == number)
            steps = np.diff(log.time[mine], prepend=log.time[mine][0])
            left = np.exp(-steps / size.lasting)
            error = size.alike * rng.standard_normal(axes)
            for k, kept in zip(mine, left, strict=True):
                new = size.alike * np.sqrt(1.0 - kept**2) * rng.standard_normal(axes)
                error = kept * error + new
                each[k] += error
        return self.rows.scale * self.rows.picked(each)

    def noisy(self, seed: int, size: Noise) -> tuple[Rows, Choice, dict[str, float]]:
        """Rows, what is free with priors that err as much as they say, and the truth."""
        rng = np.random.default_rng(seed)
        scales = {name: 1.0 + PER_FLIGHT["thrust_scale"] * rng.standard_normal() for name in SCALES}
        truth = TRUTH | scales
        means = {
            name: truth[name] + deviation * rng.standard_normal()
            for name, deviation in BEFOREHAND.items()
        }
        means |= dict.fromkeys(SCALES, 1.0)
        priors = {name: Prior(means[name], deviation) for name, deviation in BEFOREHAND.items()}
        choice = Choice(FREE, FIXED, priors, start=truth)
        measured = self.measured(truth) + self.noise(rng, size)
        return replace(self.rows, measured=measured), choice, truth
