"""Section constants identified from published loads of propellers, from a bundled CSV file."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from propmap.model.airfoil import CONSTANTS, Airfoil, SectionCovariance, SectionUncertainty
from propmap.typing import Floats

PARAMETERS = tuple(name for name, constant in CONSTANTS.items() if constant.population)
"""Names of the identified constants."""

LIFT_LAW = "plate"
"""The lift law of all identified constants.  For blades that stall at rest it is as good as the
law of the paper with a larger c_l2 (``python -m tools.catalogue.past_stall``), which has twice the
lift of a plate at 45 degrees."""

NAME_END = " identified"  # end of the names of identified section laws

MEAN_BLADES = ("family", "population")  # geometries of propellers without a known blade

POOR = (0.0048, 0.0036)  # 90th percentiles of the errors of C_T and C_P over propellers [-]

PAIRS = [(i, j) for i in range(len(PARAMETERS)) for j in range(i, len(PARAMETERS))]
TEXTS = ("propeller", "family", "tested", "geometry", "key", "verdict")
COUNTS = ("blades", "rows", "static_rows")
RANGES = ("diameter_m", "pitch_m", "rpm_low", "rpm_high", "advance_high")
ERRORS = ("thrust_rms", "power_rms", "static_thrust_rms", "static_power_rms")


@dataclass(frozen=True, eq=False)
class Identified:
    """Constants of one propeller, identified from its loads in axial flow, and their quality."""

    propeller: str  # name of its blade in the catalogue, or a new name of that form
    blades: int
    family: str  # code of its series
    tested: str  # name in the source
    geometry: str  # "measured", from its "maker", or the mean of its "family" or "population"
    diameter_m: float  # labeled diameter and pitch [m]
    pitch_m: float
    airfoil: Airfoil  # the constants, with their covariance
    covariance: Floats  # (P, P) of ``PARAMETERS``
    thrust_rms: float  # rms errors of C_T and C_P over all rows
    power_rms: float
    static_thrust_rms: float  # rms errors over the static rows; NaN without static rows
    static_power_rms: float
    rows: int  # number of all operating points
    static_rows: int
    rpm_low: float  # range of the data, with J = V/(n D) up to ``advance_high``
    rpm_high: float
    advance_high: float
    verdict: str  # "good", or the problem of the data or the fit
    key: str  # identifies the data and the settings of the fit

    @property
    def size(self) -> tuple[float, float]:
        """Labeled diameter and pitch [m]."""
        return self.diameter_m, self.pitch_m

    @property
    def discrepancy(self) -> tuple[float, float]:
        """Standard deviations of the remaining errors of C_T and C_P [-] with these constants."""
        return self.thrust_rms, self.power_rms

    @property
    def summary(self) -> str:
        """One line of text: source and range of the data, errors, and verdict."""
        size = "and at rest " if self.static_rows else ""
        return (
            f"constants identified from {self.rows} rows of {self.tested!r} in axial flow {size}"
            f"(UIUC), {self.rpm_low:.0f} to {self.rpm_high:.0f} rpm, J up to "
            f"{self.advance_high:.2f}; rms error of C_T {self.thrust_rms:.4f}, of C_P "
            f"{self.power_rms:.4f}; verdict: {self.verdict}"
        )

    @property
    def constants(self) -> Floats:
        """Values of ``PARAMETERS``, (P,)."""
        return np.array([getattr(self.airfoil, name) for name in PARAMETERS])


def identified(propeller: str, blades: int) -> Identified | None:
    """Return the bundled constants of a catalogue propeller with this number of blades, or None."""
    key = propeller.strip().lower(), blades
    return _bundled(key) if key in _rows() else None


def identified_with_name(name: str, blades: int) -> Identified | None:
    """Return the bundled constants whose ``airfoil`` has this ``name``, or None."""
    propeller = name.removesuffix(NAME_END)
    return identified(propeller, blades) if propeller != name else None


def all_identified(family: str | None = None) -> list[Identified]:
    """Return the bundled constants of one ``family``, or all, in the order of the file.

    They are for measured blades, or for the manufacturer's blade if none was measured.
    """
    rows = [item for item in _rows().items() if family in (None, item[1]["family"])]
    measured = {row["tested"] for _, row in rows if row["geometry"] == "measured"}
    return [
        _bundled(key)
        for key, row in rows
        if row["geometry"] == "measured"
        or (row["geometry"] == "maker" and row["tested"] not in measured)
    ]


def identified_without_blade() -> list[Identified]:
    """Return all bundled constants of propellers without a known blade."""
    return [_bundled(key) for key, row in _rows().items() if row["geometry"] in MEAN_BLADES]


def named_without_blade(name: str) -> Identified | None:
    """Return the entry of ``identified_without_blade`` with this lower-case ``name``, or None."""
    found = [
        key for key, row in _rows().items() if key[0] == name and row["geometry"] in MEAN_BLADES
    ]
    return _bundled(found[0]) if found else None


def one_of_each(entries: Sequence[Identified]) -> list[Identified]:
    """Keep the best fit per tested propeller; a fit with a measured blade precedes any other."""
    best: dict[str, Identified] = {}
    for one in sorted(entries, key=lambda one: (one.geometry != "measured", badness(one))):
        best.setdefault(one.tested, one)
    return [one for one in entries if best[one.tested] is one]


def badness(one: Identified) -> float:
    """Return the larger of the errors of C_T and C_P, each over ``POOR``."""
    return max(one.thrust_rms / POOR[0], one.power_rms / POOR[1])


def entry_of(row: dict[str, str]) -> Identified:
    """Return the entry for a ``row`` of the file, by column."""
    covariance = np.zeros((len(PARAMETERS), len(PARAMETERS)))
    for i, j in PAIRS:
        covariance[i, j] = covariance[j, i] = float(row[pair_name(i, j)])
    values: Any = {name: float(row[name]) for name in PARAMETERS}
    texts: Any = {name: row[name] for name in TEXTS}
    counts: Any = {name: int(row[name]) for name in COUNTS}
    numbers: Any = {name: float(row[name]) for name in (*RANGES, *ERRORS)}
    source = f"identified by propmap from the UIUC Propeller Database, {row['tested']}"
    known = SectionUncertainty(
        SectionCovariance(PARAMETERS, covariance), numbers["thrust_rms"], numbers["power_rms"]
    )
    name = f"{row['propeller']}{NAME_END}"
    airfoil = Airfoil(**values, lift_law=LIFT_LAW, name=name, source=source, uncertainty=known)
    return Identified(airfoil=airfoil, covariance=covariance, **texts, **counts, **numbers)


def pair_name(i: int, j: int) -> str:
    """Return the column name for the covariance of parameters number ``i`` and ``j``."""
    return f"cov_{PARAMETERS[i]}_{PARAMETERS[j]}"


@cache
def _rows() -> dict[tuple[str, int], dict[str, str]]:
    """Return the rows of the bundled file, by propeller and number of blades."""
    with (Path(__file__).parent / "identified" / "uiuc.csv").open(encoding="utf-8") as file:
        return {(row["propeller"], int(row["blades"])): row for row in csv.DictReader(file)}


@cache
def _bundled(key: tuple[str, int]) -> Identified:
    # Most processes need one entry, and creating all takes longer than creating a rotor.
    return entry_of(_rows()[key])
