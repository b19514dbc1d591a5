"""Eqs. (3) and (4), footnote 1, and the bounds that the root search relies on."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from propmap.physics.sections.blended import BlendedLaw
from propmap.physics.sections.law import coefficients_at
from propmap.physics.velocities import angle_of
from tests.physics.paper_physics import TABLE_I, Law, drag, lift

ALPHA = np.linspace(-np.pi, np.pi, 2001)[1:-1]
every_set = pytest.mark.parametrize("law", TABLE_I.values(), ids=TABLE_I.keys())


def lift_coefficient(alpha: jax.Array, law: BlendedLaw) -> jax.Array:
    return coefficients_at(law, alpha, jnp.asarray(5e4, alpha.dtype)).lift


def drag_coefficient(alpha: jax.Array, reynolds: jax.Array, law: BlendedLaw) -> jax.Array:
    return coefficients_at(law, alpha, reynolds).drag


def c_l(alpha: np.ndarray, law: Law) -> np.ndarray:
    return np.asarray(lift_coefficient(jnp.asarray(alpha), law.section()))


@every_set
def test_lift_is_equation_3_as_printed(law: Law) -> None:
    # Rounding of the angle, 1e-15, times M and the lift at the knee, about 50 * 2.5.
    np.testing.assert_allclose(c_l(ALPHA, law), lift(ALPHA, law), rtol=1e-12, atol=1e-12)


@every_set
def test_drag_is_equation_4(law: Law) -> None:
    for reynolds in (1e3, 5e4, 1e6):
        got = drag_coefficient(jnp.asarray(ALPHA), jnp.asarray(reynolds), law.section())
        np.testing.assert_allclose(got, drag(ALPHA, reynolds, law), rtol=1e-13)


def test_drag_by_hand() -> None:
    # Edge on at Re = 10 000: 2 * 1.02 * 1.328 / 100 + 0.01; broadside adds c_d.
    alpha, law = jnp.asarray([0.0, 0.5 * np.pi]), TABLE_I["apc"].section()
    got = drag_coefficient(alpha, jnp.asarray(1e4), law)
    np.testing.assert_allclose(got, [0.0370912, 1.8370912], rtol=1e-14)


@every_set
def test_footnote_1_is_the_simplified_lift(law: Law) -> None:
    simple = replace(law, attached=0.0)
    expected = law.c_l2 * np.sin(ALPHA) * np.cos(ALPHA)
    np.testing.assert_allclose(c_l(ALPHA, simple), expected, rtol=0.0, atol=1e-15)
    without = replace(simple, c_l1=0.0)
    np.testing.assert_array_equal(c_l(ALPHA, simple), c_l(ALPHA, without))


@every_set
def test_lift_is_odd_and_drag_even(law: Law) -> None:
    np.testing.assert_array_equal(c_l(-ALPHA, law), -c_l(ALPHA, law))
    re = jnp.asarray(5e4)
    there = drag_coefficient(jnp.asarray(ALPHA), re, law.section())
    back = drag_coefficient(jnp.asarray(-ALPHA), re, law.section())
    np.testing.assert_array_equal(there, back)


@pytest.mark.parametrize("shift", [-0.07, 0.05])
def test_zero_lift_angle_shifts_lift_and_drag(shift: float) -> None:
    law = TABLE_I["stiff"]
    shifted = replace(law, zero_lift_angle=shift)
    # The shifted angle is rounded once more, 4e-16, and the knee multiplies that by M.
    np.testing.assert_allclose(c_l(ALPHA + shift, shifted), c_l(ALPHA, law), atol=1e-12)
    re = jnp.asarray(5e4)
    moved = drag_coefficient(jnp.asarray(ALPHA + shift), re, shifted.section())
    np.testing.assert_allclose(moved, drag(ALPHA, 5e4, law), atol=1e-14)
    assert float(c_l(np.array([shift]), shifted)[0]) == 0.0


@every_set
def test_single_precision_is_finite_up_to_reversed_flow(law: Law) -> None:
    alpha = jnp.asarray([-np.pi, -1.5, 0.0, 1.4, 3.0, np.pi], jnp.float32)
    section = law.section(np.float32)
    value, slope = jax.vmap(jax.value_and_grad(lift_coefficient), (0, None))(alpha, section)
    assert value.dtype == jnp.float32
    assert np.all(np.isfinite(value))
    assert np.all(np.isfinite(slope))
    # Single precision: 24 bits of an angle of 3, next to c_l2.
    np.testing.assert_allclose(value, lift(np.asarray(alpha, float), law), atol=2e-6)


@pytest.mark.parametrize("reynolds", [2e3, 1e5])
def test_slopes_are_the_derivatives(reynolds: float) -> None:
    for law in (*TABLE_I.values(), Law(5.0, 1.0, 1.0, 0.15, sharpness=20.0)):
        section = law.section()
        alpha = jnp.asarray(np.concatenate([ALPHA, [0.0, law.alpha_0, -law.alpha_0]]))
        log_re = jnp.full_like(alpha, np.log(reynolds))

        def both(a: jax.Array, x: jax.Array, law: BlendedLaw = section) -> tuple:
            return coefficients_at(law, a, jnp.exp(x))[:2]

        one, zero = jnp.ones_like(alpha), jnp.zeros_like(alpha)
        _, by_alpha = jax.jvp(both, (alpha, log_re), (one, zero))
        _, by_log_re = jax.jvp(both, (alpha, log_re), (zero, one))
        found = coefficients_at(section, alpha, jnp.exp(log_re))
        # Same terms in another order; the slope's scale is c_l1 alpha_0 M/4.
        np.testing.assert_allclose(found.lift_slope, by_alpha[0], rtol=1e-10, atol=1e-11)
        np.testing.assert_allclose(found.drag_slope, by_alpha[1], rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(found.drag_by_log_re, by_log_re[1], rtol=1e-10)
        np.testing.assert_array_equal(by_log_re[0], found.lift_by_log_re)


def test_attached_share_is_half_at_alpha_0_and_gone_in_reversed_flow() -> None:
    law = TABLE_I["soft"].section()
    share = law.attached_share(jnp.asarray([0.0, law.alpha_0, -law.alpha_0, np.pi]))
    # exp(-M alpha_0) = 2e-8 is what the other side's stall leaves at alpha = 0.
    np.testing.assert_allclose(share, [1.0, 0.5, 0.5, 0.0], atol=1e-7)


@pytest.mark.parametrize("speed", [1e-3, 1.0, 90.0])
def test_angle_of_attack_is_arctan2_round_the_circle(speed: float) -> None:
    angle = np.linspace(-np.pi, np.pi, 1441)[1:-1]
    along, across = speed * np.cos(angle), speed * np.sin(angle)
    got = angle_of(jnp.asarray(along), jnp.asarray(across), jnp.asarray(speed))
    np.testing.assert_allclose(got, np.arctan2(across, along), atol=1e-14)


@pytest.mark.parametrize(
    ("along", "across"), [(1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (-1.0, 1e-18), (-1.0, 0.0)]
)
def test_angle_of_attack_on_the_axes(along: float, across: float) -> None:
    got = angle_of(jnp.asarray(along), jnp.asarray(across), jnp.asarray(1.0))
    assert float(got) == pytest.approx(np.arctan2(across, along), abs=1e-15)


def test_angle_of_attack_has_the_slope_of_arctan2_at_zero() -> None:
    along, across = jnp.asarray(2.0), jnp.asarray(0.0)
    slope = jax.grad(lambda c: angle_of(along, c, jnp.hypot(along, c)))(across)
    assert float(slope) == pytest.approx(0.5, rel=1e-12)  # d/dc arctan(c/2) at 0


def test_lift_slope_at_zero_lift_is_c_l1() -> None:
    law = TABLE_I["apc"]
    slope = jax.grad(lift_coefficient)(jnp.asarray(0.0), law.section())
    # The blend's share of the separated lift there, exp(-M alpha_0), is 2e-8.
    assert float(slope) == pytest.approx(law.c_l1, rel=1e-6)


FINE = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 20001)
laws = st.builds(
    Law,
    c_l1=st.floats(2.0, 9.0),
    c_l2=st.floats(0.5, 4.0),
    c_d=st.just(1.0),
    alpha_0=st.floats(0.15, 0.8),
    sharpness=st.floats(20.0, 120.0),
    attached=st.sampled_from([1.0, 1.0, 1.0, 0.0]),
)


@settings(max_examples=80, deadline=None, derandomize=True)
@given(laws)
@example(Law(2.0, 4.0, 1.0, 0.8, sharpness=20.0))
@example(Law(2.0, 4.0, 1.0, 0.15, sharpness=20.0))
@example(Law(2.0, 4.0, 1.0, 0.8, sharpness=120.0))
@example(Law(9.0, 0.5, 1.0, 0.15, sharpness=20.0))
@example(Law(4.0, 4.0, 1.0, 0.5, sharpness=120.0))
def test_bounds_of_the_lift_curve_hold(law: Law) -> None:
    bounds = law.section().bounds()
    step = FINE[1] - FINE[0]
    curve = lift(FINE, law)
    bend = np.diff(curve, 2) / step**2
    # The differences' own rounding: 1e-16 of a lift of 10, over the step's square.
    assert np.max(np.abs(curve)) <= float(bounds.lift) * (1.0 + 1e-12)
    assert np.max(np.abs(bend)) <= float(bounds.lift_bend) + 1e-6
    past_negative_stall = FINE[1:-1] > float(bounds.attached_from)
    assert np.max(bend[past_negative_stall]) <= float(bounds.foot_bend) + 1e-6
    attached = past_negative_stall & (FINE[1:-1] > 0.0) & (FINE[1:-1] < float(bounds.attached_to))
    if law.attached and law.c_l1 > law.c_l2:
        assert np.max(bend[attached], initial=-1.0) <= float(bounds.attached_bend) + 1e-6


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.floats(0.0, 5.0), st.floats(0.0, 0.2))
def test_bound_of_the_drag_curve_holds(c_d: float, c_d0: float) -> None:
    law = Law(5.0, 1.0, c_d, 0.3, c_d0=c_d0, c_p=0.0)
    a, phi = np.meshgrid(np.linspace(-np.pi, np.pi, 181), np.linspace(-np.pi, np.pi, 73))
    k, s = np.cos(phi), np.sin(phi)
    value, slope, bend = (
        c_d * np.sin(a) ** 2 + c_d0,
        c_d * np.sin(2.0 * a),
        2.0 * c_d * np.cos(2.0 * a),
    )
    found = np.abs(k**2 * s * (value + bend)) + 2.0 * np.abs(s * value - k * slope)
    assert found.max() <= float(law.section().bounds().drag_bend) + 1e-12
