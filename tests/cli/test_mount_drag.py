"""By name rotor drag is that of the installed rotor; output says which it is."""

from __future__ import annotations

import json

import numpy as np
import pytest

import propmap
from propmap.model.corrections import TYPICAL_FACTOR, Installed

from .conftest import BETA, POINT, ROTOR, RPM, SPEED, Run

NAMED = ("predict", "apc 8x6e", *POINT)


def drag(run: Run, *asked: str) -> dict[str, float]:
    return dict(json.loads(run(*asked, "--format", "json").out))


def test_by_name_it_is_installed_and_bare_where_that_is_asked_for(run: Run) -> None:
    whole, bare = drag(run, *NAMED), drag(run, *NAMED, "--bare")
    blades = bare["drag_N"]
    across, along = SPEED * np.sin(np.radians(BETA)), SPEED * np.cos(np.radians(BETA))
    model = propmap.known_model("apc 8x6e")
    at = (RPM * np.pi / 30.0, SPEED, np.radians(BETA))
    inflow = np.asarray(propmap.Rotor(model).loads(*at).mean_inflow)
    want = Installed().drag(0.1016, 1.225, along, across, inflow, np.asarray(blades))
    assert whole["drag_N"] == pytest.approx(float(want), rel=1e-6)
    assert whole["thrust_N"] == bare["thrust_N"] and whole["torque_Nm"] == bare["torque_Nm"]
    # Nothing else is known of the mount: a factor of about two either way.
    assert 0.25 < whole["drag_std_N"] / whole["drag_N"] < 0.45 < 1.5 * 0.45
    assert bare["drag_std_N"] < 0.15 * blades


def test_output_says_which(run: Run) -> None:
    told = [" ".join(run(*NAMED, *more).out.split()) for more in ((), ("--bare",))]
    assert f"of the installed rotor: {TYPICAL_FACTOR[0]:g} (+- " in told[0]
    assert "that of bare blades" in told[1] and "correction installed" in told[1]
    stated = run(*NAMED, "--correction", "installed:factor=2,area_m2=0.001").out
    assert "2 times the drag of the blades, plus the drag of 10 cm^2" in " ".join(stated.split())


def test_a_law_that_is_named_and_the_paper_s_model_are_bare(run: Run, rotor: propmap.Rotor) -> None:
    found = rotor.loads(RPM * np.pi / 30.0, SPEED, np.radians(BETA))
    asked = drag(run, "predict", *ROTOR, *POINT)
    assert asked["drag_N"] == pytest.approx(float(found.drag), rel=1e-9)
    paper, bare = drag(run, *NAMED, "--model", "paper"), drag(run, *NAMED, "--bare")
    assert paper["drag_N"] < 1.2 * bare["drag_N"]
