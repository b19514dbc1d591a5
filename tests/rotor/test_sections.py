"""Eqs. (3) and (4), footnote 1 and tables by themselves, and corrections of the lift on a blade."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

import propmap as pm
from tests.oracle.literal_section import LiteralTable, drag_coefficient, lift_coefficient, wrap
from tests.oracle.points import MU, RHO, SECTIONS
from tests.oracle.sampled import airfoil_of

BLADE, SOFT = pm.propeller("apc-8x6e"), pm.airfoil("paper-soft")
ALPHA = np.linspace(-np.pi, np.pi, 2001)[1:-1]
RANDOM = np.random.default_rng(15)
every_set = pytest.mark.parametrize("section", SECTIONS.values(), ids=SECTIONS.keys())
Section = dict[str, float]


@every_set
def test_lift_and_drag_are_equations_3_and_4_as_printed(section: Section) -> None:
    for reynolds in (1e3, 5e4, 1e6):
        lift, drag = airfoil_of(section).coefficients(ALPHA, reynolds)
        # Rounding of the angle, 1e-15, times M and the lift at the knee, about 50 * 2.5.
        np.testing.assert_allclose(lift, lift_coefficient(ALPHA, section), rtol=1e-11, atol=1e-11)
        np.testing.assert_allclose(drag, drag_coefficient(ALPHA, reynolds, section), rtol=1e-13)


sections = st.fixed_dictionaries(
    {
        "c_l1": st.floats(2.0, 9.0),
        "c_l2": st.floats(0.5, 4.0),
        "c_d": st.floats(0.0, 5.0),
        "alpha_0": st.floats(0.15, 0.8),
        "M": st.floats(20.0, 120.0),
        "attached": st.sampled_from([1.0, 1.0, 1.0, 0.0]),
        "plate": st.sampled_from([0.0, 0.44]),
    }
)


@settings(max_examples=20, derandomize=True)
@given(sections, st.floats(-0.2, 0.2))
def test_random_laws_are_the_equations(section: Section, zero_lift_angle: float) -> None:
    """Camber, footnote 1 and the lift of a plate past stall included."""
    alpha, reynolds = ALPHA[::9], 6e4
    lift, drag = airfoil_of(section, zero_lift_angle).coefficients(alpha, reynolds)
    from_zero = wrap(alpha - zero_lift_angle)
    np.testing.assert_allclose(lift, lift_coefficient(from_zero, section), atol=1e-10)
    np.testing.assert_allclose(drag, drag_coefficient(from_zero, reynolds, section), atol=1e-13)


def test_angles_and_reynolds_numbers_broadcast() -> None:
    lift, drag = SOFT.coefficients(np.array([0.0, 0.1, 0.2]), np.array([[3e4], [9e4]]))
    assert lift.shape == drag.shape == (2, 3)
    assert (lift[0] == lift[1]).all() and (drag[0] > drag[1]).all()
    assert np.shape(SOFT.coefficients(0.1, 5e4)[0]) == ()


def uneven(count: int) -> LiteralTable:
    """A rough table: uneven steps, lift and drag that differ with Re."""
    inner = np.linspace(-3.0, 3.0, 42) + RANDOM.uniform(-0.07, 0.07, 42)
    angle = np.concatenate([[-np.pi], inner, [np.pi]])
    reynolds = np.geomspace(1e4, 1e6, count) if count > 1 else np.array([1e5])
    size = (count, angle.size)
    lift_there = np.sin(2.0 * (angle + 0.1)) + RANDOM.uniform(-0.05, 0.05, size)
    drag_there = 0.05 + np.sin(angle) ** 2 + RANDOM.uniform(0.0, 0.05, size)
    lift_there[:, -1], drag_there[:, -1] = lift_there[:, 0], drag_there[:, 0]
    return LiteralTable(angle, reynolds, lift_there, drag_there)


def table_of(literal: LiteralTable) -> pm.SectionTable:
    return pm.SectionTable(literal.angle, literal.reynolds, literal.lift, literal.drag)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_tables_are_those_of_scipy_and_hermite(count: int) -> None:
    table = uneven(count)
    # The package turns the table to begin half a turn from zero lift, and has a knot more there,
    # which bends the curves of the intervals beside it.
    alpha, reynolds = RANDOM.uniform(-1.7, 1.7, 3000), 10.0 ** RANDOM.uniform(3.0, 7.0, 3000)
    for got, want in zip(
        table_of(table).coefficients(alpha, reynolds),
        table.coefficients(alpha, reynolds),
        strict=True,
    ):
        np.testing.assert_allclose(got, want, atol=1e-12)
    below, above = table_of(table).coefficients([-np.pi, np.pi], 1e5)[0]
    assert below == pytest.approx(above, abs=1e-9)


@pytest.mark.parametrize("angle", [1e-15, 1e-8, -1e-15, -1e-8])
def test_a_table_may_have_an_angle_next_to_the_one_opposite_to_zero_lift(angle: float) -> None:
    """A knot is added at the opposite angle; the interval between both may be very short."""
    alpha = np.radians(np.linspace(-180.0, 180.0, 73))
    rows = np.sin(2.0 * alpha), np.sin(alpha) ** 2
    moved = alpha + angle * (np.abs(alpha) < 3.0)
    found = (pm.SectionTable(x, np.array([1e5]), *(r[None] for r in rows)) for x in (alpha, moved))
    at = np.linspace(-np.pi, np.pi, 1000)
    plain, near = (np.stack(one.coefficients(at, 1e5)) for one in found)
    np.testing.assert_allclose(near, plain, atol=1e-3 if abs(angle) > 1e-9 else 1e-7)


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
    c_d = drag_coefficient(field.alpha, RHO * speed * chord / MU, SECTIONS["soft"])
    c = (field.normal_force / q + c_d * np.sin(phi)) / np.cos(phi)
    well = np.abs(np.cos(phi)) > 0.1
    return tuple(v[well] for v in (c, field.alpha, speed, y, chord))


@pytest.mark.parametrize("flow", [(900.0, 12.0, 1.4), (1500.0, 3.0, 0.2)])
def test_lift_is_divided_by_the_root_of_one_minus_mach_squared(
    flow: tuple[float, float, float],
) -> None:
    found, alpha, speed, *_ = corrected_lift("prandtl-glauert:sound_mps=240", flow)
    square = (speed / 240.0) ** 2
    below = square < 0.36
    plain = lift_coefficient(alpha, SECTIONS["soft"])
    want = plain / np.sqrt(1.0 - np.minimum(square, 0.49))
    # Forces are divided by what may be a small dynamic pressure.
    np.testing.assert_allclose(found[below], want[below], atol=1e-9)
    assert (np.abs(found) <= np.abs(plain) / np.sqrt(0.51) + 1e-9).all()


@pytest.mark.parametrize("flow", [(600.0, 0.0, 0.0), (200.0, 9.0, 2.4)])
def test_a_share_of_the_attached_lift_comes_back(flow: tuple[float, float, float]) -> None:
    """3 (c/y)^2 of what is missing to the straight line, up to 30 degrees, none past 60."""
    found, alpha, _, y, chord = corrected_lift("stall-delay", flow)
    flat, share = lift_coefficient(alpha, SECTIONS["soft"]), np.minimum(3.0 * (chord / y) ** 2, 1.0)
    near, far = np.abs(alpha) < np.pi / 6.0, np.abs(alpha) > np.pi / 3.0
    want = flat + share * (6.9 * alpha - flat)
    np.testing.assert_allclose(found[near], want[near], atol=1e-9)
    np.testing.assert_allclose(found[far], flat[far], atol=1e-9)


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("prandtl-glauert:sound_mps=0", "give the speed of sound"),
        ("stall-delay:strength=-1", "Snel's value is 3"),
    ],
)
def test_impossible_numbers_are_refused(text: str, remedy: str) -> None:
    with pytest.raises(pm.InputError, match=remedy):
        pm.correction(text)
    simple = pm.Airfoil(0.0, 5.0, 1.8, 0.36, lift_law="simplified")
    with pytest.raises(pm.InputError, match="no attached lift"):
        rotor("stall-delay", law=simple)
