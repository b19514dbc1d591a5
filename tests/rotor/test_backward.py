"""Rotors that turn backward: mirror images, continuity where the rotation reverses, bands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap as pm
from propmap.loads import LOADS

PLATE = pm.Airfoil(
    c_l1=0.0,
    c_l2=2.0,
    c_d=2.0,
    alpha_0=0.3,
    zero_lift_angle=0.0,
    lift_law="simplified",
    name="plate",
)
"""The law of footnote 1 without camber, which is the same for flow from both edges."""
ANGLES = np.linspace(-np.pi, np.pi, 181)
TABLE = pm.SectionTable(
    ANGLES, [5e4], [np.sin(2.0 * ANGLES)], [0.03 + 2.0 * np.sin(ANGLES) ** 2], name="table"
)
"""The same lift as a table."""
BLADE = pm.propeller("apc-8x6e")
ROTOR = pm.Rotor(pm.catalogue_model("APC 8x6E"))
SYMMETRIC = [pm.Rotor(pm.Model(BLADE, law)) for law in (PLATE, TABLE)]
VELOCITY = np.array([[0.0, 0.0, 0.0], [8.0, 0.0, 2.0], [3.0, -6.0, -1.0], [0.0, 0.0, 9.0]])


@pytest.mark.parametrize("law", [PLATE, TABLE], ids=lambda law: law.name)
def test_the_loads_of_a_symmetric_plate_are_those_of_the_rotor_upside_down(
    law: pm.Airfoil | pm.SectionTable,
) -> None:
    corrections = map(pm.correction, ("pitt-peters", "radial-friction", "tip-loss", "installed"))
    rotor = pm.Rotor(pm.Model(BLADE, law, corrections=tuple(corrections)))
    upside_down = np.array([1.0, -1.0, -1.0])  # half a turn about x
    back = rotor.wrench(-600.0, VELOCITY)
    ahead = rotor.wrench(600.0, VELOCITY * upside_down)
    for found, expected in ((back.force, ahead.force), (back.moment, ahead.moment)):
        np.testing.assert_allclose(found, expected * upside_down, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("beta", np.radians([0.0, 50.0, 90.0, 140.0, 180.0]))
@pytest.mark.parametrize("rotor", [ROTOR, *SYMMETRIC], ids=["catalogue", "plate", "table"])
def test_loads_in_wind_are_continuous_where_the_rotation_reverses(
    rotor: pm.Rotor, beta: float
) -> None:
    step = 1e-3
    omega = np.array([-3.0, -2.0, -1.0, 0.0, 1.0, 2.0]) * step
    loads = rotor.loads(omega, 12.0, beta)
    for name in LOADS:
        values = getattr(loads, name)
        steepest = 3.0 * np.abs(np.diff(values[3:])).max() + 1e-9
        assert np.abs(np.diff(values)).max() <= steepest, name


def test_a_cambered_propeller_has_less_thrust_backward_and_takes_power() -> None:
    ahead, back = (ROTOR.loads(omega, 0.0, 0.0) for omega in (600.0, -600.0))
    assert 0.4 < -back.thrust / ahead.thrust < 0.8
    assert back.torque < 0.0 < back.power
    assert back.status == "reversed"
    assert back.reverse_flow == 1.0
    assert back.mean_inflow < 0.0
    law = replace(PLATE, zero_lift_angle=-0.07)
    flat, cambered = (
        -pm.Rotor(pm.Model(BLADE, one)).loads(-600.0, 0.0, 0.0).thrust for one in (PLATE, law)
    )
    # The camber of an arc reduces the angle of attack.
    assert cambered < 0.9 * flat


def test_the_ground_below_is_a_ceiling_for_the_rotor_upside_down() -> None:
    rotor = pm.Rotor(pm.Model(BLADE, PLATE))
    back, ahead = (
        rotor.loads(-600.0, 0.0, 0.0, height=0.1),
        rotor.loads(600.0, 0.0, 0.0, ceiling=0.1),
    )
    assert back.thrust == pytest.approx(-ahead.thrust, rel=1e-9)
    assert ahead.thrust > 1.02 * rotor.loads(600.0, 0.0, 0.0).thrust


def test_points_in_both_directions_have_the_bands_of_single_points() -> None:
    omega = np.array([-600.0, 600.0])
    both = ROTOR.loads(omega, 5.0, 1.0)
    for k, one in enumerate(omega.tolist()):
        alone = ROTOR.loads(one, 5.0, 1.0)
        assert both.thrust[k] == alone.thrust
        assert both.std.thrust[k] == pytest.approx(float(alone.std.thrust), rel=1e-12)
        assert both.std.power[k] > 0.0
    share = both.std.thrust / np.abs(both.thrust)
    assert share[0] > 2.0 * share[1]


def test_functions_without_backward_rotation_refuse_a_negative_omega() -> None:
    refusals = (
        lambda: ROTOR.gradients(["omega"], -600.0, 0.0, 0.0),
        lambda: ROTOR.inflow(-600.0, 0.0, 0.0),
        lambda: ROTOR.hover_inflow(-600.0),
        lambda: pm.DynamicInflow(ROTOR).steady(-600.0, [1.0, 0.0, 0.0]),
    )
    for call in refusals:
        with pytest.raises(pm.InputError, match=r"omega is negative \(-600\)"):
            call()
