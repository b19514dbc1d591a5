"""What other propellers let expect of one, beside its own rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from propmap.catalogue.expected import (
    POPULATION,
    PopulationPrior,
    airfoil_at,
    coordinates,
    expected_prior,
)
from propmap.catalogue.identified import PARAMETERS
from propmap.fit.comparison import unlikely_constants
from propmap.fit.fit import Fitted, Settings, fit
from propmap.fit.least_squares import INDEPENDENT, INDEPENDENT_AT_REST, Rows
from propmap.fit.parameters import LEAST_ERROR, Choice, Prior, SectionPrior
from propmap.typing import Floats

from .synthetic_rows import linear_model, noisy, rows_of

QUICK = Settings(starts=1, folds=0)


def prior_of(distribution: PopulationPrior) -> SectionPrior:
    return SectionPrior(distribution, airfoil_at(distribution.mean, "expected", ""), "")


PRIOR = prior_of(PopulationPrior(expected_prior("apce").mean, POPULATION.deviation))
"""Without correlations, so that each constant can be looked at by itself."""

MEAN = {name: getattr(PRIOR.airfoil, name) for name in PARAMETERS}


def choice_of(*free: str, priors: dict[str, Prior] | None = None) -> Choice:
    fixed = {name: value for name, value in MEAN.items() if name not in free}
    start = {name: MEAN[name] for name in free if name in MEAN}
    return Choice(free, fixed, priors or {}, start, PRIOR)


def rows_on(design: dict[str, Floats], noise: Floats, **truth: float) -> Rows:
    model = linear_model(design)
    exact = model(MEAN | truth, ("c_l1",))[0]
    return noisy(rows_of(model, exact), noise)


def test_the_means_are_no_distance_away_and_slopes_are_difference_quotients() -> None:
    assert np.abs(PRIOR.z_scores(MEAN)[0]).max() < 1e-12
    values = {name: value * 1.1 + 0.003 for name, value in MEAN.items()}
    _, slopes = PRIOR.z_scores(values)
    for k, name in enumerate(PARAMETERS):
        step = 1e-6 * abs(values[name])
        high = PRIOR.z_scores(values | {name: values[name] + step})[0]
        low = PRIOR.z_scores(values | {name: values[name] - step})[0]
        np.testing.assert_allclose(slopes[:, k], (high - low) / (2.0 * step), rtol=1e-6, atol=1e-6)


def test_constants_are_spread_as_draws_from_the_coordinates_are() -> None:
    rng = np.random.default_rng(1)
    prior = prior_of(expected_prior("apce"))
    known = prior.distribution
    place = rng.multivariate_normal(known.mean, known.covariance, 10_000)
    zero_lift = place[:, PARAMETERS.index("zero_lift_angle")]
    draws = {
        "c_l1": np.exp(place[:, PARAMETERS.index("c_l1")]),
        "zero_lift_angle": zero_lift,
        # The angle from the chord line is the one that propellers share.
        "drag_angle": place[:, PARAMETERS.index("drag_angle")] - zero_lift,
    }
    for name, values in draws.items():
        mean, deviation = prior.of_constant(name) or (np.nan, np.nan)
        # To first order; 10,000 draws tell a deviation to 0.7 %.
        assert mean == pytest.approx(values.mean(), rel=0.02, abs=1e-4)
        assert deviation == pytest.approx(values.std(), rel=0.03)
    assert PRIOR.of_constant("c_p") is None


def test_without_data_that_tell_of_them_constants_stay_where_propellers_are() -> None:
    """Rows see c_l1 alone: the others keep mean and deviation, and the verdicts say so."""
    rows = rows_on({"c_l1": np.ones(60)}, np.zeros(60), c_l1=MEAN["c_l1"])
    found = fit(rows, choice_of(*PARAMETERS), QUICK)
    for k, name in enumerate(PARAMETERS):
        assert found.x[k] == pytest.approx(MEAN[name], rel=1e-4, abs=1e-6)
        if name == "c_l1":
            continue
        deviation = (PRIOR.of_constant(name) or (0.0, 0.0))[1]
        assert found.uncertainty.covariance[k, k] ** 0.5 == pytest.approx(deviation, rel=1e-3)
        assert found.uncertainty.left[k] == pytest.approx(1.0, rel=1e-3)
        told = found.uncertainty.verdicts[k]
        wanted = (
            "weak: determined mainly by its prior; standard deviation 1.00 times that of the prior"
        )
        assert told == wanted
    assert found.uncertainty.left[0] < 0.2
    assert "times that of the prior" in found.uncertainty.verdicts[0]
    pair = [PARAMETERS.index(name) for name in ("zero_lift_angle", "drag_angle")]
    assert found.uncertainty.correlation[pair[0], pair[1]] < -0.5


def test_what_is_learnt_of_one_constant_tells_of_those_that_go_with_it() -> None:
    """Rows see c_l1 alone; the others follow as conditional means of a normal distribution do."""
    prior = prior_of(expected_prior(None))
    known = prior.distribution
    rows = rows_on({"c_l1": np.ones(60)}, np.zeros(60), c_l1=1.15 * prior.airfoil.c_l1)
    start = {name: getattr(prior.airfoil, name) for name in PARAMETERS}
    choice = Choice(PARAMETERS, start=start, expected=prior)
    found = fit(rows, choice, QUICK)
    place = coordinates(found.x) - known.mean
    assert np.abs(known.correlation[0, 1:]).max() > 0.2
    want = known.covariance[:, 0] / known.covariance[0, 0] * place[0]
    np.testing.assert_allclose(place, want, atol=2e-3)


def precision_of(found: Fitted) -> float:
    """Return 1/variance of the only free parameter."""
    return 1.0 / float(found.uncertainty.covariance[0, 0])


def test_rows_that_err_together_do_not_outweigh_the_prior() -> None:
    """Rows given many times over are worth no more: precisions add as for ten of them."""
    noise = np.random.default_rng(5).normal(0.0, 0.8, 50)
    rows = rows_on({"c_l1": np.ones(1000)}, np.tile(noise, 20), c_l1=7.5)
    found = fit(rows, choice_of("c_l1"), QUICK)
    mean, deviation = MEAN["c_l1"], PRIOR.distribution.deviation[0]
    spread = float(np.std(noise))
    data, alone = INDEPENDENT / spread**2, 7.5 + float(noise.mean())
    # The prior is normal in ln c_l1: its pull and its precision at the minimum.
    x = float(found.x[0])
    pull = (np.log(x / mean)) / (deviation**2 * x)
    assert data * (alone - x) == pytest.approx(pull, rel=0.06)
    assert precision_of(found) == pytest.approx(data + 1.0 / (deviation * x) ** 2, rel=0.08)
    assert mean < x < alone


def test_rows_at_rest_count_less_and_no_stand_is_better_than_its_least_error() -> None:
    rows = rows_on({"c_l1": np.ones(50)}, np.zeros(50), c_l1=6.0)
    at_rest = replace(rows, speed=np.zeros(50))
    found = fit(at_rest, choice_of("c_l1"), QUICK)
    data = precision_of(found) - 1.0 / (PRIOR.distribution.deviation[0] * found.x[0]) ** 2
    assert data == pytest.approx(INDEPENDENT_AT_REST / LEAST_ERROR**2, rel=0.01)
    moving = fit(rows, choice_of("c_l1"), QUICK)
    data = precision_of(moving) - 1.0 / (PRIOR.distribution.deviation[0] * moving.x[0]) ** 2
    assert data == pytest.approx(INDEPENDENT / LEAST_ERROR**2, rel=0.01)
    assert rows.independent.tolist() == [INDEPENDENT]
    # A segment of a flight is one number.
    assert replace(rows, group=np.arange(50) // 10).independent.tolist() == [5.0]
    assert rows.left(np.arange(50) < 3).independent.tolist() == [3.0]


def test_a_prior_of_one_s_own_takes_the_place_of_the_propellers() -> None:
    rows = rows_on({"c_d": np.zeros(1)}, np.zeros(1))  # fewer rows than parameters are enough
    own = {"c_l1": Prior(8.0, 0.1)}
    found = fit(rows, choice_of("c_l1", "c_d", priors=own), QUICK)
    assert found.x[0] == pytest.approx(8.0, abs=1e-6)
    assert found.uncertainty.covariance[0, 0] == pytest.approx(0.1**2, rel=1e-3)
    assert found.x[1] == pytest.approx(MEAN["c_d"], rel=1e-4)
    assert unlikely_constants(found) == []


def test_constants_far_from_all_propellers_are_pointed_out() -> None:
    rows = rows_on({"c_l1": np.ones(40)}, np.zeros(40), c_l1=11.0)
    (told,) = unlikely_constants(fit(rows, choice_of("c_l1"), QUICK))
    assert "constants: c_l1 is 1" in told and "deviations from the mean over propellers" in told
    near = rows_on({"c_l1": np.ones(40)}, np.zeros(40), c_l1=5.5)
    assert unlikely_constants(fit(near, choice_of("c_l1"), QUICK)) == []
