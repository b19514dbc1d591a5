"""The geometry of a propeller: chord and twist along the blade."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from propmap.errors import InputError, quoted
from propmap.model.blade_check import check_blade, check_blades, check_root_cutout
from propmap.typing import Floats


@dataclass(frozen=True, eq=False, repr=False)
class Propeller:
    """Chord and twist of a blade at its measured stations, and how many blades there are.

    The arrays are kept as read-only float64 copies.

    Attributes
    ----------
    name : str
        What the propeller is called.
    blades : int
        Number of blades, 1 to 12.
    station : ndarray, shape (n,)
        Radii [m], n >= 4, rising from the first measured section to the tip.
    chord : ndarray, shape (n,)
        [m].
    twist : ndarray, shape (n,)
        The chord line against the disk plane [rad].
    root_cutout : float or None
        Where the loaded part of the blade begins [m]; None is the first station.
    source, citation : str
        Where the figures are from and what was done to them, and whom to cite.

    Raises
    ------
    InputError
        For a blade that cannot be: see ``propmap.model.blade_check``.
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
        for field in ("station", "chord", "twist"):
            object.__setattr__(self, field, _frozen_array(getattr(self, field), field))
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
    def root(self) -> float:
        """Where the loaded part of the blade begins [m]."""
        return float(self.station[0]) if self.root_cutout is None else self.root_cutout

    def with_root_cutout(self, radius_m: float) -> Propeller:
        """The same propeller, loaded from ``radius_m`` [m] outwards."""
        return replace(self, root_cutout=radius_m)

    def scaled(self, factor: float) -> Propeller:
        """The same shape with radius and chord ``factor`` times as large."""
        root = None if self.root_cutout is None else factor * self.root_cutout
        return replace(
            self, station=factor * self.station, chord=factor * self.chord, root_cutout=root
        )

    def fingerprint(self) -> str:
        """SHA-256 of station [m], chord [m], twist [rad], root [m] and blades, as little-endian f8.

        Name and source play no part.
        """
        import hashlib

        figures = (self.station, self.chord, self.twist, [self.root, float(self.blades)])
        return hashlib.sha256(np.concatenate(figures).astype("<f8").tobytes()).hexdigest()

    def __eq__(self, other: object) -> bool:
        return self._key() == other._key() if isinstance(other, Propeller) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key())

    def __repr__(self) -> str:
        return (
            f"Propeller({self.name!r}, {self.blades} blades, diameter {self.diameter:.4g} m, "
            f"{self.station.size} stations)"
        )

    def _key(self) -> tuple[object, ...]:
        arrays = (self.station.tobytes(), self.chord.tobytes(), self.twist.tobytes())
        return (self.name, self.blades, *arrays, self.root_cutout, self.source, self.citation)


def _frozen_array(values: Any, field: str) -> Floats:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(
            f"{field} is {quoted(values)}, expected a list of numbers",
            f"give {field} as one number per station",
        ) from None
    array.flags.writeable = False
    return array
