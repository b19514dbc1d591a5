"""Low-passed logs and their time derivatives: what a balance of forces needs of a raw log.

An accelerometer, a gyro and a motor controller each filter what they measure in their own way.  A
balance compares them, so all signals pass one filter here, forwards and backwards, which shifts
none of them in time.
"""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np

from propmap.errors import InputError
from propmap.typing import Floats
from propmap.vehicle.flight_log import FlightLog
from propmap.vehicle.logs.assembly import LONGEST_GAP

CUTOFF = 6.0
"""Of the low-pass by default [Hz]: vehicles of up to some kilograms turn within 0.2 s, and rotor
speeds of motor controllers carry noise above."""

DERIVATIVES = ("angular_acceleration", "specific_force_rate", "rotor_acceleration")
"""Fields of a log that follow from its others."""

ORDER = 2
"""Of the Butterworth filter, applied twice."""

FEWEST_PER_PERIOD = 3.0
"""Samples per period of the cut-off below which there is nothing to filter."""


def low_passed(log: FlightLog, cutoff: float = CUTOFF) -> FlightLog:
    """The log with all signals low-passed alike, and with the derivatives that follow from it.

    Rotor speeds are filtered as their squares, to which forces are proportional.  Between gaps
    each stretch is filtered by itself; a log that is slower than three samples per period of the
    cut-off is left as it is.

    Parameters
    ----------
    log : FlightLog
        n samples in order of time, of one flight.
    cutoff : float
        Frequency above which signals are removed [Hz]; 0 for no filter.

    Returns
    -------
    FlightLog
        With ``angular_acceleration``, ``specific_force_rate`` and ``rotor_acceleration``.

    Raises
    ------
    InputError
        For a cut-off that is no frequency.
    """
    if not (np.isfinite(cutoff) and cutoff >= 0.0):
        raise InputError(
            f"the low-pass is at {cutoff:g} Hz", "give a frequency, or 0 for no filter"
        )
    steps = np.diff(log.time)
    ends = [0, *(np.flatnonzero(steps > LONGEST_GAP) + 1), len(log)]
    parts = [log.picked(slice(first, last)) for first, last in itertools.pairwise(ends)]
    found = [_filtered(part, cutoff) for part in parts]
    names = ("velocity", "rates", "up", "specific_force", "rotor_speed")
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in found])
        for name in (*names, *DERIVATIVES)
    }
    return replace(log, **arrays)


def _filtered(part: FlightLog, cutoff: float) -> FlightLog:
    """One stretch without gaps."""

    def smooth(signal: Floats) -> Floats:
        return _low_pass(signal, 2.0 * cutoff * step)

    step = float(np.median(np.diff(part.time))) if len(part) > 1 else np.inf
    if cutoff > 0.0 and FEWEST_PER_PERIOD * cutoff * step <= 1.0:
        up = smooth(part.up)
        part = replace(
            part,
            velocity=smooth(part.velocity),
            rates=smooth(part.rates),
            up=up / np.linalg.norm(up, axis=1, keepdims=True),
            specific_force=smooth(part.specific_force),
            rotor_speed=np.sqrt(np.maximum(smooth(np.square(part.rotor_speed)), 0.0)),
        )
    return replace(
        part,
        angular_acceleration=_slope(part.time, part.rates),
        specific_force_rate=_slope(part.time, part.specific_force),
        rotor_acceleration=_slope(part.time, part.rotor_speed),
    )


def _low_pass(signal: Floats, relative: float) -> Floats:
    """Columns (n, k) without what is above the cut-off, ``relative`` to half the sampling rate,
    and not shifted in time."""
    from scipy.signal import butter, sosfiltfilt

    sections = butter(ORDER, relative, output="sos")
    beyond = min(signal.shape[0] - 1, round(4.0 / relative))
    return np.asarray(sosfiltfilt(sections, signal, axis=0, padlen=beyond))


def _slope(time: Floats, signal: Floats) -> Floats:
    """Time derivatives (n, k) of columns; zero where there is one sample alone."""
    if time.size < 2:
        return np.zeros_like(signal)
    return np.asarray(np.gradient(signal, time, axis=0))
