"""Eqs. (3) and (4), footnote 1 and tables by themselves, and corrections of the lift on a blade."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

import propmap as pm
from propmap.loads import LOADS, error_scales
from tests.oracle.literal_section import LiteralTable
from tests.oracle.naca_0015 import FILE, naca_0015
from tests.oracle.paper_physics import RHO, TABLE_I, Law, drag, lift, lift_law
from tests.oracle.sampled import sampled

BLADE, SOFT = pm.propeller("apc-8x6e"), pm.airfoil("paper-soft")
ALPHA = np.linspace(-np.pi, np.pi, 2001)[1:-1]
RANDOM = np.random.default_rng(15)
every_set = pytest.mark.parametrize("law", TABLE_I.values(), ids=TABLE_I.keys())


def section(law: Law) -> pm.Airfoil:
    numbers = {k: v for k, v in vars(law).items() if k not in ("attached", "plate")}
    return pm.Airfoil(**numbers, lift_law=lift_law(law))


def c_l(alpha: np.ndarray, law: Law) -> np.ndarray:
    return section(law).coefficients(alpha, 5e4)[0]


@every_set
def test_lift_is_equation_3_as_printed(law: Law) -> None:
    # Rounding of the angle, 1e-15, times M and the lift at the knee, about 50 * 2.5.
    np.testing.assert_allclose(c_l(ALPHA, law), lift(ALPHA, law), rtol=1e-11, atol=1e-11)


@every_set
def test_drag_is_equation_4(law: Law) -> None:
    for reynolds in (1e3, 5e4, 1e6):
        got = section(law).coefficients(ALPHA, reynolds)[1]
        np.testing.assert_allclose(got, drag(ALPHA, reynolds, law), rtol=1e-13)


def test_drag_by_hand() -> None:
    # Edge on at Re = 10 000: 2 * 1.02 * 1.328 / 100 + 0.01; broadside adds c_d.
    _, got = section(TABLE_I["apc"]).coefficients([0.0, 0.5 * np.pi], 1e4)
    np.testing.assert_allclose(got, [0.0370912, 1.8370912], rtol=1e-14)


def test_a_plate_has_most_lift_at_45_degrees_and_more_than_equation_3_before() -> None:
    law = replace(TABLE_I["apc"], plate=0.44)
    # Across the flow the normal force is c_l2, at 45 degrees sin / (0.56 + 0.44 sin) of it.
    normal = c_l(np.pi - 1e-9 - 0.5 * np.pi, law) / np.cos(np.pi - 1e-9 - 0.5 * np.pi)
    assert normal == pytest.approx(law.c_l2)
    got = c_l(np.radians([45.0, -45.0, 135.0]), law) / law.c_l2
    share = 0.5 / (0.56 + 0.44 * np.sqrt(0.5))
    np.testing.assert_allclose(got, [share, -share, -share], rtol=1e-8)
    stalled = np.radians(np.arange(26.0, 90.0))
    assert (c_l(stalled, law) > c_l(stalled, TABLE_I["apc"])).all()


@every_set
def test_footnote_1_is_the_simplified_lift(law: Law) -> None:
    simple = replace(law, attached=0.0)
    expected = law.c_l2 * np.sin(ALPHA) * np.cos(ALPHA)
    # Sines by the core's polynomials and by the C library differ in the last bit or two.
    np.testing.assert_allclose(c_l(ALPHA, simple), expected, rtol=0.0, atol=4e-15)
    without = replace(simple, c_l1=0.0)
    np.testing.assert_array_equal(c_l(ALPHA, simple), c_l(ALPHA, without))


@every_set
def test_lift_is_odd_and_drag_even(law: Law) -> None:
    (up, drag_up), (down, drag_down) = (section(law).coefficients(s * ALPHA, 5e4) for s in (1, -1))
    np.testing.assert_array_equal(down, -up)
    np.testing.assert_array_equal(drag_up, drag_down)


@pytest.mark.parametrize("shift", [-0.07, 0.05])
def test_zero_lift_angle_shifts_lift_and_drag(shift: float) -> None:
    law = TABLE_I["stiff"]
    shifted = replace(law, zero_lift_angle=shift)
    np.testing.assert_allclose(c_l(ALPHA + shift, shifted), c_l(ALPHA, law), atol=1e-12)
    moved = section(shifted).coefficients(ALPHA + shift, 5e4)[1]
    np.testing.assert_allclose(moved, drag(ALPHA, 5e4, law), atol=1e-14)
    assert float(c_l(np.array(shift), shifted)) == 0.0


def test_lift_slope_at_zero_lift_is_c_l1() -> None:
    law, h = TABLE_I["apc"], 1e-5
    slope = (c_l(np.array(h), law) - c_l(np.array(-h), law)) / (2.0 * h)
    # The blend's share of the separated lift there, exp(-M alpha_0), is 2e-8.
    assert float(slope) == pytest.approx(law.c_l1, rel=1e-6)


def test_attached_share_is_half_at_alpha_0_and_gone_in_reversed_flow() -> None:
    law = replace(TABLE_I["soft"], c_l2=0.0)
    angle = np.array([1e-3, law.alpha_0, -law.alpha_0, 3.1])
    np.testing.assert_allclose(c_l(angle, law) / (law.c_l1 * angle), [1, 0.5, 0.5, 0], atol=1e-9)


laws = st.builds(
    Law,
    c_l1=st.floats(2.0, 9.0),
    c_l2=st.floats(0.5, 4.0),
    c_d=st.floats(0.0, 5.0),
    alpha_0=st.floats(0.15, 0.8),
    zero_lift_angle=st.floats(-0.2, 0.2),
    sharpness=st.floats(20.0, 120.0),
    attached=st.sampled_from([1.0, 1.0, 1.0, 0.0]),
    plate=st.sampled_from([0.0, 0.44]),
)


@settings(max_examples=80, deadline=None, derandomize=True)
@given(laws)
def test_random_laws_are_the_equations(law: Law) -> None:
    np.testing.assert_allclose(c_l(ALPHA[::9], law), lift(ALPHA[::9], law), atol=1e-10)


def uneven(count: int, cambered: bool = False) -> LiteralTable:
    """A rough table: uneven steps, lift and drag that differ with Re."""
    inner = np.linspace(-3.0, 3.0, 42) + RANDOM.uniform(-0.07, 0.07, 42)
    angle = np.concatenate([[-np.pi], inner, [np.pi]])
    reynolds = np.geomspace(1e4, 1e6, count) if count > 1 else np.array([1e5])
    size = (count, angle.size)
    lift_there = np.sin(2.0 * (angle + 0.1 * cambered)) + RANDOM.uniform(-0.05, 0.05, size)
    drag_there = 0.05 + np.sin(angle) ** 2 + RANDOM.uniform(0.0, 0.05, size)
    lift_there[:, -1], drag_there[:, -1] = lift_there[:, 0], drag_there[:, 0]
    return LiteralTable(angle, reynolds, lift_there, drag_there)


def table_of(literal: LiteralTable) -> pm.SectionTable:
    return pm.SectionTable(literal.angle, literal.reynolds, literal.lift, literal.drag)


@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize("cambered", [False, True])
def test_tables_are_those_of_scipy_and_hermite(count: int, cambered: bool) -> None:
    table = uneven(count, cambered)
    # The package turns the table to begin half a turn from zero lift, and has a knot more there,
    # which bends the curves of the intervals beside it.
    alpha, reynolds = RANDOM.uniform(-1.7, 1.7, 3000), 10.0 ** RANDOM.uniform(3.0, 7.0, 3000)
    for got, want in zip(
        table_of(table).coefficients(alpha, reynolds),
        table.coefficients(alpha, reynolds),
        strict=True,
    ):
        np.testing.assert_allclose(got, want, atol=1e-12)


@pytest.mark.skipif(not FILE.exists(), reason="no shared data beside this checkout")
def test_the_naca_0015_is_interpolated_as_stated() -> None:
    table = naca_0015()
    alpha, reynolds = RANDOM.uniform(-3.14, 3.14, 5000), 10.0 ** RANDOM.uniform(3.0, 7.5, 5000)
    for got, want in zip(
        table_of(table).coefficients(alpha, reynolds),
        table.coefficients(alpha, reynolds),
        strict=True,
    ):
        np.testing.assert_allclose(got, want, atol=1e-12)


def test_both_ends_of_a_table_are_one_angle() -> None:
    below, above = table_of(uneven(3, cambered=True)).coefficients([-np.pi, np.pi], 1e5)[0]
    assert below == pytest.approx(above, abs=1e-9)


@pytest.mark.parametrize("name", ["soft", "stiff", "apc"])
def test_a_table_of_the_paper_s_law_gives_its_loads(name: str) -> None:
    """Within 0.02 % of static loads, descent included.

    It is the law that is compared: where the nodes of "standard" differ, those of "fine" tell.
    """
    table = sampled(TABLE_I[name], 0.05, 1.0, np.geomspace(1e2, 1e6, 33))
    n, random = 25, np.random.default_rng(4)
    omega, speed = random.uniform(200.0, 1000.0, n), random.uniform(0.0, 18.0, n)
    beta = random.uniform(0.0, np.pi, n)
    speed[:3], beta[3:6], beta[6:9] = 0.0, 0.0, np.pi
    laws = (pm.airfoil(f"paper-{name}"), table)

    def errors(accuracy: str, some: slice | np.ndarray) -> np.ndarray:
        point = omega[some], speed[some], beta[some]
        want, got, static = (
            pm.Rotor(pm.Model(BLADE, law), accuracy=accuracy).loads(*flow)
            for law, flow in (
                *((law, point) for law in laws),
                (laws[0], (point[0], 0.0, 0.0)),
            )
        )
        at_rest = {name: getattr(static, name) for name in ("thrust", "torque")}
        scales = error_scales(at_rest, BLADE.radius).values()
        return np.array(
            [
                np.abs(getattr(got, load) - getattr(want, load)) / scale
                for load, scale in zip(LOADS, scales, strict=True)
            ]
        )

    differ = np.flatnonzero(errors("standard", slice(None)).max(axis=0) >= 2e-4)
    assert differ.size <= 2
    assert errors("fine", differ).max(initial=0.0) < 2e-4


def rotor(*texts: str, law: Any = SOFT) -> pm.Rotor:
    corrections = tuple(pm.correction(text) for text in texts)
    return pm.Rotor(pm.Model(BLADE, law, corrections=corrections))


def corrected_lift(text: str, flow: tuple[float, float, float]) -> tuple[np.ndarray, ...]:
    """C_L of elements, from their normal force, beside angle, speed, radius and chord."""
    radius, psi = np.linspace(BLADE.root, 0.1, 12), np.linspace(0.0, 6.0, 13)
    field = rotor(text).inflow(*flow, radius=radius, azimuth=psi)
    speed = np.hypot(field.u_tangential, field.u_normal)
    y = radius[:, None] + 0.0 * speed
    chord = PchipInterpolator(BLADE.station, BLADE.chord)(y)
    q = 0.5 * RHO * speed**2 * chord
    phi = np.arctan2(field.u_normal, field.u_tangential)
    c_d = drag(field.alpha, RHO * speed * chord / 1.983e-5, TABLE_I["soft"])
    c = (field.normal_force / q + c_d * np.sin(phi)) / np.cos(phi)
    well = np.abs(np.cos(phi)) > 0.1
    return tuple(v[well] for v in (c, field.alpha, speed, y, chord))


@pytest.mark.parametrize("flow", [(900.0, 12.0, 1.4), (1500.0, 3.0, 0.2), (300.0, 20.0, 1.5)])
def test_lift_is_divided_by_the_root_of_one_minus_mach_squared(
    flow: tuple[float, float, float],
) -> None:
    found, alpha, speed, *_ = corrected_lift("prandtl-glauert:sound_mps=240", flow)
    square = (speed / 240.0) ** 2
    below = square < 0.36
    want = lift(alpha, TABLE_I["soft"]) / np.sqrt(1.0 - np.minimum(square, 0.49))
    # Forces are divided by what may be a small dynamic pressure.
    np.testing.assert_allclose(found[below], want[below], atol=1e-9)
    assert (np.abs(found) <= np.abs(lift(alpha, TABLE_I["soft"])) / np.sqrt(0.51) + 1e-9).all()


@pytest.mark.parametrize("flow", [(600.0, 0.0, 0.0), (300.0, 20.0, 1.5), (200.0, 9.0, 2.4)])
def test_a_share_of_the_attached_lift_comes_back(flow: tuple[float, float, float]) -> None:
    """3 (c/y)^2 of what is missing to the straight line, up to 30 degrees, none past 60."""
    found, alpha, _, y, chord = corrected_lift("stall-delay", flow)
    flat, share = lift(alpha, TABLE_I["soft"]), np.minimum(3.0 * (chord / y) ** 2, 1.0)
    near, far = np.abs(alpha) < np.pi / 6.0, np.abs(alpha) > np.pi / 3.0
    want = flat + share * (6.9 * alpha - flat)
    np.testing.assert_allclose(found[near], want[near], atol=1e-9)
    np.testing.assert_allclose(found[far], flat[far], atol=1e-9)


@pytest.mark.parametrize("text", ["stall-delay:strength=0", "prandtl-glauert:sound_mps=1e9"])
def test_without_strength_loads_are_the_papers(text: str) -> None:
    points = (600.0, np.array([0.0, 5.0, 12.0]), np.array([0.0, 0.4, 1.5]))
    plain, none = rotor().loads(*points), rotor(text).loads(*points)
    np.testing.assert_allclose(none.thrust, plain.thrust, rtol=1e-3)
    np.testing.assert_allclose(none.torque, plain.torque, rtol=1e-3)


def test_a_fast_tip_lifts_more() -> None:
    gain = [
        float(
            rotor("prandtl-glauert").loads(omega, 8.0, 0.2).thrust
            / rotor().loads(omega, 8.0, 0.2).thrust
        )
        for omega in (700.0, 1500.0)
    ]
    assert 1.0 < gain[0] < 1.03 < gain[1] < 1.15


def test_a_stalled_root_lifts_more() -> None:
    plain, delayed = (
        rotor(*texts).inflow(600.0, 0.0, 0.0, radius=[0.026, 0.09])
        for texts in ((), ("stall-delay",))
    )
    gain = delayed.thrust_per_radius / plain.thrust_per_radius
    assert plain.past_stall[0, 0] > 0.0
    assert gain[0] > 1.2
    assert gain[1] == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("sound", ["0", "-340", "inf", "nan"])
def test_a_speed_of_sound_that_cannot_be_is_refused(sound: str) -> None:
    with pytest.raises(pm.InputError, match="give the speed of sound"):
        pm.correction(f"prandtl-glauert:sound_mps={sound}")


@pytest.mark.parametrize("strength", ["-1", "inf", "nan"])
def test_a_strength_that_cannot_be_is_refused(strength: str) -> None:
    with pytest.raises(pm.InputError, match="Snel's value is 3"):
        pm.correction(f"stall-delay:strength={strength}")


def test_a_law_without_attached_lift_is_refused() -> None:
    simple = pm.Airfoil(0.0, 5.0, 1.8, 0.36, lift_law="simplified")
    with pytest.raises(pm.InputError, match="no attached lift"):
        rotor("stall-delay", law=simple)


def test_each_loss_changes_the_loads() -> None:
    found = {
        text: float(rotor(*text.split(), law=pm.airfoil("paper-apc")).loads(600.0, 4.0, 1.0).thrust)
        for text in ("", "tip-loss", "hub-loss", "hub-loss:radius_m=0.012")
    }
    assert found["tip-loss"] < 0.99 * found[""]
    assert len({round(value, 6) for value in found.values()}) == 4
