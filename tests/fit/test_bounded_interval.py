"""Intervals within bounds, where they have closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from propmap.fit.uncertainty import bounded_intervals

COVARIANCE = np.array([[0.04, 0.03], [0.03, 0.09]])
ROOT = np.linalg.cholesky(np.linalg.inv(COVARIANCE)).T
CENTER = np.array([1.0, 2.0])
FAR = np.full(2, 100.0)


def test_far_from_bounds_they_are_the_usual_ones() -> None:
    low, high = bounded_intervals(CENTER, ROOT, -FAR, FAR, 1.96)
    half = 1.96 * np.sqrt(np.diag(COVARIANCE))
    np.testing.assert_allclose(low, CENTER - half, rtol=1e-9)
    np.testing.assert_allclose(high, CENTER + half, rtol=1e-9)


def test_of_a_sum_each_part_ends_where_the_other_meets_its_bound() -> None:
    """x + y = 3 +- 0.2 (95 %), 0 <= y <= 1.5: x from 1.5 - 0.2 to 3 + 0.2."""
    root = np.array([[9.8, 9.8]])
    low, high = bounded_intervals(
        np.array([3.0, 0.0]), root, np.array([-100.0, 0.0]), np.array([100.0, 1.5]), 1.96
    )
    assert (low[0], high[0]) == pytest.approx((1.3, 3.2))
    assert (low[1], high[1]) == (0.0, 1.5)


def test_a_minimum_beyond_a_bound() -> None:
    """Within the bound, what exceeds the least value there counts, not the free minimum."""
    low, high = bounded_intervals(np.array([-1.0]), np.eye(1), np.zeros(1), np.array([9.0]), 2.0)
    assert low[0] == 0.0
    assert high[0] == pytest.approx(np.sqrt(5.0) - 1.0)


def test_a_bound_of_one_narrows_what_is_correlated_with_it() -> None:
    wide = bounded_intervals(CENTER, ROOT, -FAR, FAR, 1.96)
    low, high = bounded_intervals(CENTER, ROOT, -FAR, np.array([100.0, 2.1]), 1.96)
    assert high[0] < wide[1][0] - 0.02
    assert low[0] == pytest.approx(wide[0][0])
    assert high[1] == 2.1


def test_what_the_data_do_not_see_fills_its_bounds() -> None:
    low, high = bounded_intervals(CENTER, np.array([[5.0, 0.0]]), -FAR, FAR, 2.0)
    assert (low[0], high[0]) == pytest.approx((0.6, 1.4))
    assert (low[1], high[1]) == (-100.0, 100.0)
