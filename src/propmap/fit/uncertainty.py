"""How well a fit determines its parameters, from the residuals and their derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.fit.bounded_interval import Quadratic, bounded_intervals
from propmap.fit.parameters import EVERY, Choice
from propmap.fit.rows import Rows
from propmap.fit.search import NOISE_FLOOR, Evaluator, Minimum

AT_BOUND = 1e-6
"""Distance from a bound, in spreads, within which the bound holds a parameter."""

LARGEST_STRETCH = 4.0
"""Of an interval where the model is not linear; by then the parameter is no longer identified."""

NEGLIGIBLE = 1e-6
"""Singular value, relative to the largest, below which data say nothing of a direction: its
square has to stand above the rounding errors of the largest one's."""


@dataclass(frozen=True)
class Uncertainty:
    """How uncertain P parameters are.

    Attributes
    ----------
    covariance : ndarray, shape (P, P)
        As if there were no bounds; a variance is infinite where the data say nothing.
    low, high : ndarray, shape (P,)
        Ends of the 95 % intervals, within the bounds.
    correlation : ndarray, shape (P, P)
        Of the errors [-].
    singular_values : ndarray, shape (P,)
        Of the residuals' derivatives per spread, relative to the largest.
    verdicts : tuple of str
        A sentence for each.
    identified : tuple of bool
        Whether the data determine it.
    error : ndarray, shape (L,)
        Standard deviation of a residual of each load, as a share of its scale.
    """

    covariance: Floats
    low: Floats
    high: Floats
    correlation: Floats
    singular_values: Floats
    verdicts: tuple[str, ...]
    identified: tuple[bool, ...]
    error: Floats


def uncertainty(rows: Rows, choice: Choice, found: Minimum) -> Uncertainty:
    """Gauss-Newton covariance, with errors of the size that the residuals of each load have.

    Where ``rows.group`` tells of stretches within which errors are alike, sums over stretches
    take the place of sums over rows (the cluster-robust covariance), or correlated samples
    would count as independent ones.

    Parameters
    ----------
    rows, choice : Rows, Choice
        What was fitted, and which parameters were free.
    found : Minimum
        Where the search ended.
    """
    from scipy.special import stdtrit  # scipy.stats takes half a second to import

    x = found.x
    spread, lower, upper = (choice.column(a) for a in ("spread", "lower", "upper"))
    seen = np.linalg.norm(found.slopes, axis=0) * spread
    # Where data say nothing of a parameter, they do not press it against a bound either.
    held = (x - lower < AT_BOUND * spread) | (upper - x < AT_BOUND * spread)
    held &= seen > NEGLIGIBLE * max(float(seen.max()), 1e-300)
    used = rows.weight > 0.0
    parts = [rows.of_load(k) for k in range(len(rows.names))]
    counts = np.array([np.count_nonzero(part) for part in parts])
    share = x.size / max(int(counts.sum()), 1)
    error = np.array([_standard_error(found.residual[part], share) for part in parts])
    slopes = found.slopes * spread
    information = slopes.T @ slopes
    mean, prior = choice.prior_columns
    mean_error = float(np.sqrt(np.sum(counts * error**2) / max(counts.sum(), 1)))
    held_by_prior = (mean_error * spread / prior) ** 2
    if rows.group is None:
        middle = (slopes * error[rows.load][:, None] ** 2).T @ slopes
        freedom = max(int(counts.sum()) - x.size, 1)
    else:
        middle, freedom = _by_group(slopes, found.residual, rows.group[used], used)
    known = _sandwich(
        information + np.diag(held_by_prior), middle + np.diag(held_by_prior * mean_error**2)
    )
    covariance = known.covariance * np.outer(spread, spread)
    deviation = np.sqrt(np.diag(covariance))
    # At a minimum the sum of squares only slopes towards bounds.
    uphill = slopes.T @ found.residual + held_by_prior * (x - mean) / spread
    centre = x / spread - known.inverse @ np.where(held, uphill, 0.0)
    quantile = float(stdtrit(freedom, 0.975))
    low, high = bounded_intervals(centre, known.root, lower / spread, upper / spread, quantile)
    ends = np.stack([np.minimum(low, x / spread), np.maximum(high, x / spread)])
    narrow = np.flatnonzero(~held & (ends[1] - ends[0] <= 1.0))
    low, high = _stretched(ends, narrow, rows, choice, found) * spread
    singular = np.linalg.svd(slopes, compute_uv=False)
    scale = np.where(deviation > 0.0, deviation, 1.0)
    with np.errstate(invalid="ignore"):
        correlation = covariance / np.outer(scale, scale)
    np.fill_diagonal(correlation, 1.0)
    half, by_prior = quantile * deviation, deviation > 0.7 * prior
    judged = [
        _verdict(name, x[k], (low[k], high[k]), half[k], bool(held[k]), bool(by_prior[k]))
        for k, name in enumerate(choice.free)
    ]
    return Uncertainty(
        covariance,
        low,
        high,
        correlation,
        np.asarray(singular / max(float(singular[0]), 1e-300)),
        tuple(text for text, _ in judged),
        tuple(good for _, good in judged),
        error,
    )


