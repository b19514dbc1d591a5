"""Coverage studies: the intervals are those of fits one by one, whoever makes them."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.fit.fit import Settings, fit
from propmap.fit.least_squares import Rows
from propmap.fit.parameters import Choice
from tests.fit.synthetic_rows import decay_model, rows_of, true_values, truth_of
from tests.workers_elsewhere import Elsewhere
from tools.interval_coverage import noisy_intervals

THREE = Choice(("c_l1", "c_l2", "c_d"))
NOISE = 0.03


def exact(count: int) -> Rows:
    model = decay_model(np.linspace(0.0, 2.0, count))
    return rows_of(model, true_values(model))


def test_intervals_are_those_of_single_fits_and_of_workers() -> None:
    rows, workers = exact(60), Elsewhere()
    here = noisy_intervals(rows, THREE, NOISE, 5)
    there = noisy_intervals(
        rows, THREE, NOISE, 5, workers=workers, remake=functools.partial(exact, 60)
    )
    assert workers.tasks == 5
    for name in ("low", "high", "identified"):
        np.testing.assert_array_equal(getattr(here, name), getattr(there, name))
    rng = np.random.default_rng(2017)
    for k in range(5):
        noisy = replace(rows, measured=rows.measured + NOISE * rng.standard_normal(60))
        sure = fit(noisy, THREE, Settings(starts=1, folds=0)).uncertainty
        np.testing.assert_array_equal(here.low[k], sure.low)
        np.testing.assert_array_equal(here.high[k], sure.high)


def test_workers_elsewhere_need_a_way_to_make_the_rows() -> None:
    with pytest.raises(InputError, match="give remake"):
        noisy_intervals(exact(60), THREE, NOISE, 5, workers=Elsewhere())


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    found = noisy_intervals(exact(60), THREE, NOISE, 300, seed=1)
    inside = found.hold(truth_of(THREE)).mean(axis=0)
    # 19 in 20; of 300 draws the share is known to 0.013.
    np.testing.assert_allclose(inside, 0.95, atol=0.04)
