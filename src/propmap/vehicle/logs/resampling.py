"""Signals of different rates on one clock."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.errors import InputError
from propmap.vehicle.logs.recording import FEWEST_SAMPLES, Signal

LONGEST_GAP = 0.25
"""[s] between two samples of a signal that are still interpolated."""


def common_clock(
    leading: Sequence[Signal],
    following: Sequence[Signal],
    source: str,
    rate: float | None = None,
) -> Floats:
    """Times [s] at which all signals are known; (n,), rising.

    Without a ``rate`` [1/s], the sample times of the slowest of the ``leading`` signals.
    Times inside a gap of any signal longer than 0.25 s are left out: gaps are cut, not bridged.
    Raises ``InputError`` where nothing is left.
    """
    signals = [*leading, *following]
    for signal in signals:
        step = float(np.median(np.diff(signal.time)))
        if step > LONGEST_GAP:
            raise InputError(
                f"{signal.name} comes every {step:.3g} s, expected every {LONGEST_GAP:g} s or less",
                "log it at a higher rate, and give times in seconds",
                source,
            )
    last_to_start = max(signals, key=lambda signal: signal.time[0])
    first_to_end = min(signals, key=lambda signal: signal.time[-1])
    start, end = last_to_start.time[0], first_to_end.time[-1]
    if rate is None:
        slowest = max(leading, key=lambda signal: float(np.median(np.diff(signal.time))))
        time = slowest.time[(slowest.time >= start) & (slowest.time <= end)]
    else:
        if not 0.1 <= rate <= 10000.0:
            raise InputError(f"the rate is {rate} 1/s", "give samples per second, such as 50")
        time = np.arange(start, end, 1.0 / rate)
    known = np.ones(time.size, dtype=np.bool_)
    for signal in signals:
        known &= ~_in_gap(signal, time)
    if int(known.sum()) < FEWEST_SAMPLES:
        raise InputError(
            f"all signals together are known at {int(known.sum())} times: {first_to_end.name} "
            f"ends at {end:.6g} s, {last_to_start.name} begins at {start:.6g} s",
            "log all of them at once, with the stamps of one clock",
            source,
        )
    return time[known]


def interpolated(signal: Signal, time: Floats) -> Floats:
    """Values of a signal at the times (n,) [s], linearly between its samples; (n, k)."""
    columns = [np.interp(time, signal.time, column) for column in signal.values.T]
    return np.stack(columns, axis=1)


def _in_gap(signal: Signal, time: Floats) -> NDArray[np.bool_]:
    """Which times lie between two samples that are too far apart, none of them at either."""
    after = np.clip(np.searchsorted(signal.time, time), 1, signal.time.size - 1)
    wide = signal.time[after] - signal.time[after - 1] > LONGEST_GAP
    at_sample = (time == signal.time[after]) | (time == signal.time[after - 1])
    return np.asarray(wide & ~at_sample)
