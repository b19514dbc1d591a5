"""Interpolation along an axis, and points that fill the envelope evenly."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import qmc

from propmap.table.interpolation import interpolate, pad
from propmap.table.verification import sobol

KNOTS = np.array([0.0, 0.1, 0.15, 0.4, 1.0, 1.1, 2.0])


def test_parabolas_are_reproduced() -> None:
    def parabola(x: np.ndarray) -> np.ndarray:
        return np.stack([1.0 - 2.0 * x + 3.0 * x**2, x], -1)

    x = np.linspace(0.0, 2.0, 101)
    padded = pad(KNOTS, parabola(KNOTS), None, None)
    np.testing.assert_allclose(interpolate(KNOTS, padded, x), parabola(x), atol=1e-13)


def test_value_and_slope_are_continuous() -> None:
    values = np.random.default_rng(0).random(KNOTS.size)
    padded, step = pad(KNOTS, values, None, None), 1e-7
    for knot in KNOTS[1:-1]:
        around = interpolate(KNOTS, padded, knot + step * np.array([-2.0, -1.0, 0.0, 1.0, 2.0]))
        before, after = np.diff(around)[[0, 3]] / step
        assert before == pytest.approx(after, abs=1e-4)


@pytest.mark.parametrize(("count", "seed"), [(1, 0), (8192, 8192)])
def test_points_that_fill_the_envelope_are_scipys(count: int, seed: int) -> None:
    np.testing.assert_array_equal(sobol(count, seed), qmc.Sobol(3, seed=seed).random(count))
