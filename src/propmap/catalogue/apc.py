"""Blades of APC by its own files, and how measured blades of the series differ from them."""

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
}  # code and title of a series by its mark behind the size; other marks name none known here

_TITLE = re.compile(r"[\d.]+x[\d.]+([A-Z]*)(?:-\d(?:Blade)?)?")


class ApcBlade(NamedTuple):
    """A line of the table; numbers that are most of it are left as text."""

    title: str  # of APC's file, such as "5x4E-3"
    blades: int
    radius: float  # [m]
    station: str  # over the radius [-], as many as there are stations
    chord: str  # over the radius [-]
    twist: str  # [deg], of the line from leading to trailing edge

    @property
    def source(self) -> str:
        """Where the geometry is from."""
        return (
            f"APC PE0 file {self.title}: chord and twist of the line from leading to trailing edge"
        )

    def propeller(self) -> Propeller:
        """Make the propeller."""
        station, chord, twist = (
            np.array(text.split(), float) for text in (self.station, self.chord, self.twist)
        )
        shape = station * self.radius, chord * self.radius, np.radians(twist)
        return Propeller(name_of(self.title), self.blades, *shape, None, self.source, APC_CITATION)


def name_of(title: str) -> str:
    """Give the name that the blade of an APC file with this ``title`` has."""
    return f"apc-{title.lower()}"


def series_of(title: str) -> tuple[str, str] | None:
    """Find code and title of the series of an APC file's ``title``; None where it is not known."""
    found = _TITLE.fullmatch(title)
    return SERIES.get(found[1]) if found else None


@lru_cache(maxsize=1)
def apc_blades() -> dict[str, ApcBlade]:
    """List the table's blades by their names in the catalogue."""
    lines = BLADES.read_text(encoding="utf-8").splitlines()[1:]
    rows = (line.split(",") for line in lines)
    return {
        name_of(title): ApcBlade(title, int(blades), float(radius), *shape)
        for title, blades, radius, *shape in rows
    }


# -------------------------------------------------------------------------------------------------
# Measured blades beside their makers' files.
#
# UIUC measured blades of which APC gives the mould's figures.  At three quarters of the radius they
# differ by an angle and a factor that are common to a series, and by a scatter about these.


class Difference(NamedTuple):
    """What a blade of a series measures more than in its maker's file, at 0.75 R: the logarithm of
    the ratio of the chords, and the difference of the twists [rad]."""

    mean: Floats  # (2,)
    covariance: Floats  # (2, 2) of a further propeller, with that of the mean


def difference(family: str | None, without: str = "") -> Difference:
    """Give the difference of a series, or over series where none of it was measured; the propeller
    that the catalogue calls ``without`` is left out."""
    every = {code: _further(pairs) for code, pairs in _pairs(without).items()}
    if family in every:
        return every[family]
    means = np.stack([one.mean for one in every.values()])
    within = np.mean([one.covariance for one in every.values()], axis=0)
    return _further(means, within)


def _further(some: Floats, each: Floats | float = 0.0) -> Difference:
    """Predict one more than the ``some`` (n, 2), which has the covariance ``each`` besides."""
    return Difference(some.mean(axis=0), np.cov(some.T) * (1.0 + 1.0 / len(some)) + each)


def _pairs(without: str) -> dict[str, Floats]:
    found: dict[str, list[tuple[float, float]]] = {}
    for line in DIFFERENCES.read_text(encoding="utf-8").splitlines()[1:]:
        family, title, ratio, degrees = line.split(",")
        if name_of(title) != without:
            pair = np.log(float(ratio)), np.radians(float(degrees))
            found.setdefault(family, []).append(pair)
    return {family: np.array(pairs) for family, pairs in found.items()}
