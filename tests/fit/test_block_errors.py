"""Errors of residuals that are alike within segments: jackknife, degrees of freedom, coverage."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from propmap.fit.comparison import by_flight
from propmap.fit.fit import Settings, fit
from propmap.fit.least_squares import Rows
from propmap.fit.parameters import Choice
from propmap.fit.uncertainty import block_errors
from propmap.vehicle.log import FlightLog, joined

NONE = np.zeros((3, 3))


def test_segments_count_as_refits_without_them_say() -> None:
    """The linear jackknife: refit without each of 24 uneven segments of five rows."""
    rng = np.random.default_rng(5)
    slopes = rng.standard_normal((120, 3)) * np.exp(rng.standard_normal((24, 3))).repeat(5, 0)
    group = 2 * np.arange(24).repeat(5)  # no segment follows another
    measured = np.random.default_rng(6).standard_normal(120)

    def fitted(kept: np.ndarray) -> np.ndarray:
        return np.linalg.lstsq(slopes[kept], measured[kept], rcond=None)[0]

    every, whole = fitted(np.ones(120, bool)), slopes.T @ slopes
    middle, freedom = block_errors(slopes, slopes @ every - measured, group, whole, NONE)
    moves = np.array([fitted(group != 2 * k) - every for k in range(24)])
    inverse = np.linalg.inv(whole)
    wanted = 23.0 / 24.0 * moves.T @ moves
    np.testing.assert_allclose(inverse @ middle @ inverse, wanted, rtol=1e-8)
    assert (freedom < 23.0).all() and (freedom > 2.0).all()


def test_even_segments_have_all_degrees_of_freedom_and_priors_more() -> None:
    slopes = np.tile(np.eye(3), (40, 1))
    group = np.arange(40).repeat(3)
    residual = np.random.default_rng(7).standard_normal(120)
    whole = slopes.T @ slopes
    _, freedom = block_errors(slopes, residual, group, whole, NONE)
    np.testing.assert_allclose(freedom, 39.0)
    _, freedom = block_errors(slopes, residual, group, whole + 1e3 * np.eye(3), 1e3 * np.eye(3))
    assert (freedom > 1000.0).all()


@pytest.mark.parametrize(("alike", "least"), [(3, 1.15), (1, 1.0)])
def test_errors_go_on_past_the_end_of_a_segment(alike: int, least: float) -> None:
    """A mean's variance where errors last three segments of ten rows, and where they last one."""
    rng, count = np.random.default_rng(10), 300
    one, whole, found = np.ones((10 * count, 1)), np.array([[10.0 * count]]), []
    for _ in range(4):
        errors = np.convolve(rng.standard_normal(count + alike - 1), np.ones(alike), "valid")
        errors = errors.repeat(10)
        errors -= errors.mean()
        following, separate = (
            block_errors(one, errors, step * np.arange(count).repeat(10), whole, np.zeros((1, 1)))
            for step in (1, 2)
        )
        found.append((following[0] / separate[0]).item())
    # Neighbors share 2/3 of their variance, or none but by chance.
    assert least <= min(found) and np.mean(found) == pytest.approx(
        7.0 / 3.0 if alike == 3 else 1.05, rel=0.05
    )


def test_errors_of_each_flight() -> None:
    """The second flight has three times the errors of the first."""
    time = np.arange(0.0, 20.0, 0.1)
    still = np.zeros((time.size, 3))
    one = FlightLog("x", time, still, still, still, still, np.ones((time.size, 4)))
    log = joined([one, one], ("first", "second"))
    size = np.where(log.flight == 0, 0.1, 0.3)[:, None]
    noise = size * np.random.default_rng(9).standard_normal((len(log), 1))
    at = np.cos(log.time)[:, None]

    def table(points: np.ndarray) -> Any:
        return lambda values, _: (values["c_l1"] * at[points], at[points][..., None])

    rows = Rows.of_points(
        ("force_z",), ("N",), 5.0 * at + noise, 1.0 + 0.0 * at, 0.0 * log.time, table,
        log.segments(1.0),
    )  # fmt: skip
    fitted = fit(rows, Choice(("c_l1",)), Settings(starts=1, folds=4))
    found = by_flight(fitted, log)["force_z"]
    assert list(found) == ["first", "second"] and found["first"].rows == time.size
    for flight, wanted in (("first", 0.1), ("second", 0.3)):
        assert found[flight].rms == pytest.approx(wanted, rel=0.1)
        assert found[flight].cross_validated_rms == pytest.approx(found[flight].rms, rel=0.05)
    both = np.mean([found[name].cross_validated_rms ** 2 for name in found]) ** 0.5
    assert fitted.cross_validated[0] == pytest.approx(both)
    assert by_flight(fitted, one) == {}
