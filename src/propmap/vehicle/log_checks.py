"""Whether a recording can be what it is said to be: frames, units, clocks, sensors that fail."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.typing import Floats
from propmap.units import DEGREE, GRAVITY, KMH
from propmap.vehicle import log
from propmap.vehicle.log import LONGEST_GAP, Recording, Signal, cleaned, common_clock, interpolated

# -------------------------------------------------------------------------------------------------
# Whether the signals of a recording describe one motion: frames, units and clocks show.
#
# The attitude's own turning is what a gyro reads, and the change of the velocity, with gravity, is
# what an accelerometer reads.  Where they disagree, each usual mistake is put right in turn; the
# one
# after which they agree is named.

CUTOFF = 3.0
"""Low-pass [Hz] before signals are compared: slow motion is enough to tell frames and units."""

TURNING, ACCELERATING = 0.1, 0.5
"""Root mean square of rates [rad/s] and accelerations [m/s^2] below which nothing is said."""

DISAGREE, AGREE = 0.15, 0.07
"""Mismatch from which signals do not belong together, and below which they do.  0 is equal, 0.2
twice as large, 1 unrelated, 2 opposite; real flights have 0.001 to 0.01."""

WINDOW, BROKEN = 2.0, 0.4
"""Stretches [s] that are looked at by themselves, and the mismatch from which one is told."""

MOST_LATE, LATE = 0.6, 0.03
"""Delays [s] that are tried, and from which a remark is due."""


@dataclass(frozen=True, eq=False)
class Pair:
    """One motion by two ways, (n, 3) each, at n times [s]."""

    time: Floats
    expected: Floats
    measured: Floats
    least: float

    def mismatch(self, which: NDArray[np.bool_] | slice = slice(None)) -> float:
        """Squared difference over the sum of the squares, of the axis on which it is largest.

        ``which`` says which samples are looked at.  NaN where they move too little.
        """
        a, b = self.expected[which], self.measured[which]
        sizes = np.stack([np.sum(a**2, axis=0), np.sum(b**2, axis=0)])
        moves = sizes.max(axis=0) > self.least**2 * len(a)
        off = np.sum((a - b) ** 2, axis=0)[moves] / sizes.sum(axis=0)[moves]
        return float(off.max()) if off.size else np.nan


def check_consistency(recording: Recording) -> list[str]:
    """Compare attitude with gyro, and velocity with accelerometer.

    Parameters
    ----------
    recording : Recording
        As it was read.

    Returns
    -------
    list of str
        Warnings.

    Raises
    ------
    InputError
        Where the signals agree once a usual mistake is put right: it is named.
    """
    recording = cleaned(recording)
    turning, moving = pairs(recording)
    if not any(pair.mismatch() > DISAGREE for pair in (turning, moving)):
        return _late(recording, turning) or _stretches(recording, turning, moving)
    found = []
    for slip in slips(recording, turning.expected, turning.measured):
        try:
            put_right = [pair.mismatch() for pair in pairs(slip.put_right)]
        except InputError:  # no log at all, if that were it
            continue
        if not any(mismatch > AGREE for mismatch in put_right):
            found.append((float(np.nansum(put_right)), slip))
    if found:
        _, best = min(found, key=lambda one: one[0])
        raise InputError(best.cause, best.remedy, recording.source)
    return _late(recording, turning) or _stretches(recording, turning, moving)


def pairs(recording: Recording) -> tuple[Pair, Pair]:
    """Rates by the attitude and by the gyro, accelerations by the velocity and by the
    accelerometer; the latter without samples where there is no accelerometer."""
    own, rest = recording.attitude, [recording.velocity, recording.rates]
    force = recording.specific_force
    rest += [force] if force is not None else []
    # At their own times the signs of quaternions must not jump.
    smooth = Signal(own.name, own.time, log.continuous(own.values))
    time = common_clock([own], rest, recording.source)
    ends = np.flatnonzero(np.diff(time) > LONGEST_GAP) + 1
    parts = [part for part in np.split(time, ends) if part.size > 3]
    each = [_compared(recording, smooth, part) for part in parts]
    joined = [np.concatenate(arrays) for arrays in zip(*each, strict=True)]
    when, turned, gyro, moved, pushed = joined
    some = slice(0 if force is None else None)
    return (
        Pair(when, turned, gyro, TURNING),
        Pair(when[some], moved[some], pushed[some], ACCELERATING),
    )


def _compared(recording: Recording, attitude: Signal, time: Floats) -> tuple[Floats, ...]:
    """Times between samples of a stretch without gaps, and what is compared there."""
    quaternions = _low_passed(interpolated(attitude, time), time)
    turn = log.attitude_to_flu_enu(quaternions, recording.body_frame, recording.world_frame)
    steps = np.diff(time)[:, None]
    turned = (turn[:-1].inv() * turn[1:]).as_rotvec() / steps

    def in_flu(signal: Signal) -> Floats:
        values = log.body_to_flu(interpolated(signal, time), recording.body_frame)
        return _low_passed(values, time)

    gyro = in_flu(recording.rates)
    if recording.velocity_in == "body":
        velocity = turn.apply(in_flu(recording.velocity))
    else:
        over_ground = interpolated(recording.velocity, time)
        velocity = _low_passed(log.world_to_enu(over_ground, recording.world_frame), time)
    moved = np.diff(velocity, axis=0) / steps
    pushed = np.full_like(moved, np.nan)
    if recording.specific_force is not None:
        pushed = _between(turn.apply(in_flu(recording.specific_force)))
        pushed[:, 2] -= GRAVITY
    middle = 0.5 * (time[1:] + time[:-1])
    return middle, turned, _between(gyro), moved, pushed


def _between(values: Floats) -> Floats:
    return np.asarray(0.5 * (values[1:] + values[:-1]))


def _low_passed(values: Floats, time: Floats) -> Floats:
    """Without what is faster than 3 Hz, where there are samples enough."""
    step = float(np.median(np.diff(time)))
    if 4.0 * CUTOFF * step > 1.0 or time.size < 20:
        return values
    from scipy.signal import butter, sosfiltfilt

    sections = butter(2, 2.0 * CUTOFF * step, output="sos")
    beyond = min(time.size - 1, round(0.5 / step))
    return np.asarray(sosfiltfilt(sections, values, axis=0, padlen=beyond))


def _late(recording: Recording, turning: Pair) -> list[str]:
    """A remark where gyro and attitude agree much better with a delay between their clocks."""
    now = turning.mismatch()
    if not now > 0.5 * AGREE:
        return []
    tried = {}
    for late in np.arange(-MOST_LATE, MOST_LATE + 0.01, 0.02):
        columns = [np.interp(turning.time + late, turning.time, c) for c in turning.measured.T]
        tried[float(late)] = replace(turning, measured=np.stack(columns, axis=1)).mismatch()
    late = min(tried, key=lambda key: tried[key])
    if abs(late) < LATE or not tried[late] < min(AGREE, 0.25 * now):
        return []
    return [
        f"{recording.source}: {recording.rates.name} come {abs(late):.2g} s "
        f"{'after' if late > 0.0 else 'before'} {recording.attitude.name}: give all signals the "
        "stamps of one clock"
    ]


def _stretches(recording: Recording, turning: Pair, moving: Pair) -> list[str]:
    """Remarks on when the signals disagree."""
    force = recording.specific_force
    names = [(turning, recording.rates.name, recording.attitude.name)]
    if force is not None:
        names.append((moving, force.name, recording.velocity.name))
    told = []
    for pair, measured, other in names:
        first, last = float(pair.time[0]), float(pair.time[-1])
        ends = np.linspace(first, last, max(round((last - first) / WINDOW), 1) + 1)
        bad = [
            (begin, end)
            for begin, end in itertools.pairwise(ends)
            if pair.mismatch((pair.time >= begin) & (pair.time <= end)) > BROKEN
        ]
        if bad:
            told.append(
                f"{recording.source}: {measured} and {other} describe different motions in "
                f"{len(bad)} of {len(ends) - 1} stretches, from {bad[0][0]:.4g} to {bad[-1][1]:.4g}"
                " s: look for a jump of a clock, a sensor that failed, or wrong axes; cut the log"
            )
    return told


# -------------------------------------------------------------------------------------------------
# Usual mistakes in frames, units and columns of a recording, and how it reads without them.

OTHER = {"flu": "frd", "frd": "flu", "enu": "ned", "ned": "enu", "body": "world", "world": "body"}

HALF_TURN = np.array([1.0, -1.0, -1.0])
"""FLU to FRD and back."""

SPEED_UNITS = {"km/h": 1.0 / KMH, "cm/s": 100.0, "mm/s": 1000.0}
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
        (DEGREE, "are in degrees per second", "convert them to rad/s"),
        (1.0 / DEGREE, "are 57 times too small", "convert degrees to radians once, not twice"),
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
    meant = log.attitude_to_flu_enu(q, body, world).as_quat(scalar_first=True)
    stated = log.attitude_to_flu_enu(meant, recording.body_frame, recording.world_frame)
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
        turned = log.world_to_enu(signal.values, "ned")
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
    smooth = Signal(own.name, own.time, log.continuous(own.values))
    turn = log.attitude_to_flu_enu(
        interpolated(smooth, at), recording.body_frame, recording.world_frame
    )
    flu = log.body_to_flu(force.values, recording.body_frame)

    def with_force(in_flu: Floats) -> Recording:
        values = log.body_to_flu(in_flu, recording.body_frame)
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


# -------------------------------------------------------------------------------------------------
# Sensors that stood still, reached the end of their range or fell silent.

AT_END = 0.005
"""Share of samples at the end of a range from which it is told."""

IN_A_ROW = 3
"""Samples at an end of the range, one after the other, that are no chance."""

HELD = 0.2
"""Share of samples equal to the one before from which a signal is one that keeps its values."""

WIDE = 2.0
"""Range [m/s^2] or [rad/s] below which no sensor is at its end."""

MOST_GAPS = 3
"""Of which is told."""

AXES = "xyz"


def sensor_faults(recording: Recording) -> list[str]:
    """Warnings on gaps, on signals that never change, and on sensors at the end of their range.

    Parameters
    ----------
    recording : Recording
        As it was read.
    """
    recording = cleaned(recording)
    told = _gaps(recording)
    for signal in recording.signals().values():
        still = np.ptp(signal.values, axis=0) == 0.0
        if still.all():
            told.append(f"{signal.name} never change: log what was measured")
        elif signal is recording.specific_force and still.any():
            axes = " and ".join(AXES[k] for k in np.flatnonzero(still))
            told.append(f"{signal.name} never changes along {axes}: look for a dead axis")
        elif signal is recording.rotor_speed and still.any():
            rotors = " and ".join(str(k + 1) for k in np.flatnonzero(still))
            told.append(
                f"{signal.name} never changes of rotor {rotors} in the order of the log: log its "
                "measured speed"
            )
    measured = [recording.rates, recording.specific_force]
    told += [text for signal in measured if signal for text in _saturated(signal)]
    return [f"{recording.source}: {text}" for text in told]


def _gaps(recording: Recording) -> list[str]:
    """Where a signal says nothing, or its clock jumped ahead; once for those of one table."""
    found: dict[tuple[float, float], str] = {}
    for signal in recording.signals().values():
        for k in np.flatnonzero(np.diff(signal.time) > LONGEST_GAP):
            found.setdefault((signal.time[k], signal.time[k + 1]), signal.name)
    return [
        f"{name} has no sample from {begin:.6g} to {end:.6g} s, which is left out: if its clock "
        "jumped, correct the times"
        for (begin, end), name in list(found.items())[:MOST_GAPS]
    ]


def _saturated(signal: Signal) -> list[str]:
    told = []
    for axis, column in zip(AXES, signal.values.T, strict=True):
        if np.ptp(column) < WIDE:
            continue
        for end in (column.max(), column.min()):
            count = _in_rows(column, end)
            elsewhere = column[column != end]
            steady = np.count_nonzero(np.diff(elsewhere) == 0.0) > HELD * elsewhere.size
            if count > AT_END * column.size and not steady:
                told.append(
                    f"{signal.name} stands at {end:.4g} along {axis} in {count} samples, as at the "
                    "end of the sensor's range: widen the range, or damp its mount"
                )
    return told


def _in_rows(column: Floats, value: float) -> int:
    """How many samples are the ``value`` in a row with others that are."""
    runs = (len([*run]) for same, run in itertools.groupby(column == value) if same)
    return sum(length for length in runs if length >= IN_A_ROW)


# -------------------------------------------------------------------------------------------------
# Whether a recording can be what it is said to be: the place where such checks meet.


def check_recording(recording: Recording) -> list[str]:
    """Look for mistakes in frames, units, columns and clocks, and for sensors that failed.

    Checks that need the vehicle and its rotors are in ``propmap.flight.checks``.

    Parameters
    ----------
    recording : Recording
        As it was read.

    Returns
    -------
    list of str
        Warnings.

    Raises
    ------
    InputError
        For a mistake that is certain; the line names it and what to do.
    """
    return [*sensor_faults(recording), *check_consistency(recording)]
