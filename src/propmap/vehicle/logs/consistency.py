"""Whether the signals of a recording describe one motion: frames, units and clocks show.

The attitude's own turning is what a gyro reads, and the change of the velocity, with gravity, is
what an accelerometer reads.  Where they disagree, each usual mistake is put right in turn; the one
after which they agree is named.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.typing import Floats
from propmap.vehicle.flight_log import GRAVITY
from propmap.vehicle.logs import frames
from propmap.vehicle.logs.assembly import LONGEST_GAP, common_clock, interpolated
from propmap.vehicle.logs.recording import Recording, Signal, cleaned
from propmap.vehicle.logs.slips import slips

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
    smooth = Signal(own.name, own.time, frames.continuous(own.values))
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
    turn = frames.attitude_to_flu_enu(quaternions, recording.body_frame, recording.world_frame)
    steps = np.diff(time)[:, None]
    turned = (turn[:-1].inv() * turn[1:]).as_rotvec() / steps

    def in_flu(signal: Signal) -> Floats:
        values = frames.body_to_flu(interpolated(signal, time), recording.body_frame)
        return _low_passed(values, time)

    gyro = in_flu(recording.rates)
    if recording.velocity_in == "body":
        velocity = turn.apply(in_flu(recording.velocity))
    else:
        over_ground = interpolated(recording.velocity, time)
        velocity = _low_passed(frames.world_to_enu(over_ground, recording.world_frame), time)
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
