"""Section constants identified from published loads, propeller by propeller, in one CSV file."""

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
"""The constants that were identified."""

LIFT_LAW = "plate"
"""The lift law of all identified constants.  On blades that stall at rest it is as good as the
paper's with a larger c_l2 (``python -m tools.catalogue.past_stall``), which has twice the lift of a
plate at 45 degrees."""

MEAN_BLADES = ("family", "population")  # geometries of propellers whose own is not known

POOR = (0.0048, 0.0036)  # errors of C_T and C_P [-] that nine propellers in ten stay below

PAIRS = [(i, j) for i in range(len(PARAMETERS)) for j in range(i, len(PARAMETERS))]
TEXTS = ("propeller", "family", "tested", "geometry", "key", "verdict")
COUNTS = ("blades", "rows", "static_rows")
RANGES = ("diameter_m", "pitch_m", "rpm_low", "rpm_high", "advance_high")
ERRORS = ("thrust_rms", "power_rms", "static_thrust_rms", "static_power_rms")


@dataclass(frozen=True, eq=False)
class Identified:
    """Constants of one propeller from its loads in axial flow, and how far they can be trusted."""

    propeller: str  # name of its blade in the catalogue, or one made up in that form
    blades: int
    family: str  # code of its series
    tested: str  # what the source calls it
    geometry: str  # "measured", of its "maker", or the mean of its "family" or "population"
    diameter_m: float  # as labelled, as the pitch
    pitch_m: float
    airfoil: Airfoil  # with how well they are known
    covariance: Floats  # (P, P) of ``PARAMETERS``
    thrust_rms: float  # errors of C_T and C_P over all rows, and at rest; NaN without such
    power_rms: float
    static_thrust_rms: float
    static_power_rms: float
    rows: int  # operating points in all
    static_rows: int
    rpm_low: float  # range of the data, with J = V/(n D) up to ``advance_high``
    rpm_high: float
    advance_high: float
    verdict: str  # "good", or what is wrong with the data or the fit
    key: str  # identifies the data and the settings of the fit

    @property
    def size(self) -> tuple[float, float]:
        """Labelled diameter and pitch [m]."""
        return self.diameter_m, self.pitch_m

    @property
    def discrepancy(self) -> tuple[float, float]:
        """Standard deviations of C_T and C_P [-] that these constants leave, beside their own."""
        return self.thrust_rms, self.power_rms

    @property
    def summary(self) -> str:
        """Say in one line whose constants these are, what they rest on, and how well they fit."""
        size = "and at rest " if self.static_rows else ""
        return (
            f"constants identified from {self.rows} loads of {self.tested!r} in axial flow {size}"
            f"(UIUC), {self.rpm_low:.0f} to {self.rpm_high:.0f} rpm, J up to "
            f"{self.advance_high:.2f}: rms error of C_T {self.thrust_rms:.4f}, of C_P "
            f"{self.power_rms:.4f}; {self.verdict}"
        )

    @property
    def constants(self) -> Floats:
        """Values of ``PARAMETERS``, (P,)."""
        return np.array([getattr(self.airfoil, name) for name in PARAMETERS])


def identified(propeller: str, blades: int) -> Identified | None:
    """Find the bundled constants of a blade of the catalogue on a rotor with so many ``blades``."""
    key = propeller.strip().lower(), blades
    return _bundled(key) if key in _rows() else None


def all_identified(family: str | None = None) -> list[Identified]:
    """List the bundled constants of blades that were measured, in the order of the file, and of
    makers' blades where none was; those of one ``family``, or all."""
    rows = [item for item in _rows().items() if family in (None, item[1]["family"])]
    measured = {row["tested"] for _, row in rows if row["geometry"] == "measured"}
    return [
        _bundled(key)
        for key, row in rows
        if row["geometry"] == "measured"
        or (row["geometry"] == "maker" and row["tested"] not in measured)
    ]


def identified_without_blade() -> list[Identified]:
    """List all bundled constants of propellers whose blades are not known."""
    return [_bundled(key) for key, row in _rows().items() if row["geometry"] in MEAN_BLADES]


def named_without_blade(name: str) -> Identified | None:
    """Find the one of ``identified_without_blade`` with this ``name``, in lower case."""
    found = [
        key for key, row in _rows().items() if key[0] == name and row["geometry"] in MEAN_BLADES
    ]
    return _bundled(found[0]) if found else None


def one_of_each(entries: Sequence[Identified]) -> list[Identified]:
    """Keep, of ``entries`` for one tested propeller, a measured blade's, of these the best fit."""
    best: dict[str, Identified] = {}
    for one in sorted(entries, key=lambda one: (one.geometry != "measured", badness(one))):
        best.setdefault(one.tested, one)
    return [one for one in entries if best[one.tested] is one]


def badness(one: Identified) -> float:
    """Take the larger of the errors of C_T and C_P, each over ``POOR``."""
    return max(one.thrust_rms / POOR[0], one.power_rms / POOR[1])


def entry_of(row: dict[str, str]) -> Identified:
    """Make the entry of a ``row`` of the file, by column."""
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
    name = f"{row['propeller']} identified"
    airfoil = Airfoil(**values, lift_law=LIFT_LAW, name=name, source=source, uncertainty=known)
    return Identified(airfoil=airfoil, covariance=covariance, **texts, **counts, **numbers)


def pair_name(i: int, j: int) -> str:
    """Name the column of the covariance of parameters number ``i`` and ``j``."""
    return f"cov_{PARAMETERS[i]}_{PARAMETERS[j]}"


@cache
def _rows() -> dict[tuple[str, int], dict[str, str]]:
    """Read the bundled file's rows, by propeller and number of blades."""
    with (Path(__file__).parent / "identified" / "uiuc.csv").open(encoding="utf-8") as file:
        return {(row["propeller"], int(row["blades"])): row for row in csv.DictReader(file)}


@cache
def _bundled(key: tuple[str, int]) -> Identified:
    # Made when it is asked for: a process wants one of them, and all take longer than a rotor.
    return entry_of(_rows()[key])
