"""How well a fit determines its parameters, from the residuals and their derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.fit.block_errors import block_errors
from propmap.fit.bounded_interval import Quadratic, bounded_intervals
from propmap.fit.parameters import LINEAR, Choice, described, general
from propmap.fit.rows import Rows
from propmap.fit.search import NOISE_FLOOR, Evaluator, Minimum, weight_of_priors
from propmap.fit.section_prior import LEAST_ERROR
from propmap.typing import Floats

AT_BOUND = 1e-6
"""Distance from a bound, in spreads, within which the bound holds a parameter."""

HELD_BY_PRIOR = 0.7
"""Share of the deviation beforehand above which a prior says more of a parameter than the data."""

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
    left : ndarray, shape (P,)
        Standard deviation over that beforehand [-]: 1 where the data say nothing, 0 where nothing
        was known.
    """

    covariance: Floats
    low: Floats
    high: Floats
    correlation: Floats
    singular_values: Floats
    verdicts: tuple[str, ...]
    identified: tuple[bool, ...]
    error: Floats
    left: Floats


def uncertainty(
    rows: Rows, choice: Choice, found: Minimum, error: float = NOISE_FLOOR
) -> Uncertainty:
    """Gauss-Newton covariance, with errors of the size that the residuals of each load have.

    Where ``rows.group`` tells of stretches within which errors are alike, ``block_errors`` of
    stretches take the place of those of rows, or correlated samples would count as independent
    ones.  Where other propellers tell what to expect, the rows of each
    load err together as far as ``rows.independent`` says, by ``LEAST_ERROR`` at least.

    Parameters
    ----------
    rows, choice : Rows, Choice
        What was fitted, and which parameters were free.
    found : Minimum
        Where the search ended.
    error : float
        Of a residual, as in the ``search``; counts where other propellers tell what to expect.
    """
    from scipy.special import stdtrit  # scipy.stats takes half a second to import

    x = found.x
    spread, lower, upper = (choice.column(a) for a in ("spread", "lower", "upper"))
    seen = np.linalg.norm(found.slopes, axis=0) * spread
    # Where data say nothing of a parameter, they do not press it against a bound either.
    held = (x - lower < AT_BOUND * spread) | (upper - x < AT_BOUND * spread)
    held &= seen > NEGLIGIBLE * max(float(seen.max()), 1e-300)
    used = rows.weight > 0.0
    counts = rows.counts
    apart, by_prior = choice.apart(x)
    by_prior = by_prior * spread
    slopes = found.slopes * spread
    information, prior_information = slopes.T @ slopes, by_prior.T @ by_prior
    errors = residual_errors(rows, choice, found, error)
    if choice.expected is None:
        error = float(np.sqrt(np.sum(counts * errors**2) / max(counts.sum(), 1)))
    weight = weight_of_priors(rows, choice, error)
    whole, by_priors = (information + weight**2 * prior_information, weight**4 * prior_information)
    freedom: Floats | int
    if rows.group is not None:
        stretches = slopes[used], found.residual[used], rows.group[used]
        middle, freedom = block_errors(*stretches, whole, by_priors)
    elif choice.expected is not None:
        alike = counts / np.maximum(rows.independent, 1.0)
        variance = alike * np.maximum(errors, LEAST_ERROR) ** 2
        middle = (slopes * variance[rows.load][:, None]).T @ slopes
        freedom = max(round(float(rows.independent.sum())), 1)
    else:
        middle = (slopes * errors[rows.load][:, None] ** 2).T @ slopes
        freedom = max(int(counts.sum()) - x.size, 1)
    known = _sandwich(whole, middle + by_priors)
    covariance = known.covariance * np.outer(spread, spread)
    deviation = np.sqrt(np.diag(covariance))
    # At a minimum the sum of squares only slopes towards bounds.
    uphill = slopes.T @ found.residual + weight**2 * (by_prior.T @ apart)
    centre = x / spread - known.inverse @ np.where(held, uphill, 0.0)
    quantile = np.broadcast_to(stdtrit(freedom, 0.975), x.shape)
    low, high = bounded_intervals(centre, known.root, lower / spread, upper / spread, quantile)
    ends = np.stack([np.minimum(low, x / spread), np.maximum(high, x / spread)])
    bent = np.array([general(name) not in LINEAR for name in choice.free])
    narrow = np.flatnonzero(~held & bent & (ends[1] - ends[0] <= 1.0))
    low, high = _stretched(ends, narrow, rows, choice, found, weight) * spread
    singular = np.zeros(x.size)
    # Fewer rows than parameters leave directions that the data do not see at all.
    seen_at_all = np.linalg.svd(slopes, compute_uv=False)
    singular[: seen_at_all.size] = seen_at_all
    scale = np.where(deviation > 0.0, deviation, 1.0)
    with np.errstate(invalid="ignore"):
        correlation = covariance / np.outer(scale, scale)
    np.fill_diagonal(correlation, 1.0)
    left = _left(deviation / spread, by_prior)
    judged = [
        _verdict(name, x[k], (low[k], high[k]), quantile[k] * deviation[k], bool(held[k]), left[k])
        for k, name in enumerate(choice.free)
    ]
    if choice.expected is not None:
        judged = [
            _beside_prior(verdict, left[k]) if choice.prior_of(name) else verdict
            for k, (name, verdict) in enumerate(zip(choice.free, judged, strict=True))
        ]
    return Uncertainty(
        covariance,
        low,
        high,
        correlation,
        np.asarray(singular / max(float(singular[0]), 1e-300)),
        tuple(text for text, _ in judged),
        tuple(good for _, good in judged),
        errors,
        left,
    )


