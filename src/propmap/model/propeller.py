"""The blade geometry of a propeller, and its checks."""

from __future__ import annotations

import functools
import operator
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from propmap.errors import InputError, quoted
from propmap.model.unit_errors import Range, likely_cause
from propmap.typing import ByValue, Floats


@dataclass(frozen=True, eq=False, repr=False)
class Propeller(ByValue):
    """A propeller: chord and twist of the blade at its stations, and the number of blades.

    The arrays are stored as read-only float64 copies.

    Attributes
    ----------
    name : str
        Name of the propeller.
    blades : int
        Number of blades, 1 to 12.
    station : ndarray, shape (n,)
        Radii [m], n >= 4, increasing from the first measured section to the tip.
    chord : ndarray, shape (n,)
        Chord [m].
    twist : ndarray, shape (n,)
        Angle between chord line and disk plane [rad].
    root_cutout : float or None
        Radius at which the loaded part of the blade begins [m]; None for the first station.
    source, citation : str
        Source and treatment of the geometry, and the reference to cite.

    Raises
    ------
    InputError
        For an impossible blade, see ``check_blade``.
    """

    name: str
    blades: int
    station: Floats
    chord: Floats
    twist: Floats
    root_cutout: float | None = None
    source: str = ""
    citation: str = ""

    def __post_init__(self) -> None:
        for array in ("station", "chord", "twist"):
            object.__setattr__(self, array, _frozen_array(getattr(self, array), array))
        check_blade(self.station, self.chord, self.twist)
        object.__setattr__(self, "blades", check_blades(self.blades))
        if self.root_cutout is not None:
            root = check_root_cutout(self.root_cutout, self.station)
            object.__setattr__(self, "root_cutout", root)

    @property
    def radius(self) -> float:
        """Tip radius [m], the last station."""
        return float(self.station[-1])

    @property
    def diameter(self) -> float:
        """Diameter [m]."""
        return 2.0 * self.radius

    @property
    def summary(self) -> str:
        """Number of blades and radius, as text."""
        return f"{self.blades} blades, R = {self.radius:.4g} m"

    @property
    def root(self) -> float:
        """Radius at which the loaded part of the blade begins [m]."""
        return float(self.station[0]) if self.root_cutout is None else self.root_cutout

    def with_root_cutout(self, radius_m: float) -> Propeller:
        """Return this propeller with loads only outside the radius ``radius_m`` [m]."""
        return replace(self, root_cutout=radius_m)

    def scaled(self, factor: float) -> Propeller:
        """Return this propeller with radius and chord multiplied by ``factor``."""
        root = None if self.root_cutout is None else factor * self.root_cutout
        return replace(
            self, station=factor * self.station, chord=factor * self.chord, root_cutout=root
        )

    def fingerprint(self) -> str:
        """Return the SHA-256 hash of station, chord, twist, root and blades as little-endian f8.

        Lengths are in m and angles in rad.  The hash does not depend on name and source.
        """
        import hashlib

        figures = (self.station, self.chord, self.twist, [self.root, float(self.blades)])
        return hashlib.sha256(np.concatenate(figures).astype("<f8").tobytes()).hexdigest()

    def __repr__(self) -> str:
        return (
            f"Propeller({self.name!r}, {self.blades} blades, diameter {self.diameter:.4g} m, "
            f"{self.station.size} stations)"
        )


def _frozen_array(values: Any, field: str) -> Floats:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        found = f"{field} is {quoted(values)}, expected a list of numbers"
        raise InputError(found, f"give {field} as one number per station") from None
    array.flags.writeable = False
    return array


