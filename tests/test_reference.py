"""The plain reference: by hand, beside the frozen literal loads, and beside the rotor."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import propmap as pm
from papers.gill_dandrea_2017 import reference
from papers.gill_dandrea_2017.reference import Case
from tests.oracle.make_reference import frozen_rows

BLADE = pm.propeller("apc-8x6e")
LAW = pm.airfoil("paper-apc")
BEYOND = {"zero_lift_angle": -0.05, "reynolds_camber": -0.02, "drag_angle": 0.07}
BEYOND |= {"reynolds_lift": 0.12, "reynolds_drag": -0.35}
"""Constants that the paper does not have, as small propellers have them."""

MODELS = {
    "paper": pm.Model(BLADE, LAW),
    "recommended": pm.Model(BLADE, LAW, corrections=pm.model_corrections("recommended")),
    "recommended with camber": pm.Model(
        BLADE, LAW.with_parameters(**BEYOND), corrections=pm.model_corrections("recommended")
    ),
}

FEW = [(600.0, 4.0, 0.0), (600.0, 16.0, 180.0), (600.0, 5.0, 180.0)]
"""Omega [rad/s], V [m/s] and beta [deg]: hover's neighbor, windmill, vortex ring."""

MANY = [
    *((350.0, 0.0, 0.0), (1000.0, 0.0, 0.0), (600.0, 18.0, 0.0), (300.0, 15.0, 0.0)),
    *((600.0, 3.0, 30.0), (600.0, 8.0, 45.0), (600.0, 2.0, 85.0), (800.0, 15.0, 60.0)),
    *((400.0, 10.0, 70.0), (600.0, 10.0, 90.0), (900.0, 20.0, 90.0), (300.0, 12.0, 90.0)),
    *((600.0, 9.0, 180.0), (600.0, 7.0, 170.0), (600.0, 6.0, 150.0), (700.0, 4.0, 130.0)),
    *((600.0, 4.0, 110.0), (600.0, 10.0, 95.0), (600.0, 12.0, 120.0), (600.0, 25.0, 180.0)),
    *((600.0, 18.0, 170.0), (400.0, 15.0, 150.0)),
]
"""Hover, climb, oblique and edgewise flight, descent with the vortex ring, windmill."""

MORE_RADII = {(600.0, 12.0, 120.0): 400}
"""There a wide stretch stalls at once, and one annulus of 200 is 0.16 % of the static thrust."""


def flow(speed: float, beta_deg: float) -> tuple[float, float]:
    """V cos(beta) and V sin(beta) [m/s], without rounding where one of them is zero."""
    beta = math.radians(beta_deg)
    axial = 0.0 if beta_deg == 90.0 else speed * math.cos(beta)
    return axial, 0.0 if beta_deg in (0.0, 180.0) else speed * math.sin(beta)


def differences(model: pm.Model, point: tuple[float, float, float], *steps: int) -> Any:
    """Differences of the six loads, as shares of its thrust (times R) and torque at rest."""
    omega, speed, beta = point
    axial, across = flow(speed, beta)
    rotor = pm.Rotor(model, accuracy="fine")
    want = rotor.loads_at_velocity(omega, [across, 0.0, axial])
    rest = rotor.loads(omega, 0.0, 0.0)
    thrust, torque = float(rest.thrust), float(rest.torque)
    moment = thrust * BLADE.radius
    got = reference.loads(model, omega, axial, across, *steps)
    scales = (thrust, thrust, torque, moment, thrust, moment)
    return [
        (value - float(getattr(want, name))) / scale
        for name, value, scale in zip(got._fields, got, scales, strict=True)
    ]


