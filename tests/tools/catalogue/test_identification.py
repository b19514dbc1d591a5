"""Constants of one propeller from coefficients made with known ones."""

from __future__ import annotations

import numpy as np
import pytest

import propmap as pm
from propmap.catalogue.expected import POPULATION, PopulationPrior, constants_of
from propmap.catalogue.identified import PARAMETERS
from tools.catalogue.database import MeasuredPropeller
from tools.catalogue.identification import AxialTest, Identification, airfoil_of, identify
from tools.catalogue.verdict import conflict, verdict

BLADE = pm.propeller("uiuc-apce-10x5")
TRUTH = np.array([5.9, 2.2, 1.8, 0.26, -0.06, 0.018, -0.026, 0.15, -0.3, 0.08])
RPM = np.concatenate([np.linspace(2500.0, 6500.0, 9), np.full(12, 4000.0), np.full(12, 6500.0)])
ADVANCE = np.concatenate([np.zeros(9), *2 * [np.linspace(0.1, 0.65, 12)]])
RUN = np.repeat([0, 1, 2], [9, 12, 12])


def made(thrust: np.ndarray, power: np.ndarray) -> MeasuredPropeller:
    return MeasuredPropeller("x", "x", "x", 2, RPM, ADVANCE, thrust, power, RUN)


def coefficients(
    blade: pm.Propeller, law: pm.Airfoil, rpm: np.ndarray, advance: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """C_T and C_P by the rotor's own loads, which are evaluated another way than a fit's."""
    turns, diameter = rpm / 60.0, 2.0 * blade.radius
    loads = pm.Rotor(pm.Model(blade, law)).loads(2.0 * np.pi * turns, advance * turns * diameter, 0)
    thrust = loads.thrust / (1.225 * turns**2 * diameter**4)
    return thrust, 2.0 * np.pi * turns * loads.torque / (1.225 * turns**3 * diameter**5)


@pytest.fixture(scope="module")
def tested() -> MeasuredPropeller:
    return made(*coefficients(BLADE, airfoil_of(TRUTH), RPM, ADVANCE))


@pytest.fixture(scope="module")
def found(tested: MeasuredPropeller) -> Identification:
    wide = PopulationPrior(POPULATION.mean, 10.0 * POPULATION.deviation)
    return identify(AxialTest(BLADE, tested), wide)


def test_the_truth_is_found_where_the_prior_is_wide(found: Identification) -> None:
    apart = np.abs(found.constants - TRUTH) / np.sqrt(np.diag(found.covariance))
    assert apart.max() < 0.5
    sure = dict(zip(PARAMETERS, found.constants, strict=True))
    assert sure["c_l1"] == pytest.approx(5.9, rel=0.02)
    assert sure["zero_lift_angle"] == pytest.approx(-0.06, abs=0.003)
    assert sure["reynolds_camber"] == pytest.approx(-0.026, abs=0.004)
    assert max(found.thrust_rms, found.power_rms) < 3e-4


def test_without_rows_that_say_anything_the_prior_is_left(tested: MeasuredPropeller) -> None:
    """With a prior that is nearly certain, neither constants nor their errors move."""
    narrow = PopulationPrior(POPULATION.mean, 1e-3 * POPULATION.deviation)
    found = identify(AxialTest(BLADE, tested), narrow)
    np.testing.assert_allclose(found.constants, constants_of(POPULATION.mean), rtol=1e-2)
    assert found.held == pytest.approx(1.0, abs=1e-3)
    assert "from the prior" in verdict(tested, found)


def test_repeated_runs_that_disagree_are_told(found: Identification) -> None:
    thrust = np.where(RUN == 2, 1.12, 1.0) * np.interp(ADVANCE, [0.0, 0.7], [0.1, 0.0])
    tested = made(thrust, 0.5 * thrust + 0.02)
    assert conflict(tested) == (0.0, 0.0)  # at another rotational speed
    alike = tested._replace(rpm=np.where(RUN == 2, 4030.0, RPM))
    by_thrust, by_power = conflict(alike)
    assert 0.04 < by_thrust < 0.12 and 0.0 < by_power < by_thrust
    assert "runs at one rotational speed differ by" in verdict(alike, found)
    assert "differ" not in verdict(tested, found)