def monotone_cubics(x: Floats, y: Floats) -> Floats:
    """Return the cubics of the monotone interpolation (PCHIP) of values y (..., n) at knots x (n,).

    The coefficients (..., n - 1, 4) of each interval multiply powers of the distance from its first
    knot, lowest power first.  Slopes: Fritsch & Butland, SIAM J. Sci. Stat. Comput. 5(2), 1984, doi
    10.1137/0905021; the rule at the ends is that of SciPy, whose import would take 0.2 s.
    """
    h = np.diff(x)
    rise = np.diff(y) / h
    before, after, wide = rise[..., :-1], rise[..., 1:], 2.0 * h[1:] + h[:-1]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        mean = (wide + h[1:] + 2.0 * h[:-1]) / (wide / before + (h[1:] + 2.0 * h[:-1]) / after)
    inner = np.where(before * after > 0.0, mean, 0.0)

    def end(k: int, inward: int) -> Floats:
        near, far, (h_0, h_1) = rise[..., k], rise[..., inward], h[[k, inward]]
        slope = ((2.0 * h_0 + h_1) * near - h_0 * far) / (h_0 + h_1)
        slope = np.where(slope * near > 0.0, slope, 0.0)
        steep = (near * far < 0.0) & (np.abs(slope) > 3.0 * np.abs(near))
        return np.where(steep, 3.0 * near, slope)[..., None]

    slope = np.concatenate([end(0, 1), inner, end(-1, -2)], axis=-1)
    first, last = slope[..., :-1], slope[..., 1:]
    powers = y[..., :-1], first, (3.0 * rise - 2.0 * first - last) / h
    return np.stack([*powers, (first + last - 2.0 * rise) / h**2], axis=-1)


@functools.lru_cache(maxsize=64)
def blade_intervals(blade: Propeller, root: float, more_twist: float = 0.0) -> Floats:
    """Return the intervals (n, 9) between stations of a blade with ``more_twist`` [rad].

    Each row contains the first radius [m], and the cubics of chord [m] and twist [rad].  If the
    ``root`` [m] is inside the first station, the blade is extended to it.  The chord line keeps its
    geometric pitch, y tan(theta).  The chord continues with its mean slope over the first 0.1 R of
    the blade, limited to 0.5 to 1 times the first chord.
    """

    def rows(y: Floats, chord: Floats, twist: Floats) -> Floats:
        return np.hstack([y[:-1, None], *monotone_cubics(y, np.stack([chord, twist]))])

    found = rows(blade.station, blade.chord, blade.twist + more_twist)
    first, widest, twist = found[0, [0, 1, 5]]
    if root < first:
        further = min(first + 0.1 * blade.radius, blade.radius)
        start, *cubic = found[np.searchsorted(found[:, 0], further, side="right") - 1, :5]
        chord = np.polyval(cubic[::-1], further - start)
        y = np.linspace(root, first, 13)
        chord = widest + (chord - widest) / (further - first) * (y - first)
        twist = np.arctan2(first * np.sin(twist), y * np.cos(twist))
        found = np.vstack([rows(y, np.clip(chord, 0.5 * widest, widest), twist), found])
    found.flags.writeable = False
    return found


# --- Checks of a blade before the computation of loads -------------------------------------------

LIKELY_RADIUS = Range(0.025, 0.4)  # [m]
WIDEST_CHORD = Range(0.12, 0.45)  # the largest chord over the radius; measured 0.15 to 0.38
MIN_STATIONS, MAX_BLADES, MAX_ROOT_CUTOUT = 4, 12, 0.9
MAX_RADIUS = 20.0  # [m], larger than flying rotors, smaller than a model propeller in millimeters
MAX_TWIST = 1.6  # [rad]; blades have less than 92 degrees: a larger value is in degrees


