"""Sensors that stood still, reached the end of their range or fell silent."""

from __future__ import annotations

import itertools

import numpy as np

from propmap.typing import Floats
from propmap.vehicle.logs.assembly import LONGEST_GAP
from propmap.vehicle.logs.recording import Recording, Signal, cleaned

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
