"""Steady segments of a flight, and tables of steady operating points."""

from __future__ import annotations

import itertools
import os
import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.io.csv import header_names, read_csv_table, read_lines
from propmap.io.geometry import parse_number
from propmap.typing import Floats
from propmap.units import RPM
from propmap.vehicle.log import LONGEST_GAP, FlightLog, in_vehicle_frame
from propmap.vehicle.vehicle import Vehicle

# --- Steady segments of a flight, and the operating points from these segments -------------------

MOVING = 1.0  # speed above which a vehicle is certainly not on the ground [m/s]
IDLE = 0.3  # share of the usual thrust below which the rotors do not carry the vehicle
SMOOTHING = 0.25
"""Averaging time of signals [s], because noise must not end a steady segment."""

RESOLUTION = 1e-3  # accuracy of the longest segment in error messages [s]


@dataclass(frozen=True, eq=False)
class _Piece:
    """Samples of a log without a gap."""

    first: int  # index of the first sample in the log
    time: Floats
    scaled: Floats  # signals divided by their bands, (n, channels)


def airborne(log: FlightLog) -> NDArray[np.bool_]:
    """Return whether the rotors carry the vehicle at each sample (n,).

    On the ground, the sum of the squared rotor speeds, to which thrust is proportional, is far
    below its median in motion.  For a log without motion, the 90th percentile replaces the median.
    The result does not depend on the unit of the speeds, which may be wrong.
    """
    squares = np.sum(np.square(log.rotor_speed), axis=1)
    moving = log.speed > MOVING
    usual = np.median(squares[moving]) if moving.any() else np.percentile(squares, 90.0)
    return np.asarray((squares > IDLE * usual) & (squares > 0.0))


def steady_segments(
    log: FlightLog,
    *,
    seconds: float = 2.0,
    speed_band: float = 0.5,
    climb_band: float = 0.5,
    rate_band: float = 0.3,
    tilt_band: float = 0.1,
) -> list[slice]:
    """Return the steady segments of a log with a length of at least ``seconds``, in order.

    A circle flown nose first at constant speed is steady.  Segments exclude gaps in the log and
    time on the ground.  Signals are averaged over 0.25 s.  Without a steady segment, raise an
    ``InputError`` with the band that ended the longest segment.

    A band is the largest difference between two samples of a segment.  There are bands for:

    - each velocity component in the vehicle frame [m/s],
    - the climb rate [m/s],
    - each angular rate [rad/s],
    - the direction of ``up`` [rad].
    """
    bands = {
        "speed_band": (speed_band, log.velocity),
        "climb_band": (climb_band, log.climb_rate[:, None]),
        "rate_band": (rate_band, log.rates),
        "tilt_band": (tilt_band, log.up),
    }
    limits = {name: band for name, (band, _) in bands.items()}
    for name, value in {"seconds": seconds, **limits}.items():
        if not value > 0.0:
            raise InputError(f"{name} is {value}", "give a number above 0")
    scaled = np.concatenate([signal / band for band, signal in bands.values()], axis=1)
    pieces = _pieces(log, scaled)
    segments = [segment for piece in pieces for segment in _segments(piece, seconds)]
    if not segments:
        names = [name for name, (_, signal) in bands.items() for _ in signal.T]
        raise _none_steady(log, pieces, seconds, names, limits)
    return segments


def operating_points(log: FlightLog, segments: list[slice]) -> FlightLog:
    """Return the means over each of the ``segments``, one row per segment; ``up`` has length 1."""
    means = log.with_each(lambda array: np.array([np.mean(array[s], axis=0) for s in segments]))
    return replace(means, up=means.up / np.linalg.norm(means.up, axis=1, keepdims=True))


