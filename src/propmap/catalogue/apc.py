"""Blades from APC's files, and the differences of measured blades from these files."""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from propmap.model.propeller import Propeller
from propmap.typing import Floats

APC_CITATION = "Landing Products Inc. (APC Propellers), performance data files, 2022"
FOLDER = Path(__file__).parent / "apc_files"
BLADES, DIFFERENCES = FOLDER / "blades.csv", FOLDER / "differences.csv"

SERIES = {
    "E": ("apce", "Thin Electric"),
    "EP": ("apce", "Thin Electric Pusher"),
    "SF": ("apcsf", "Slow Flyer"),
    "MR": ("apcmr", "Multi-Rotor"),
    "": ("apcsp", "Sport"),
}  # code and title of a series by the letters after the size; other letters are not known

_TITLE = re.compile(r"[\d.]+x[\d.]+([A-Z]*)(?:-\d(?:Blade)?)?")


class ApcBlade(NamedTuple):
    """A row of the table; the arrays stay text until they are needed."""

    title: str  # title of APC's file, such as "5x4E-3"
    blades: int
    radius: float  # [m]
    station: str  # over the radius [-]
    chord: str  # over the radius [-]
    twist: str  # [deg], of the line from leading to trailing edge

    @property
    def source(self) -> str:
        """Source of the geometry."""
        return f"APC PE0 file {self.title}: chord, and twist of the chord line"

    def propeller(self) -> Propeller:
        """Return the propeller."""
        station, chord, twist = (
            np.array(text.split(), float) for text in (self.station, self.chord, self.twist)
        )
        shape = station * self.radius, chord * self.radius, np.radians(twist)
        return Propeller(name_of(self.title), self.blades, *shape, None, self.source, APC_CITATION)


def name_of(title: str) -> str:
    """Return the name in the catalogue of a blade from an APC file with this ``title``."""
    return f"apc-{title.lower()}"


def series_of(title: str) -> tuple[str, str] | None:
    """Return code and title of the series in the ``title`` of an APC file; None if unknown."""
    found = _TITLE.fullmatch(title)
    return SERIES.get(found[1]) if found else None


@lru_cache(maxsize=1)
def apc_blades() -> dict[str, ApcBlade]:
    """Return the blades of the table by their names in the catalogue."""
    lines = BLADES.read_text(encoding="utf-8").splitlines()[1:]
    rows = (line.split(",") for line in lines)
    return {
        name_of(title): ApcBlade(title, int(blades), float(radius), *shape)
        for title, blades, radius, *shape in rows
    }


# -------------------------------------------------------------------------------------------------
# Differences between measured blades and manufacturers' files.
#
# UIUC measured blades for which APC publishes the geometry of the mold.  At three quarters of the
# radius, twist and chord differ by an angle and a factor common to a series, plus a scatter.


class Difference(NamedTuple):
    """Measured blade minus manufacturer's file for a series, at 0.75 R: the logarithm of the ratio
    of the chords, and the difference of the twists [rad]."""

    mean: Floats  # (2,)
    covariance: Floats  # (2, 2) for another propeller, including the covariance of the mean


def difference(family: str | None, without: str = "") -> Difference:
    """Return the difference of a series, or over all series if no blade of it was measured; the
    propeller with the catalogue name ``without`` is excluded."""
    every = {code: _further(pairs) for code, pairs in _pairs(without).items()}
    if family in every:
        return every[family]
    means = np.stack([one.mean for one in every.values()])
    within = np.mean([one.covariance for one in every.values()], axis=0)
    return _further(means, within)


def _further(some: Floats, each: Floats | float = 0.0) -> Difference:
    """Predict another member of a sample (n, 2), with the additional covariance ``each``."""
    return Difference(some.mean(axis=0), np.cov(some.T) * (1.0 + 1.0 / len(some)) + each)


def _pairs(without: str) -> dict[str, Floats]:
    found: dict[str, list[tuple[float, float]]] = {}
    for line in DIFFERENCES.read_text(encoding="utf-8").splitlines()[1:]:
        family, title, ratio, degrees = line.split(",")
        if name_of(title) != without:
            pair = np.log(float(ratio)), np.radians(float(degrees))
            found.setdefault(family, []).append(pair)
    return {family: np.array(pairs) for family, pairs in found.items()}
