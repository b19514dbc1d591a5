"""Section constants identified from published loads, propeller by propeller, in one CSV file."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from propmap.errors import InputError
from propmap.model.airfoil import Airfoil, SectionCovariance, SectionUncertainty
from propmap.typing import Floats

PARAMETERS = (
    "c_l1",
    "c_d",
    "alpha_0",
    "zero_lift_angle",
    "c_d0",
    "reynolds_camber",
    "drag_angle",
)
"""The constants that were identified; the others are held, c_l2 at the value in the file."""

POOR = (0.0048, 0.0036)
"""Errors of C_T and C_P [-] that nine propellers in ten stay below."""

_PAIRS = [(i, j) for i in range(len(PARAMETERS)) for j in range(i, len(PARAMETERS))]
_TEXTS = ("propeller", "family", "tested", "geometry", "key", "verdict")
_COUNTS = ("blades", "rows", "static_rows")
_RANGES = ("diameter_m", "pitch_m", "rpm_low", "rpm_high", "advance_high")
_ERRORS = ("thrust_rms", "power_rms", "static_thrust_rms", "static_power_rms")


@dataclass(frozen=True, eq=False)
class Identified:
    """Constants of one propeller, and how far they can be trusted.

    Attributes
    ----------
    propeller : str
        Name of its blade in the catalogue; that of an unmeasured blade is made likewise.
    blades : int
        Number of blades.
    family, tested : str
        Code of its series, and what the source calls it.
    geometry : str
        Which blade the constants belong to: "measured", or the mean of the measured blades of its
        "family" or of the whole "population", of its size (``expected_blade``).
    diameter_m, pitch_m : float
        As labelled [m].
    airfoil : Airfoil
        The constants, with how well they are known.
    covariance : ndarray, shape (7, 7)
        Of ``PARAMETERS``, in their units.
    thrust_rms, power_rms, static_thrust_rms, static_power_rms : float
        Root mean squares of the errors of C_T and C_P over all rows and over those at rest [-];
        NaN where there are none.
    rows, static_rows : int
        Operating points in all, and at rest.
    rpm_low, rpm_high, advance_high : float
        Range of the data: rotational speed [1/min], and J = V/(n D) up to this [-].
    verdict : str
        "good", or what is wrong with the data or the fit.
    key : str
        Tells the data and the settings of the fit from others.
    """

    propeller: str
    blades: int
    family: str
    tested: str
    geometry: str
    diameter_m: float
    pitch_m: float
    airfoil: Airfoil
    covariance: Floats
    thrust_rms: float
    power_rms: float
    static_thrust_rms: float
    static_power_rms: float
    rows: int
    static_rows: int
    rpm_low: float
    rpm_high: float
    advance_high: float
    verdict: str
    key: str

    @property
    def section_covariance(self) -> SectionCovariance:
        """``covariance`` with its names, as tables take it."""
        return SectionCovariance(PARAMETERS, self.covariance)

    @property
    def size(self) -> tuple[float, float]:
        """Labelled diameter and pitch [m]."""
        return self.diameter_m, self.pitch_m

    @property
    def discrepancy(self) -> tuple[float, float]:
        """Standard deviations of C_T and C_P [-] that these constants leave, beside their own."""
        return self.thrust_rms, self.power_rms

    @property
    def told(self) -> str:
        """In one line: whose constants these are, what they rest on, and how well they fit."""
        size = "and at rest " if self.static_rows else ""
        return (
            f"constants identified from {self.rows} loads of {self.tested!r} in axial flow {size}"
            f"(UIUC), {self.rpm_low:.0f} to {self.rpm_high:.0f} rpm, J up to "
            f"{self.advance_high:.2f}: rms error of C_T {self.thrust_rms:.4f}, of C_P "
            f"{self.power_rms:.4f}; {self.verdict}"
        )

    @property
    def constants(self) -> Floats:
        """Values of ``PARAMETERS``, (7,)."""
        return np.array([getattr(self.airfoil, name) for name in PARAMETERS])


def identified(propeller: str, blades: int) -> Identified | None:
    """The bundled constants of a propeller; None where there are none.

    Parameters
    ----------
    propeller : str
        Name of the blade in the catalogue, in upper or lower case.
    blades : int
        How many of them the rotor has.
    """
    key = propeller.strip().lower(), blades
    return _bundled(key) if key in _rows() else None


def all_identified() -> list[Identified]:
    """All bundled constants of measured blades, in the order of the file."""
    return [_bundled(key) for key, row in _rows().items() if row["geometry"] == "measured"]


def identified_without_blade() -> list[Identified]:
    """All bundled constants of propellers whose blades were never measured."""
    return [_bundled(key) for key, row in _rows().items() if row["geometry"] != "measured"]


def named_without_blade(name: str) -> Identified | None:
    """That of ``identified_without_blade`` with this ``name``, in lower case, if there is one."""
    found = [
        key for key, row in _rows().items() if key[0] == name and row["geometry"] != "measured"
    ]
    return _bundled(found[0]) if found else None


def one_of_each(entries: Sequence[Identified]) -> list[Identified]:
    """Of ``entries`` for several blades of one tested propeller, the one that fits best."""
    best: dict[str, Identified] = {}
    for one in entries:
        kept = best.get(one.tested)
        if kept is None or badness(one) < badness(kept):
            best[one.tested] = one
    return list(best.values())


def badness(one: Identified) -> float:
    """The larger of the errors of C_T and C_P, each over ``POOR``."""
    return max(one.thrust_rms / POOR[0], one.power_rms / POOR[1])


def as_csv(entries: Sequence[Identified]) -> str:
    """The entries as the text of a file that ``parse_identified`` reads."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_header())
    for one in entries:
        numbers = [
            *(getattr(one, name) for name in _RANGES),
            one.airfoil.c_l2,
            *one.constants,
            *(one.covariance[pair] for pair in _PAIRS),
        ]
        writer.writerow(
            [
                *(getattr(one, name) for name in _TEXTS),
                *(getattr(one, name) for name in _COUNTS),
                *(f"{value:.8g}" for value in numbers),
                *(f"{getattr(one, name):.5f}" for name in _ERRORS),
            ]
        )
    return text.getvalue()


