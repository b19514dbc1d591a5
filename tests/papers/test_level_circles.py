"""The tethered quadrotor: balanced, and the hover model off as physics says."""

from __future__ import annotations

import numpy as np
import pytest

import propmap
from papers.gill_dandrea_2017.level_circles import (
    Case,
    Circles,
    circles,
    first_crossing,
    hover_failure,
    quadrotor,
    static_inflow,
)
from papers.gill_dandrea_2017.paper import blade
from propmap.loads import LOADS
from propmap.units import GRAVITY

SPEED = np.array([0.0, 2.0, 4.0, 6.0, 8.0])


def test_first_crossing() -> None:
    assert first_crossing(SPEED, np.array([-1.0, -1.0, 1.0, -1.0, 1.0])) == pytest.approx(3.0)
    assert first_crossing(SPEED, np.array([-1.0, -3.0, -2.0, -1.0, 0.0])) == pytest.approx(8.0)
    assert first_crossing(SPEED, np.array([1.0, 2.0, -1.0, -2.0, -3.0])) is None


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


def test_static_inflow_carries_a_quarter_of_the_weight() -> None:
    case = Case(0.8, 0.0)
    vehicle, v = quadrotor(case), static_inflow(case)
    disk = np.pi * vehicle.propeller.radius**2
    assert 4.0 * 2.0 * vehicle.air.density * disk * v**2 == pytest.approx(0.8 * GRAVITY)


def test_blades_at_other_stations_have_the_same_loads() -> None:
    law = propmap.airfoil("paper-stiff").with_parameters(zero_lift_angle=-0.07)
    speed, beta = np.array([0.0, 6.0, 6.0, 14.0]), np.radians([0.0, 30.0, 90.0, 90.0])
    for name in ("apc-8x4.5mr", "apc-11x7e"):
        own = propmap.Rotor(propmap.Model(propmap.propeller(name), law)).loads(600.0, speed, beta)
        other = propmap.Rotor(propmap.Model(blade(name), law)).loads(600.0, speed, beta)
        for load in LOADS:
            expected, most = getattr(own, load), 1e-3 * np.abs(getattr(own, load)).max()
            assert getattr(other, load) == pytest.approx(expected, abs=most), (name, load)
    half, full = blade("apc-8x4.5mr", 0.05), blade("apc-8x4.5mr")
    assert half.radius == pytest.approx(0.05)
    assert half.chord.max() / 0.05 == pytest.approx(full.chord.max() / 0.1016, rel=1e-6)


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
