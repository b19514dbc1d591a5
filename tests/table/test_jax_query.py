"""The query in JAX: the same numbers, and derivatives through jit, vmap and grad."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from propmap.loads import LOADS
from propmap.table import JaxTable, LoadTable

from .conftest import random_points

FIELDS = (*LOADS, "power")


def _vectors(invented: LoadTable) -> tuple[np.ndarray, np.ndarray]:
    omega, speed, beta = random_points(invented, 64, seed=10)
    turn = np.linspace(0.0, 6.0, 64)
    inplane = speed * np.sin(beta)
    return omega, np.stack(
        [inplane * np.cos(turn), inplane * np.sin(turn), speed * np.cos(beta)], -1
    )


def test_same_numbers(invented: LoadTable) -> None:
    points = random_points(invented, 300, seed=11)
    with jax.enable_x64(True):
        found = jax.jit(lambda table: table.loads(*points))(JaxTable.from_table(invented))
    expected = invented.loads(*points)
    for name in FIELDS:
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), 1e-9, 1e-12)


def test_single_precision_is_close(invented: LoadTable) -> None:
    omega, velocity = _vectors(invented)
    found = jax.jit(lambda table: table.loads_at_velocity(omega, velocity))(
        JaxTable.from_table(invented)
    )
    assert found.thrust.dtype == jnp.float32
    expected = invented.loads_at_velocity(omega, velocity)
    np.testing.assert_allclose(found.thrust, expected.thrust, rtol=1e-4, atol=1e-5)


def test_derivatives_through_jit_vmap_and_grad(invented: LoadTable) -> None:
    omega, velocity = _vectors(invented)
    with jax.enable_x64(True):
        table = JaxTable.from_table(invented)

        def loads(table: JaxTable, w: jax.Array, v: jax.Array) -> jax.Array:
            found = table.loads_at_velocity(w, v)
            return jnp.stack([getattr(found, name) for name in FIELDS])

        # In reverse, load by load, as ``grad`` does.
        grad = jax.jit(jax.vmap(jax.jacrev(loads, argnums=(1, 2)), in_axes=(None, 0, 0)))
        by_omega, by_velocity = grad(table, jnp.asarray(omega), jnp.asarray(velocity))
    gradient = invented.gradient_at_velocity(omega, velocity)
    for k, name in enumerate(FIELDS):
        expected = getattr(gradient, name)
        np.testing.assert_allclose(by_omega[:, k], expected[:, 0], rtol=1e-8, atol=1e-10)
        np.testing.assert_allclose(by_velocity[:, k], expected[:, 1:], rtol=1e-8, atol=1e-10)


def test_derivatives_without_motion_across(invented: LoadTable) -> None:
    velocities = [[0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, 0.0, -2.0]]
    with jax.enable_x64(True):
        table = JaxTable.from_table(invented)

        def loads(v: jax.Array) -> jax.Array:
            found = table.loads_at_velocity(500.0, v)
            return jnp.stack([getattr(found, name) for name in FIELDS])

        slopes = jax.jit(jax.jacrev(loads))
        for velocity in velocities:
            expected = invented.gradient_at_velocity(500.0, velocity)
            for name, found in zip(FIELDS, slopes(jnp.asarray(velocity)), strict=True):
                want = getattr(expected, name)[1:]
                np.testing.assert_allclose(found, want, rtol=1e-8, atol=1e-12)


def test_the_code_is_that_of_numpy(invented: LoadTable) -> None:
    cells = invented.content.cells.copy()
    cells[:, :9], cells[:, 9:14], cells[5:9, 4:20] = 1, 2, 3
    coefficients = invented.content.coefficients.copy()
    coefficients[:, :, :, 20] = np.nan
    flagged = LoadTable(replace(invented.content, cells=cells, coefficients=coefficients))
    points = random_points(flagged, 500, seed=13)
    points[0][::7] = 2000.0
    expected = flagged.loads(*points).code
    assert set(expected.tolist()) == {0, 1, 2, 4, 5}
    with jax.enable_x64(True):
        found = jax.jit(lambda table, *p: table.code(*p, table.loads(*p).thrust))(
            JaxTable.from_table(flagged), *points
        )
    np.testing.assert_array_equal(found, expected)


def test_outside_is_nan_unless_clamped(invented: LoadTable) -> None:
    with jax.enable_x64(True):
        table = JaxTable.from_table(invented)
        both = jax.jit(lambda *p: (table.loads(*p), table.loads(*p, clamp=True)))
        for point in [(100.0, 1.0, 1.0), (500.0, 50.0, 1.0)]:
            lost, held = both(*point)
            assert np.isnan(np.asarray(lost)).all()
            expected = invented.loads(*point, clamp=True)
            assert float(held.thrust) == pytest.approx(expected.thrust, rel=1e-9)
        thrust = jax.grad(lambda v: table.loads_at_velocity(500.0, v, clamp=True).thrust)
        slope = jax.jit(thrust)(jnp.array([0.0, 0.0, 50.0]))
        assert (np.asarray(slope) == 0.0).all()
