"""Flights of six axes with known parameters are identified: the small part of a benchmark."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from propmap.fit.fit import Settings, fit
from propmap.fit.parameters import Choice, Prior

from .flight_twin import BEFOREHAND, FIXED, FREE, TRUTH, Noise, Twin

pytestmark = pytest.mark.slow
ONCE = Settings(starts=1, folds=0)


@pytest.fixture(scope="module")
def twin() -> Twin:
    return Twin()


def test_without_noise_all_is_found_to_a_thousandth(twin: Twin) -> None:
    priors = {name: Prior(TRUTH[name], deviation) for name, deviation in BEFOREHAND.items()}
    choice = Choice(FREE, FIXED, priors, start={"c_l1": 5.0})
    found = fit(replace(twin.rows, measured=twin.measured(TRUTH)), choice, ONCE)
    np.testing.assert_allclose(found.x, [TRUTH[name] for name in FREE], rtol=1e-3)


def test_errors_are_of_the_size_that_intervals_say(twin: Twin) -> None:
    """`make bench ONLY=flight_twins` counts a hundred of these."""
    z, named = [], set()
    for seed in range(1000, 1003):
        rows, choice, truth = twin.noisy(seed, Noise())
        found = fit(rows, choice, ONCE)
        sure = found.uncertainty
        off = (found.x - [truth[name] for name in FREE]) / np.sqrt(np.diag(sure.covariance))
        z += [off[k] for k in range(len(FREE)) if sure.identified[k]]
        named |= {name for name, good in zip(FREE, sure.identified, strict=True) if good}
    assert {"c_l1", "sensor_x", "sensor_z", "center_x", "clock_offset[1]"} <= named
    # Some 30 numbers of variance 1, some alike.
    assert 0.5 < np.sqrt(np.mean(np.square(z))) < 1.6 and np.max(np.abs(z)) < 4.5
