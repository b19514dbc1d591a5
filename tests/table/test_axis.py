"""Interpolation along an axis: exact for parabolas, smooth across knots, knots anywhere."""

from __future__ import annotations

import numpy as np
import pytest

from propmap.table.interpolation import interpolate, interval_polynomials, locate, pad

KNOTS = np.array([0.0, 0.1, 0.15, 0.4, 1.0, 1.1, 2.0])


def test_parabolas_are_reproduced() -> None:
    def parabola(x: np.ndarray) -> np.ndarray:
        return np.stack([1.0 - 2.0 * x + 3.0 * x**2, x], -1)

    x = np.linspace(0.0, 2.0, 101)
    padded = pad(KNOTS, parabola(KNOTS), None, None)
    np.testing.assert_allclose(interpolate(KNOTS, padded, x), parabola(x), atol=1e-13)


@pytest.mark.parametrize("parity", [1.0, -1.0])
def test_symmetry_at_the_end(parity: float) -> None:
    """An even function has no slope at its plane of symmetry, an odd one no value beyond."""
    values = np.cos(KNOTS) if parity > 0.0 else np.sin(KNOTS)
    padded = pad(KNOTS, values, np.array(parity), None)
    step = 1e-6
    slope = (interpolate(KNOTS, padded, np.array([step]))[0] - values[0]) / step
    expected = 0.0 if parity > 0.0 else 1.0
    assert slope == pytest.approx(expected, abs=2e-3)


def test_value_and_slope_are_continuous() -> None:
    values = np.random.default_rng(0).random(KNOTS.size)
    padded, step = pad(KNOTS, values, None, None), 1e-7
    for knot in KNOTS[1:-1]:
        around = interpolate(KNOTS, padded, knot + step * np.array([-2.0, -1.0, 0.0, 1.0, 2.0]))
        before, after = np.diff(around)[[0, 3]] / step
        assert before == pytest.approx(after, abs=1e-4)


def test_weights_add_up_to_one_and_pick_the_knots() -> None:
    weights = interval_polynomials(KNOTS)
    np.testing.assert_allclose(weights.sum(axis=1)[:, 1:], 0.0, atol=1e-12)
    np.testing.assert_allclose(weights[:, :, 0], [[0.0, 1.0, 0.0, 0.0]] * (KNOTS.size - 1))
    i, t = locate(KNOTS, np.array([0.0, 0.1, 1.05, 2.0]))
    assert i.tolist() == [0, 1, 4, 5]
    np.testing.assert_allclose(t, [0.0, 0.0, 0.5, 1.0])