def _pieces(log: FlightLog, scaled: Floats) -> list[_Piece]:
    """Return the pieces of a flight between gaps and landings, with smoothed signals."""
    from scipy.ndimage import uniform_filter1d

    def smoothed(part: slice) -> Floats:
        if part.stop - part.start < 2:
            return scaled[part]
        width = max(1, round(SMOOTHING / float(np.median(np.diff(log.time[part])))))
        return np.asarray(uniform_filter1d(scaled[part], width, axis=0, mode="reflect"))

    flying = airborne(log)
    steps = np.diff(log.time)
    # The wide steps of a log with a low rate are not gaps.
    longest = max(LONGEST_GAP, 1.5 * float(np.median(steps))) if steps.size else LONGEST_GAP
    ends = (steps > longest) | (flying[1:] != flying[:-1])
    bounds = [0, *(np.flatnonzero(ends) + 1), len(log)]
    parts = [slice(*ends) for ends in itertools.pairwise(bounds) if flying[ends[0]]]
    return [_Piece(part.start, log.since_start[part], smoothed(part)) for part in parts]


def _segments(piece: _Piece, seconds: float) -> list[slice]:
    """Return the segments of a piece.

    Each begins as early as possible, and ends before the first sample outside a band.
    """
    segments = []
    start = 0
    while start < piece.time.size:
        # End of a segment of least length; 1 us absorbs the rounding of times.
        least = int(np.searchsorted(piece.time, piece.time[start] + seconds - 1e-6))
        if least >= piece.time.size:
            break
        # Backward from this end, the first sample outside the bands limits the start.
        back = _count_within(piece.scaled[start : least + 1][::-1])
        if back < least + 1 - start:
            start = least + 1 - back
            continue
        end = start + _count_within(piece.scaled[start:])
        segments.append(slice(piece.first + start, piece.first + end))
        start = end
    return segments


def _count_within(scaled: Floats) -> int:
    """Return the number of samples, from the first, that stay within the bands."""
    size = 256
    while True:
        part = scaled[:size]
        highest, lowest = np.maximum.accumulate(part, axis=0), np.minimum.accumulate(part, axis=0)
        within = np.all(highest - lowest <= 1.0, axis=1)
        if not within.all():
            return int(np.argmin(within))
        if size >= scaled.shape[0]:
            return int(scaled.shape[0])
        size *= 2


def _none_steady(
    log: FlightLog, pieces: list[_Piece], seconds: float, names: list[str], limits: dict[str, float]
) -> InputError:
    """Return the error with the band that ended the longest segment; ``names``: band by channel."""
    if not pieces:
        fault = "the rotors never carry the vehicle"
        return InputError(fault, "give the log of a flight", log.source)

    each = []
    for piece in pieces:
        low, high = 0.0, seconds
        while high - low > RESOLUTION:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if _segments(piece, middle) else (low, middle)
        longest = max(_segments(piece, low), key=lambda one: one.stop - one.start)
        segment = slice(longest.start - piece.first, longest.stop - piece.first)
        each.append((float(np.ptp(piece.time[segment])), piece, segment))
    lasts, best, segment = max(each, key=lambda one: one[0])
    found = f"no steady segment of {seconds:g} s: the longest lasts {lasts:.2f} s, "
    found += f"from {best.time[segment.start]:.6g} s"
    if segment.stop < best.time.size:
        with_next, verb = slice(segment.start, segment.stop + 1), "ended"
    elif segment.start > 0:
        with_next, verb = slice(segment.start - 1, segment.stop), "limited"
    else:
        fault = f"{found}, ended by a gap, a landing or the end of the log"
        return InputError(fault, "lower seconds, or fly constant speeds for longer", log.source)
    worst = names[int(np.argmax(np.ptp(best.scaled[with_next], axis=0)))]
    remedy = f"raise {worst} or lower seconds, or fly constant speeds for longer"
    return InputError(f"{found}, {verb} by {worst} = {limits[worst]:g}", remedy, log.source)


# --- Tables of steady operating points: CSV with speed, attitude and rpm -------------------------

REQUIRED = ("speed_mps", "pitch_deg")
OPTIONAL = ("roll_deg", "climb_mps", "yaw_rate_dps")
RPM_COLUMN = re.compile(r"rpm_[1-9][0-9]*")

STEEPEST = 85.0  # largest pitch and roll of a steady flight [deg]


