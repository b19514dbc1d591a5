"""Intervals that contain the truth as often as they say, and verdicts that say why not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from propmap.fit.fit import Settings, fit
from propmap.fit.least_squares import NOISE_FLOOR, Rows, search
from propmap.fit.parameters import EVERY, Choice, Prior
from propmap.fit.uncertainty import Uncertainty, bounded_intervals, uncertainty

from .synthetic_rows import Floats, linear_model, noisy, rows_of, true_values, truth_of

DRAWS = 400
NOISE = np.random.default_rng(1).normal(0.0, 0.05, 40)
QUICK = Settings(starts=1, folds=0)
THREE = Choice(("c_l1", "c_l2", "c_d"))
SPREADS = np.array([EVERY[name].spread for name in THREE.free])


def judged(rows: Rows, choice: Choice) -> tuple[Floats, Uncertainty]:
    found = search(rows, choice, [choice.first])
    return found.x, uncertainty(rows, choice, found)


def coverage(rows: Rows, choice: Choice, noise: Callable[[np.random.Generator], Floats]) -> Floats:
    """Share of draws in which each 95 % interval contains the truth (P,)."""
    rng = np.random.default_rng(3)
    inside = np.zeros(len(choice.free))
    for _ in range(DRAWS):
        _, sure = judged(noisy(rows, noise(rng)), choice)
        truth = truth_of(choice)
        inside += (sure.low <= truth) & (truth <= sure.high)
    return inside / DRAWS


def design(count: int, seed: int = 0) -> dict[str, Floats]:
    rng = np.random.default_rng(seed)
    return {name: rng.normal(size=count) for name in ("c_l1", "c_l2", "c_d")}


def exact(count: int = 40) -> Rows:
    model = linear_model(design(count))
    return rows_of(model, true_values(model))


def test_two_loads_with_different_noise() -> None:
    """c_l1 is seen in the noisy load alone, c_l2 in the quiet one, c_d in both."""
    count = 60
    columns = design(2 * count, seed=1)
    load = np.repeat([0, 1], count)
    columns["c_l1"] = np.where(load == 0, columns["c_l1"], 0.0)
    columns["c_l2"] = np.where(load == 1, columns["c_l2"], 0.0)
    model = linear_model(columns)
    rows = rows_of(model, true_values(model), load=load)
    deviation = np.where(load == 0, 0.08, 0.02)
    _, sure = judged(noisy(rows, deviation * np.random.default_rng(11).normal(size=120)), THREE)
    np.testing.assert_allclose(sure.error, [0.08, 0.02], rtol=0.3)
    width = sure.high - sure.low
    assert width[0] > 3.0 * width[1]


@pytest.mark.slow
def test_groups_of_errors_alike_within_them_have_the_promised_coverage() -> None:
    """Inputs and errors of the twelve rows of a group hardly differ."""
    index = np.repeat(np.arange(40), 12)
    rng = np.random.default_rng(5)
    columns = {
        name: rng.normal(size=40)[index] + 0.1 * rng.normal(size=index.size) for name in THREE.free
    }
    model = linear_model(columns)
    rows = rows_of(model, true_values(model), group=index)

    def noise(rng: np.random.Generator) -> Floats:
        return 0.05 * rng.normal(size=40)[index] + 0.01 * rng.normal(size=index.size)

    # 400 draws of a 95 % interval have a standard deviation of 1.1 %: four of these deviations.
    share = coverage(rows, THREE, noise)
    assert (share >= 0.90).all() and (share <= 0.99).all(), share


def test_textbook_covariance_and_correlation() -> None:
    rows = noisy(exact(200), np.random.default_rng(10).normal(0.0, 0.05, 200))
    x, sure = judged(rows, THREE)
    matrix = np.stack([design(200)[name] for name in THREE.free], axis=1)
    expected = 0.05**2 * np.linalg.inv(matrix.T @ matrix)
    # The noise of these 200 rows is known to 5 %.
    np.testing.assert_allclose(np.diag(sure.covariance), np.diag(expected), rtol=0.25)
    deviation = np.sqrt(np.diag(sure.covariance))
    expected_correlation = sure.covariance / np.outer(deviation, deviation)
    np.testing.assert_allclose(sure.correlation, expected_correlation, atol=1e-12)
    np.testing.assert_allclose((sure.high - sure.low) / 2.0, 1.972 * deviation, rtol=1e-3)
    np.testing.assert_allclose((sure.high + sure.low) / 2.0, x)
    # Seven rows leave four degrees of freedom: Student's quantile is 2.776, not 1.96.
    few = judged(noisy(exact(7), np.random.default_rng(1).normal(0.0, 0.01, 7)), THREE)[1]
    half = 2.776 * np.sqrt(np.diag(few.covariance))
    np.testing.assert_allclose((few.high - few.low) / 2.0, half, rtol=1e-3)
    assert sure.verdicts == ("identified",) * 3 and sure.identified == (True,) * 3
    singular = np.linalg.svd(matrix * SPREADS, compute_uv=False)
    np.testing.assert_allclose(sure.singular_values, singular / singular[0], rtol=1e-9)
    # Rows without noise err by the floor: the loads are computed to no better than that.
    exactly = judged(exact(200), THREE)[1].covariance
    floor = NOISE_FLOOR**2 * np.linalg.inv(matrix.T @ matrix)
    np.testing.assert_allclose(exactly, floor, rtol=1e-6)


def test_held_by_a_bound() -> None:
    model = linear_model(design(40))
    x, sure = judged(noisy(rows_of(model, true_values(model, c_d=-0.5)), NOISE), THREE)
    assert x[2] == 0.0
    assert sure.verdicts[2] == "weak: at its bound 0" and not sure.identified[2]
    # The interval ends at the bound, and the parameter is not taken as known.
    assert sure.low[2] == 0.0 < sure.high[2]
    assert np.all(np.diag(sure.covariance) > 0.0)
    assert sure.identified[:2] == (True, True)
    alone = rows_of(linear_model({"c_d": np.ones(10)}), np.full(10, 11.0))
    high = judged(alone, Choice(("c_d",), start={"c_d": 5.0}))[1]
    assert high.verdicts == ("weak: at its bound 10",) and high.covariance[0, 0] > 0.0


def test_a_direction_that_the_data_say_nothing_of() -> None:
    columns = design(40)
    del columns["c_d"]
    model = linear_model(columns)
    _, sure = judged(noisy(rows_of(model, true_values(model)), NOISE), THREE)
    assert sure.verdicts[2] == "weak: the data do not determine c_d; its value depends on its start"
    assert (sure.low[2], sure.high[2]) == (0.0, 10.0)
    assert sure.identified == (True, True, False)
    assert np.isfinite(sure.high[:2]).all()
    assert sure.singular_values[2] == 0.0


def test_two_parameters_seen_only_in_their_sum() -> None:
    columns = design(40)
    columns["c_d"] = columns["c_l2"]
    model = linear_model(columns)
    x, sure = judged(noisy(rows_of(model, true_values(model)), NOISE), THREE)
    assert sure.identified == (True, False, False)
    # c_l2 + c_d is about 4 and c_d is above zero, so the bounds say something of both.
    assert all("weak: the data allow" in sure.verdicts[k] for k in (1, 2))
    np.testing.assert_allclose(sure.low[1:], 0.0)
    np.testing.assert_allclose(sure.high[1:], x[1] + x[2], atol=0.1)
    assert np.isinf(sure.covariance[1, 1]) and np.isinf(sure.covariance[2, 2])


def test_too_noisy_to_say() -> None:
    rows = noisy(exact(), 200.0 * NOISE)
    _, sure = judged(rows, Choice(("c_l1",), {"c_l2": 2.5, "c_d": 1.5}))
    assert sure.verdicts[0].startswith("weak: the data allow 0.5 to ")
    assert "difference between propellers, 1" in sure.verdicts[0]
    assert np.isfinite(sure.high[0])


@pytest.mark.parametrize("deviation", [0.003, 0.02, 3.0])
def test_a_prior_has_the_textbook_s_effect(deviation: float) -> None:
    """One parameter: the precisions add, and the estimate is their weighted mean."""
    column = np.linspace(0.5, 1.5, 400)
    model = linear_model({"c_l2": column})
    noise = np.random.default_rng(4).normal(0.0, 0.2, 400)
    rows = noisy(rows_of(model, true_values(model)), noise)
    mean = 2.45
    found = fit(rows, Choice(("c_l2",), priors={"c_l2": Prior(mean, deviation)}), QUICK)
    data = float(column @ column) / 0.2**2
    alone = float(column @ rows.measured) / float(column @ column)
    belief = 1.0 / deviation**2
    # The noise is known to 1/sqrt(800), and so is the weight of the data.
    assert found.x[0] == pytest.approx((data * alone + belief * mean) / (data + belief), abs=2e-3)
    expected = 1.0 / np.sqrt(data + belief)
    assert np.sqrt(found.uncertainty.covariance[0, 0]) == pytest.approx(expected, rel=0.05)
    by_prior = expected > 0.7 * deviation
    assert found.uncertainty.verdicts[0] == (
        "weak: determined mainly by its prior" if by_prior else "identified"
    )
    assert by_prior == (deviation < 0.01)


def test_intervals_within_bounds_have_closed_forms() -> None:
    """x + y = 3 +- 0.2 (95 %), 0 <= y <= 1.5: x from 1.5 - 0.2 to 3 + 0.2."""
    root = np.array([[9.8, 9.8]])
    low, high = bounded_intervals(
        np.array([3.0, 0.0]), root, np.array([-100.0, 0.0]), np.array([100.0, 1.5]), 1.96
    )
    assert (low[0], high[0]) == pytest.approx((1.3, 3.2))
    assert (low[1], high[1]) == (0.0, 1.5)
    # Within a bound the cost above the least value there counts, not above the free minimum.
    low, high = bounded_intervals(np.array([-1.0]), np.eye(1), np.zeros(1), np.array([9.0]), 2.0)
    assert low[0] == 0.0
    assert high[0] == pytest.approx(np.sqrt(5.0) - 1.0)
    # Far from bounds they are the usual ones; a bound of one narrows a correlated other.
    center, covariance = np.array([1.0, 2.0]), np.array([[0.04, 0.03], [0.03, 0.09]])
    root, far = np.linalg.cholesky(np.linalg.inv(covariance)).T, np.full(2, 100.0)
    wide = bounded_intervals(center, root, -far, far, 1.96)
    half = 1.96 * np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(wide, [center - half, center + half], rtol=1e-9)
    low, high = bounded_intervals(center, root, -far, np.array([100.0, 2.1]), 1.96)
    assert high[0] < wide[1][0] - 0.02
    assert low[0] == pytest.approx(wide[0][0])
    assert high[1] == 2.1
