"""The query in JAX: the same numbers, and derivatives through jit, vmap and grad."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from propmap.loads import LOADS
from propmap.table import JaxTable, LoadTable

from .conftest import flagged_content, random_points

FIELDS = (*LOADS, "power")
QUICKLY = {"xla_backend_optimization_level": 0}
"""Compilation takes longer than all else here."""


def _vectors(invented: LoadTable) -> tuple[np.ndarray, np.ndarray]:
    omega, speed, beta = random_points(invented, 64, seed=10)
    turn = np.linspace(0.0, 6.0, 64)
    inplane = speed * np.sin(beta)
    vectors = [inplane * np.cos(turn), inplane * np.sin(turn), speed * np.cos(beta)]
    return omega, np.stack(vectors, -1)


def test_same_numbers_and_the_same_code() -> None:
    """Outside, loads are NaN, or clamped if asked."""
    flagged = LoadTable(flagged_content())
    points = random_points(flagged, 500, seed=13)
    points[0][::7], points[1][1::7] = 2000.0, 50.0

    def query(table: JaxTable, *p: jax.Array) -> tuple[object, object, object]:
        loads = table.loads(*p)
        return loads, table.loads(*p, clamp=True), table.code(*p, loads.thrust)

    with jax.enable_x64(True):
        answer = jax.jit(query, compiler_options=QUICKLY)
        lost, held, code = answer(JaxTable.from_table(flagged), *points)
    expected, clamped = flagged.loads(*points), flagged.loads(*points, clamp=True)
    assert set(expected.code.tolist()) == {0, 1, 2, 4, 5}
    np.testing.assert_array_equal(code, expected.code)
    for name in FIELDS:
        np.testing.assert_allclose(getattr(lost, name), getattr(expected, name), 1e-9, 1e-12)
        np.testing.assert_allclose(getattr(held, name), getattr(clamped, name), 1e-9, 1e-12)


def test_single_precision_is_close(invented: LoadTable) -> None:
    omega, velocity = _vectors(invented)
    thrust = jax.jit(
        lambda table: table.loads_at_velocity(omega, velocity).thrust, compiler_options=QUICKLY
    )
    found = thrust(JaxTable.from_table(invented))
    assert found.dtype == jnp.float32
    expected = invented.loads_at_velocity(omega, velocity)
    np.testing.assert_allclose(found, expected.thrust, rtol=1e-4, atol=1e-5)


def test_derivatives_through_jit_vmap_and_grad(invented: LoadTable) -> None:
    """Also without motion across the axis, and zero where the velocity is clamped."""
    omega, velocity = _vectors(invented)
    velocity[:4] = [[0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, 0.0, -2.0], [0.0, 0.0, 50.0]]
    omega[:4] = 500.0

    def loads(table: JaxTable, w: jax.Array, v: jax.Array, clamp: jax.Array) -> jax.Array:
        free = table.loads_at_velocity(w, v)
        held = table.loads_at_velocity(w, v, clamp=True)
        rows = [jnp.where(clamp, getattr(held, n), getattr(free, n)) for n in FIELDS]
        return jnp.stack(rows)

    with jax.enable_x64(True):
        # In reverse, load by load, as ``grad`` does.
        slopes = jax.jacrev(loads, argnums=(1, 2))
        slopes = jax.vmap(slopes, in_axes=(None, 0, 0, 0))
        grad = jax.jit(slopes, compiler_options=QUICKLY)
        table, clamp = JaxTable.from_table(invented), np.arange(64) == 3
        by_omega, by_velocity = grad(table, jnp.asarray(omega), jnp.asarray(velocity), clamp)
    assert (np.asarray(by_velocity[3]) == 0.0).all()
    gradient, kept = invented.gradient_at_velocity(omega, velocity), ~clamp
    for k, name in enumerate(FIELDS):
        expected = getattr(gradient, name)[kept]
        np.testing.assert_allclose(by_omega[kept, k], expected[:, 0], rtol=1e-8, atol=1e-10)
        np.testing.assert_allclose(by_velocity[kept, k], expected[:, 1:], rtol=1e-8, atol=1e-10)