def case(law: pm.Airfoil = LAW, **changes: Any) -> Case:
    """A case at one radius and one azimuth, pi/2."""
    whole: dict[str, Any] = {
        "omega": 600.0,
        "v_axial": 2.0,
        "v_inplane": 8.0,
        "y": np.array([0.07]),
        "dy": 0.01,
        "psi": np.array([0.5 * np.pi]),
        "chord": lambda y: 0.02 + 0.0 * y,
        "twist": lambda y: 0.3 + 0.0 * y,
    }
    return Case(model=pm.Model(BLADE, law), airfoil=law, **(whole | changes))


# Each equation by hand.


def test_lift_is_equation_3_as_printed() -> None:
    """Where the printed sigma does not overflow."""
    a = np.linspace(-1.2, 1.2, 101)
    falling, rising = np.exp(-50.0 * (a - LAW.alpha_0)), np.exp(50.0 * (a + LAW.alpha_0))
    sigma = (1.0 + falling + rising) / ((1.0 + falling) * (1.0 + rising))
    printed = (1.0 - sigma) * LAW.c_l1 * a + sigma * LAW.c_l2 * np.sin(a) * np.cos(a)
    np.testing.assert_allclose(reference.lift_coefficient(a, LAW), printed, atol=1e-12)


def test_footnote_1_is_the_simplified_lift() -> None:
    """And far past stall, where nothing is attached, a plate has its own lift."""
    law = LAW.with_parameters(lift_law="simplified")
    a = np.array([0.25 * np.pi, -0.25 * np.pi, 2.0])
    want = [0.5 * law.c_l2, -0.5 * law.c_l2, law.c_l2 * math.sin(2.0) * math.cos(2.0)]
    np.testing.assert_allclose(reference.lift_coefficient(a, law), want)
    share = 0.5 / (0.56 + 0.44 * math.sqrt(0.5))
    found = reference.lift_coefficient(a[:1], LAW.with_parameters(lift_law="plate"))
    np.testing.assert_allclose(found, share * LAW.c_l2, rtol=1e-8)


def test_drag_is_equation_4() -> None:
    """At Re = 10 404, whose root is 102, friction is 2 c_p / 100; across the flow c_d is added."""
    got = reference.drag_coefficient(np.array([0.0, 0.5 * np.pi]), np.full(2, 10404.0), LAW)
    np.testing.assert_allclose(got, [0.02656 + 0.01, 1.8 + 0.02656 + 0.01])


def test_angles_come_within_half_a_turn() -> None:
    got = reference.wrapped(np.array([np.pi, -np.pi, 1.5 * np.pi, -1.5 * np.pi, 0.3]))
    np.testing.assert_allclose(got, [np.pi, np.pi, -0.5 * np.pi, 0.5 * np.pi, 0.3])


def test_the_element_is_in_the_air_of_equations_1_and_2() -> None:
    """On the advancing side U_T is 50 m/s, U_P 5 m/s; without drag the lift is across the flow."""
    law = LAW.with_parameters(c_d=0.0, c_d0=0.0, c_p=0.0)
    at = case(law)
    normal, tangential = reference.blade_element(at, 0.07, 3.0)
    alpha = 0.3 - math.atan(0.1)
    lift = 0.5 * 1.225 * (50.0**2 + 5.0**2) * 0.02
    lift *= float(reference.lift_coefficient(np.array([alpha]), law)[0])
    np.testing.assert_allclose(np.hypot(normal, tangential), lift)
    np.testing.assert_allclose(tangential / normal, 0.1)


def test_air_from_behind_pushes_backwards() -> None:
    """On the retreating side of fast flight a flat section is blown along the rotation."""
    at = case(omega=50.0, v_axial=0.0, v_inplane=20.0, psi=np.array([1.5 * np.pi]))
    at = replace(at, twist=lambda y: 0.0 * y)
    normal, tangential = reference.blade_element(at, 0.07, 0.0)
    assert tangential[0] < 0.0
    assert abs(normal[0]) < 1e-12


