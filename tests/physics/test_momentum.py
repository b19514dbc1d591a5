"""Eqs. (9), (10) and (12), and the windmill branch."""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from propmap.physics.momentum import (
    annulus_thrust_slope,
    past_momentum_theory,
    static_inflow,
    windmill_annulus_thrust_slope,
)

Y = 0.06
STEEP = (0.0, 1.0, 2.5, 3.5)  # V sin(beta) [m/s], at 10 m/s of descent: less than 10/sqrt(8)
SHALLOW = (3.6, 5.0, 12.0)


def annulus_thrust(*flow: jax.Array) -> jax.Array:
    return annulus_thrust_slope(*flow)[0]


def windmill_annulus_thrust(*flow: jax.Array) -> jax.Array:
    return windmill_annulus_thrust_slope(*flow)[0]


def wake(
    function: Callable[..., jax.Array], v_axial: float, v_inplane: float, inflow: np.ndarray
) -> np.ndarray:
    at = jnp.asarray(Y), jnp.asarray(v_axial), jnp.asarray(v_inplane)
    return np.asarray(function(*at, jnp.asarray(inflow)))


def mirrored(v_axial: float, v_inplane: float, inflow: np.ndarray) -> np.ndarray:
    flow = jnp.asarray(v_axial), jnp.asarray(v_inplane), jnp.asarray(inflow)
    return np.asarray(past_momentum_theory(*flow))


def glauert(v_axial: float, v_inplane: float, v_i: np.ndarray) -> np.ndarray:
    return 4.0 * np.pi * Y * v_i * np.sqrt(v_inplane**2 + (v_axial + v_i) ** 2)


@pytest.mark.parametrize("v_axial", [-9.0, 0.0, 6.0])
@pytest.mark.parametrize("v_inplane", [0.0, 4.0])
def test_annulus_thrust_is_equation_10(v_axial: float, v_inplane: float) -> None:
    v_i = np.linspace(-12.0, 12.0, 49)
    got = wake(annulus_thrust, v_axial, v_inplane, v_i)
    # Where the disk is becalmed the speed floor of 1e-9 m/s remains, times 4 pi y v_i = 7.
    np.testing.assert_allclose(got, glauert(v_axial, v_inplane, v_i), rtol=1e-14, atol=1e-8)


def test_axial_climb_is_equation_9() -> None:
    # dT = 4 rho pi y v_i (V + v_i) dy; at 0.06 m, 5 + 3 m/s: 4 pi * 0.06 * 3 * 8.
    got = wake(annulus_thrust, 5.0, 0.0, np.array([3.0]))
    assert float(got[0]) == pytest.approx(18.095573684677209, rel=1e-14)


def test_hover_annuli_add_up_to_the_static_thrust_of_equation_12() -> None:
    # With uniform v_i the annuli of (10) make T = 2 rho pi R^2 v_i^2, which is (12) inverted.
    y, w = np.polynomial.legendre.leggauss(4)
    radii = 0.05 * (y + 1.0)
    dt = annulus_thrust(jnp.asarray(radii), *(jnp.asarray(a) for a in (0.0, 0.0, 4.2)))
    thrust = 1.225 * 0.05 * np.sum(w * np.asarray(dt))
    v_i0 = static_inflow(*(jnp.asarray(a) for a in (thrust, 1.225, 0.1)))
    assert float(v_i0) == pytest.approx(4.2, rel=1e-13)


@pytest.mark.parametrize("v_inplane", STEEP)
def test_windmill_state_is_equation_10(v_inplane: float) -> None:
    v_i = np.linspace(-3.0, 5.0, 81)  # V cos(beta) + 2 v_i <= 0
    got = wake(windmill_annulus_thrust, -10.0, v_inplane, v_i)
    np.testing.assert_allclose(got, glauert(-10.0, v_inplane, v_i), rtol=1e-13, atol=1e-14)
    assert np.all(got[v_i > 0.0] > 0.0)  # thrust keeps the sign of v_i in windmill descent


