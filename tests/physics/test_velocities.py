"""Eqs. (1) and (2), and the azimuth nodes."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from propmap.physics.velocities import (
    azimuth_nodes,
    floored_norm,
    normal_velocity,
    tangential_velocity,
)

# A mean of a few dozen numbers of size one is good to some units in the last place.
ROUNDING = 1e-14


def test_tangential_velocity_is_equation_1() -> None:
    omega, y, speed, beta = 512.0, 0.071, 13.0, 1.1
    for psi in (0.0, 0.4, 0.5 * np.pi, 2.0, np.pi, 4.5, 1.5 * np.pi):
        got = tangential_velocity(
            jnp.asarray(omega), jnp.asarray(y), speed * jnp.sin(beta), jnp.sin(psi)
        )
        expected = omega * y + speed * np.sin(beta) * np.sin(psi)
        np.testing.assert_allclose(got, expected, rtol=1e-14)  # three operations


def test_the_advancing_side_is_at_a_quarter_turn() -> None:
    # 100 rad/s at 0.05 m is 5 m/s; 3 m/s in the plane add on one side, subtract on the other.
    arguments = jnp.asarray(100.0), jnp.asarray(0.05), jnp.asarray(3.0)
    assert float(tangential_velocity(*arguments, jnp.asarray(1.0))) == pytest.approx(8.0)
    assert float(tangential_velocity(*arguments, jnp.asarray(-1.0))) == pytest.approx(2.0)


@pytest.mark.parametrize("beta", [0.0, 0.7, 0.5 * np.pi, 2.5, np.pi])
def test_normal_velocity_is_equation_2(beta: float) -> None:
    got = normal_velocity(jnp.asarray(9.0) * jnp.cos(beta), jnp.asarray(2.5))
    np.testing.assert_allclose(got, 9.0 * np.cos(beta) + 2.5, rtol=1e-14, atol=ROUNDING)


@pytest.mark.parametrize("azimuths", [4, 6, 16, 48])
def test_nodes_take_the_mean_of_trigonometric_polynomials_exactly(azimuths: int) -> None:
    nodes = azimuth_nodes(azimuths)
    assert nodes.count == len(nodes.sines)
    for power in range(azimuths):
        # The mean of sin^(2k) over a turn is the product of (2j - 1)/(2j) up to k.
        even = np.prod([(2 * j - 1) / (2 * j) for j in range(1, power // 2 + 1)])
        expected = 0.0 if power % 2 else even
        mean = np.sum(np.asarray(nodes.sines) ** power) / nodes.count
        assert mean == pytest.approx(expected, abs=ROUNDING)


@pytest.mark.parametrize("azimuths", [4, 16, 48])
def test_no_azimuth_counts_twice(azimuths: int) -> None:
    # With psi = 0 and psi = 2 pi both in, the mean of sin^2 would be (n/2)/(n + 1).
    sines = np.asarray(azimuth_nodes(azimuths).sines)
    assert np.mean(np.ones_like(sines)) == 1.0
    assert np.mean(sines**2) == pytest.approx(0.5, abs=ROUNDING)
    assert len(np.unique(np.round(sines, 12))) == len(sines)


def test_nodes_are_those_of_a_whole_turn_each_value_once() -> None:
    psi = 2.0 * np.pi * (np.arange(24) + 0.5) / 24  # both halves of the turn
    whole = np.unique(np.round(np.sin(psi), 12))
    np.testing.assert_allclose(np.sort(azimuth_nodes(24).sines), whole, atol=1e-12)


def test_a_smooth_mean_converges_spectrally() -> None:
    # The mean of exp(sin(psi)) is the Bessel function I_0(1) (Abramowitz & Stegun 9.8).
    sines = np.asarray(azimuth_nodes(16).sines)
    assert np.mean(np.exp(sines)) == pytest.approx(1.2660658777520084, rel=1e-13)


def test_the_single_node_of_axial_flow_sees_no_inplane_velocity() -> None:
    nodes = azimuth_nodes(1)
    assert nodes.count == 1
    np.testing.assert_array_equal(nodes.sines, [0.0])


def test_the_node_count_survives_flattening() -> None:
    for nodes in (azimuth_nodes(8), azimuth_nodes(8).__class__(np.arange(9.0), np.array(3))):
        leaves, tree = jax.tree.flatten(nodes)
        back = jax.tree.unflatten(tree, leaves)
        assert int(back.count) == int(nodes.count)
        np.testing.assert_array_equal(back.sines, nodes.sines)


def test_floored_norm_is_the_norm_and_has_a_gradient_at_rest() -> None:
    assert float(floored_norm(jnp.asarray(3.0), jnp.asarray(-4.0))) == pytest.approx(5.0, rel=1e-15)
    at_rest, gradient = jax.value_and_grad(floored_norm)(jnp.asarray(0.0), jnp.asarray(0.0))
    assert 0.0 < float(at_rest) < 1e-8  # no load notices a nanometre per second
    assert float(gradient) == 0.0