def test_means_over_a_turn_are_equations_5_to_7() -> None:
    """Two azimuths on which forces are known: half of their sums and differences."""
    both = case(psi=np.array([0.5, 1.5]) * np.pi)
    v_i = np.full((1, 2), 3.0)
    (n1, n2), (t1, t2) = (part[0] for part in reference.blade_element(both, both.y[:, None], v_i))
    got = reference.disk_loads(both, v_i)
    assert got.thrust == pytest.approx(0.01 * (n1 + n2))  # N_b / 2 = 1, dy = 0.01
    assert got.drag == pytest.approx(0.01 * (t1 - t2))
    assert got.torque == pytest.approx(0.01 * 0.07 * (t1 + t2))
    assert got.roll_moment == pytest.approx(0.01 * 0.07 * (n1 - n2))
    assert reference.annulus_thrust(both, 0.07, np.array([3.0]))[0] == pytest.approx(n1 + n2)


def test_momentum_is_equations_9_and_10() -> None:
    """Across 4 m/s and through 3 m/s make 5 m/s; in axial flow U_P alone counts."""
    at = case(v_axial=1.0, v_inplane=4.0)
    per = 4.0 * 1.225 * math.pi * 0.07
    assert reference.momentum_thrust(at, 0.07, 2.0) == pytest.approx(per * 2.0 * 5.0)
    at = case(v_axial=1.0, v_inplane=0.0)
    assert reference.momentum_thrust(at, 0.07, 2.0) == pytest.approx(per * 2.0 * 3.0)


@pytest.mark.parametrize("v_inplane", [0.0, 0.5, 2.0, 5.0])
def test_momentum_on_the_windmill_branch_is_positive_and_rises(v_inplane: float) -> None:
    """In windmill descent, where the wake is above the disk, nothing of (8) is negated."""
    at = case(v_axial=-8.0, v_inplane=v_inplane, windmill=True)
    v_i = np.linspace(0.01, 20.0, 4000)
    thrust = reference.momentum_thrust(at, 0.07, v_i)
    assert (thrust > 0.0).all()
    assert (np.diff(thrust) > -1e-9).all()
    assert np.diff(thrust).max() < 0.2  # without a jump
    slow = v_i < 3.9 if v_inplane == 0.0 else v_i < 0.0  # before 2 v_i = |V cos(beta)|: eq. (10)
    np.testing.assert_allclose(
        thrust[slow], reference.momentum_thrust(replace(at, windmill=False), 0.07, v_i[slow])
    )


def test_the_largest_root_of_equation_11_is_taken() -> None:
    """Between it and any larger inflow the momentum has more thrust than the blades."""
    blade = reference.make_case(MODELS["paper"], 628.0, 0.0, 0.0, 60, 12)
    found = reference.annulus_inflow(blade, 0.038)

    def more(v: Any) -> Any:
        return reference.annulus_thrust(blade, 0.038, v) - reference.momentum_thrust(
            blade, 0.038, v
        )

    assert abs(more(np.array([found]))[0]) < 1e-8
    assert (more(np.linspace(1.0001 * found, 60.0, 20000)) < 0.0).all()


def ideal_rotor() -> pm.Model:
    """Constant chord, twist 0.08 R/y and no drag: the inflow in hover is uniform."""
    y = np.linspace(0.02, 0.2, 80)
    blade = pm.Propeller("ideal", 2, y, np.full(80, 0.012), np.arctan(0.08 * 0.2 / y))
    law = pm.Airfoil(5.7, 2.0, 0.0, 1.4, c_d0=0.0, c_p=0.0)
    return pm.Model(blade, law)


