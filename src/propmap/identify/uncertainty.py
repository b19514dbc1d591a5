"""How well a fit determines its parameters, from the residuals and their derivatives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.identify.parameters import Choice
from propmap.identify.rows import Rows
from propmap.identify.search import NOISE_FLOOR, Minimum

Floats = NDArray[np.float64]

AT_BOUND = 1e-6
"""Distance from a bound, in spreads, within which a parameter is held by it."""

NEGLIGIBLE = 1e-6
"""Singular value, relative to the largest, below which data say nothing of a direction: its
square has to stand above the rounding errors of the largest one's."""


@dataclass(frozen=True)
class Uncertainty:
    """P parameters' uncertainties.

    covariance : (P, P); infinite variance where the data say nothing.  A parameter that a bound
        holds counts as free: with it taken as known, the others' intervals come out too narrow.
    low, high : ends of the 95 % intervals (P,), cut at the bound that holds a parameter.
    correlation : (P, P).
    singular_values : of the residuals' derivatives per spread, largest first, relative to it.
    verdicts : a sentence for each.  identified : (P,).
    error : standard deviation of a residual as a share of its scale, per load.
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
    """
    from scipy.stats import t as student

    x, names = found.x, choice.free
    spread, lower, upper = (choice.column(a) for a in ("spread", "lower", "upper"))
    seen = np.linalg.norm(found.slopes, axis=0) * spread
    # Where data say nothing of a parameter, they do not press it against a bound either.
    held = (x - lower < AT_BOUND * spread) | (upper - x < AT_BOUND * spread)
    held &= seen > NEGLIGIBLE * max(float(seen.max()), 1e-300)
    used = rows.weight > 0.0
    counts = np.array([np.count_nonzero(used & (rows.load == k)) for k in range(len(rows.names))])
    share = x.size / max(int(counts.sum()), 1)
    error = np.array(
        [
            _standard_error(found.residual[used & (rows.load == k)], share)
            for k in range(len(rows.names))
        ]
    )
    slopes = found.slopes * spread
    information = slopes.T @ slopes
    prior = np.array([choice.priors[n].deviation if n in choice.priors else np.inf for n in names])
    mean_error = float(np.sqrt(np.sum(counts * error**2) / max(counts.sum(), 1)))
    held_by_prior = (mean_error * spread / prior) ** 2
    if rows.group is None:
        middle = (slopes * error[rows.load][:, None] ** 2).T @ slopes
        freedom = max(int(counts.sum()) - x.size, 1)
    else:
        middle, freedom = _by_group(slopes, found.residual, rows.group[used], used)
    spreads = _sandwich(
        information + np.diag(held_by_prior), middle + np.diag(held_by_prior * mean_error**2)
    )
    covariance = spreads * np.outer(spread, spread)
    deviation = np.sqrt(np.diag(covariance))
    half: Floats = np.asarray(student.ppf(0.975, freedom) * deviation)
    singular = np.linalg.svd(slopes, compute_uv=False)
    scale = np.where(deviation > 0.0, deviation, 1.0)
    with np.errstate(invalid="ignore"):
        correlation = covariance / np.outer(scale, scale)
    np.fill_diagonal(correlation, 1.0)
    judged = [
        _verdict(k, choice, x, half, bool(held[k]), deviation[k], prior[k]) for k in range(x.size)
    ]
    return Uncertainty(
        covariance,
        np.where(held, np.maximum(x - half, lower), x - half),
        np.where(held, np.minimum(x + half, upper), x + half),
        correlation,
        np.asarray(singular / max(float(singular[0]), 1e-300)),
        tuple(text for text, _ in judged),
        tuple(good for _, good in judged),
        error,
    )


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


def _sandwich(information: Floats, middle: Floats) -> Floats:
    """inverse(information) middle inverse(information); infinite where there is none."""
    values, vectors = np.linalg.eigh(information)
    seen = values > NEGLIGIBLE**2 * max(float(values[-1]), 1e-300)
    inverse = (vectors[:, seen] / values[seen]) @ vectors[:, seen].T
    covariance = inverse @ middle @ inverse
    blind = np.sum(vectors[:, ~seen] ** 2, axis=1) > 1e-6
    covariance[np.diag_indices_from(covariance)] = np.where(blind, np.inf, np.diag(covariance))
    return np.asarray(covariance)


def _verdict(
    k: int, choice: Choice, x: Floats, half: Floats, held: bool, deviation: float, prior: float
) -> tuple[str, bool]:
    name = choice.free[k]
    spread = choice.column("spread")[k]
    if held:
        low, high = choice.column("lower")[k], choice.column("upper")[k]
        bound = low if x[k] - low < high - x[k] else high
        return f"weak: held by its bound {bound:g}", False
    if deviation > 0.7 * prior:
        return "weak: held by its prior", False
    if half[k] <= 0.5 * spread:
        return "identified", True
    if not np.isfinite(half[k]):
        return f"weak: held by its start, the data say nothing of {name}", False
    return (
        f"weak: held by its start, the data leave it +-{half[k]:.2g} where propellers differ by "
        f"about {spread:g}",
        False,
    )