def residual_errors(
    rows: Rows, choice: Choice, found: Minimum, error: float = NOISE_FLOOR
) -> Floats:
    """Standard deviation of a residual of each load, as a share of its scale; (L,).

    Parameters
    ----------
    rows, choice, found, error
        As for ``uncertainty``.
    """
    counts, determined = rows.counts, float(found.x.size)
    if choice.expected is not None:
        spread = choice.column("spread")
        slopes, by_prior = found.slopes * spread, choice.apart(found.x)[1] * spread
        information = slopes.T @ slopes
        whole = information + weight_of_priors(rows, choice, error) ** 2 * by_prior.T @ by_prior
        determined = float(np.trace(np.linalg.pinv(whole) @ information))
    share = determined / max(int(counts.sum()), 1)
    parts = [found.residual[rows.of_load(k)] for k in range(len(rows.names))]
    return np.array([_standard_error(part, share) for part in parts])


def _left(deviation: Floats, by_prior: Floats) -> Floats:
    """The ``deviation`` (P,) over that of the priors, whose slopes are (K, P); 0 without one."""
    if not by_prior.size:
        return np.zeros_like(deviation)
    beforehand = np.diag(np.linalg.pinv(by_prior.T @ by_prior))
    known = np.any(by_prior != 0.0, axis=0)
    return np.where(known, deviation / np.sqrt(np.where(known, beforehand, 1.0)), 0.0)


def _stretched(
    ends: Floats,
    narrow: NDArray[np.intp],
    rows: Rows,
    choice: Choice,
    found: Minimum,
    weight: float,
) -> Floats:
    """Ends (2, P) of intervals, in spreads, moved outwards where the model is not linear.

    At an end, with the other parameters where the linear model has the least sum of squares,
    the model is evaluated and made linear anew.  If its least sum of squares there exceeds the
    minimum's by less than the first linear model had it, the end is too near.  Only the ends of
    the parameters with the indices ``narrow`` are looked at.
    """
    spread, lower, upper = (choice.column(a) for a in ("spread", "lower", "upper"))
    evaluator = Evaluator(rows, choice, NOISE_FLOOR)

    def with_priors(at: Floats, residual: Floats, slopes: Floats) -> tuple[Floats, Floats]:
        apart, by_prior = choice.apart(at)
        both = np.concatenate([slopes, weight * by_prior]) * spread
        return np.concatenate([residual, weight * apart]), both

    x = found.x / spread
    residual, slopes = with_priors(found.x, found.residual, found.slopes)
    bounds = (lower / spread, upper / spread)
    first = Quadratic(slopes, slopes @ x - residual, *bounds)
    moved, at_minimum = ends.copy(), float(residual @ residual)
    for k in narrow:
        for side in range(2):
            end = float(ends[side, k])
            foreseen, there = first.profile(k, end)
            if end == bounds[side][k] or foreseen <= at_minimum:
                continue
            r, j = with_priors(there * spread, *evaluator.at(there * spread))
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
    name: str, x: float, ends: tuple[float, float], half: float, held: bool, left: float
) -> tuple[str, bool]:
    """In words, and whether the parameter is identified; ``half`` an interval without bounds."""
    known, (low, high) = described(name), ends
    lower, upper, spread = known.lower, known.upper, known.spread
    if held:
        return f"weak: held by its bound {lower if x - lower < upper - x else upper:g}", False
    if left > HELD_BY_PRIOR:
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


def _beside_prior(verdict: tuple[str, bool], left: float) -> tuple[str, bool]:
    """The verdict with how much of a prior's standard deviation is ``left`` over."""
    text, good = verdict
    text = text.replace("held by its start, the data leave it", "data and prior leave it")
    return f"{text}; {left:.2f} of the prior's deviation is left", good
