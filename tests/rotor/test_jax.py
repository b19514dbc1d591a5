"""Loads as a function of JAX arrays: the numbers of ``Rotor``, through JAX's transformations."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import propmap
import propmap.jax
from propmap.loads import FLOW, LOADS

OMEGA = np.array([300.0, 628.0, 900.0, 628.0, 500.0])
V_AXIAL = np.array([0.0, 3.0, -2.0, 0.0, 8.0])
V_INPLANE = np.array([0.0, 8.0, 12.0, 15.0, 0.0])


@pytest.fixture(scope="module")
def rotor() -> propmap.Rotor:
    recommended = propmap.model_corrections("recommended")
    blade, law = propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")
    return propmap.Rotor(propmap.Model(blade, law, corrections=recommended))


def test_loads_and_derivatives_are_those_of_the_rotor(rotor: propmap.Rotor) -> None:
    def one(*flow: jax.Array) -> jax.Array:
        return propmap.jax.loads(rotor, *flow)

    with jax.enable_x64(True):
        found = jax.jit(one)(OMEGA, V_AXIAL, V_INPLANE)
        slopes = jax.jit(jax.vmap(jax.jacfwd(one, argnums=(0, 1, 2))))(OMEGA, V_AXIAL, V_INPLANE)
        assert found.dtype == jnp.float64
    by_flow = rotor.gradients(FLOW, OMEGA, V_AXIAL, V_INPLANE).slopes
    for k in range(len(FLOW)):
        np.testing.assert_allclose(slopes[k].T, by_flow[:, k], rtol=1e-12, atol=1e-15)
    expected, _ = rotor.gradients((), OMEGA, V_AXIAL, V_INPLANE)
    np.testing.assert_array_equal(found, expected)


def test_grad_of_a_mission_adds_the_slopes_up(rotor: propmap.Rotor) -> None:
    def energy(omega: jax.Array) -> jax.Array:
        return (propmap.jax.loads(rotor, omega, V_AXIAL, 3.0)[2] * omega).sum()

    with jax.enable_x64(True):
        found = jax.jit(jax.grad(energy))(jnp.asarray(OMEGA))
    loads, slopes = rotor.gradients(("omega",), OMEGA, V_AXIAL, 3.0)
    torque = list(LOADS).index("torque")
    np.testing.assert_allclose(found, loads[torque] + slopes[torque, 0] * OMEGA, rtol=1e-12)


def test_axes_that_vmap_adds_keep_their_place(rotor: propmap.Rotor) -> None:
    speeds = np.linspace(0.0, 12.0, 4)

    def along(omega: jax.Array, speed: jax.Array) -> jax.Array:
        return propmap.jax.loads(rotor, omega, speed * np.ones(2), speed)

    with jax.enable_x64(True):
        rows = jax.vmap(jax.vmap(along, in_axes=(None, 0)), in_axes=(0, None))
        found = jax.jit(rows)(OMEGA, speeds)
    assert found.shape == (5, 4, len(LOADS), 2)
    expected, _ = rotor.gradients(
        (), OMEGA[:, None, None], speeds[:, None] * np.ones(2), speeds[:, None]
    )
    np.testing.assert_array_equal(np.moveaxis(found, 2, 0), expected)


def test_callers_in_single_precision_get_the_loads_rounded(rotor: propmap.Rotor) -> None:
    given = [x.astype(np.float32) for x in (OMEGA, V_AXIAL, V_INPLANE)]
    loads_at = jax.jit(lambda *x: jax.jvp(lambda *y: propmap.jax.loads(rotor, *y), x, x))
    one, tangent = loads_at(*given)
    assert one.dtype == tangent.dtype == jnp.float32
    flow = [x.astype(np.float64) for x in given]
    loads, slopes = rotor.gradients(FLOW, *flow)
    np.testing.assert_array_equal(one, loads.astype(np.float32))
    expected = np.einsum("lkn,kn->ln", slopes, np.array(flow))
    scale = np.abs(expected).max(axis=1, keepdims=True)
    assert (np.abs(tangent - expected) <= 1e-6 * scale).all()


def test_refused_values_tell_why(rotor: propmap.Rotor) -> None:
    with pytest.raises(Exception, match="negative"):
        propmap.jax.loads(rotor, -1.0, 0.0, 0.0).block_until_ready()