def test_thrust_in_hover_is_that_of_uniform_momentum() -> None:
    """T = 2 rho A v^2, with v = Omega R s/16 (sqrt(1 + 32 theta_t/s) - 1), s = c_l1 N_b c/(pi R).

    A is that of the ring between root and tip.  The closed form has small angles: 1 %.
    """
    model, omega = ideal_rotor(), 400.0
    s = 5.7 * 2.0 * 0.012 / (math.pi * 0.2)
    v = omega * 0.2 * s / 16.0 * (math.sqrt(1.0 + 32.0 * 0.08 / s) - 1.0)
    at = reference.make_case(model, omega, 0.0, 0.0, 60, 12)
    found = [reference.annulus_inflow(at, y) for y in (0.1, 0.15, 0.195)]
    np.testing.assert_allclose(found, v, rtol=0.01)
    area = math.pi * (0.2**2 - 0.02**2)
    thrust = reference.loads(model, omega, 0.0, 0.0, 60).thrust
    assert thrust == pytest.approx(2.0 * 1.225 * area * v**2, rel=0.01)
    # Equation (12) has the whole disk.
    whole = math.sqrt(thrust / (2.0 * 1.225 * math.pi * 0.2**2))
    assert reference.static_inflow(at) == pytest.approx(whole, rel=1e-3)


def test_the_vortex_ring_is_confined_to_steep_slow_descent() -> None:
    """Its share of the inflow is 1 in its midst, where in vertical descent it is at its largest."""

    def share(axial: float, across: float) -> float:
        return reference.vortex_ring(case(v_axial=axial, v_inplane=across), 5.0)[0]

    assert share(-5.0, 0.0) == 1.0
    assert 0.0 < share(-1.5, 0.0) < 1.0
    assert 0.0 < share(-5.0, 3.5) < 1.0
    assert share(-0.99, 0.0) == share(-10.01, 0.0) == share(-5.0, 4.76) == 0.0
    _, at_rest = reference.vortex_ring(case(v_axial=0.0, v_inplane=0.0), 5.0)
    _, in_descent = reference.vortex_ring(case(v_axial=-5.0, v_inplane=0.0), 5.0)
    assert at_rest == 5.0
    assert in_descent == pytest.approx(5.0 * (1.0 + 1.125 - 1.372 + 1.718 - 0.655))


def test_a_rolling_moment_induces_the_inflow_of_pitt_and_peters() -> None:
    """In a climb so fast that the wake is hardly skewed: v_s = 2 L/(rho pi R^3 W)."""
    model = MODELS["recommended"]
    at = reference.make_case(MODELS["paper"], 600.0, 9.0, 0.3, 60, 12)
    v_i = np.array([reference.annulus_inflow(at, y) for y in at.y])
    added = reference.pitt_peters(at, v_i, 1.0)
    sine, arm = np.sin(at.psi), at.y / BLADE.radius
    v_s = 2.0 * float((added * sine).mean() / arm.mean())
    roll = reference.loads(model, 600.0, 9.0, 0.3, 60, 12).roll_moment
    mean = float((at.y * v_i).sum() / at.y.sum())
    area = 1.225 * math.pi * BLADE.radius**2
    mass_flow = 9.0 + 2.0 * mean
    assert v_s == pytest.approx(2.0 * roll / (area * BLADE.radius * mass_flow), rel=0.01)


def test_camber_and_least_drag_have_angles_of_their_own() -> None:
    """At Re 5e4 of the rotation the zero-lift angle is the constant; at more it grows by ln Re."""
    at = case(LAW.with_parameters(**BEYOND))
    y = 5e4 * 1.983e-5 / (1.225 * 600.0 * 0.02)
    assert reference.zero_lift_angle(at, y) == pytest.approx(-0.05)
    assert reference.zero_lift_angle(at, 2.0 * y) == pytest.approx(-0.05 - 0.02 * math.log(2.0))
    assert reference.zero_lift_angle(at, 9.0 * y) == pytest.approx(-0.05 - 0.02 * math.log(2.4))


