"""Eqs. (5)-(7): forces of an element, loads of an annulus."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from propmap.physics.element import (
    Annulus,
    Station,
    annulus,
    annulus_loads,
    annulus_thrust,
    annulus_thrust_slope,
    element_forces,
)
from propmap.physics.geometry import make_blade
from propmap.physics.velocities import azimuth_nodes
from tests.physics.paper_physics import MU, RHO, TABLE_I, Law, drag, forces, medium, turn

N_B = 3.0
APC = TABLE_I["apc"]
LAWS = {
    **TABLE_I,
    "cambered": replace(APC, zero_lift_angle=-0.06),
    "simplified": replace(APC, attached=0.0),
}
every_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())

# One element per column: fast climb, hover, U_P < 0, reverse flow with U_P of both signs,
# stall, a driven blade, a pitched-down blade in reverse flow.
RADIUS = np.array([0.03, 0.07, 0.06, 0.025, 0.025, 0.04, 0.09, 0.03])
CHORD = np.array([0.02, 0.023, 0.022, 0.018, 0.018, 0.021, 0.011, 0.02])
TWIST = np.array([0.7, 0.36, 0.4, 0.75, 0.75, 0.6, 0.25, -0.3])
OMEGA = np.array([600.0, 500.0, 450.0, 300.0, 300.0, 200.0, 500.0, 250.0])
AXIAL = np.array([15.0, 0.0, -14.0, -6.0, 2.0, 0.0, 25.0, -1.0])
INPLANE = np.array([3.0, 0.0, 5.0, 18.0, 18.0, 1.0, 4.0, 20.0])
INFLOW = np.array([2.0, 4.0, 3.0, 1.0, 1.5, 0.2, -1.0, 0.5])
SINE = np.array([0.3, 0.0, -0.8, -1.0, -0.9, 1.0, 0.5, -0.95])
ELEMENT, FLOW = (RADIUS, CHORD, TWIST), (OMEGA, AXIAL, INPLANE)


def make(law: Law, element: tuple = ELEMENT, flow: tuple = FLOW) -> Annulus:
    radius, chord, twist = (jnp.asarray(a) for a in element)
    angle, per_speed = twist - law.zero_lift_angle, RHO / MU * chord
    station = Station(
        radius, chord, jnp.sin(angle), jnp.cos(angle), per_speed, 1.0 / jnp.sqrt(per_speed)
    )
    ends = (jnp.asarray(N_B), jnp.asarray(0.0), jnp.asarray(0.11))
    return Annulus(station, *(jnp.asarray(a) for a in flow), *ends, law.section())


def test_the_cases_cover_reverse_flow_and_flow_from_below() -> None:
    u_t, u_p = OMEGA * RADIUS + INPLANE * SINE, AXIAL + INFLOW
    for signs in ((u_t > 0) & (u_p > 0), (u_t > 0) & (u_p < 0), (u_t < 0) & (u_p > 0)):
        assert signs.any()
    assert ((u_t < 0) & (u_p < 0)).any()


@every_law
def test_element_forces_are_those_with_explicit_angles(law: Law) -> None:
    got = element_forces(make(law), jnp.asarray(INFLOW), jnp.asarray(SINE))[:2]
    expected = forces(law, ELEMENT, FLOW, INFLOW, SINE)
    # Rounding of the angles, 1e-15, times the blend's M; normal and tangential force of one
    # element may differ a hundredfold, hence the absolute part.
    for mine, literal in zip(got, expected, strict=True):
        np.testing.assert_allclose(mine, literal, rtol=1e-11, atol=1e-13)


@every_law
def test_written_out_slope_is_the_derivative_of_element_forces(law: Law) -> None:
    at, v, sine = make(law), jnp.asarray(INFLOW), jnp.asarray(SINE)
    normal, slope = jax.jvp(lambda x: element_forces(at, x, sine)[0], (v,), (jnp.ones_like(v),))
    got_slope = element_forces(at, v, sine).normal_slope
    assert np.max(np.abs(normal)) > 0.0
    np.testing.assert_allclose(got_slope, slope, rtol=1e-10)


def test_slope_is_a_central_difference_of_the_literal_force() -> None:
    h = 1e-5
    above = forces(APC, ELEMENT, FLOW, INFLOW + h, SINE)[0]
    below = forces(APC, ELEMENT, FLOW, INFLOW - h, SINE)[0]
    slope = element_forces(make(APC), jnp.asarray(INFLOW), jnp.asarray(SINE)).normal_slope
    # h^2 times a third derivative of about M^3/U^3, and rounding over h.
    np.testing.assert_allclose(slope, (above - below) / (2.0 * h), rtol=1e-6, atol=1e-8)


def test_a_blade_at_rest_in_still_air_has_no_force_and_finite_gradients() -> None:
    element, still = (np.array([0.05]), np.array([0.02]), np.array([0.4])), (np.zeros(1),) * 3

    def total(v: jax.Array, omega: jax.Array, inplane: jax.Array) -> jax.Array:
        at = make(APC, element, still)._replace(omega=omega, v_inplane=inplane)
        normal, tangential, *_ = element_forces(at, v, jnp.asarray(0.5))
        return jnp.sum(normal + 2.0 * tangential)

    zero = jnp.zeros(1)
    value, gradient = jax.value_and_grad(total, (0, 1, 2))(zero, zero, zero)
    assert abs(float(value)) < 1e-12  # the floor of 1e-9 m/s to the power of 1.5
    assert np.all(np.isfinite(gradient))
    assert np.all(np.isfinite(element_forces(make(APC, element, still), zero, zero)))


def test_reverse_flow_at_the_retreating_root_pushes_down() -> None:
    # 100 rad/s at 0.03 m is 3 m/s, less 10 m/s in the plane: U_T = -7 m/s, U_P = 0.  The
    # trailing edge leads, and with a twist of 0.3 rad it is the lower one: the blade meets
    # the air like a plate pitched DOWN by 0.3 rad.  So the force is downwards.
    # phi = pi, alpha = 0.3 - pi = -2.8416, sin = -0.29552, cos = -0.95534, stalled, hence
    # C_L = 1.7 * 0.28232 = 0.47995; dL cos(phi) = -(49/2) * 0.02 * 0.47995 = -0.23518.
    # The drag pushes the blade on in its rotation: -(dD) with C_D = 1.8 * 0.29552^2 + ...
    # With arctan instead of arctan2, phi = 0, alpha = +0.3 and the force is upwards.
    element, flow = ([0.03], [0.02], [0.3]), ([100.0], [0.0], [10.0])
    frictionless = replace(APC, c_p=0.0, c_d0=0.0)
    at = make(frictionless, tuple(map(np.array, element)), tuple(map(np.array, flow)))
    normal, tangential, *_ = element_forces(at, jnp.zeros(1), jnp.asarray(-1.0))
    assert float(normal[0]) == pytest.approx(-0.23518, rel=1e-4)
    assert float(tangential[0]) == pytest.approx(-0.5 * 49.0 * 0.02 * 1.8 * 0.29552**2, rel=1e-4)


def test_friction_in_an_annulus_is_that_of_equation_4() -> None:
    # A blade edge on, without lift: only c_d0 and the 1/sqrt(Re) term remain.
    element = (np.array([0.08]), np.array([0.015]), np.array([0.0]))
    at = make(APC, element, (np.array([500.0]), np.zeros(1), np.zeros(1)))
    tangential = element_forces(at, jnp.zeros(1), jnp.asarray(0.0))[1]
    c_d = drag(0.0, RHO * 40.0 * 0.015 / MU, APC)
    assert float(tangential[0]) == pytest.approx(0.5 * 40.0**2 * 0.015 * c_d, rel=1e-12)


@pytest.mark.parametrize("azimuths", [1, 2, 6, 12])
def test_annulus_loads_are_equations_5_to_7(azimuths: int) -> None:
    # Averages over a whole turn, written out; with one node only the axial flow counts.
    sines = turn(azimuths) if azimuths > 1 else np.zeros(1)
    column = tuple(a[:, None] for a in ELEMENT), tuple(a[:, None] for a in FLOW)
    normal, tangential = forces(APC, *column, INFLOW[:, None], sines[None, :])
    at, v, nodes = make(APC), jnp.asarray(INFLOW), azimuth_nodes(azimuths)
    got = annulus_loads(at, v, nodes)
    expected = (
        N_B * np.mean(normal, axis=1),  # (5)
        N_B * np.mean(tangential * sines, axis=1),  # (6)
        N_B * RADIUS * np.mean(tangential, axis=1),  # (7)
        N_B * RADIUS * np.mean(normal * sines, axis=1),
        0.0 * INFLOW,
        0.0 * INFLOW,
    )
    for mine, literal in zip(got, expected, strict=True):
        np.testing.assert_allclose(mine, literal, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(annulus_thrust(at, v, nodes), got.thrust, rtol=1e-13)
    thrust, slope = annulus_thrust_slope(at, v, nodes)
    np.testing.assert_allclose(thrust, got.thrust, rtol=1e-11)
    h = 1e-5
    above, below = (
        N_B * np.mean(forces(APC, *column, x[:, None], sines)[0], axis=1)
        for x in (INFLOW + h, INFLOW - h)
    )
    np.testing.assert_allclose(slope, (above - below) / (2.0 * h), rtol=1e-6, atol=1e-7)


def test_zero_lift_angle_turns_the_blade() -> None:
    cambered = LAWS["cambered"]
    turned = (RADIUS, CHORD, TWIST - cambered.zero_lift_angle)
    v, sine = jnp.asarray(INFLOW), jnp.asarray(SINE)
    for a, b in zip(
        element_forces(make(cambered), v, sine),
        element_forces(make(APC, turned), v, sine),
        strict=True,
    ):
        np.testing.assert_allclose(a, b, rtol=1e-13)


def test_friction_is_gone_at_a_pointed_tip_with_a_finite_gradient() -> None:
    stations, twist = np.array([0.02, 0.04, 0.07, 0.1]), np.array([0.5, 0.4, 0.3, 0.2])

    def force(tip_chord: jax.Array) -> jax.Array:
        chord = jnp.array([0.02, 0.02, 0.015, 0.0]).at[-1].add(tip_chord)
        blade = make_blade(
            jnp.asarray(stations), chord, jnp.asarray(twist), jnp.asarray(2.0), jnp.asarray(0.02)
        )
        flow = (jnp.asarray([500.0]), jnp.zeros(1), jnp.zeros(1))
        at = annulus(blade, APC.section(), medium(), jnp.asarray([[0.1]]), *flow)
        return element_forces(at, jnp.ones((1, 1)), jnp.asarray(0.0)).tangential[0, 0]

    value, slope = jax.value_and_grad(force)(jnp.asarray(0.0))
    assert abs(float(value)) < 1e-9
    assert np.isfinite(float(slope))


def test_a_section_meets_the_reynolds_number_of_its_chord() -> None:
    stations = jnp.array([0.02, 0.04, 0.07, 0.1])
    chord, twist = jnp.full(4, 0.021), jnp.full(4, 0.3)
    blade = make_blade(stations, chord, twist, jnp.asarray(2.0), jnp.asarray(0.02))
    flow = (jnp.asarray([500.0]), jnp.zeros(1), jnp.zeros(1))
    at = annulus(blade, APC.section(), medium(), jnp.asarray([[0.05]]), *flow)
    per_speed = RHO * 0.021 / MU
    assert float(at.station.reynolds_per_speed[0, 0]) == pytest.approx(per_speed, rel=1e-14)
    assert float(at.station.inverse_root[0, 0]) == pytest.approx(per_speed**-0.5, rel=1e-14)
