"""Uncertainty of fitted parameters: intervals within bounds, and errors correlated in blocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.fit.least_squares import NOISE_FLOOR, Evaluator, Minimum, Rows, weight_of_priors
from propmap.fit.parameters import LEAST_ERROR, LINEAR, Choice, described, general
from propmap.typing import Floats

AT_BOUND = 1e-6  # largest distance of a parameter from its bound, in units of ``Parameter.spread``

HELD_BY_PRIOR = 0.7  # standard deviation / that of the prior, above which the prior dominates
LARGEST_STRETCH = 4.0  # largest factor that widens one side of an interval

NEGLIGIBLE = 1e-6
"""Ratio to the largest singular value, below which data do not determine a direction.  The square
of this ratio must exceed the relative rounding error of the largest squared singular value."""


@dataclass(frozen=True)
class Uncertainty:
    """Uncertainty of P parameters.

    Attributes
    ----------
    covariance : ndarray, shape (P, P)
        Covariance, ignoring the bounds.  The variance of a parameter that the data do not determine
        is infinite.
    low, high : ndarray, shape (P,)
        Ends of the 95 % intervals, within the bounds.
    correlation : ndarray, shape (P, P)
        Correlation of the errors [-].
    singular_values : ndarray, shape (P,)
        Singular values of the Jacobian of the residuals, divided by the largest of them.  The unit
        of each parameter is its typical difference between propellers or vehicles.
    verdicts : tuple of str
        Sentence on each parameter.
    identified : tuple of bool
        Whether the data determine each parameter.
    error : ndarray, shape (L,)
        Standard deviation of a residual of each load, as a share of its scale.
    left : ndarray, shape (P,)
        Standard deviation / that of the prior [-]: 1 if data add nothing, 0 without a prior.
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
    """Return the Gauss-Newton uncertainty, with errors as large as the residuals of each load.

    For rows in segments, ``block_errors`` counts each segment as one measurement.  For other rows
    with a prior from other propellers, errors are correlated and at least ``LEAST_ERROR``.  Fits
    with such a prior use ``error``, the argument of ``search``.
    """
    from scipy.special import stdtrit  # scipy.stats takes half a second to import

    x = found.x
    spread, lower, upper = (choice.column(a) for a in ("spread", "lower", "upper"))
    seen = np.linalg.norm(found.slopes, axis=0) * spread
    # A parameter at a bound is held by the data, unless the residuals do not depend on it.
    held = (x - lower < AT_BOUND * spread) | (upper - x < AT_BOUND * spread)
    held &= seen > NEGLIGIBLE * max(float(seen.max()), 1e-300)
    used = rows.weight > 0.0
    counts = rows.counts
    from_prior, by_prior = choice.prior_residuals(x)
    by_prior = by_prior * spread
    slopes = found.slopes * spread
    information, prior_information = slopes.T @ slopes, by_prior.T @ by_prior
    errors = residual_errors(rows, choice, found, error)
    if choice.expected is None:
        error = float(np.sqrt(np.sum(counts * errors**2) / max(counts.sum(), 1)))
    weight = weight_of_priors(rows, choice, error)
    whole, by_priors = information + weight**2 * prior_information, weight**4 * prior_information
    freedom: Floats | int
    if rows.group is not None:
        stretches = slopes[used], found.residual[used], rows.group[used]
        middle, freedom = block_errors(*stretches, whole, by_priors)
    elif choice.expected is not None:
        shared = counts / np.maximum(rows.independent, 1.0)
        variance = shared * np.maximum(errors, LEAST_ERROR) ** 2
        middle = (slopes * variance[rows.load][:, None]).T @ slopes
        freedom = max(round(float(rows.independent.sum())), 1)
    else:
        middle = (slopes * errors[rows.load][:, None] ** 2).T @ slopes
        freedom = max(int(counts.sum()) - x.size, 1)
    covariance, inverse, root = _sandwich(whole, middle + by_priors)
    covariance = covariance * np.outer(spread, spread)
    deviation = np.sqrt(np.diag(covariance))
    # At a minimum, the sum of squares could decrease only beyond bounds.
    uphill = slopes.T @ found.residual + weight**2 * (by_prior.T @ from_prior)
    center = x / spread - inverse @ np.where(held, uphill, 0.0)
    quantile = np.broadcast_to(stdtrit(freedom, 0.975), x.shape)
    low, high = bounded_intervals(center, root, lower / spread, upper / spread, quantile)
    ends = np.stack([np.minimum(low, x / spread), np.maximum(high, x / spread)])
    bent = np.array([general(name) not in LINEAR for name in choice.free])
    narrow = np.flatnonzero(~held & bent & (ends[1] - ends[0] <= 1.0))
    low, high = _stretched(ends, narrow, rows, choice, found, weight) * spread
    singular = np.zeros(x.size)
    # Fewer rows than parameters give fewer singular values; the others are zero.
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
    relative = np.asarray(singular / max(float(singular[0]), 1e-300))
    texts, good = tuple(text for text, _ in judged), tuple(good for _, good in judged)
    return Uncertainty(covariance, low, high, correlation, relative, texts, good, errors, left)


