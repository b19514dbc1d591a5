"""Usual mistakes in frames, units and columns of a recording, and how it reads without them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from propmap.typing import Floats
from propmap.vehicle.flight_log import GRAVITY
from propmap.vehicle.logs import frames
from propmap.vehicle.logs.assembly import interpolated
from propmap.vehicle.logs.recording import Recording, Signal

OTHER = {"flu": "frd", "frd": "flu", "enu": "ned", "ned": "enu", "body": "world", "world": "body"}

HALF_TURN = np.array([1.0, -1.0, -1.0])
"""FLU to FRD and back."""

SPEED_UNITS = {"km/h": 3.6, "cm/s": 100.0, "mm/s": 1000.0}
"""Per m/s."""

OFF_TIME = 0.2
"""Relative error of the time from which it is named."""


@dataclass(frozen=True, eq=False)
class Slip:
    """A mistake that was made, what to do, and the recording without it."""

    cause: str
    remedy: str
    put_right: Recording


def slips(recording: Recording, turned: Floats, gyro: Floats) -> Iterator[Slip]:
    """Each mistake that may have been made in a recording.

    Parameters
    ----------
    recording : Recording
        Cleaned.
    turned, gyro : ndarray, shape (n, 3)
        Rates by the attitude and by the gyro [rad/s].
    """
    yield from _of_rates(recording)
    yield from _of_attitude(recording)
    yield from _of_velocity(recording)
    if recording.specific_force is not None:
        yield from _of_force(recording, recording.specific_force)
    yield from _of_time(recording, turned, gyro)


def _changed(signal: Signal, values: Floats) -> Signal:
    return Signal(signal.name, signal.time, values)


def _of_rates(recording: Recording) -> Iterator[Slip]:
    rates, frame = recording.rates, OTHER[recording.body_frame]
    for factor, cause, remedy in (
        (np.pi / 180.0, "are in degrees per second", "convert them to rad/s"),
        (180.0 / np.pi, "are 57 times too small", "convert degrees to radians once, not twice"),
    ):
        yield Slip(
            f"{rates.name} {cause}: taken so, they agree with the attitude",
            remedy,
            replace(recording, rates=_changed(rates, rates.values * factor)),
        )
    flipped = _changed(rates, rates.values * HALF_TURN)
    yield Slip(
        f"{rates.name} are along the axes of {frame.upper()}, not {recording.body_frame.upper()}: "
        "so they agree with the attitude",
        "change the signs of their y and z",
        replace(recording, rates=flipped),
    )
    force = recording.specific_force
    if force is not None:
        yield Slip(
            f"{rates.name} and {force.name} are along the axes of {frame.upper()}, not "
            f"{recording.body_frame.upper()}: taken so, they agree with attitude and velocity",
            "change the signs of y and z of both",
            replace(
                recording, rates=flipped, specific_force=_changed(force, force.values * HALF_TURN)
            ),
        )


def _of_attitude(recording: Recording) -> Iterator[Slip]:
    signal = recording.attitude
    agrees = "taken so, it agrees with the gyro"
    q = signal.values

    def with_quaternions(values: Floats) -> Recording:
        return replace(recording, attitude=_changed(signal, values))

    yield Slip(
        f"{signal.name} turns world to body axes, expected body to world: {agrees}",
        "change the signs of qx, qy and qz",
        with_quaternions(q * np.array([1.0, -1.0, -1.0, -1.0])),
    )
    for order, first, named in (
        ([3, 0, 1, 2], "x, y, z, w", "qw is the last column, qx the first"),
        ([1, 2, 3, 0], "w, x, y, z", "qw is the column that is named qx"),
    ):
        yield Slip(
            f"{signal.name} has its numbers in the order {first}: {agrees}",
            f"correct the columns, {named}",
            with_quaternions(q[:, order]),
        )
    body, world = OTHER[recording.body_frame], OTHER[recording.world_frame]
    meant = frames.attitude_to_flu_enu(q, body, world).as_quat(scalar_first=True)
    stated = frames.attitude_to_flu_enu(meant, recording.body_frame, recording.world_frame)
    yield Slip(
        f"{signal.name} turns {body.upper()} to {world.upper()}, stated are "
        f"{recording.body_frame.upper()} and {recording.world_frame.upper()}: {agrees}",
        "give all signals in the same frames",
        with_quaternions(stated.as_quat(scalar_first=True)),
    )


def _of_velocity(recording: Recording) -> Iterator[Slip]:
    signal, frame = recording.velocity, recording.velocity_in
    agrees = "taken so, it agrees with the accelerometer"

    def with_velocity(values: Floats) -> Recording:
        return replace(recording, velocity=_changed(signal, values))

    other = OTHER[frame]
    yield Slip(
        f"{signal.name} is along {other} axes, not {frame} axes: {agrees}",
        f'write velocity_in = "{other}" in [log]',
        replace(recording, velocity_in=other),
    )
    if frame == "body":
        stated, turned = recording.body_frame, signal.values * HALF_TURN
        remedy = "change the signs of its y and z"
    else:
        stated = recording.world_frame
        turned = frames.world_to_enu(signal.values, "ned")
        remedy = "give it along the axes of world_frame"
    yield Slip(
        f"{signal.name} is along the axes of {OTHER[stated].upper()}, not {stated.upper()}: "
        f"{agrees}",
        remedy,
        with_velocity(turned),
    )
    if frame == "world":
        upwards = np.array([1.0, 1.0, 1.0 if recording.world_frame == "enu" else -1.0])
        climbing = signal.values.copy()
        climbing[:, 2] = np.gradient(signal.values[:, 2], signal.time)
        yield Slip(
            f"the third component of {signal.name} is an altitude, whose change agrees with the "
            "accelerometer",
            "name the column of the vertical velocity [m/s] instead",
            with_velocity(climbing * upwards),
        )
    for unit, factor in SPEED_UNITS.items():
        yield Slip(
            f"{signal.name} is in {unit}: {agrees}",
            "convert it to m/s",
            with_velocity(signal.values / factor),
        )
    slope = np.gradient(signal.values, signal.time, axis=0)
    yield Slip(
        f"{signal.name} holds positions, whose change agrees with the accelerometer",
        "name the columns of the velocity [m/s] instead",
        replace(recording, velocity=_changed(signal, slope), velocity_in="world"),
    )


def _of_force(recording: Recording, force: Signal) -> Iterator[Slip]:
    agrees = "taken so, it agrees with the velocity"
    at = np.clip(force.time, recording.attitude.time[0], recording.attitude.time[-1])
    own = recording.attitude
    smooth = Signal(own.name, own.time, frames.continuous(own.values))
    turn = frames.attitude_to_flu_enu(
        interpolated(smooth, at), recording.body_frame, recording.world_frame
    )
    flu = frames.body_to_flu(force.values, recording.body_frame)

    def with_force(in_flu: Floats) -> Recording:
        values = frames.body_to_flu(in_flu, recording.body_frame)
        return replace(recording, specific_force=_changed(force, values))

    upward = turn.apply(np.tile([0.0, 0.0, GRAVITY], (at.size, 1)), inverse=True)
    yield Slip(
        f"gravity is taken off {force.name}, which reads about 0 in hover: with it, it agrees "
        "with the velocity",
        "give what the accelerometer reads, about 9.8 m/s^2 upwards in hover",
        with_force(flu + upward),
    )
    yield Slip(
        f"{force.name} points the wrong way, down in hover: {agrees}",
        "change its sign",
        with_force(-flu),
    )
    stated = recording.body_frame
    yield Slip(
        f"{force.name} is along the axes of {OTHER[stated].upper()}, not {stated.upper()}: "
        f"{agrees}",
        "change the signs of its y and z",
        with_force(flu * HALF_TURN),
    )
    yield Slip(
        f"{force.name} is along world axes, not body axes: {agrees}",
        "give it along the axes of the body, as an accelerometer reads",
        with_force(turn.apply(flu, inverse=True)),
    )
    yield Slip(
        f"{force.name} is in units of g: {agrees}",
        "convert it to m/s^2",
        with_force(flu * GRAVITY),
    )


def _of_time(recording: Recording, turned: Floats, gyro: Floats) -> Iterator[Slip]:
    along, size = float(np.sum(turned * gyro)), float(np.sum(turned**2))
    slow = along / size if size > 0.0 else 0.0
    if slow <= 0.0 or abs(slow - 1.0) < OFF_TIME:
        return
    signals = {
        name: Signal(signal.name, signal.time / slow, signal.values)
        for name, signal in recording.signals().items()
    }
    yield Slip(
        f"the times are {slow:.3g} times those by which attitude and gyro agree",
        "give the times of the measurements in seconds",
        replace(recording, **signals),  # type: ignore[arg-type]
    )
