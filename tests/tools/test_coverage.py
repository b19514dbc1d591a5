"""Studies: shares inside the bands and the intervals of fits, and what corrections add to drag."""

from __future__ import annotations

import functools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import propmap as pm
from propmap import bands
from propmap.errors import InputError
from propmap.fit.fit import Settings, fit
from propmap.fit.least_squares import Rows
from propmap.fit.parameters import Choice
from propmap.model.corrections import TYPICAL_FACTOR
from tests.fit.synthetic_rows import decay_model, rows_of, true_values, truth_of
from tests.workers_elsewhere import Elsewhere
from tools.coverage import axial_z_scores, campaigns, in_plane, shares_of, vehicles
from tools.drag_effects import ADDED, drag_effects
from tools.interval_coverage import noisy_intervals

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
needs_data = pytest.mark.skipif(not DATA.exists(), reason="needs the reference data")
BAND = 1.959964


@needs_data
@pytest.mark.slow
def test_axial_bands_hold_runs_that_were_left_out() -> None:
    for name, scores in axial_z_scores(DATA).items():
        assert scores.size > 4000
        assert 0.92 <= np.mean(np.abs(scores) <= BAND) <= 0.98, name
        assert 0.7 <= np.sqrt(np.mean(scores**2)) <= 1.3, name


@needs_data
def test_oblique_bands_hold_two_tunnels() -> None:
    least = {"thrust": 0.88, "torque": 0.88, "drag": 0.88}
    least |= {"roll_moment": 0.84, "side_force": 0.80, "pitch_moment": 0.80}
    first, second = campaigns(DATA)
    for one in (first, second):
        for name in one.measured:
            held = np.mean(np.abs(one.z_scores(name)) <= BAND)
            assert held >= least[name], (one.name, name, held)
    assert (np.abs(second.z_scores("torque")) <= BAND).all()


@needs_data
@pytest.mark.slow
def test_shares_are_those_that_the_campaigns_give() -> None:
    for name, share in shares_of(campaigns(DATA)).items():
        table = bands.OBLIQUE if name in bands.OBLIQUE else bands.INPLANE
        assert table[name] == pytest.approx(share, abs=0.02), name


@needs_data
def test_installed_drag_by_name() -> None:
    first, _ = campaigns(DATA)
    drag = first.loads().drag
    assert np.sqrt(np.mean((drag / first.measured["drag"] - 1.0) ** 2)) <= 0.10
    found = list(in_plane(DATA))
    assert len(found) == 20
    errors = np.array([one.installed.drag / one.measured - 1.0 for one in found])
    assert np.median(np.sqrt(np.mean(errors**2, axis=1))) <= 0.20
    # The factor lies between the two tunnels'.
    factors = [one.factor for one in found]
    assert np.mean(factors) < TYPICAL_FACTOR[0] < 2.8
    assert np.std(factors, ddof=1) < TYPICAL_FACTOR[1]


def test_whole_vehicles_have_more_than_bare_blades() -> None:
    for name, _, bare, installed, half in vehicles():
        assert 0.3 < bare < 0.75 < installed < bare + 3.0 * half, name


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
    with pytest.raises(InputError, match="give remake"):
        noisy_intervals(exact(60), THREE, NOISE, 5, workers=Elsewhere())


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    found = noisy_intervals(exact(60), THREE, NOISE, 300, seed=1)
    inside = found.hold(truth_of(THREE)).mean(axis=0)
    # 19 in 20; of 300 draws the share is known to 0.013.
    np.testing.assert_allclose(inside, 0.95, atol=0.04)


def test_each_is_added_to_those_before() -> None:
    found = drag_effects(ADDED[1:])
    assert [one.corrections for one in found] == [(), ADDED[1:2], ADDED[1:]]
    paper, longer, both = found
    assert (paper.change == 0.0).all()
    assert ((longer.change > 0.08) & (longer.change < 0.22)).all()
    more = both.drag / longer.drag - 1.0
    assert ((more > 0.02) & (more < 0.05)).all()
    model = pm.Model(pm.propeller("apc-8x6e"), pm.airfoil("paper-apc"))
    edgewise = pm.Rotor(model).loads(200.0 * np.pi, 10.0, np.pi / 2)
    # A batch has other nodes than a single point, within the accuracy promised.
    assert paper.drag[3, 1] == pytest.approx(float(edgewise.drag), rel=1e-3)