def _stretched(
    ends: Floats, narrow: NDArray[np.intp], rows: Rows, choice: Choice, found: Minimum
) -> Floats:
    """Ends (2, P) of intervals, in spreads, moved outwards where the model is not linear.

    At an end, with the other parameters where the linear model has the least sum of squares,
    the model is evaluated and made linear anew.  If its least sum of squares there exceeds the
    minimum's by less than the first linear model had it, the end is too near.  Only the ends of
    the parameters with the indices ``narrow`` are looked at.
    """
    spread, lower, upper = (choice.column(a) for a in ("spread", "lower", "upper"))
    x, residual, slopes = found.x / spread, found.residual, found.slopes * spread
    bounds = (lower / spread, upper / spread)
    first = Quadratic(slopes, slopes @ x - residual, *bounds)
    evaluator = Evaluator(rows, choice, NOISE_FLOOR)
    moved, at_minimum = ends.copy(), float(residual @ residual)
    for k in narrow:
        for side in range(2):
            end = float(ends[side, k])
            foreseen, there = first.profile(k, end)
            if end == bounds[side][k] or foreseen <= at_minimum:
                continue
            r, j = evaluator.at(there * spread)
            j = j * spread
            least, _ = Quadratic(j, j @ there - r, *bounds).profile(k, end)
            share = (least - at_minimum) / (foreseen - at_minimum)
            stretch = max(1.0, max(share, LARGEST_STRETCH**-2) ** -0.5)
            moved[side, k] = x[k] + stretch * (end - x[k])
    return np.clip(moved, *bounds)


def _standard_error(residual: Floats, share: float) -> float:
    """Of residuals of which ``share`` parameters each were fitted, at least the noise floor."""
    if residual.size == 0:
        return NOISE_FLOOR
    freedom = max(residual.size * (1.0 - share), 1.0)
    return max(float(np.sqrt(residual @ residual / freedom)), NOISE_FLOOR)


def _by_group(
    slopes: Floats, residual: Floats, group: NDArray[np.intp], used: NDArray[np.bool_]
) -> tuple[Floats, int]:
    labels, index = np.unique(group, return_inverse=True)
    floor = np.where(np.abs(residual) < NOISE_FLOOR, NOISE_FLOOR * np.sign(residual), residual)
    scores = np.zeros((labels.size, slopes.shape[1]))
    np.add.at(scores, index, (slopes * floor[:, None])[used])
    small = labels.size / max(labels.size - 1, 1)
    return small * scores.T @ scores, max(labels.size - slopes.shape[1], 1)


class _Known(NamedTuple):
    """Of the parameters in spreads: (P, P) infinite where there is none; the inverse of the
    information, zero along what the data do not see; W (R, P) of ``bounded_intervals``."""

    covariance: Floats
    inverse: Floats
    root: Floats


def _sandwich(information: Floats, middle: Floats) -> _Known:
    """inverse(information) middle inverse(information)."""
    values, vectors = np.linalg.eigh(information)
    seen = values > NEGLIGIBLE**2 * max(float(values[-1]), 1e-300)
    values, blind, vectors = values[seen], vectors[:, ~seen], vectors[:, seen]
    inverse = (vectors / values) @ vectors.T
    covariance = inverse @ middle @ inverse
    lost = np.sum(blind**2, axis=1) > 1e-6
    covariance[np.diag_indices_from(covariance)] = np.where(lost, np.inf, np.diag(covariance))
    errors, turned = np.linalg.eigh(vectors.T @ middle @ vectors)
    errors = np.maximum(errors, NEGLIGIBLE**2 * errors.max(initial=1e-300))
    root = ((turned / np.sqrt(errors)).T * values) @ vectors.T
    return _Known(covariance, inverse, root)


def _verdict(
    name: str, x: float, ends: tuple[float, float], half: float, held: bool, by_prior: bool
) -> tuple[str, bool]:
    """In words, and whether the parameter is identified; ``half`` an interval without bounds."""
    known, (low, high) = EVERY[name], ends
    lower, upper, spread = known.lower, known.upper, known.spread
    if held:
        return f"weak: held by its bound {lower if x - lower < upper - x else upper:g}", False
    if by_prior:
        return "weak: held by its prior", False
    if high - low <= spread:
        alone = half <= 0.5 * spread
        return "identified" if alone else "identified, given the bounds of the others", True
    if low == lower and high == upper:
        return f"weak: held by its start, the data say nothing of {name}", False
    return (
        f"weak: held by its start, the data leave it {low:.3g} to {high:.3g} where propellers "
        f"differ by about {spread:g}",
        False,
    )
