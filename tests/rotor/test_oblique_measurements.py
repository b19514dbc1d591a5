"""The recommended model against the oblique campaign of 2019: what was fitted and what was not."""

from __future__ import annotations

import numpy as np
import pytest

import propmap
from propmap.catalogue.lookup import measurement
from propmap.fit.least_squares import rms
from propmap.results import Loads

DATA = measurement("gill-dandrea-2019-8x6e")
SOME = np.arange(0, DATA.omega.size, 3)
"""Every third point, for time."""


def _loads(model: str) -> Loads:
    rotor = propmap.Rotor(
        propmap.Model(
            propmap.propeller("apc-8x6e"),
            propmap.airfoil("apc-8x6e-2019"),
            propmap.Air(density=DATA.air_density),
            propmap.model_corrections(model),
        ),
    )
    return rotor.loads(*(values[SOME] for values in (DATA.omega, DATA.speed, DATA.beta)))


@pytest.fixture(scope="module")
def recommended() -> Loads:
    return _loads("recommended")


def _off(loads: Loads, name: str) -> float:
    measured = DATA.loads[name][SOME]
    return rms(getattr(loads, name) - measured) / rms(measured)


def test_fitted_loads_and_the_rolling_moment_come_out(recommended: Loads) -> None:
    for name in ("thrust", "torque"):
        assert _off(recommended, name) <= 0.03, name
    # Not fitted; a quarter too large where a rolling moment induces no inflow.
    assert _off(recommended, "roll_moment") <= 0.06
    assert _off(_loads("paper"), "roll_moment") > 0.2


def test_the_pitching_moment_has_the_measured_sign(recommended: Loads) -> None:
    measured = DATA.loads["pitch_moment"][SOME]
    assert (recommended.pitch_moment[measured != 0.0] * measured[measured != 0.0] > 0.0).all()


def test_the_campaign_has_more_drag_than_the_blades(recommended: Loads) -> None:
    """Nothing is tuned to it: whoever changes that has to change what the documents say."""
    assert 1.9 < rms(DATA.loads["drag"][SOME]) / rms(recommended.drag) < 2.6
