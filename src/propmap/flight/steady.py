"""Stretches of a flight in which nothing changes, and the operating points they give."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.errors import InputError
from propmap.flight.airborne import airborne
from propmap.vehicle.flight_log import FlightLog
from propmap.vehicle.logs.resampling import LONGEST_GAP

SMOOTHING = 0.25
"""[s] over which signals are averaged before their range is taken: noise is not a change."""


@dataclass(frozen=True, eq=False)
class _Piece:
    """Samples without a gap: the first, and the signals over their bands, (n, channels)."""

    first: int
    time: Floats
    scaled: Floats


def steady_stretches(
    log: FlightLog,
    *,
    seconds: float = 2.0,
    speed_band: float = 0.5,
    climb_band: float = 0.5,
    rate_band: float = 0.3,
    tilt_band: float = 0.1,
) -> list[slice]:
    """Stretches of at least so many ``seconds`` in which the flight is steady, in order.

    Each band is the largest difference between two moments of a stretch: speed_band [m/s] of
    every component of the velocity in the vehicle's frame, climb_band [m/s] of the climb rate,
    rate_band [rad/s] of every angular rate, tilt_band [rad] of the direction of ``up``.
    Signals are averaged over 0.25 s before.  A circle flown nose first at constant speed is
    steady.  Time on the ground and gaps in the log belong to no stretch.
    Raises ``InputError`` where there is none; it names the limit that ended the longest one.
    """
    bands = {
        "speed_band": (speed_band, log.velocity),
        "climb_band": (climb_band, log.climb_rate[:, None]),
        "rate_band": (rate_band, log.rates),
        "tilt_band": (tilt_band, log.up),
    }
    for name, value in {
        "seconds": seconds,
        **{key: band for key, (band, _) in bands.items()},
    }.items():
        if not value > 0.0:
            raise InputError(f"{name} is {value}", "give a number above 0")
    names = [name for name, (_, signal) in bands.items() for _ in signal.T]
    scaled = np.concatenate([signal / band for band, signal in bands.values()], axis=1)
    pieces = _pieces(log, scaled)
    stretches = [stretch for piece in pieces for stretch in _stretches(piece, seconds)]
    if not stretches:
        limits = {name: band for name, (band, _) in bands.items()}
        raise _none_steady(log, pieces, seconds, names, limits)
    return stretches


def operating_points(log: FlightLog, stretches: list[slice]) -> FlightLog:
    """The averages over the stretches, one row per stretch; ``up`` has length 1 again."""
    means = {
        field.name: np.array([np.mean(getattr(log, field.name)[s], axis=0) for s in stretches])
        for field in fields(FlightLog)
        if field.name != "source"
    }
    means["up"] /= np.linalg.norm(means["up"], axis=1, keepdims=True)
    return FlightLog(source=log.source, **means)


def _pieces(log: FlightLog, scaled: Floats) -> list[_Piece]:
    """The flight between gaps and landings, its signals smoothed."""
    flying = airborne(log)
    steps = np.diff(log.time)
    # A log read at a low rate has wider steps, which are no gaps.
    longest = max(LONGEST_GAP, 1.5 * float(np.median(steps))) if steps.size else LONGEST_GAP
    ends = (steps > longest) | (flying[1:] != flying[:-1])
    bounds = [0, *(np.flatnonzero(ends) + 1), len(log)]
    return [
        _Piece(first, log.time[first:last], _smoothed(log.time[first:last], scaled[first:last]))
        for first, last in itertools.pairwise(bounds)
        if flying[first]
    ]


def _smoothed(time: Floats, signals: Floats) -> Floats:
    """Averages over ``SMOOTHING`` around each sample; (n, channels)."""
    from scipy.ndimage import uniform_filter1d

    if time.size < 2:
        return signals
    width = max(1, round(SMOOTHING / float(np.median(np.diff(time)))))
    return np.asarray(uniform_filter1d(signals, width, axis=0, mode="reflect"))


def _stretches(piece: _Piece, seconds: float) -> list[slice]:
    """Stretches of one piece: from the first moment that allows one, as far as the bands."""
    stretches = []
    start = 0
    while start < piece.time.size:
        # Where a stretch of the least duration would end; rounding of times must not matter.
        least = int(np.searchsorted(piece.time, piece.time[start] + seconds - 1e-6))
        if least >= piece.time.size:
            break
        # Backwards from there: no stretch that goes so far can begin before what ends it.
        back = _count_within(piece.scaled[start : least + 1][::-1])
        if back < least + 1 - start:
            start = least + 1 - back
            continue
        end = start + _count_within(piece.scaled[start:])
        stretches.append(slice(piece.first + start, piece.first + end))
        start = end
    return stretches


def _range(scaled: Floats) -> Floats:
    return np.asarray(np.max(scaled, axis=0) - np.min(scaled, axis=0))


def _count_within(scaled: Floats) -> int:
    """How many samples from the first on stay within the bands."""
    size = 256
    while True:
        part = scaled[:size]
        within = np.all(_running_range(part) <= 1.0, axis=1)
        if not within.all():
            return int(np.argmin(within))
        if size >= scaled.shape[0]:
            return int(scaled.shape[0])
        size *= 2


def _running_range(scaled: Floats) -> Floats:
    """Range from the first sample to each; (n, channels)."""
    highest = np.maximum.accumulate(scaled, axis=0)
    return np.asarray(highest - np.minimum.accumulate(scaled, axis=0))


def _windows_within(scaled: Floats, count: int) -> NDArray[np.bool_]:
    """Which windows of ``count`` samples stay within the bands, by their first sample."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    # A filter's window is centred: shifted so that it begins at the sample.
    shift = -(count // 2)
    highest = maximum_filter1d(scaled, count, axis=0, origin=shift)
    lowest = minimum_filter1d(scaled, count, axis=0, origin=shift)
    within = np.all(highest - lowest <= 1.0, axis=1)
    return np.asarray(within[: scaled.shape[0] - count + 1])


def _longest(piece: _Piece) -> slice:
    """The stretch of most samples within the bands, however short."""
    low, high = 1, piece.time.size
    while low < high:
        middle = (low + high + 1) // 2
        if _windows_within(piece.scaled, middle).any():
            low = middle
        else:
            high = middle - 1
    start = int(np.argmax(_windows_within(piece.scaled, low)))
    return slice(start, start + low)


def _none_steady(
    log: FlightLog,
    pieces: list[_Piece],
    seconds: float,
    names: list[str],
    limits: dict[str, float],
) -> InputError:
    if not pieces:
        return InputError(
            "the rotors never carry the vehicle", "give the log of a flight", log.source
        )
    best, stretch, duration = pieces[0], slice(0, 1), -1.0
    for piece in pieces:
        found = _longest(piece)
        lasts = float(piece.time[found.stop - 1] - piece.time[found.start])
        if lasts > duration:
            best, stretch, duration = piece, found, lasts
    found_text = (
        f"no steady stretch of {seconds:g} s: the longest lasts {duration:.2f} s, "
        f"from {best.time[stretch.start]:.6g} s"
    )
    if stretch.stop < best.time.size:
        worst = names[int(np.argmax(_range(best.scaled[stretch.start : stretch.stop + 1])))]
        ended, loosen = f"{worst} = {limits[worst]:g} ended it", f"raise {worst} or lower seconds"
    elif stretch.start > 0:
        worst = names[int(np.argmax(_range(best.scaled[stretch.start - 1 : stretch.stop])))]
        ended, loosen = f"{worst} = {limits[worst]:g} began it", f"raise {worst} or lower seconds"
    else:
        ended, loosen = "a gap, a landing or the log's end ended it", "lower seconds"
    return InputError(
        f"{found_text}, {ended}", f"{loosen}, or fly constant speeds for longer", log.source
    )
