"""What a blade must satisfy before any load is computed from it."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any

import numpy as np

from propmap.errors import InputError, quoted
from propmap.model.usual_ranges import CHORD_SLIPS, LENGTH_SLIPS, WIDEST_CHORD, Range, guessed
from propmap.typing import Floats

MIN_STATIONS = 4
MAX_BLADES = 12
MAX_ROOT_CUTOUT = 0.9
# Above any rotor that flies, and below a model propeller in millimetres.
MAX_RADIUS = 20.0
# No blade is set at 92 degrees to its disk, so a larger figure is in degrees.
MAX_TWIST = 1.6


def check_blade(
    station: Floats,
    chord: Floats,
    twist: Floats,
    where: str = "",
    labels: Sequence[str] = (),
) -> None:
    """Raise ``InputError`` unless the three columns describe one blade from root to tip.

    Parameters
    ----------
    station, chord, twist : ndarray, shape (n,)
        [m], [m] and [rad].
    where : str
        The file, for the message.
    labels : sequence of str
        n names of the stations, such as "line 7".
    """
    columns = {"station": station, "chord": chord, "twist": twist}
    for field, values in columns.items():
        if values.ndim != 1 or values.size != station.size:
            raise InputError(
                f"{field} has shape {values.shape}, expected one value per station",
                "give station, chord and twist as lists of one length",
                where,
            )
    if station.size < MIN_STATIONS:
        raise InputError(
            f"found {station.size} stations, expected at least {MIN_STATIONS}",
            "add stations between root and tip",
            where,
        )
    labels = labels or [f"station {i}" for i in range(station.size)]
    for field, values in columns.items():
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise InputError(
                f"{labels[bad[0]]}: {field} is {values[bad[0]]}, expected a finite number",
                "remove the row or correct it",
                where,
            )
    _check_stations(station, where, labels)
    _check_chord(chord, float(station[-1]), where, labels)
    steepest = int(np.argmax(np.abs(twist)))
    if abs(twist[steepest]) > MAX_TWIST:
        raise InputError(
            f"{labels[steepest]}: twist is {twist[steepest]:g} rad, expected at most {MAX_TWIST}; "
            "it looks like degrees",
            "the column must be in radians or be named twist_deg",
            where,
        )


def _check_stations(station: Floats, where: str, labels: Sequence[str]) -> None:
    if station[0] <= 0.0:
        raise InputError(
            f"{labels[0]}: the first station is at {station[0]:g} m, expected more than 0",
            "start at the hub radius, where the blade begins",
            where,
        )
    falls = np.flatnonzero(station[1:] <= station[:-1])
    if falls.size:
        i = int(falls[0])
        repeated = station[i + 1] == station[i]
        raise InputError(
            f"{labels[i + 1]}: station {station[i + 1]:g} m "
            + ("is repeated" if repeated else f"is unsorted (it follows {station[i]:g} m)")
            + ", expected stations that rise from root to tip",
            "keep one row per station" if repeated else "sort the rows by station",
            where,
        )
    if station[-1] > MAX_RADIUS:
        raise InputError(
            f"{labels[-1]}: the radius is {station[-1]:g} m, expected at most {MAX_RADIUS:g} m"
            + guessed(float(station[-1]), Range(0.025, 0.4), LENGTH_SLIPS),
            "check the units; lengths are in metres",
            where,
        )


def _check_chord(chord: Floats, radius: float, where: str, labels: Sequence[str]) -> None:
    low, high = int(np.argmin(chord)), int(np.argmax(chord))
    if chord[low] < 0.0:
        raise InputError(
            f"{labels[low]}: chord is {chord[low]:g} m, expected 0 or more",
            "correct the negative chord",
            where,
        )
    if chord[high] == 0.0:
        raise InputError("every chord is 0", "give the chord of each station", where)
    if chord[high] >= radius:
        raise InputError(
            f"{labels[high]}: chord is {chord[high]:g} m, "
            f"expected less than the radius of {radius:g} m"
            + guessed(float(chord[high]) / radius, WIDEST_CHORD, CHORD_SLIPS),
            "check the units of chord and radius",
            where,
        )


def check_blades(blades: Any, where: str = "") -> int:
    """The number of blades as an ``int``; ``InputError`` unless it is a whole 1 to 12."""
    try:
        count = operator.index(blades)
    except TypeError:
        count = 0
    if isinstance(blades, bool | np.bool_) or not 1 <= count <= MAX_BLADES:
        raise InputError(
            f"the number of blades is {quoted(blades)}, "
            f"expected a whole number from 1 to {MAX_BLADES}",
            "pass --blades 2 (in Python: blades=2)",
            where,
        )
    return count


def check_root_cutout(root_cutout: Any, station: Floats, where: str = "") -> float:
    """The root cut-out [m] as a ``float``; ``InputError`` unless it lies on the blade."""
    first, last = float(station[0]), MAX_ROOT_CUTOUT * float(station[-1])
    try:
        value = float(root_cutout)
    except (TypeError, ValueError):
        value = float("nan")
    if not first <= value <= last:
        raise InputError(
            f"the root cut-out is {quoted(root_cutout)} m, "
            f"expected between {first:.6g} m (first station) and {last:.6g} m (0.9 radius)",
            "choose a root cut-out on the blade, in metres",
            where,
        )
    return value


def twist_from_degrees(degrees: Floats, where: str = "") -> Floats:
    """Twist [rad] from a column in degrees, refused where its figures look like radians.

    A blade whose steepest section stands at less than 1.6 degrees makes no propeller, so such a
    column of ``degrees`` (n,) is taken for radians under the wrong name.
    """
    steepest = float(np.nanmax(np.abs(degrees), initial=0.0))
    if degrees.size and steepest < MAX_TWIST:
        raise InputError(
            f"the largest twist is {steepest:g} degrees; it looks like radians",
            "the column must be in degrees or be named twist_rad",
            where,
        )
    return np.deg2rad(degrees)