def residual_errors(
    rows: Rows, choice: Choice, found: Minimum, error: float = NOISE_FLOOR
) -> Floats:
    """Return the standard deviation of a residual of each load (L,), as a share of its scale."""
    counts, determined = rows.counts, float(found.x.size)
    if choice.expected is not None:
        spread = choice.column("spread")
        slopes, by_prior = found.slopes * spread, choice.prior_residuals(found.x)[1] * spread
        information = slopes.T @ slopes
        whole = information + weight_of_priors(rows, choice, error) ** 2 * by_prior.T @ by_prior
        determined = float(np.trace(np.linalg.pinv(whole) @ information))
    share = determined / max(int(counts.sum()), 1)
    parts = [found.residual[rows.of_load(k)] for k in range(len(rows.names))]
    return np.array([_standard_error(part, share) for part in parts])


def _left(deviation: Floats, by_prior: Floats) -> Floats:
    """Return ``deviation`` (P,) divided by the deviation of the prior; 0 without a prior."""
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
    """Return ``ends`` (2, P) of intervals, in units of ``Parameter.spread``.

    The sum of squares at each end of a parameter in ``narrow`` is computed by linearization at the
    minimum and by linearization at that end.  If the second result is smaller, widen the interval.
    """
    spread, lower, upper = (choice.column(a) for a in ("spread", "lower", "upper"))
    evaluator = Evaluator(rows, choice, NOISE_FLOOR)

    def linearized(at: Floats, residual: Floats, slopes: Floats) -> tuple[Quadratic, float]:
        """Return the sum of squares with priors, linearized at ``at``, and its value there."""
        from_prior, by_prior = choice.prior_residuals(at * spread)
        r = np.concatenate([residual, weight * from_prior])
        j = np.concatenate([slopes, weight * by_prior]) * spread
        # The triangular factor has P + 1 rows and the same sum of squares as all rows.
        reduced = np.asarray(np.linalg.qr(np.column_stack([j, j @ at - r]), mode="r"))
        return Quadratic(reduced[:, :-1], reduced[:, -1], *bounds), float(r @ r)

    x = found.x / spread
    bounds = (lower / spread, upper / spread)
    first, at_minimum = linearized(x, found.residual, found.slopes)
    stretched = ends.copy()
    for k in narrow:
        for side in range(2):
            end = float(ends[side, k])
            foreseen, there = first.profile(k, end)
            if end == bounds[side][k] or foreseen <= at_minimum:
                continue
            at = np.clip(there * spread, lower, upper)
            least, _ = linearized(there, *evaluator.at(at))[0].profile(k, end)
            share = (least - at_minimum) / (foreseen - at_minimum)
            stretch = max(1.0, max(share, LARGEST_STRETCH**-2) ** -0.5)
            stretched[side, k] = x[k] + stretch * (end - x[k])
    return np.clip(stretched, *bounds)


def _standard_error(residual: Floats, share: float) -> float:
    """Return the standard error of residuals with ``share`` fitted parameters per residual."""
    if residual.size == 0:
        return NOISE_FLOOR
    freedom = max(residual.size * (1.0 - share), 1.0)
    return max(float(np.sqrt(residual @ residual / freedom)), NOISE_FLOOR)


def _sandwich(information: Floats, middle: Floats) -> tuple[Floats, Floats, Floats]:
    """Return three matrices for parameters in units of ``Parameter.spread``.

    The first is the covariance inverse(information) middle inverse(information), with infinite
    variances for parameters that the data do not determine.  The second is inverse(information),
    zero in the directions that the data do not determine.  The third is W (R, P) of
    ``bounded_intervals``.
    """
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
    return covariance, inverse, root


def _verdict(
    name: str, x: float, ends: tuple[float, float], half: float, held: bool, left: float
) -> tuple[str, bool]:
    """Return a verdict, and whether it is "identified"; ``half``: half width without bounds."""
    known, (low, high) = described(name), ends
    lower, upper, spread = known.lower, known.upper, known.spread
    if held:
        return f"weak: at its bound {lower if x - lower < upper - x else upper:g}", False
    if left > HELD_BY_PRIOR:
        return "weak: determined mainly by its prior", False
    if high - low <= spread:
        alone = half <= 0.5 * spread
        return "identified" if alone else "identified, given the bounds of other parameters", True
    if low == lower and high == upper:
        return f"weak: the data do not determine {name}; its value depends on its start", False
    return (
        f"weak: the data allow {low:.3g} to {high:.3g}, wider than the typical difference "
        f"between propellers, {spread:g}",
        False,
    )


def _beside_prior(verdict: tuple[str, bool], left: float) -> tuple[str, bool]:
    """Return the verdict with the share of the prior's standard deviation that is ``left``."""
    text, good = verdict
    text = text.replace("the data allow", "data and prior allow")
    return f"{text}; standard deviation {left:.2f} times that of the prior", good


# --- Confidence intervals of parameters with bounds ----------------------------------------------


