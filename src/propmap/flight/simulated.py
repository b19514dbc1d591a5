"""Operating points flown one after the other, as a log with the noise of its sensors."""

from __future__ import annotations

import io
import json
from dataclasses import dataclass, replace

import numpy as np

from propmap.errors import InputError
from propmap.typing import Floats
from propmap.vehicle.files import CHOICES, LogMap
from propmap.vehicle.log import GRAVITY, FlightLog, in_vehicle_frame, pitch_and_roll

HARDEST = 2.0
"""Largest acceleration [m/s^2] from one speed to the next."""

SHORTEST = 0.5
"""Least time [s] from one speed to the next."""

MOST_SAMPLES = 2_000_000

VECTORS = {
    "velocity": ("vx_mps", "vy_mps", "vz_mps"),
    "rates": ("p_radps", "q_radps", "r_radps"),
    "specific_force": ("ax_mps2", "ay_mps2", "az_mps2"),
}
ANGLES = ("roll", "pitch", "yaw")


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of one sample; the noise is white, so that averages have less.

    Attributes
    ----------
    rotor_speed : float
        As a share of the rotor speed [-].
    velocity : float
        Of each component [m/s].
    attitude : float
        Of pitch and roll [rad].
    specific_force : float
        Of each component [m/s^2].
    """

    rotor_speed: float = 0.005
    velocity: float = 0.05
    attitude: float = 0.005
    specific_force: float = 0.3


NOISELESS = SensorNoise(0.0, 0.0, 0.0, 0.0)


def check_sampling(dwell: float, rate: float) -> None:
    """Raise ``InputError`` for a ``dwell`` [s] or a ``rate`` [1/s] that makes no log."""
    if not 1.0 <= dwell <= 3600.0:
        raise InputError(f"each speed is held for {dwell:g} s", "give from 1 to 3600 s")
    if not 4.0 <= rate <= 10_000.0:
        raise InputError(f"the rate is {rate:g} samples per second", "give from 4 to 10000")


def fly(
    points: FlightLog,
    *,
    dwell: float = 6.0,
    rate: float = 100.0,
    noise: SensorNoise = NOISELESS,
    seed: int = 0,
) -> FlightLog:
    """A log of level circles flown one after the other.

    Between two speeds the vehicle leans into the acceleration and the rotors carry it, by the
    thrust alone: these moments are there to be left out, as in a real log.

    Parameters
    ----------
    points : FlightLog
        Operating points of ``trim``, in the order in which they are flown.
    dwell : float
        How long each is held [s].
    rate : float
        Samples per second [1/s].
    noise : SensorNoise
        Of the sensors.
    seed : int
        Of the noise.
    """
    check_sampling(dwell, rate)
    speed, (pitch, roll) = points.speed, pitch_and_roll(points.up)
    turn = np.sum(points.rates * points.up, axis=1)
    # The smooth change below is at most twice as fast as its mean.
    lasts = np.maximum(2.0 * np.abs(np.diff(speed)) / HARDEST, SHORTEST)
    begins = dwell * np.arange(1, speed.size) + np.concatenate([[0.0], np.cumsum(lasts)])[:-1]
    count = int((dwell * speed.size + lasts.sum()) * rate)
    if count > MOST_SAMPLES:
        raise InputError(f"the log would have {count} samples", "lower the rate or the dwell")
    time = np.arange(count) / rate
    share = np.clip((time[:, None] - begins) / lasts, 0.0, 1.0)
    done = share - np.sin(2.0 * np.pi * share) / (2.0 * np.pi)

    def course(values: Floats) -> Floats:
        return values[0] + done @ np.diff(values, axis=0)

    push = (1.0 - np.cos(2.0 * np.pi * share)) @ (np.diff(speed) / lasts)
    speed, turn = course(speed), course(turn)
    pitch, roll = course(pitch) + np.arctan(push / GRAVITY), course(roll)
    harder = (1.0 + (push / GRAVITY) ** 2) ** 0.25
    up = in_vehicle_frame(0.0, 0.0, 1.0, pitch, roll)
    roll_rate, pitch_rate = (np.gradient(angle, 1.0 / rate) for angle in (roll, pitch))
    tilting = [roll_rate, np.cos(roll) * pitch_rate, -np.sin(roll) * pitch_rate]
    log = FlightLog(
        source="simulated flight",
        time=time,
        velocity=in_vehicle_frame(speed, 0.0, 0.0, pitch, roll),
        rates=turn[:, None] * up + np.stack(tilting, axis=1),
        up=up,
        specific_force=in_vehicle_frame(push, speed * turn, GRAVITY, pitch, roll),
        rotor_speed=course(points.rotor_speed) * harder[:, None],
    )
    return _measured(log, pitch, roll, noise, np.random.default_rng(seed))


def _measured(
    log: FlightLog, pitch: Floats, roll: Floats, noise: SensorNoise, rng: np.random.Generator
) -> FlightLog:
    def noisy(values: Floats, size: float) -> Floats:
        return values + size * rng.standard_normal(values.shape)

    pitch, roll = noisy(pitch, noise.attitude), noisy(roll, noise.attitude)
    even = np.ones_like(log.rotor_speed)
    return replace(
        log,
        velocity=noisy(log.velocity, noise.velocity),
        up=in_vehicle_frame(0.0, 0.0, 1.0, pitch, roll),
        specific_force=noisy(log.specific_force, noise.specific_force),
        rotor_speed=np.abs(log.rotor_speed * noisy(even, noise.rotor_speed)),
    )


def log_map(rotors: int) -> LogMap:
    """How a file of ``log_csv`` is to be read."""
    columns = {"time": ("time_s",), **VECTORS, **{name: (f"{name}_rad",) for name in ANGLES}}
    columns["rotor_speed"] = tuple(f"rotor_{k}_radps" for k in range(1, rotors + 1))
    return LogMap("flu", "enu", "body", "rad/s", columns=columns)


def log_table(rotors: int) -> str:
    """The same as the text of the table ``[log]`` for a vehicle file."""
    how, several = log_map(rotors), (*VECTORS, "rotor_speed")
    stated = {key: how.stated(key) for key in CHOICES}
    columns = {key: names if key in several else names[0] for key, names in how.columns.items()}
    # Texts and lists of texts are the same in JSON and in TOML.
    tables = [
        [heading, *(f"{key} = {json.dumps(value)}" for key, value in table.items())]
        for heading, table in (("[log]", stated), ("[log.columns]", columns))
    ]
    return "\n\n".join("\n".join(lines) for lines in tables) + "\n"


def log_csv(log: FlightLog) -> str:
    """The log as CSV; the heading, which a log does not have, follows from the yaw rate."""
    pitch, roll = pitch_and_roll(log.up)
    turn = np.sum(log.rates * log.up, axis=1)
    steps = 0.5 * (turn[1:] + turn[:-1]) * np.diff(log.time)
    yaw = np.concatenate([[0.0], np.cumsum(steps)])
    vectors = np.concatenate([getattr(log, name) for name in VECTORS], axis=1)
    angles = np.stack([roll, pitch, yaw], axis=1)
    names = [name for part in log_map(log.rotor_speed.shape[1]).columns.values() for name in part]
    text = io.StringIO()
    table = np.column_stack([log.time, vectors, angles, log.rotor_speed])
    np.savetxt(text, table, "%.9g", delimiter=",", header=",".join(names), comments="")
    return text.getvalue()
