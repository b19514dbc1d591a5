"""Operating points flown one after the other, as a log with the noise of its sensors."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from propmap.arrays.types import Floats
from propmap.errors import InputError
from propmap.flight.leaning import in_leaning_frame, lean
from propmap.vehicle.flight_log import GRAVITY, FlightLog

HARDEST = 2.0
"""[m/s^2], largest acceleration from one speed to the next."""

SHORTEST = 0.5
"""[s] from one speed to the next."""

MOST_SAMPLES = 2_000_000


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of one sample; white, so that averages have less.

    rotor_speed : as a share of it [-].  velocity : [m/s].  attitude : of pitch and roll [rad].
    specific_force : [m/s^2].
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
    """A log of level circles, each held for ``dwell`` [s], sampled ``rate`` [1/s] times.

    points : of ``trim``, in the order in which they are flown.  seed : of the noise.
    Between two speeds the vehicle leans into the acceleration and the rotors carry it, by the
    thrust alone: these moments are there to be left out, as in a real log.
    """
    check_sampling(dwell, rate)
    speed, (pitch, roll) = points.speed, lean(points.up)
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
    nothing = np.zeros_like(time)

    def seen(forward: Floats, left: Floats, vertical: Floats) -> Floats:
        return in_leaning_frame(np.stack([forward, left, vertical], axis=1), pitch, roll)

    up = seen(nothing, nothing, nothing + 1.0)
    tilting = np.stack(
        [
            np.gradient(roll, 1.0 / rate),
            np.cos(roll) * np.gradient(pitch, 1.0 / rate),
            -np.sin(roll) * np.gradient(pitch, 1.0 / rate),
        ],
        axis=1,
    )
    log = FlightLog(
        source="simulated flight",
        time=time,
        velocity=seen(speed, nothing, nothing),
        rates=turn[:, None] * up + tilting,
        up=up,
        specific_force=seen(push, speed * turn, nothing + GRAVITY),
        rotor_speed=course(points.rotor_speed) * harder[:, None],
    )
    return _measured(log, pitch, roll, noise, np.random.default_rng(seed))


def _measured(
    log: FlightLog, pitch: Floats, roll: Floats, noise: SensorNoise, rng: np.random.Generator
) -> FlightLog:
    def error(size: float, shape: tuple[int, ...]) -> Floats:
        return size * rng.standard_normal(shape)

    n = len(log)
    vertical = np.tile([0.0, 0.0, 1.0], (n, 1))
    tilted = pitch + error(noise.attitude, (n,)), roll + error(noise.attitude, (n,))
    return replace(
        log,
        velocity=log.velocity + error(noise.velocity, (n, 3)),
        up=in_leaning_frame(vertical, *tilted),
        specific_force=log.specific_force + error(noise.specific_force, (n, 3)),
        rotor_speed=np.abs(
            log.rotor_speed * (1.0 + error(noise.rotor_speed, log.rotor_speed.shape))
        ),
    )
