"""The tethered quadrotor: balanced, and the hover model off as physics says."""

from __future__ import annotations

import numpy as np
import pytest

import propmap
from papers.gill_dandrea_2017.level_circles import (
    Case,
    Circles,
    circles,
    hover_failure,
    quadrotor,
)
from propmap.units import GRAVITY

SPEED = np.array([0.0, 2.0, 4.0, 6.0, 8.0])


def test_where_the_hover_model_fails() -> None:
    nothing = {name: np.zeros(5) for name in Circles._fields}
    share = np.array([0.001, -0.03, -0.12, -0.02, 0.02])
    found = Circles(**(nothing | {"speed": SPEED, "hover_error": 2.0 * GRAVITY * share}))
    failure = hover_failure(found, mass=2.0)
    assert failure.exceeds[0] == pytest.approx(2.0 + 2.0 * 0.02 / 0.09)
    assert failure.exceeds[1] == pytest.approx(2.0 + 2.0 * 0.07 / 0.09)
    # Rounding above zero in hover is no change of sign.
    assert failure.sign_changes == pytest.approx(7.0)
    below = Circles(**(nothing | {"speed": SPEED, "hover_error": -2.0 * GRAVITY * SPEED / 100}))
    assert hover_failure(below, mass=2.0).sign_changes is None


def test_circles_balance_weight_and_drag() -> None:
    case = Case(0.5, 0.0)
    found = circles(quadrotor(case), propmap.airfoil("paper-soft"), np.array([0.0, 3.0, 8.0, 14.0]))
    up = found.thrust * np.cos(found.pitch) + found.drag * np.sin(found.pitch)
    # The rotors' velocities differ a little in direction on so narrow a circle.
    assert up == pytest.approx(0.5 * GRAVITY, rel=5e-3)
    assert found.thrust[1:] * np.tan(found.pitch[1:]) == pytest.approx(found.drag[1:], rel=0.02)
    assert found.pitch[0] == pytest.approx(0.0, abs=1e-6)
    assert abs(found.hover_error[0]) < 2e-3 * 0.5 * GRAVITY
    # Fresh air carries: at the rotor speeds needed the hover model predicts too little.
    assert (found.rotor_speed[1:] < found.rotor_speed[0]).all()
    assert (found.hover_error[1:] < 0.0).all()
    vehicle, law = quadrotor(Case(0.5, 0.04)), propmap.airfoil("paper-soft")
    dragged = circles(vehicle, law, np.array([3.0, 8.0, 14.0]))
    assert (dragged.pitch > found.pitch[1:]).all()
    assert dragged.hover_error[0] < 0.0 < dragged.hover_error[-1]
