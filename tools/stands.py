"""Print the errors of catalogue predictions of static loads of multirotor propellers on stands.

Usage: python -m tools.stands STANDS

STANDS is the file stands.csv of the reference data: static thrust and torque of some 150 propellers
from nine sources.  The tool skips rows whose notes mark them as suspect, unverified or excluded,
rows below the fraction ``SLOW`` of the highest rotor speed, and manufacturers whose series the UIUC
database contains.  76 propellers remain.  ``DENSITY`` is assumed if none was recorded.

For each measurement, the tool computes the median of log(measured / predicted load) over its rows.
The prediction uses the mean blade and the constants of all series of the UIUC database.  Several
measurements of one propeller are replaced by their median.  The medians over the propellers are the
shift of ``propmap.catalogue.expected``.  The standard deviation of each kind minimizes the mean
interval score of the 95 % bands (Gneiting, Raftery, J. Am. Stat. Assoc. 102, 2007).  It is then
widened by the t distribution, and includes differences between stands.  Outside the diameters on
stands, the bands widen with the slope of the errors over log(diameter).  Below these diameters, the
slope follows from one smaller propeller, ``TINY``.

Each propeller is then predicted without its own measurements.  The tool prints, by kind, the median
error of thrust and torque, half the width of the 95 % bands, and the share of propellers inside.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import t as student_t

from propmap.catalogue.expected import (
    CARBON,
    LARGE,
    STAND_DEVIATIONS,
    STAND_SIZES,
    airfoil_at,
    bundled_mean,
    expected_prior,
    stand_kind,
)
from propmap.model.air import Air
from propmap.model.corrections import model_corrections
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import INCH, RPM
from tools.catalogue.left_out import BAND
from tools.coverage import rows_of

DENSITY = 1.20  # [kg/m^3], where none was recorded
SLOW = 0.35  # smallest rotor speed, as a fraction of the highest

SCATTER, FAR = 0.25, 0.7
"""Limits of log(measured / predicted thrust) over the rows of a measurement: standard deviation,
and magnitude of the median.  Beyond them, the rotor speeds are wrong and the rows are discarded."""

DOUBTFUL = ("SUSPECT", "UNVERIFIED", "EXCLUDE")
IN_DATABASE = ("apc", "graupner", "aeronaut")  # manufacturers of series of the UIUC database


TINY = ("Crazyflie 2 propeller 46 mm", 0.047 / INCH, 0.017 / INCH)
"""Name in the file, and size [in] by the designation 47x17 mm.  The file contains no pitch."""


class Measured(NamedTuple):
    """A propeller measured on one stand or on several."""

    propeller: tuple[str, float, float, int]  # manufacturer, diameter and pitch [m], blades
    errors: Floats  # (2,): logarithm of measured over predicted thrust and torque

    @property
    def kind(self) -> str:
        """A key of ``STAND_DEVIATIONS``."""
        maker, diameter, _, blades = self.propeller
        carbon = any(maker == name.lower()[:4].strip() for name in CARBON)
        return stand_kind(carbon and diameter >= LARGE, blades)


def read_stands(path: Path) -> list[Measured]:
    """Read the propellers of the file, each with the median over its measurements."""
    groups: dict[tuple[str, ...], list[dict[str, str]]] = {}
    for row in rows_of(path):
        doubtful = any(word in row["note"] for word in DOUBTFUL)
        if row["pitch_in"] and not doubtful and row["maker"].lower() not in IN_DATABASE:
            tester = row["note"].rpartition("tester ")[2] if "tester " in row["note"] else ""
            names = ("source", "maker", "name", "diameter_in", "pitch_in", "blades")
            groups.setdefault((tester, *(row[name] for name in names)), []).append(row)
    found: dict[tuple[str, float, float, int], list[Measured]] = {}
    for rows in groups.values():
        one = _measured(rows)
        if one is not None:
            found.setdefault(one.propeller, []).append(one)
    medians = []
    for propeller, some in found.items():
        medians.append(Measured(propeller, np.median([m.errors for m in some], axis=0)))
    return medians


def _measured(rows: Sequence[dict[str, str]]) -> Measured | None:
    """Return one measurement; None with fewer than three valid rows, or beyond a limit above."""

    def column(name: str, missing: float) -> Floats:
        return np.array([float(row[name] or missing) for row in rows])

    first, rpm = rows[0], column("rpm", np.nan)
    fast = (rpm > SLOW * np.quantile(rpm, 0.98)) & (rpm <= 1.02 * np.quantile(rpm, 0.995))
    thrust, torque = column("thrust_N", np.nan), column("torque_Nm", np.nan)
    fast &= thrust > 0.02
    if fast.sum() < 3:
        return None
    size = float(first["diameter_in"]) * INCH, float(first["pitch_in"]) * INCH
    blades = int(first["blades"])
    prior = expected_prior(None, size, "population")
    blade = bundled_mean().propeller(first["name"], *size, blades)
    law = airfoil_at(prior.mean, "all series", "")
    rotor = Rotor(Model(blade, law, Air(DENSITY), model_corrections("recommended")))
    found = rotor.loads(rpm[fast] * RPM, 0.0, 0.0)
    loads = np.stack([found.thrust, found.torque]) * column("density_kgm3", DENSITY)[fast] / DENSITY
    with np.errstate(invalid="ignore", divide="ignore"):
        errors = np.log(np.stack([thrust, torque])[:, fast] / loads)
    errors[~np.isfinite(errors)] = np.nan
    if np.nanstd(errors[0]) > SCATTER or abs(np.nanmedian(errors[0])) > FAR:
        return None
    level = [
        np.median(row[known]) if (known := np.isfinite(row)).any() else np.nan for row in errors
    ]
    return Measured((first["maker"].lower()[:4].strip(), *size, blades), np.array(level))


def best_deviation(errors: Floats) -> float:
    """Return the standard deviation that minimizes the mean interval score of the 95 % bands.

    The result is multiplied by the ratio of the 97.5 % quantiles of the t distribution and the
    normal distribution.  The degrees of freedom are the number of ``errors`` minus one.
    """

    def score(deviation: float) -> float:
        outside = np.maximum(np.abs(errors) - BAND * deviation, 0.0)
        return float(2.0 * BAND * deviation + 40.0 * outside.mean())

    found = minimize_scalar(score, bounds=(0.01, 1.0), method="bounded").x
    return float(found * student_t.ppf(0.975, len(errors) - 1) / BAND)


class Shift(NamedTuple):
    """Distribution of the errors of thrust and torque over propellers."""

    mean: Floats  # (2,) medians
    deviations: dict[str, Floats]  # (2,) by kind
    correlation: float


def shift_of(every: Sequence[Measured]) -> Shift:
    """Estimate the distribution of the errors of thrust and torque."""
    errors = np.stack([one.errors for one in every])
    kinds = np.array([one.kind for one in every])
    mean = np.nanmedian(errors, axis=0)
    left = errors - mean
    known = np.isfinite(left)
    deviations = {
        kind: np.array([best_deviation(left[(kinds == kind) & known[:, k], k]) for k in range(2)])
        for kind in STAND_DEVIATIONS
    }
    signs = np.sign(left[known.all(axis=1)])  # robust: quadrant correlation about the medians
    return Shift(mean, deviations, float(np.sin(0.5 * np.pi * np.mean(signs.prod(axis=1)))))


def diameters(every: Sequence[Measured]) -> dict[str, list[float]]:
    """Return the smallest and the largest diameter [in] of each kind."""
    found: dict[str, list[float]] = {kind: [] for kind in STAND_DEVIATIONS}
    for one in every:
        found[one.kind].append(round(one.propeller[1] / INCH, 2))
    return {kind: [min(some), max(some)] for kind, some in found.items()}


def size_trend(every: Sequence[Measured]) -> float:
    """Return the root mean square slope of the errors over log(diameter), by kind and load.

    The mean square includes the variance of each slope.
    """
    squares = []
    for kind in STAND_DEVIATIONS:
        own = [one for one in every if one.kind == kind]
        x, y = np.log([one.propeller[1] for one in own]), np.stack([one.errors for one in own])
        for errors in y.T:
            known = np.isfinite(errors)
            line, covariance = np.polyfit(x[known], errors[known], 1, cov=True)
            squares.append(line[0] ** 2 + covariance[0, 0])
    return float(np.sqrt(np.mean(squares)))


def tiny_trend(path: Path, found: Shift) -> float:
    """Return the slope over log(diameter) below the diameters of two-blade propellers.

    With this slope, the error of the thrust of ``TINY`` equals its standard deviation.
    """
    name, diameter, pitch = TINY
    size = {"diameter_in": str(diameter), "pitch_in": str(pitch)}
    one = _measured([row | size for row in rows_of(path) if row["name"] == name])
    assert one is not None
    error, deviation = one.errors[0] - found.mean[0], found.deviations["two blades"][0]
    beyond = np.log(STAND_SIZES["two blades"][0] / diameter)
    return float(np.sqrt(error**2 - deviation**2) / beyond)


def main(path: Path) -> None:
    """Print the held-out errors, then the numbers of propmap.catalogue.expected."""
    every = read_stands(path)
    lines: dict[str, list[tuple[Floats, Floats]]] = {kind: [] for kind in STAND_DEVIATIONS}
    for k, one in enumerate(every):
        without = shift_of([*every[:k], *every[k + 1 :]])
        lines[one.kind].append((one.errors - without.mean, without.deviations[one.kind]))
    print(f"{'held-out propellers':<26}n  thrust, torque: median error   half width      inside")
    for kind, some in lines.items():
        error, deviation = (np.stack(part) for part in zip(*some, strict=True))
        known = np.isfinite(error)
        texts = []
        for k in range(2):
            e, d = error[known[:, k], k], deviation[known[:, k], k]
            inside = np.mean(np.abs(e) <= BAND * d)
            texts.append((np.median(np.abs(e)), BAND * np.median(d), inside))
        shown = "  ".join(f"{a:.1%} {b:.1%}" for a, b in zip(*texts, strict=True))
        print(f"{kind:<24}{len(some):>3}  {shown}")
    found = shift_of(every)
    print(f"STANDS = {len(every)}")
    print(f"STAND_SHIFT = {found.mean.round(3).tolist()}")
    deviations = {kind: value.round(3).tolist() for kind, value in found.deviations.items()}
    print(f"STAND_DEVIATIONS = {json.dumps(deviations)}")
    print(f"STAND_CORRELATION = {found.correlation:.2f}")
    print(f"STAND_SIZES = {json.dumps(diameters(every))}")
    print(f"SIZE_TREND = {size_trend(every):.2f}")
    print(f"TINY_TREND = {tiny_trend(path, found):.2f}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