@pytest.mark.parametrize("v_inplane", STEEP)
def test_windmill_branch_is_monotone_and_continuous(v_inplane: float) -> None:
    v_i = np.linspace(-5.0, 20.0, 25001)
    thrust = wake(windmill_annulus_thrust, -10.0, v_inplane, v_i)
    rise = np.diff(thrust)
    assert np.all(rise > -1e-12)
    # |d/dv of v sqrt(x^2 + (V + v)^2)| is at most |V + v| + x + |v|: 34 m/s; the step is 1e-3.
    assert np.max(rise) < 4.0 * np.pi * Y * 34.0 * 1e-3
    assert np.min(np.diff(glauert(-10.0, v_inplane, v_i))) < -1e-6  # which (10) itself is not


@pytest.mark.parametrize("v_inplane", STEEP)
def test_beyond_the_turn_the_falling_stretch_of_equation_10_is_mirrored(
    v_inplane: float,
) -> None:
    # The same curve made another way: the sum of the rises of (10), each without its sign,
    # averaged with the parabola that this is in axial flow.
    v_i = np.linspace(-5.0, 20.0, 200001)
    literal = glauert(-10.0, v_inplane, v_i)
    climbed = literal[0] + np.concatenate([[0.0], np.cumsum(np.abs(np.diff(literal)))])
    turn = min(np.roots([2.0, -30.0, 100.0 + v_inplane**2]).real)
    parabola = glauert(-10.0, v_inplane, np.array(turn)) + 4.0 * np.pi * Y * (v_i - turn) ** 2
    share = 1.0 - 8.0 * (v_inplane / 10.0) ** 2
    expected = np.where(v_i > turn, share * parabola + (1.0 - share) * climbed, literal)
    got = wake(windmill_annulus_thrust, -10.0, v_inplane, v_i)
    # A turning point lies between two grid points: about 4 pi y 1e-4 m/s times the slope's
    # change over a step; where the disk is becalmed (10) has a kink, which is on the grid.
    np.testing.assert_allclose(got, expected, atol=1e-6)


@pytest.mark.parametrize("v_inplane", [0.1, 1.0, 2.0])
def test_thrust_goes_on_rising_where_the_disk_is_becalmed(v_inplane: float) -> None:
    # (10) is flat there, at the larger root; a flat place of the wake's thrust would give the
    # residual of (11) a second hump and branches of its own.
    becalmed = max(np.roots([2.0, -30.0, 100.0 + v_inplane**2]).real)
    around = becalmed + np.array([-1e-4, 1e-4])
    rise = np.diff(wake(windmill_annulus_thrust, -10.0, v_inplane, around))[0] / 2e-4
    share = 1.0 - 8.0 * (v_inplane / 10.0) ** 2
    assert rise == pytest.approx(4.0 * np.pi * Y * 10.0 * share**1.5, rel=1e-2)


def test_thrust_coefficients_at_half_and_full_induction() -> None:
    # C_T = dT / (rho/2 V^2 2 pi y dy), a = v_i / V: 4 a (1 - a) = 1 at 1/2, 2 at a = 1.
    v_i = np.array([2.5, 5.0, 7.5, 10.0])
    c_t = wake(windmill_annulus_thrust, -10.0, 0.0, v_i) / (100.0 * np.pi * Y)
    np.testing.assert_allclose(c_t, [0.75, 1.0, 1.25, 2.0], rtol=1e-9)


@pytest.mark.parametrize("v_inplane", SHALLOW)
def test_shallow_descent_is_unchanged(v_inplane: float) -> None:
    v_i = np.linspace(-5.0, 20.0, 501)
    got = wake(windmill_annulus_thrust, -10.0, v_inplane, v_i)
    np.testing.assert_allclose(got, glauert(-10.0, v_inplane, v_i), rtol=1e-13)
    assert not mirrored(-10.0, v_inplane, v_i).any()