def test_pressure_drag_is_least_at_its_own_angle() -> None:
    """With pressure drag alone a section at rest in the turning air has none at that angle."""
    only = {"c_l1": 0.0, "c_l2": 0.0, "c_d0": 0.0, "c_p": 0.0, "reynolds_drag": 0.0}
    at = case(LAW.with_parameters(**{**BEYOND, **only}), v_axial=0.0, v_inplane=0.0)
    _, least = reference.blade_element(replace(at, twist=lambda _: 0.02), 0.07, 0.0)
    _, more = reference.blade_element(replace(at, twist=lambda _: 0.12), 0.07, 0.0)
    assert least[0] == pytest.approx(0.0, abs=1e-12)
    pressure = 0.5 * 1.225 * 42.0**2 * 0.02
    assert more[0] == pytest.approx(pressure * LAW.c_d * math.sin(0.1) ** 2)


def test_nothing_turns_and_nothing_blows() -> None:
    assert reference.loads(MODELS["paper"], 0.0, 0.0, 0.0, 4) == pytest.approx(np.zeros(6))


# Beside what others computed.


def test_hover_and_climb_are_those_of_the_frozen_loads() -> None:
    """0.1 % of the static load, a midpoint rule across the jump at stall included."""
    rows = [
        row for row in frozen_rows("reference_loads") if row.v_inplane == 0.0 and row.rpm > 3000.0
    ][::30]
    assert len(rows) >= 3
    for row in rows:
        model = pm.Model(BLADE, pm.airfoil(f"paper-{row.set}"))
        got = reference.loads(model, row.rpm * math.pi / 30.0, row.v_axial, 0.0)
        assert got.thrust == pytest.approx(row.thrust, abs=1e-3 * row.static_thrust)
        assert got.torque == pytest.approx(row.torque, abs=1e-3 * row.static_torque)


@pytest.mark.parametrize("point", FEW)
def test_the_rotor_agrees_in_axial_flow(point: tuple[float, float, float]) -> None:
    assert np.abs(differences(MODELS["paper"], point, 100)).max() < 1e-3


def test_the_rotor_agrees_in_oblique_flow() -> None:
    found = differences(MODELS["recommended with camber"], (600.0, 8.0, 60.0), 60, 24)
    assert np.abs(found).max() < 1e-3


POINTS = {
    "paper": MANY[::2],
    "recommended": MANY[1::2],
    "recommended with camber": MANY[1::4],  # the same points with another section law
}


@pytest.mark.slow
@pytest.mark.parametrize("name", POINTS)
def test_the_rotor_agrees_from_climb_to_windmill(name: str) -> None:
    worst = {}
    for point in POINTS[name]:
        omega, speed, beta = point
        azimuths = 64 if flow(speed, beta)[1] < 0.3 * omega * BLADE.radius else 160
        steps = MORE_RADII.get(point, 200), azimuths
        worst[point] = np.abs(differences(MODELS[name], point, *steps)).max()
    assert max(worst.values()) < 1e-3, {at: one for at, one in worst.items() if one >= 1e-3}


# What it refuses.


def test_other_models_are_refused() -> None:
    model = pm.Model(BLADE, LAW, corrections=(pm.correction("tip-loss"),))
    with pytest.raises(pm.InputError, match=r"tip-loss.* is not in the reference; leave it out"):
        reference.loads(model, 600.0, 0.0, 0.0)
    angle = np.linspace(-np.pi, np.pi, 37)
    lift = np.sin(2.0 * angle)[None]
    table = pm.SectionTable(angle, np.array([1e5]), lift, 0.1 + 0.0 * lift)
    with pytest.raises(pm.InputError, match="SectionTable; give an Airfoil"):
        reference.loads(pm.Model(BLADE, table), 600.0, 0.0, 0.0)
    y = np.linspace(0.005, 0.1, 20)
    wide = pm.Propeller("wide", 12, y, np.full(20, 0.09), np.full(20, 1.2))
    law = LAW.with_parameters(c_l1=8.0, c_l2=10.0, alpha_0=1.0)
    with pytest.raises(pm.InputError, match="the blades are too wide there"):
        reference.loads(pm.Model(wide, law), 600.0, 0.0, 0.0, 20)
