"""Functions of our own instead of the mathematics library's."""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from propmap.arrays.elementary import arctangent, power_of_two, sine_and_cosine
from propmap.arrays.namespace import by_numpy

EXPONENTS = np.concatenate([np.linspace(-100.0, 100.0, 4001), np.arange(-99.5, 100.0)])


def in_numpy(function: Callable, x: np.ndarray) -> np.ndarray:
    with by_numpy():
        return np.asarray(function(x))


@pytest.mark.parametrize("run", [lambda f, x: f(x), lambda f, x: jax.jit(f)(x), in_numpy])
def test_power_of_two_is_the_library_s(run: Callable) -> None:
    # Compiled too: a compiler that reorders sums would round the exponent wrongly.
    for precision, digits in ((np.float64, 1e-15), (np.float32, 3e-7)):
        x = EXPONENTS.astype(precision)
        got = np.asarray(run(power_of_two, x if run is in_numpy else jnp.asarray(x)))
        assert got.dtype == precision
        np.testing.assert_allclose(got, 2.0 ** x.astype(np.float64), rtol=digits)


def test_power_of_two_is_its_own_slope() -> None:
    x = jnp.linspace(-20.0, 20.0, 401)
    slope = jax.vmap(jax.grad(power_of_two))(x)
    np.testing.assert_allclose(slope, np.log(2.0) * 2.0 ** np.asarray(x), rtol=1e-14)


def test_power_of_nothing_known_is_unknown() -> None:
    assert np.isnan(power_of_two(jnp.asarray(np.nan)))


def test_arctangent_is_the_library_s() -> None:
    t = np.linspace(-1.0, 1.0, 2001)
    np.testing.assert_allclose(arctangent(jnp.asarray(t)), np.arctan(t), rtol=1e-15)


def test_sine_and_cosine_are_the_library_s() -> None:
    angle = np.linspace(-np.pi, np.pi, 2001)
    sine, cosine = sine_and_cosine(jnp.asarray(angle))
    np.testing.assert_allclose(sine, np.sin(angle), atol=2e-15)
    np.testing.assert_allclose(cosine, np.cos(angle), atol=2e-15)
