"""The search, its refusals, cross-validation and the bootstrap."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.fit import fit as module
from propmap.fit.fit import Settings, fit
from propmap.fit.least_squares import Minimum, Rows, search, starts
from propmap.fit.parameters import Choice
from tests.workers_elsewhere import Elsewhere

from .synthetic_rows import Floats, decay_model, noisy, rows_of, true_values, truth_of

THREE = Choice(("c_l1", "c_l2", "c_d"))
TIME = np.linspace(0.0, 2.0, 60)
QUICK = Settings(starts=1, folds=0)


def decaying(noise: float = 0.0) -> Rows:
    model = decay_model(TIME)
    added = noise * np.random.default_rng(7).normal(size=TIME.size)
    return noisy(rows_of(model, true_values(model)), added)


def test_a_known_minimum_from_several_starts() -> None:
    begin = starts(THREE, 8, seed=1)
    found = search(decaying(), THREE, begin)
    np.testing.assert_allclose(found.x, truth_of(THREE), rtol=1e-6)
    assert np.max(np.abs(found.residual)) < 1e-6
    assert len(found.ends) == 8
    assert sum(end.minimum == 1 for end in found.ends) >= 6
    assert [end.cost for end in found.ends] == sorted(end.cost for end in found.ends)
    begun = sorted(tuple(end.start) for end in found.ends)
    assert begun == sorted(tuple(x0) for x0 in begin)
    assert found.unsolved == 0


def test_residuals_are_shares_of_the_scales_and_weights_leave_out() -> None:
    rows = replace(decaying(0.1), scale=np.full(TIME.size, 4.0))
    kept = np.arange(TIME.size) % 3 != 0
    found = search(rows.left(kept), THREE, [THREE.first])
    value, slope = rows.model(THREE.values(found.x), THREE.free)
    np.testing.assert_allclose(found.residual, ((value - rows.measured) / 4.0)[kept])
    np.testing.assert_allclose(found.slopes, slope[kept] / 4.0)
    np.testing.assert_allclose(found.slopes.T @ found.residual, 0.0, atol=1e-6)
    fitted = fit(rows, THREE, QUICK)
    value, _ = rows.model(fitted.values, THREE.free)
    np.testing.assert_allclose(fitted.residual, value - rows.measured)
    assert np.isnan(fitted.cross_validated).all() and fitted.bootstrapped.shape == (0, 3)


def two_valleys(values: Mapping[str, float], free: tuple[str, ...]) -> tuple[Floats, Floats]:
    """At c_l1 = 5 and 7 the first number is met, at 7 alone the second too."""
    x = values["c_l1"] - 6.0
    slopes = np.array([[2.0 * x], [0.1]])
    return np.array([x**2, 0.1 * x]), slopes if free == ("c_l1",) else np.zeros((2, len(free)))


def test_two_minima_are_told_apart() -> None:
    choice = Choice(("c_l1",))
    rows = rows_of(two_valleys, np.array([1.0, 0.1]))
    begin = [np.array([x]) for x in (4.0, 4.5, 7.5, 8.0, 9.0)]
    found = search(rows, choice, begin)
    assert found.x[0] == pytest.approx(7.0, abs=1e-6)
    assert [end.minimum for end in found.ends] == [1, 1, 1, 2, 2]
    best, other = found.ends[0], found.ends[3]
    assert other.x[0] == pytest.approx(5.01, abs=0.02)
    assert best.cost < 1e-10 < other.cost
    assert {float(end.start[0]) for end in found.ends[3:]} == {4.0, 4.5}


def with_lost(count: int) -> Rows:
    """Rows of which the model gives ``count`` no value."""
    rows = decaying(0.02)

    def model(values: Mapping[str, float], free: tuple[str, ...]) -> tuple[Floats, Floats]:
        value, slope = rows.model(values, free)
        value[:count] = np.nan
        return value, slope

    return replace(rows, model=model)


def test_rows_without_a_value_are_counted_and_left_out() -> None:
    found = search(with_lost(3), THREE, [THREE.first])
    assert found.unsolved == 3
    np.testing.assert_array_equal(found.residual[:3], 0.0)
    kept = np.arange(TIME.size) >= 3
    without = search(decaying(0.02).left(kept), THREE, [THREE.first])
    np.testing.assert_allclose(found.x, without.x, rtol=1e-5)
    with pytest.raises(InputError, match="no solution at 4 of 60 rows; check the units"):
        search(with_lost(4), THREE, [THREE.first])
    with pytest.raises(InputError, match="2 measured numbers for 3 free parameters; give more"):
        fit(decaying().left(np.arange(TIME.size) < 2), THREE)


def test_a_robust_loss_resists_outliers() -> None:
    rows = decaying(0.01)
    outliers = np.zeros(TIME.size)
    outliers[[10, 30, 50]] = 1.0
    bad = noisy(rows, outliers)
    clean = fit(rows, THREE, QUICK)
    deviation = np.sqrt(np.diag(clean.uncertainty.covariance))
    plain = fit(bad, THREE, QUICK)
    robust = fit(bad, THREE, replace(QUICK, loss="soft_l1"))
    off_plain = np.abs(plain.x - clean.x) / deviation
    off_robust = np.abs(robust.x - clean.x) / deviation
    assert off_plain.max() > 10.0
    # They still pull, as three numbers of twice the usual error would, all upwards.
    assert off_robust.max() < 0.25 * off_plain.max()
    np.testing.assert_allclose(robust.residual[[10, 30, 50]], -1.0, atol=0.05)
    without = fit(rows, THREE, replace(QUICK, loss="soft_l1"))
    assert (np.abs(without.x - clean.x) < deviation).all()


def kept_points(
    monkeypatch: pytest.MonkeyPatch, rows: Rows, settings: Settings
) -> list[np.ndarray]:
    """The weights of all rows with which every refit is done; what was measured tells them."""
    assert np.unique(rows.measured).size == rows.measured.size
    seen = []

    def watched(part: Rows, *arguments: object, **options: object) -> Minimum:
        seen.append(np.zeros(rows.measured.size))
        seen[-1][np.isin(rows.measured, part.measured)] = part.weight
        return search(part, *arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(module, "search", watched)
    fit(rows, THREE, settings)
    return seen[1:]


@pytest.mark.parametrize("grouped", [False, True])
def test_cross_validation_leaves_out_whole_points_or_groups(
    grouped: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Five folds over ten groups of six rows, or without groups over points of six rows."""
    sixes = np.repeat(np.arange(10), 6)
    point = np.repeat(np.arange(30), 2) if grouped else sixes
    rows = replace(decaying(0.02), point=point, group=sixes if grouped else None)
    weights = kept_points(monkeypatch, rows, Settings(starts=1, folds=5))
    assert len(weights) == 5
    left_out = np.array([weight.reshape(10, 6) == 0.0 for weight in weights])
    np.testing.assert_array_equal(left_out.all(axis=2), left_out.any(axis=2))
    np.testing.assert_array_equal(left_out[:, :, 0].sum(axis=0), 1)
    np.testing.assert_array_equal(left_out[:, :, 0].sum(axis=1), 2)


def test_the_bootstrap_draws_whole_groups(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = replace(decaying(0.02), group=np.repeat(np.arange(10), 6))
    weights = kept_points(monkeypatch, rows, Settings(starts=1, folds=0, bootstrap=4))
    assert len(weights) == 4
    for weight in weights:
        drawn = weight.reshape(10, 6) ** 2
        np.testing.assert_array_equal(drawn, drawn[:, :1] * np.ones(6))
        assert drawn[:, 0].sum() == pytest.approx(10.0)


def test_workers_make_the_same_bootstrap() -> None:
    settings, workers = Settings(starts=1, folds=0, bootstrap=6), Elsewhere()
    here = fit(decaying(0.03), THREE, settings)
    remake = functools.partial(decaying, 0.03)
    there = fit(remake(), THREE, settings, workers=workers, remake=remake)
    assert workers.tasks == 6
    np.testing.assert_array_equal(here.bootstrapped, there.bootstrapped)
    other = fit(decaying(0.03), THREE, replace(settings, seed=5))
    assert (other.bootstrapped != here.bootstrapped).any()
