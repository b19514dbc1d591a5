"""Fits start from what propellers let expect; a thrust test that went astray without."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.catalogue.identified import PARAMETERS
from propmap.cli.fit import FitChoice, section_prior
from propmap.fit.files import FitFile, read_fit
from propmap.fit.parameters import Choice
from propmap.loads import LOADS
from propmap.model.airfoil import Airfoil, parameter_set

from .conftest import Run
from .fit_inputs import fit_record

FIVE = ("c_l1", "c_l2", "c_d", "alpha_0", "zero_lift_angle")


def chosen(
    wanted: str | None = None, prop: str = "apc-8x6e", base: Airfoil | None = None, **stated: Any
) -> Choice:
    """As `fit tunnel` chooses."""
    asked = FitChoice(prior_from=wanted, **stated)
    expected = asked.expected(prop, propmap.propeller("apc-8x6e"), base)
    return asked.chosen(FIVE, base, expected=expected)


def test_all_constants_from_the_family_by_default() -> None:
    choice = chosen()
    assert choice.free == PARAMETERS
    assert choice.expected is not None and "family apce" in choice.expected.source
    # The search starts at the most likely constants.
    assert np.abs(choice.prior_residuals(choice.first)[0]).max() < 1e-9


def test_whoever_says_what_to_fit_gets_that_and_no_more() -> None:
    four = chosen(free="c_l1,c_l2,c_d,alpha_0")
    assert four == Choice()
    assert four.first.tolist() == [2.0 * np.pi, 2.0, 0.0, 0.47]
    law = parameter_set("paper-apc")
    based = chosen(base=law)
    assert based.expected is None and based.free == FIVE and based.fixed["c_d0"] == law.c_d0
    assert chosen("none").free == FIVE and chosen("none").fixed == {}


def test_what_is_stated_wins_over_the_prior() -> None:
    choice = chosen(fix=["c_d=1.5"], prior=["c_l2=1.9:0.2", "c_l1=5:0.1"])
    assert "c_d" not in choice.free and choice.fixed["c_d"] == 1.5
    assert "c_l2" in choice.free and "c_l2" not in choice.fixed
    told = choice.prior_of("c_l1")
    assert told is not None and (told.mean, told.deviation) == (5.0, 0.1)
    few = chosen("family", free="c_l1", base=parameter_set("paper-apc"))
    assert few.expected is not None and few.fixed["c_l2"] == parameter_set("paper-apc").c_l2


@pytest.mark.parametrize(
    ("wanted", "prop", "says"),
    [
        ("family", "apc-8x6e", "16 propellers of the family apce"),
        ("family", "uiuc-apcsf-10x7", "of the family apcsf"),
        ("family", "my-blade.csv", "small propellers of all families"),
        ("family", "HQ 5x4.3x3", "small propellers of all families"),
        ("population", "apc-8x6e", "small propellers of all families"),
        ("gwsdd", "my-blade.csv", "13 propellers of the family gwsdd"),
        (" Family", "apc-8x6e", "without the catalogue constants of"),
    ],
)
def test_whose_prior(wanted: str, prop: str, says: str) -> None:
    blade = None if prop == "my-blade.csv" else propmap.propeller(prop)
    prior = section_prior(wanted, prop, blade, by_default=False)
    assert prior is not None and says in prior.source


def deviations(file: FitFile, speed: float, beta: float) -> float:
    """Standard deviation of thrust over thrust at 6000 rpm, by derivatives of its own."""
    rotor = propmap.Rotor(file.model)
    assert file.covariance is not None
    omega, v = np.array([200.0 * np.pi]), np.array([speed])
    flow = omega, v * np.cos(beta), v * np.sin(beta)
    names = file.covariance.names
    found = rotor.gradients(names, *flow)
    k = list(LOADS).index("thrust")
    slope = found.slopes[k, :, 0]
    return float(np.sqrt(slope @ file.covariance.matrix @ slope) / abs(found.loads[k, 0]))


@pytest.mark.slow
def test_thrust_alone_at_low_speed_leaves_physical_constants(run: Run) -> None:
    """APC 8x4.5MR at 0 and 5 m/s, Davoudi & Duraisamy 2019: without a prior the fit ends at c_l1
    above 10 and c_d = 0, and extrapolates badly."""
    done = run(
        "fit", "tunnel", "apc-8x4.5mr", "davoudi-8x4.5mr-thrust", "--starts", "1", "--folds", "0",
        "-o", "fit.toml",
    )  # fmt: skip
    assert done.code == 0
    assert (
        "note: the prior of the section constants is from small propellers of all families"
        in done.err
    )
    law, found = parameter_set("fit.toml"), fit_record(Path("fit.toml"))
    assert 4.0 < law.c_l1 < 8.0 and 1.0 < law.c_d < 5.0
    assert 0.2 < law.alpha_0 < 0.4 and -0.1 < law.zero_lift_angle < 0.0 and 0.0 < law.c_d0 < 0.05
    held = [n for n, p in found["parameters"].items() if "held by its prior" in p["verdict"]]
    # Thrust tells of lift, not of drag; how far the blade is turned is not known to a degree.
    assert {"c_d", "c_d0", "alpha_0"} <= set(held) and "zero_lift_angle" not in held
    assert not any(found["parameters"][name]["identified"] for name in held)
    file = read_fit(Path("fit.toml"))
    for degrees in (60.0, 90.0):
        slow = deviations(file, 5.0, np.radians(degrees))
        assert slow < 0.08
        for speed in (10.0, 15.0):
            assert deviations(file, speed, np.radians(degrees)) > 1.2 * slow
