"""Print the chord of propellers with more than two blades, from static thrust, and its errors.

Usage: python -m tools.chord_by_blades STAND LOADS

STAND contains static thrust of five-inch multirotor propellers, with the columns ``COLUMNS``.
LOADS is the loads.csv of the UIUC database.  From it the tool uses blades that were tested on hubs
with two, three and four blades.

The chord factor of a propeller multiplies the chord of the mean blade so that the median error of
static thrust is zero.  On a hub the factor is relative to that with two blades.  The factor for
more than two blades is the mean of the stand, shrunk toward the mean of the hubs.

Each propeller of the stand is then predicted with the factor of the other propellers.  The tool
prints the median error over all rows, half the width of the 95 % band (from the errors of the other
propellers) and the fraction of rows inside it.  The air density at the stand was not recorded;
``DENSITY`` is assumed.  The rotor speed was derived from the motor current.  The last lines are
the numbers of propmap.catalogue.expected.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from propmap.catalogue.expected import (
    STAND_DEVIATION,
    bundled_mean,
    expected_constants,
    expected_prior,
    known_at_rest,
    left_at_rest,
    slopes_of,
)
from propmap.catalogue.identified import PARAMETERS
from propmap.model.air import Air
from propmap.model.airfoil import SectionCovariance
from propmap.model.corrections import model_corrections
from propmap.model.model import Model
from propmap.results import Loads
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import INCH, RPM
from tools.catalogue.database import label_of, read_uiuc_database, refiled
from tools.catalogue.left_out import BAND

COLUMNS = ("propeller", "blades", "diameter_in", "pitch_in", "rpm", "thrust_N")
DENSITY = 1.20  # [kg/m^3] of the stand's air

STEPS, ERROR = 20, 1e-4
"""Maximum steps of the search for a factor, and the thrust error at which it ends."""


class StaticTest(NamedTuple):
    """Static thrust (n,) of one propeller."""

    name: str
    series: str
    blades: int
    size: tuple[float, float]  # diameter and pitch [m]
    omega: Floats  # [rad/s]
    thrust: Floats  # [N]
    density: float  # [kg/m^3]

    def rotor(self, factor: float, deviation: float = STAND_DEVIATION) -> Rotor:
        """Return the rotor with ``factor`` on the chord of the mean blade, and a standard
        ``deviation`` of the logarithm of static thrust."""
        mean = bundled_mean().propeller(self.name, *self.size, self.blades)
        blade = replace(mean, chord=factor * mean.chord)
        law = expected_constants(None, self.size, "population").airfoil
        prior = expected_prior(None, self.size, "population")
        left = left_at_rest(prior.covariance, deviation)
        slopes, narrowed = slopes_of(prior.mean), known_at_rest(prior.covariance, left)
        covariance = SectionCovariance(PARAMETERS, slopes @ narrowed @ slopes.T)
        assert law.uncertainty is not None  # for type checkers: expected constants have one
        known = replace(law.uncertainty, covariance=covariance)
        law = law.with_parameters(uncertainty=known)
        return Rotor(Model(blade, law, Air(self.density), model_corrections("recommended")))

    def loads(self, factor: float, deviation: float = STAND_DEVIATION) -> Loads:
        """Predict the loads of the propeller."""
        return self.rotor(factor, deviation).loads(self.omega, 0.0, 0.0)

    def error(self, factor: float) -> float:
        """Return the median of ln(predicted / measured thrust)."""
        return float(np.median(np.log(self.loads(factor).thrust / self.thrust)))

    def factor(self) -> float:
        """Find the factor at which the median error is zero."""
        found = 1.0
        for _ in range(STEPS):
            error = self.error(found)
            if abs(error) < ERROR:
                break
            # Thrust is nearly proportional to the chord.
            found *= np.exp(-error)
        return found

    def slopes(self, factor: float) -> Floats:
        """Return the median over the rows of the derivatives of the logarithm of thrust with
        respect to the coordinates of the constants (P,)."""
        found = self.rotor(factor).gradients(PARAMETERS, self.omega, 0.0, 0.0)
        by_constants = (found.slopes[0] / found.loads[0]).T
        prior = expected_prior(None, self.size, "population")
        return np.asarray(np.median(by_constants @ slopes_of(prior.mean), axis=0))


def read_stand(path: Path) -> list[StaticTest]:
    """Read the propellers of the stand; lines that begin with # are comments."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line[:1] != "#"]
    by_name: dict[str, list[dict[str, str]]] = {}
    for row in csv.DictReader(lines):
        by_name.setdefault(row["propeller"], []).append(row)
    found = []
    for name, rows in by_name.items():
        first = rows[0]
        size = float(first["diameter_in"]) * INCH, float(first["pitch_in"]) * INCH
        omega, thrust = (np.array([float(row[c]) for row in rows]) for c in ("rpm", "thrust_N"))
        count = int(first["blades"])
        found.append(StaticTest(name, name, count, size, omega * RPM, thrust, DENSITY))
    return found


