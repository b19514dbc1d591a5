"""Consistency checks of a recording: frames, units, clocks, and failed sensors."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.model.unit_errors import UNIT_ERRORS
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle import log


def check_recording(recording: log.Recording) -> list[str]:
    """Return warnings of failed sensors and of inconsistent frames, units, columns and clocks.

    Raises ``InputError`` for a mistake that is certain.  Checks that need the vehicle and its
    rotors are in ``propmap.flight.checks``.  Times in messages count from the start of the log.
    """
    recording = log.cleaned(recording).from_start()
    found = [*recording.notes, *_gaps(recording), *_dead_sensors(recording)]
    for signal in (recording.rates, recording.specific_force):
        found += _saturated(signal) if signal else []
    found += _disagreements(recording)
    return [f"{recording.source}: {text}" for text in found]


# -------------------------------------------------------------------------------------------------
# Comparison of redundant signals, which reveals wrong frames, units and clocks.
#
# The rate of change of the attitude must equal the gyro's reading.  The rate of change of the
# velocity must equal the accelerometer's reading without gravity.  If they disagree, common
# mistakes are corrected one at a time; a message reports the correction that restores agreement.

CUTOFF = 3.0
"""Cut-off of the low-pass before the comparison [Hz]: slow motion suffices to check conventions."""

TURNING, ACCELERATING = 0.1, 0.5
"""Root mean square of rates [rad/s] and accelerations [m/s^2] below which nothing is compared."""

DISAGREE, AGREE = 0.15, 0.07
"""Mismatch above which signals disagree, and below which they agree.

