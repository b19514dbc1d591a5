"""Chord and twist between the stations, against SciPy's PCHIP."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from propmap.arrays.namespace import by_numpy
from propmap.physics.geometry import blade_shape, make_blade, pchip_slopes

KNOTS = 9
KINDS = ("rising", "falling", "wavy", "level stretches")


def data(kind: str, seed: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    x = np.cumsum(random.uniform(0.05, 1.0, KNOTS))
    y = random.normal(size=KNOTS)
    if kind == "rising":
        y = np.cumsum(np.abs(y))
    elif kind == "falling":
        y = -np.cumsum(np.abs(y))
    elif kind == "level stretches":
        y = np.repeat(y[:3], 3)
    return x, y


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(25))
def test_slopes_are_those_of_scipy(kind: str, seed: int) -> None:
    x, y = data(kind, seed)
    expected = PchipInterpolator(x, y).derivative()(x)
    with by_numpy():
        np.testing.assert_allclose(pchip_slopes(x, y), expected, rtol=1e-12, atol=1e-12)


def test_three_stations_are_enough_for_slopes() -> None:
    x, y = np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0, 1.0])
    expected = PchipInterpolator(x, y).derivative()(x)
    with by_numpy():
        np.testing.assert_allclose(pchip_slopes(x, y), expected, rtol=1e-13)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [3, 4])
def test_chord_and_twist_are_scipys_between_the_stations(kind: str, seed: int) -> None:
    x, chord = data(kind, seed)
    _, twist = data("wavy", seed + 100)
    blade = make_blade(*(jnp.asarray(a) for a in (x, chord, twist, 2.0, x[0])))
    radius = np.linspace(x[0], x[-1], 400).reshape(200, 2)
    chord_there, twist_there = blade_shape(blade, jnp.asarray(radius))
    # Cubics in another form: a few roundings of values of size one to five.
    np.testing.assert_allclose(chord_there, PchipInterpolator(x, chord)(radius), atol=1e-12)
    np.testing.assert_allclose(twist_there, PchipInterpolator(x, twist)(radius), atol=1e-12)


def test_at_the_stations_the_shape_is_the_data() -> None:
    x, chord = data("wavy", 7)
    _, twist = data("falling", 8)
    blade = make_blade(*(jnp.asarray(a) for a in (x, chord, twist, 2.0, x[0])))
    chord_there, twist_there = blade_shape(blade, jnp.asarray(x))
    # Left ends are the data to the last bit; the last station is a right end, a sum of four.
    np.testing.assert_array_equal(np.asarray(chord_there)[:-1], chord[:-1])
    np.testing.assert_array_equal(np.asarray(twist_there)[:-1], twist[:-1])
    np.testing.assert_allclose(chord_there[-1], chord[-1], atol=1e-14)
    np.testing.assert_allclose(twist_there[-1], twist[-1], atol=1e-14)


def test_gradients_with_respect_to_the_data_are_finite_differences() -> None:
    x, chord = data("wavy", 11)
    _, twist = data("falling", 12)
    radius = np.linspace(x[0], x[-1], 31)
    weight = np.cos(5.0 * radius)

    def total(c: Any, t: Any) -> Any:
        blade = make_blade(jnp.asarray(x), c, t, 2.0, x[0])
        chord_there, twist_there = blade_shape(blade, jnp.asarray(radius))
        return jnp.sum(weight * chord_there) + jnp.sum(weight**2 * twist_there)

    def independent(c: np.ndarray, t: np.ndarray) -> float:
        by_chord = np.sum(weight * PchipInterpolator(x, c)(radius))
        return float(by_chord + np.sum(weight**2 * PchipInterpolator(x, t)(radius)))

    by_chord, by_twist = jax.jit(jax.grad(total, (0, 1)))(jnp.asarray(chord), jnp.asarray(twist))
    h = 1e-6
    for k, one in enumerate(np.eye(KNOTS) * h):
        fd = (independent(chord + one, twist) - independent(chord - one, twist)) / (2.0 * h)
        assert float(by_chord[k]) == pytest.approx(fd, rel=1e-7, abs=1e-8)  # h^2 and 1e-16/h
        fd = (independent(chord, twist + one) - independent(chord, twist - one)) / (2.0 * h)
        assert float(by_twist[k]) == pytest.approx(fd, rel=1e-7, abs=1e-8)


def test_the_tip_radius_is_the_last_station() -> None:
    x, chord = data("wavy", 1)
    blade = make_blade(*(jnp.asarray(a) for a in (x, chord, chord, 2.0, x[1])))
    assert float(blade.tip) == x[-1]
    assert float(blade.root) == x[1]
