"""Print what chord blades have on propellers with more than two, and how well that predicts thrust.

Usage: python -m tools.chord_by_blades STAND LOADS

STAND has static thrust of five-inch propellers of multirotors, the columns ``COLUMNS``; LOADS is
the UIUC database's loads.csv, of which the blades count that were tested on hubs for two, three and
four.  A propeller's chord is the factor on the mean blade's with which the median error of its
static thrust is nil; on a hub it is counted from that with two blades.  The factor of all with more
than two is the mean over the stand's, drawn towards that of the hubs.  Each propeller of the stand
is then predicted with the factor of the others: printed are its median error over all rows, half
the width of the 95 % band, by the same errors of the others (whose factors it is counted in), and
what share of the rows it holds.  The density of the stand's air was not recorded and is taken to be
``DENSITY``; the rotational speed is that of the motors' current.  The numbers of
propmap.catalogue.expected are the last lines.
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
from propmap.model.corrections import corrections_of
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
"""Most steps of the search for a factor, and the error of thrust at which it ends."""


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
        """Make its rotor by size and number of blades, with ``factor`` on the mean blade's chord,
        and static thrust known to a ``deviation``."""
        mean = bundled_mean().propeller(self.name, *self.size, self.blades)
        blade = replace(mean, chord=factor * mean.chord)
        law = expected_constants(None, self.size, "population").airfoil
        prior = expected_prior(None, self.size, "population")
        left = left_at_rest(prior.covariance, deviation)
        slopes, narrowed = slopes_of(prior.mean), known_at_rest(prior.covariance, left)
        covariance = SectionCovariance(PARAMETERS, slopes @ narrowed @ slopes.T)
        assert law.uncertainty is not None  # expected constants have it
        known = replace(law.uncertainty, covariance=covariance)
        law = law.with_parameters(uncertainty=known)
        return Rotor(Model(blade, law, Air(self.density), corrections_of("recommended")))

    def loads(self, factor: float, deviation: float = STAND_DEVIATION) -> Loads:
        """Predict its loads."""
        return self.rotor(factor, deviation).loads(self.omega, 0.0, 0.0)

    def error(self, factor: float) -> float:
        """Take the median of ln(predicted / measured thrust)."""
        return float(np.median(np.log(self.loads(factor).thrust / self.thrust)))

    def factor(self) -> float:
        """Find the factor with which the median error is nil."""
        found = 1.0
        for _ in range(STEPS):
            error = self.error(found)
            if abs(error) < ERROR:
                break
            # Thrust goes with nearly the first power of the chord.
            found *= np.exp(-error)
        return found

    def slopes(self, factor: float) -> Floats:
        """Differentiate the logarithm of thrust by the coordinates of constants (P,), median over
        the rows."""
        found = self.rotor(factor).gradients(PARAMETERS, self.omega, 0.0, 0.0)
        by_constants = (found.slopes[0] / found.loads[0]).T
        prior = expected_prior(None, self.size, "population")
        return np.asarray(np.median(by_constants @ slopes_of(prior.mean), axis=0))


def read_stand(path: Path) -> list[StaticTest]:
    """Read the propellers of the stand; lines that start with # are comments."""
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
    """Read the static rows of the database's blades that were tested on several hubs."""
    density = Air().density  # of no consequence to coefficients
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
    """Find the factor of each test with more than two blades over that of the blade with two."""
    two = {test.name: test.factor() for test in hubs if test.blades == 2}
    return [(test, test.factor() / two[test.name]) for test in hubs if test.blades > 2]


def means_by_series(ratios: Sequence[tuple[StaticTest, float]]) -> Floats:
    """Average the logarithms of ``hub_ratios``, with one vote for each blade of a series."""
    by_blade: dict[tuple[str, str], list[float]] = {}
    for test, ratio in ratios:
        by_blade.setdefault((test.series, test.name), []).append(float(np.log(ratio)))
    by_series: dict[str, list[float]] = {}
    for (series, _), some in by_blade.items():
        by_series.setdefault(series, []).append(float(np.mean(some)))
    return np.array([np.mean(some) for some in by_series.values()])


def rule(stand: Floats, hubs: Floats) -> tuple[float, float]:
    """Combine logarithms of factors of the stand's propellers and of series on hubs; returns the
    logarithm of the factor to expect on the stand, and its standard deviation.

    Both scatter alike. The stand's mean is taken to be normal about that of the hubs, by as much
    as the two differ (C. N. Morris, J. Am. Stat. Assoc. 78, 1983).
    """
    squares = sum(float(((some - some.mean()) ** 2).sum()) for some in (stand, hubs))
    known = squares / (stand.size + hubs.size - 2) / stand.size
    apart = float(stand.mean() - hubs.mean())
    weight = max(0.0, 1.0 - known / apart**2)
    return float(hubs.mean()) + weight * apart, float(np.sqrt(weight * known))


def widened(errors: Sequence[float]) -> float:
    """Take the root mean square of ``errors``, widened so that 1.96 of it hold 95 % as they are
    few."""
    from scipy.stats import t

    few = float(t.ppf(0.975, len(errors))) / BAND
    return few * float(np.sqrt(np.mean(np.square(errors))))


class LeftOut(NamedTuple):
    """A propeller of the stand, predicted from the others."""

    test: StaticTest
    own: float  # its own factor
    factor: float  # that of the others
    error: float  # median of ln(predicted / measured thrust)
    half_width: float  # of the 95 % band over thrust, median
    inside: float  # share of the rows in it


def left_out(stand: Sequence[StaticTest], hubs: Floats) -> list[LeftOut]:
    """Predict each of the ``stand`` with the factor of the others."""
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
    """Print."""
    stand, ratios = read_stand(stand_file), hub_ratios(read_hubs(loads_file))
    hubs = means_by_series(ratios)
    print("one blade on hubs for more than two, chord over that with two")
    for test, ratio in ratios:
        print(f"  {test.name:<20} {test.blades} blades  {ratio:.3f}")
    print("stand                blades rows   own  from the others  error  95 % band  holds")
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