def read_level_table(path: str | os.PathLike[str], vehicle: Vehicle) -> FlightLog:
    """Read operating points from a CSV file with a header line and one row per point.

    Required columns:

    - ``speed_mps``: horizontal airspeed toward the nose, >= 0
    - ``pitch_deg``: positive nose down, the top of the vehicle leans into the flight direction
    - ``rpm_1`` ... ``rpm_n``: mechanical rpm of the rotors in their order, >= 0

    Optional columns, by default 0:

    - ``roll_deg``: about the x axis of the vehicle, after the pitch, positive right side down
    - ``climb_mps``: positive up
    - ``yaw_rate_dps``: about the vertical, positive to the left

    Other columns are ignored.  The file may have any dialect of ``propmap.io.csv``.  The log has
    the times 0, 1, 2 ... and no ``specific_force``.  An ``InputError`` names file, line and column.
    """
    where, rotors = os.fspath(path), len(vehicle.mounts)
    speeds = [f"rpm_{k}" for k in range(1, rotors + 1)]
    known = (*REQUIRED, *OPTIONAL, *speeds)
    file = read_csv_table(read_lines(path, "table of operating points"), known, where)
    header = file.header if file else []
    for name in REQUIRED:
        if name not in header:
            remedy = f"the first line must name {', '.join([*REQUIRED, *speeds])}"
            raise InputError(f"line 1: column {name} is missing", remedy, where)
    found = sum(RPM_COLUMN.fullmatch(name) is not None for name in header)
    if found != rotors or not set(speeds) <= set(header):
        fault = f"line 1 has {found} columns rpm_1, rpm_2 ..., the vehicle has {rotors} rotors"
        raise InputError(fault, f"name {', '.join(speeds)}", where)
    names = [*REQUIRED, *(name for name in OPTIONAL if name in header), *speeds]
    repeated = [name for name in names if header.count(name) > 1]
    if repeated:
        raise InputError(f"line 1: column {repeated[0]} occurs twice", "keep one of them", where)
    if file is None or not file.rows:
        raise InputError("there is no row below the header", "add a row per point", where)
    table = np.array([_row(cells, line, header, names, where) for line, cells in file.rows])
    columns = dict(zip(names, table.T, strict=True))
    zero = np.zeros(len(table))
    pitch = np.radians(columns["pitch_deg"])
    roll = np.radians(columns.get("roll_deg", zero))
    up = in_vehicle_frame(0.0, 0.0, 1.0, pitch, roll)
    climb = columns.get("climb_mps", zero)
    return FlightLog(
        source=where,
        time=np.arange(len(table), dtype=np.float64),
        velocity=in_vehicle_frame(columns["speed_mps"], 0.0, climb, pitch, roll),
        rates=np.radians(columns.get("yaw_rate_dps", zero))[:, None] * up,
        up=up,
        specific_force=np.full((len(table), 3), np.nan),
        rotor_speed=table[:, -rotors:] * RPM,
    )


def is_level_table(path: Path) -> bool:
    """Return whether the first line of the file names the columns of ``read_level_table``."""
    if path.suffix.lower() != ".csv" or not path.is_file():
        return False
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        line = file.readline()
    needed = ("pitch_deg", "rpm_1")
    return set(needed) <= set(header_names(line, needed))


def _row(
    cells: list[str], line: int, header: list[str], names: list[str], where: str
) -> list[float]:
    values = []
    for name in names:
        place = header.index(name)
        at = f"{where}, line {line}, column {name}"
        value = parse_number(cells[place] if place < len(cells) else "", name, at)
        if value < 0.0 and (name == "speed_mps" or name.startswith("rpm")):
            remedy = "give 0 or more: flight is nose first, and the vehicle file states the spins"
            raise InputError(f"{value:g} is negative", remedy, at)
        if name in ("pitch_deg", "roll_deg") and abs(value) > STEEPEST:
            remedy = f"give degrees from -{STEEPEST:g} to {STEEPEST:g}, 0 in hover"
            raise InputError(f"{value:g} is too steep for steady flight", remedy, at)
        values.append(value)
    return values