def check_blade(station: Floats, chord: Floats, twist: Floats, labels: Sequence[str] = ()) -> None:
    """Raise ``InputError`` unless columns (n,) [m], [m], [rad] are one blade from root to tip.

    ``labels`` are the names of the stations in messages, such as "line 7".
    """
    columns = {"station": station, "chord": chord, "twist": twist}
    for field, values in columns.items():
        if values.ndim != 1 or values.size != station.size:
            found = f"{field} has shape {values.shape}, expected one value per station"
            raise InputError(found, "give station, chord and twist as lists of one length")
    if station.size < MIN_STATIONS:
        found = f"found {station.size} stations, expected at least {MIN_STATIONS}"
        raise InputError(found, "add stations between root and tip")
    labels = labels or [f"station {i}" for i in range(station.size)]
    for field, values in columns.items():
        for k in np.flatnonzero(~np.isfinite(values)).tolist():
            found = f"{labels[k]}: {field} is {values[k]}, expected a finite number"
            raise InputError(found, "remove the row or correct it")
    if station[0] <= 0.0:
        found = f"{labels[0]}: the first station is at {station[0]:g} m, expected more than 0"
        raise InputError(found, "start with the hub radius, where the blade begins")
    for k in (np.flatnonzero(station[1:] <= station[:-1]) + 1).tolist():
        repeated = station[k] == station[k - 1]
        how = "repeated" if repeated else f"unsorted (it follows {station[k - 1]:g} m)"
        fault = f"{labels[k]}: station {station[k]:g} m is {how}, expected stations that increase "
        fault += "from root to tip"
        remedy = "keep one row per station" if repeated else "sort the rows by station"
        raise InputError(fault, remedy)
    radius, low, high = float(station[-1]), int(np.argmin(chord)), int(np.argmax(chord))
    if radius > MAX_RADIUS:
        found = f"{labels[-1]}: the radius is {radius:g} m, expected at most {MAX_RADIUS:g} m"
        found += likely_cause(radius, LIKELY_RADIUS, "length")
        raise InputError(found, "check the units; lengths must be in meters")
    if chord[low] < 0.0:
        found = f"{labels[low]}: chord is {chord[low]:g} m, expected 0 or more"
        raise InputError(found, "correct the negative chord")
    if chord[high] == 0.0:
        raise InputError("every chord is 0", "give the chord of each station")
    if chord[high] >= radius:
        found = f"{labels[high]}: chord is {chord[high]:g} m, expected less than the radius of "
        found += f"{radius:g} m"
        found += likely_cause(float(chord[high]) / radius, WIDEST_CHORD, "chord over radius")
        raise InputError(found, "check the units of chord and radius")
    steepest = int(np.argmax(np.abs(twist)))
    if abs(twist[steepest]) > MAX_TWIST:
        found = f"{labels[steepest]}: twist is {twist[steepest]:g} rad, expected at most "
        found += f"{MAX_TWIST}; it looks like degrees"
        raise InputError(found, "the column must be in radians or be named twist_deg")


def check_blades(blades: Any) -> int:
    """Return the number of blades, or raise ``InputError`` unless it is an integer, 1 to 12."""
    try:
        count = operator.index(blades)
    except TypeError:
        count = 0
    if isinstance(blades, bool | np.bool_) or not 1 <= count <= MAX_BLADES:
        found = f"the number of blades is {quoted(blades)}, expected a whole number from 1 to "
        raise InputError(f"{found}{MAX_BLADES}", "pass --blades 2 (in Python: blades=2)")
    return count


def check_root_cutout(root_cutout: Any, station: Floats) -> float:
    """Return the root cut-out [m], or raise ``InputError`` unless it lies on the blade."""
    first, last = float(station[0]), MAX_ROOT_CUTOUT * float(station[-1])
    try:
        value = float(root_cutout)
    except (TypeError, ValueError):
        value = float("nan")
    if not first <= value <= last:
        found = f"the root cut-out is {quoted(root_cutout)} m, expected between {first:.6g} m"
        found += f" (first station) and {last:.6g} m (0.9 radius)"
        raise InputError(found, "choose a root cut-out on the blade, in meters")
    return value


def twist_from_degrees(degrees: Floats) -> Floats:
    """Return ``degrees`` (n,) in radians.

    Raise ``InputError`` if all values are below 1.6: such twists are likely in radians.
    """
    steepest = float(np.nanmax(np.abs(degrees), initial=0.0))
    if degrees.size and steepest < MAX_TWIST:
        found = f"the largest twist is {steepest:g} degrees; it looks like radians"
        raise InputError(found, "the column must be in degrees or be named twist_rad")
    return np.deg2rad(degrees)