class Quadratic(NamedTuple):
    """A sum of squares |slopes x - target|^2 within bounds; slopes (R, P), bounds (P,)."""

    slopes: Floats
    target: Floats
    lower: Floats
    upper: Floats

    def profile(self, k: int, value: float) -> tuple[float, Floats]:
        """Return the least sum of squares with parameter k at ``value``, and x (P,) there."""
        from scipy.optimize import lsq_linear

        rest = np.arange(self.lower.size) != k
        wanted = self.target - self.slopes[:, k] * value
        x = np.full(self.lower.size, value)
        if not rest.any():
            return float(wanted @ wanted), x
        bounds = (self.lower[rest], self.upper[rest])
        inside = lsq_linear(self.slopes[:, rest], wanted, bounds, "bvls")
        x[rest] = inside.x
        return 2.0 * float(inside.cost), x


def bounded_intervals(
    center: Floats, root: Floats, lower: Floats, upper: Floats, quantile: Floats | float
) -> tuple[Floats, Floats]:
    """Return the ends (P,) of the profile intervals of |W (x - center)|^2 within bounds, where W is
    ``root`` (R, P).

    For each value of a parameter, the sum of squares is minimized over the other parameters within
    bounds.  The interval contains the values at which this sum exceeds the minimum by at most the
    square of ``quantile`` of Student's t.  Far from bounds, it is center +- quantile * deviation.
    """
    from scipy.optimize import brentq, lsq_linear

    squares = Quadratic(root, root @ center, lower, upper)
    best = lsq_linear(root, squares.target, (lower, upper), "bvls")
    each = np.broadcast_to(quantile, center.shape)
    ends = np.empty((2, center.size))
    for k, middle in enumerate(best.x):
        allowed = 2.0 * float(best.cost) + float(each[k]) ** 2

        def beyond(v: float, k: int = k, allowed: float = allowed) -> float:
            return squares.profile(k, v)[0] - allowed

        for side, bound in enumerate((lower[k], upper[k])):
            ends[side, k] = bound
            if bound != middle and beyond(bound) > 0.0:
                ends[side, k] = brentq(beyond, middle, bound)
    return ends[0], ends[1]


# --- Errors of parameters from residuals that are correlated within segments of the data ---------

MOST_ALONE = 0.9  # upper limit of the share of one segment in the information on a direction


def block_errors(
    slopes: Floats, residual: Floats, group: NDArray[np.intp], whole: Floats, by_priors: Floats
) -> tuple[Floats, Floats]:
    """Return the cluster-robust covariance (P, P) of the gradient of half the sum of squares, and
    Satterthwaite's degrees of freedom (P,).

    ``slopes`` are (M, P), and ``group`` numbers the segments.  The residuals of a segment are those
    of a fit without it (CR3 of Bell and McCaffrey, Survey Methodology 28, 2002, page 169).  With
    few segments, the residuals of a fit to all segments are too small.  Some errors last longer
    than a segment: a positive covariance of consecutive segments, with consecutive numbers in
    ``group``, adds to the variance.  ``whole`` is the information of data and priors, and
    ``by_priors`` is the part of the priors in the covariance.
    """
    labels, index = np.unique(group, return_inverse=True)
    floor = np.where(np.abs(residual) < NOISE_FLOOR, NOISE_FLOOR * np.sign(residual), residual)
    values, vectors = np.linalg.eigh(whole)
    seen = values > 1e-12 * max(float(values[-1]), 1e-300)
    root = vectors[:, seen] * np.sqrt(values[seen])
    back = (vectors[:, seen] / np.sqrt(values[seen])).T
    each, evenness = np.zeros((2, labels.size, whole.shape[0]))
    for k in range(labels.size):
        mine = slopes[index == k]
        score = back @ (mine.T @ floor[index == k])
        share = back @ mine.T @ mine @ back.T
        alone, ways = np.linalg.eigh(share)
        each[k] = root @ ways @ ((ways.T @ score) / (1.0 - np.minimum(alone, MOST_ALONE)))
        evenness[k] = np.einsum("sp,st,tp->p", back, share, back)
    small = max(labels.size - 1, 1) / labels.size
    inverse = back.T @ back
    moved, follows = each @ inverse, np.diff(labels) == 1
    shared = 2.0 * np.sum((moved[:-1] * moved[1:])[follows], axis=0)
    wider = np.sqrt(1.0 + np.maximum(shared, 0.0) / np.maximum(np.sum(moved**2, axis=0), 1e-300))
    turned = whole * wider
    middle = turned @ inverse @ each.T @ each @ inverse @ turned.T
    of_data = np.einsum("pq,qr,rp->p", inverse, small * middle, inverse)
    of_priors = np.einsum("pq,qr,rp->p", inverse, by_priors, inverse)
    squares = np.sum(evenness**2, axis=0)
    counted = np.sum(evenness, axis=0) ** 2 / np.where(squares > 0.0, squares, 1.0)
    counted = np.clip(counted, 1.0, max(labels.size - 1, 1))
    # The variance from priors is exact, which increases the degrees of freedom.
    both = of_data + of_priors
    unknown = np.where(both > 0.0, of_data / np.where(both > 0.0, both, 1.0), 1.0)
    return small * middle, counted / np.maximum(unknown, 1e-3) ** 2