For scale: 0 for equal signals, 0.2 if one is twice the other, 1 for unrelated and 2 for opposite
signals.  Real flights have 0.001 to 0.01."""

WINDOW, BROKEN = 2.0, 0.4
"""Length of separately compared segments [s], and mismatch above which a segment is reported."""

MOST_LATE, LATE = 0.6, 0.03  # largest delay that is tried, and least delay that is reported [s]


@dataclass(frozen=True, eq=False)
class Pair:
    """One motion from two sensors, (n, 3) each, at n times [s]."""

    time: Floats
    expected: Floats
    measured: Floats
    least: float  # root mean square below which an axis is not compared

    def mismatch(self, which: NDArray[np.bool_] | slice = slice(None)) -> float:
        """Return the sum of (a - b)^2 divided by the sum of a^2 + b^2, for the worst axis.

        a and b are ``expected`` and ``measured`` at the samples ``which``.  The result is NaN if
        the motion is too small.
        """
        a, b = self.expected[which], self.measured[which]
        sizes = np.stack([np.sum(a**2, axis=0), np.sum(b**2, axis=0)])
        moves = sizes.max(axis=0) > self.least**2 * len(a)
        off = np.sum((a - b) ** 2, axis=0)[moves] / sizes.sum(axis=0)[moves]
        return float(off.max()) if off.size else np.nan


def _disagreements(recording: log.Recording) -> list[str]:
    """Return warnings if attitude and gyro, or velocity and accelerometer, disagree; raise
    ``InputError`` for a mistake that explains all disagreements."""
    turning, moving = pairs(recording)
    if any(pair.mismatch() > DISAGREE for pair in (turning, moving)):
        found = []
        for cause, remedy, corrected in mistakes(recording, turning):
            try:
                left = [pair.mismatch() for pair in pairs(corrected)]
            except InputError:  # this correction makes the log unusable
                continue
            if not any(mismatch > AGREE for mismatch in left):
                found.append((float(np.nansum(left)), cause, remedy))
        if found:
            _, cause, remedy = min(found)
            after = f"{cause}: all signals agree after this correction"
            raise InputError(after, remedy, recording.source)
    return _late(recording, turning) or _broken_segments(recording, turning, moving)


def pairs(recording: log.Recording) -> tuple[Pair, Pair]:
    """Return the rates from attitude and gyro, and the accelerations from velocity and
    accelerometer; the latter pair is empty without an accelerometer."""
    own, rest = recording.attitude, [recording.velocity, recording.rates]
    force = recording.specific_force
    rest += [force] if force is not None else []
    # The signs of quaternions must not jump, since components are interpolated.
    smooth = log.Signal(own.name, own.time, log.continuous(own.values))
    time = log.common_clock([own], rest, recording.source)
    ends = np.flatnonzero(np.diff(time) > log.LONGEST_GAP) + 1
    parts = [part for part in np.split(time, ends) if part.size > 3]
    each = [_compared(recording, smooth, part) for part in parts]
    when, turned, gyro, accelerated, pushed = (
        np.concatenate(arrays) for arrays in zip(*each, strict=True)
    )
    some = slice(0 if force is None else None)
    return (
        Pair(when, turned, gyro, TURNING),
        Pair(when[some], accelerated[some], pushed[some], ACCELERATING),
    )


def _compared(recording: log.Recording, attitude: log.Signal, time: Floats) -> tuple[Floats, ...]:
    """Return the midpoints of the sample intervals in a segment without gaps.  Also return rates
    from attitude and gyro, and accelerations from velocity and accelerometer, at the midpoints."""
    step = float(np.median(np.diff(time)))

    def smooth(values: Floats) -> Floats:
        if 4.0 * CUTOFF * step > 1.0 or time.size < 20:
            return values
        return log.low_pass(values, 2.0 * CUTOFF * step, round(0.5 / step))

    def in_flu(signal: log.Signal) -> Floats:
        return smooth(log.body_to_flu(log.interpolated(signal, time), recording.body_frame))

    def between(values: Floats) -> Floats:
        return 0.5 * (values[1:] + values[:-1])

    quaternions = smooth(log.interpolated(attitude, time))
    turn = log.attitude_to_flu_enu(quaternions, recording.body_frame, recording.world_frame)
    steps = np.diff(time)[:, None]
    turned = (turn[:-1].inv() * turn[1:]).as_rotvec() / steps
    if recording.velocity_in == "body":
        velocity = turn.apply(in_flu(recording.velocity))
    else:
        over_ground = log.interpolated(recording.velocity, time)
        velocity = smooth(log.world_to_enu(over_ground, recording.world_frame))
    accelerated = np.diff(velocity, axis=0) / steps
    pushed = np.full_like(accelerated, np.nan)
    if recording.specific_force is not None:
        pushed = between(turn.apply(in_flu(recording.specific_force)))
        pushed[:, 2] -= GRAVITY
    return between(time), turned, between(in_flu(recording.rates)), accelerated, pushed


def _late(recording: log.Recording, turning: Pair) -> list[str]:
    """Warn if gyro and attitude agree much better with a delay between their clocks."""
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
        f"{recording.rates.name} come {abs(late):.2g} s {'after' if late > 0.0 else 'before'} "
        f"{recording.attitude.name}: use the time stamps of one clock for all signals"
    ]


def _broken_segments(recording: log.Recording, turning: Pair, moving: Pair) -> list[str]:
    """Warn of segments in which the signals disagree."""
    force = recording.specific_force
    names = [(turning, recording.rates.name, recording.attitude.name)]
    if force is not None:
        names.append((moving, force.name, recording.velocity.name))
    found = []
    for pair, measured, other in names:
        first, last = float(pair.time[0]), float(pair.time[-1])
        ends = np.linspace(first, last, max(round((last - first) / WINDOW), 1) + 1)
        bad = [
            (begin, end)
            for begin, end in itertools.pairwise(ends)
            if pair.mismatch((pair.time >= begin) & (pair.time <= end)) > BROKEN
        ]
        if bad:
            found.append(
                f"{measured} and {other} describe different motions in {len(bad)} of "
                f"{len(ends) - 1} segments, from {bad[0][0]:.4g} to {bad[-1][1]:.4g} s: look for "
                "a jump of a clock, a failed sensor or wrong axes; cut the log"
            )
    return found


# --- Common mistakes in frames, units and columns, and the recording without each of them --------

OTHER = {"flu": "frd", "frd": "flu", "enu": "ned", "ned": "enu", "body": "world", "world": "body"}

HALF_TURN = np.array([1.0, -1.0, -1.0])  # signs that convert between FLU and FRD
OFF_TIME = 0.2  # least relative error of the time scale that is reported


def mistakes(recording: log.Recording, turning: Pair) -> Iterator[tuple[str, str, log.Recording]]:
    """Yield each possible mistake: cause, remedy, and the recording without it.

    ``recording`` must be cleaned; ``turning`` contains its rates from attitude and gyro.
    """

    def corrected(values: Floats, signal: log.Signal, **more: Any) -> log.Recording:
        name = next(n for n, one in recording.signals().items() if one is signal)
        changed: Any = {name: replace(signal, values=values)}
        return replace(recording, **changed, **more)

    body, world, frame = recording.body_frame, recording.world_frame, recording.velocity_in
    other_body = f"along the axes of {OTHER[body].upper()}, not {body.upper()}"
    rates, attitude, velocity = recording.rates, recording.attitude, recording.velocity
    force = recording.specific_force
    for like, factor in UNIT_ERRORS["angular rate"].items():
        cause = f"{rates.name} are in {like}"
        yield cause, "convert deg/s to rad/s exactly once", corrected(rates.values / factor, rates)
    flipped = corrected(rates.values * HALF_TURN, rates)
    yield f"{rates.name} are {other_body}", "change the signs of their y and z", flipped
    if force is not None:
        both = replace(flipped, specific_force=replace(force, values=force.values * HALF_TURN))
        cause = f"{rates.name} and {force.name} are {other_body}"
        yield cause, "change the signs of y and z of both", both

    q = attitude.values
    cause = f"{attitude.name} rotates world to body axes, expected body to world"
    inverse = corrected(q * np.array([1.0, -1.0, -1.0, -1.0]), attitude)
    yield cause, "change the signs of qx, qy and qz", inverse
    for order, first, named in (
        ([3, 0, 1, 2], "x, y, z, w", "qw is the last column, qx the first"),
        ([1, 2, 3, 0], "w, x, y, z", "qw is the column with the name qx"),
    ):
        cause = f"{attitude.name} has components in the order {first}"
        yield cause, f"correct the columns, {named}", corrected(q[:, order], attitude)
    meant = log.attitude_to_flu_enu(q, OTHER[body], OTHER[world]).as_quat(scalar_first=True)
    stated = log.attitude_to_flu_enu(meant, body, world).as_quat(scalar_first=True)
    yield (
        f"{attitude.name} rotates {OTHER[body].upper()} to {OTHER[world].upper()}, but the stated "
        f"frames are {body.upper()} and {world.upper()}",
        "give all signals in the same frames",
        corrected(stated, attitude),
    )

    other = OTHER[frame]
    yield (
        f"{velocity.name} is along {other} axes, not {frame} axes",
        f'write velocity_in = "{other}" in [log]',
        replace(recording, velocity_in=other),
    )
    if frame == "body":
        turned, remedy = velocity.values * HALF_TURN, "change the signs of its y and z"
    else:
        turned, remedy = (
            log.world_to_enu(velocity.values, "ned"),
            "give it along the axes of world_frame",
        )
    axes = body if frame == "body" else world
    cause = f"{velocity.name} is along the axes of {OTHER[axes].upper()}, not {axes.upper()}"
    yield cause, remedy, corrected(turned, velocity)
    if frame == "world":
        climb = np.gradient(velocity.values[:, 2], velocity.time)
        climbing = velocity.values.copy()
        climbing[:, 2] = climb if world == "enu" else -climb
        yield (
            f"the third component of {velocity.name} is an altitude",
            "name the column of the vertical velocity [m/s] instead",
            corrected(climbing, velocity),
        )
    for like, factor in (UNIT_ERRORS["speed"] | UNIT_ERRORS["fine speed"]).items():
        cause = f"{velocity.name} is in {like}"
        yield cause, "convert it to m/s", corrected(velocity.values / factor, velocity)
    slope = np.gradient(velocity.values, velocity.time, axis=0)
    yield (
        f"{velocity.name} contains positions",
        "name the columns of the velocity [m/s] instead",
        corrected(slope, velocity, velocity_in="world"),
    )

    if force is not None:
        at = np.clip(force.time, attitude.time[0], attitude.time[-1])
        smooth = replace(attitude, values=log.continuous(q))
        turn = log.attitude_to_flu_enu(log.interpolated(smooth, at), body, world)
        flu = log.body_to_flu(force.values, body)
        upward = turn.apply(np.tile([0.0, 0.0, GRAVITY], (at.size, 1)), inverse=True)
        for cause, remedy, values in (
            (
                f"gravity is subtracted from {force.name}, which is about 0 in hover",
                "give the reading of the accelerometer, about 9.8 m/s^2 upwards in hover",
                flu + upward,
            ),
            (f"{force.name} points down in hover, expected up", "change its sign", -flu),
            (f"{force.name} is {other_body}", "change the signs of its y and z", flu * HALF_TURN),
            (
                f"{force.name} is along world axes, not body axes",
                "give it along the axes of the body, like the reading of an accelerometer",
                turn.apply(flu, inverse=True),
            ),
            *(
                (f"{force.name} is in {like}", "convert it to m/s^2", flu / factor)
                for like, factor in UNIT_ERRORS["specific force"].items()
            ),
        ):
            yield cause, remedy, corrected(log.body_to_flu(values, body), force)

    along = float(np.sum(turning.expected * turning.measured))
    size = float(np.sum(turning.expected**2))
    slow = 0.0 if not size > 0.0 else along / size
    if slow > 0.0 and abs(slow - 1.0) >= OFF_TIME:
        signals: Any = {
            name: replace(signal, time=signal.time / slow)
            for name, signal in recording.signals().items()
        }
        yield (
            f"the times are {slow:.3g} times as large as attitude and gyro imply",
            "give the times of the measurements in seconds",
            replace(recording, **signals),
        )


# --- Failed sensors: constant readings, saturation, and gaps -------------------------------------

AT_END = 0.005  # least fraction of samples at an end of the range that is reported
IN_A_ROW = 3  # number of consecutive samples at an end of the range that counts as saturation
HELD = 0.2
"""Fraction of samples equal to their predecessor above which a signal counts as sample-and-hold."""

WIDE = 2.0  # signals with a smaller range [m/s^2] or [rad/s] are not checked for saturation
MOST_GAPS = 3  # largest number of gaps in warnings
AXES = "xyz"


def _gaps(recording: log.Recording) -> list[str]:
    """Warn of gaps in signals, once for all signals of one table."""
    found: dict[tuple[float, float], str] = {}
    for signal in recording.signals().values():
        if signal is recording.supply:  # voltages change slowly, so gaps are interpolated
            continue
        for k in np.flatnonzero(np.diff(signal.time) > log.LONGEST_GAP):
            found.setdefault((signal.time[k], signal.time[k + 1]), signal.name)
    return [
        f"{name} has no sample from {begin:.6g} to {end:.6g} s, and this time is left out: if the "
        "clock jumped, correct the times"
        for (begin, end), name in list(found.items())[:MOST_GAPS]
    ]


def _dead_sensors(recording: log.Recording) -> list[str]:
    """Warn of signals, axes or rotors whose values never change."""
    found = []
    for signal in recording.signals().values():
        still = np.ptp(signal.values, axis=0) == 0.0
        if still.all():
            found.append(f"values of {signal.name} never change: log the measured values")
        elif signal is recording.specific_force and still.any():
            axes = " and ".join(AXES[k] for k in np.flatnonzero(still))
            found.append(f"{signal.name} never changes along {axes}: look for a dead axis")
        elif signal is recording.rotor_speed and still.any():
            rotors = " and ".join(str(k + 1) for k in np.flatnonzero(still))
            found.append(
                f"{signal.name} never changes for rotor {rotors} (in the order of the log): log "
                "the measured speed"
            )
    return found


def _saturated(signal: log.Signal) -> list[str]:
    """Warn of axes of a sensor that reach the end of its range."""
    found = []
    for axis, column in zip(AXES, signal.values.T, strict=True):
        if np.ptp(column) < WIDE:
            continue
        for end in (column.max(), column.min()):
            runs = (len([*run]) for same, run in itertools.groupby(column == end) if same)
            count = sum(length for length in runs if length >= IN_A_ROW)
            elsewhere = column[column != end]
            steady = np.count_nonzero(np.diff(elsewhere) == 0.0) > HELD * elsewhere.size
            if count > AT_END * column.size and not steady:
                found.append(
                    f"{signal.name} is {end:.4g} along {axis} in {count} samples, probably the end "
                    "of the sensor's range: widen the range, or damp its mount"
                )
    return found