def test_windmill_thrust_is_continuous_where_the_turning_points_merge() -> None:
    merge, v_i = 10.0 / np.sqrt(8.0), np.linspace(0.0, 12.0, 121)
    inside = wake(windmill_annulus_thrust, -10.0, merge * (1.0 - 1e-6), v_i)
    outside = wake(windmill_annulus_thrust, -10.0, merge * (1.0 + 1e-6), v_i)
    # V sin(beta) moves by 7e-6 m/s, which times 4 pi y v_i of 9 m/s is 6e-5.
    np.testing.assert_allclose(inside, outside, atol=1e-4)


def test_is_mirrored_begins_where_the_far_wake_stands_still() -> None:
    v_i = np.array([-1.0, 4.999, 5.001, 12.0])  # -10 + 2 v_i = 0 at 5 m/s
    np.testing.assert_array_equal(mirrored(-10.0, 0.0, v_i), [False, False, True, True])
    # (10) turns where 2 v_i^2 + 3 V v_i + V^2 + x^2 = 0, at the smaller root.
    turn = min(np.roots([2.0, -30.0, 104.0]).real)
    around = np.array([turn - 1e-6, turn + 1e-6])
    np.testing.assert_array_equal(mirrored(-10.0, 2.0, around), [False, True])


@pytest.mark.parametrize("v_inplane", [0.0, 10.0 / np.sqrt(8.0), 12.0])
def test_windmill_gradients_are_finite(v_inplane: float) -> None:
    slopes = jax.grad(windmill_annulus_thrust, (1, 2, 3))(
        jnp.asarray(Y), jnp.asarray(-10.0), jnp.asarray(v_inplane), jnp.asarray(6.0)
    )
    assert np.all(np.isfinite(slopes))


def test_static_inflow_is_equation_12() -> None:
    # 3 N on a disk of 0.1 m: sqrt(3 / (2 * 1.225 * pi * 0.01)) = 6.243 m/s.
    got = static_inflow(jnp.asarray([3.0, 12.0]), jnp.asarray(1.225), jnp.asarray(0.1))
    expected = np.sqrt(3.0 / (2.0 * 1.225 * np.pi * 0.01))
    np.testing.assert_allclose(got, [expected, 2.0 * expected], rtol=1e-14)


@pytest.mark.parametrize("thrust", [0.0, -2.0])
def test_static_inflow_is_zero_without_thrust_with_a_finite_gradient(thrust: float) -> None:
    value, slopes = jax.value_and_grad(static_inflow, (0, 1, 2))(
        jnp.asarray(thrust), jnp.asarray(1.225), jnp.asarray(0.1)
    )
    assert float(value) == 0.0
    np.testing.assert_array_equal(slopes, [0.0, 0.0, 0.0])


@pytest.mark.parametrize("v_inplane", [*STEEP, *SHALLOW])
@pytest.mark.parametrize(
    ("both", "v_axial"),
    [
        (annulus_thrust_slope, 6.0),
        (annulus_thrust_slope, -9.0),
        (windmill_annulus_thrust_slope, -10.0),
    ],
)
def test_slopes_are_the_derivatives(
    both: Callable[..., tuple[jax.Array, jax.Array]], v_axial: float, v_inplane: float
) -> None:
    # Away from where the parts of the windmill curve meet.
    inflow = np.linspace(-3.0, 20.0, 47) + 0.0137
    at = jnp.asarray(Y), jnp.asarray(v_axial), jnp.asarray(v_inplane)
    v = jnp.asarray(inflow)
    (thrust, slope), (derivative, _) = jax.jvp(lambda v: both(*at, v), (v,), (jnp.ones_like(v),))
    np.testing.assert_allclose(slope, derivative, rtol=1e-9, atol=1e-9)
    if both is annulus_thrust_slope:
        np.testing.assert_allclose(thrust, annulus_thrust(*at, v), rtol=1e-15)