def parse_identified(text: str, where: str) -> list[Identified]:
    """The entries of a file's ``text``; ``where`` names it in errors.

    Raises
    ------
    InputError
        For other columns than those of ``as_csv`` and for what is not a number.
    """
    reader = csv.DictReader(io.StringIO(text))
    if reader.fieldnames != _header():
        raise InputError(
            "the columns are not those of identified constants",
            "write the file anew with `propmap fit catalogue`",
            where,
        )
    found = []
    for line, row in enumerate(reader, start=2):
        try:
            found.append(_entry(row))
        except (TypeError, ValueError) as error:
            raise InputError(f"line {line}: {error}", "correct the row", where) from None
    return found


def _entry(row: dict[str, str]) -> Identified:
    covariance = np.zeros((len(PARAMETERS), len(PARAMETERS)))
    for i, j in _PAIRS:
        covariance[i, j] = covariance[j, i] = float(row[_pair(i, j)])
    values: Any = {name: float(row[name]) for name in ("c_l2", *PARAMETERS)}
    texts: Any = {name: row[name] for name in _TEXTS}
    counts: Any = {name: int(row[name]) for name in _COUNTS}
    numbers: Any = {name: float(row[name]) for name in (*_RANGES, *_ERRORS)}
    source = f"identified by propmap from the UIUC Propeller Database, {row['tested']}"
    known = SectionUncertainty(
        SectionCovariance(PARAMETERS, covariance), numbers["thrust_rms"], numbers["power_rms"]
    )
    name = f"{row['propeller']} identified"
    airfoil = Airfoil(**values, name=name, source=source, uncertainty=known)
    return Identified(airfoil=airfoil, covariance=covariance, **texts, **counts, **numbers)


def _header() -> list[str]:
    pairs = [_pair(i, j) for i, j in _PAIRS]
    return [*_TEXTS, *_COUNTS, *_RANGES, "c_l2", *PARAMETERS, *pairs, *_ERRORS]


def _pair(i: int, j: int) -> str:
    return f"cov_{PARAMETERS[i]}_{PARAMETERS[j]}"


@cache
def _rows() -> dict[tuple[str, int], dict[str, str]]:
    """The bundled file's rows by propeller and number of blades."""
    with (Path(__file__).parent / "identified" / "uiuc.csv").open(encoding="utf-8") as file:
        return {(row["propeller"], int(row["blades"])): row for row in csv.DictReader(file)}


@cache
def _bundled(key: tuple[str, int]) -> Identified:
    # Made when it is asked for: a process wants one of them, and all take longer than a rotor.
    return _entry(_rows()[key])