def read_hubs(path: Path) -> list[StaticTest]:
    """Read the static rows of blades of the database that were tested on several hubs."""
    density = Air().density  # any value: it cancels, since the database contains coefficients
    tests = []
    for one in refiled(read_uiuc_database(path)):
        rest = one.advance == 0.0
        if rest.any():
            label, omega = label_of(one), one.rpm[rest] * RPM
            force = density * (omega / (2.0 * np.pi)) ** 2 * label.diameter**4
            size = label.diameter, label.pitch
            loads = omega, one.thrust[rest] * force
            tests.append(StaticTest(one.blade, one.family, one.blades, size, *loads, density))
    several = {test.name for test in tests if test.blades > 2}
    return [test for test in tests if test.name in several]


def hub_ratios(hubs: Sequence[StaticTest]) -> list[tuple[StaticTest, float]]:
    """Return each test with more than two blades and its factor over that with two blades."""
    two = {test.name: test.factor() for test in hubs if test.blades == 2}
    return [(test, test.factor() / two[test.name]) for test in hubs if test.blades > 2]


def means_by_series(ratios: Sequence[tuple[StaticTest, float]]) -> Floats:
    """Average the logarithms of ``hub_ratios`` by series, with equal weight for each blade."""
    by_blade: dict[tuple[str, str], list[float]] = {}
    for test, ratio in ratios:
        by_blade.setdefault((test.series, test.name), []).append(float(np.log(ratio)))
    by_series: dict[str, list[float]] = {}
    for (series, _), some in by_blade.items():
        by_series.setdefault(series, []).append(float(np.mean(some)))
    return np.array([np.mean(some) for some in by_series.values()])


def rule(stand: Floats, hubs: Floats) -> tuple[float, float]:
    """Return the logarithm of the factor to expect on the stand, and its standard deviation.

    ``stand`` are logarithms of the factors of propellers, ``hubs`` those of series.  Their scatter
    is assumed equal.  The mean of the stand is assumed normal about that of the hubs, with the
    difference of the two as its deviation (C. N. Morris, J. Am. Stat. Assoc. 78, 1983).
    """
    squares = sum(float(((some - some.mean()) ** 2).sum()) for some in (stand, hubs))
    known = squares / (stand.size + hubs.size - 2) / stand.size
    apart = float(stand.mean() - hubs.mean())
    weight = max(0.0, 1.0 - known / apart**2)
    return float(hubs.mean()) + weight * apart, float(np.sqrt(weight * known))


def widened(errors: Sequence[float]) -> float:
    """Return the rms of a few ``errors``, widened by Student's t so that 1.96 times the result
    contains 95 %."""
    from scipy.stats import t

    few = float(t.ppf(0.975, len(errors))) / BAND
    return few * float(np.sqrt(np.mean(np.square(errors))))


class LeftOut(NamedTuple):
    """A propeller of the stand, predicted from the other propellers."""

    test: StaticTest
    own: float  # factor of this propeller
    factor: float  # factor of the other propellers
    error: float  # median of ln(predicted / measured thrust)
    half_width: float  # of the 95 % band over thrust, median
    inside: float  # fraction of the rows inside the band


def left_out(stand: Sequence[StaticTest], hubs: Floats) -> list[LeftOut]:
    """Predict each propeller of the ``stand`` with the factor of the other propellers."""
    own = [test.factor() for test in stand]
    factors = []
    for test in stand:
        others = [
            np.log(factor)
            for other, factor in zip(stand, own, strict=True)
            if other is not test and other.blades > 2
        ]
        factors.append(np.exp(rule(np.array(others), hubs)[0]) if test.blades > 2 else 1.0)
    errors = [test.error(factor) for test, factor in zip(stand, factors, strict=True)]
    found = []
    for i, test in enumerate(stand):
        loads = test.loads(factors[i], widened([*errors[:i], *errors[i + 1 :]]))
        half = BAND * loads.std.thrust
        width = float(np.median(half / loads.thrust))
        inside = float(np.mean(np.abs(loads.thrust - test.thrust) <= half))
        found.append(LeftOut(test, own[i], factors[i], errors[i], width, inside))
    return found


def main(stand_file: Path, loads_file: Path) -> None:
    """Print the factors, the held-out predictions and the resulting numbers."""
    stand, ratios = read_stand(stand_file), hub_ratios(read_hubs(loads_file))
    hubs = means_by_series(ratios)
    print("blades on hubs for more than two, chord over that with two")
    for test, ratio in ratios:
        print(f"  {test.name:<20} {test.blades} blades  {ratio:.3f}")
    print("stand                blades rows   own  held-out factor  error  95 % band inside")
    found = left_out(stand, hubs)
    for one in found:
        print(
            f"  {one.test.name:<20}{one.test.blades:>5}{one.test.omega.size:>5}{one.own:>7.3f}"
            f"{one.factor:>16.3f}{np.expm1(one.error):>+8.1%}{one.half_width:>9.1%}"
            f"{one.inside:>8.0%}"
        )
    more = np.log([one.own for one in found if one.test.blades > 2])
    mean, deviation = rule(more, hubs)
    slopes = np.mean([one.test.slopes(one.factor) for one in found], axis=0)
    print(f"CHORD_OF_MORE = {np.exp(mean):.3f}, its logarithm to {deviation:.3f}")
    errors = [one.error for one in found]
    print(f"LEFT_OUT_ERROR = {np.abs(np.expm1(errors)).max():.3f}")
    print(f"STAND_DEVIATION = {widened(errors):.3f}")
    print(f"AT_REST = {', '.join(f'{value:.2f}' for value in slopes)}")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(Path(sys.argv[1]), Path(sys.argv[2]))
