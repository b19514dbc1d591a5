"""A whole identification: search, uncertainty, residuals, cross-validation, bootstrap."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.fit.parameters import Choice
from propmap.fit.residuals import rms
from propmap.fit.rows import Rows, remembering
from propmap.fit.search import NOISE_FLOOR, Minimum, search, starts
from propmap.fit.uncertainty import Uncertainty, uncertainty

MEDIAN_TO_DEVIATION = 1.4826
"""Standard deviation over median size, of normal errors."""


@dataclass(frozen=True)
class Settings:
    """How a fit is done.

    starts : searches, the first from the first guess.  loss : "linear" or "soft_l1".
    folds : of the cross-validation, 0 for none.  bootstrap : repetitions, 0 for none.
    seed : of the random starts, folds and draws.
    """

    starts: int = 4
    loss: str = "linear"
    folds: int = 5
    bootstrap: int = 0
    seed: int = 2017


@dataclass(frozen=True)
class Fitted:
    """What came out.

    choice, settings, rows : what went in.  minimum : where the search ended.
    uncertainty : of the free parameters.
    x : (P,).  residual : (M,), model minus measurement in units of the measurement.
    cross_validated : (L,) rms error per load on rows left out, NaN if not done.
    bootstrapped : (B, P) repeated fits on operating points drawn with replacement.
    seconds : of the whole identification.
    """

    choice: Choice
    settings: Settings
    rows: Rows
    minimum: Minimum
    uncertainty: Uncertainty
    residual: Floats
    cross_validated: Floats
    bootstrapped: Floats
    seconds: float

    @property
    def x(self) -> Floats:
        """The free parameters at the minimum (P,)."""
        return self.minimum.x

    @property
    def values(self) -> dict[str, float]:
        """All parameters by name."""
        return self.choice.values(self.x)

    def rms(self, load: int) -> float:
        """Root mean square of the residuals of the load of this index, in its unit."""
        return rms(self.residual[self.rows.of_load(load)])

    def compared(self, load: int) -> tuple[Floats, Floats]:
        """Modelled and measured values of the load of this index, in its unit."""
        mine = self.rows.of_load(load)
        measured = self.rows.measured[mine]
        return measured + self.residual[mine], measured


def fit(rows: Rows, choice: Choice, settings: Settings | None = None) -> Fitted:
    """Identify the free parameters; eq. (18) for level flights.

    rows : what was measured, with its model.  choice : what is free.  settings : how to search,
    by default ``Settings()``.
    Raises ``InputError`` where the data cannot determine anything.
    """
    settings = settings or Settings()
    begin = time.perf_counter()
    rows = replace(rows, model=remembering(rows.model))
    first = starts(choice, settings.starts, settings.seed)
    found = search(rows, choice, first)
    spread_of_errors = uncertainty(rows, choice, found)
    error = NOISE_FLOOR
    if choice.priors or settings.loss != "linear":
        # Only now is known how large errors are, against which priors and outliers count.
        error = _typical_error(rows, settings, found, spread_of_errors)
        again = search(rows, choice, [found.x], loss=settings.loss, error=error)
        found = replace(again, ends=found.ends)
        spread_of_errors = uncertainty(rows, choice, found)
    residual = found.residual * rows.scale / np.where(rows.weight > 0.0, rows.weight, 1.0)
    return Fitted(
        choice,
        settings,
        rows,
        found,
        spread_of_errors,
        residual,
        _cross_validate(rows, choice, settings, found, error),
        _bootstrap(rows, choice, settings, found, error),
        time.perf_counter() - begin,
    )


def _typical_error(rows: Rows, settings: Settings, found: Minimum, sure: Uncertainty) -> float:
    """Standard deviation of a residual as a share of its scale, whatever the outliers."""
    if settings.loss == "linear":
        return float(np.median(sure.error))
    sizes = np.abs(found.residual[rows.weight > 0.0])
    return max(MEDIAN_TO_DEVIATION * float(np.median(sizes)), NOISE_FLOOR)


def _again(rows: Rows, choice: Choice, settings: Settings, found: Minimum, error: float) -> Minimum:
    return search(rows, choice, [found.x], loss=settings.loss, error=error, follow=True)


def _cross_validate(
    rows: Rows, choice: Choice, settings: Settings, found: Minimum, error: float
) -> Floats:
    points = np.unique(rows.point)
    sums, counts = np.zeros(len(rows.names)), np.zeros(len(rows.names))
    if settings.folds < 2 or points.size < 2 * settings.folds:
        return np.full(len(rows.names), np.nan)
    fold = _folds(rows, points, settings)
    for k in range(settings.folds):
        kept = np.zeros(int(points.max()) + 1, bool)
        kept[points] = fold != k
        part = _again(rows.left(kept), choice, settings, found, error)
        value, _ = rows.model(choice.values(part.x), choice.free)
        out = ~kept[rows.point] & (rows.weight > 0.0) & np.isfinite(value)
        np.add.at(sums, rows.load[out], (value - rows.measured)[out] ** 2)
        np.add.at(counts, rows.load[out], 1.0)
    return np.sqrt(sums / np.maximum(counts, 1.0))


def _folds(rows: Rows, points: NDArray[np.intp], settings: Settings) -> NDArray[np.intp]:
    """Which fold each point is in: at random, but whole groups together."""
    rng = np.random.default_rng(settings.seed)
    if rows.group is None:
        return rng.permutation(points.size) % settings.folds
    group = np.zeros(int(points.max()) + 1, int)
    group[rows.point] = rows.group
    labels, index = np.unique(group[points], return_inverse=True)
    return (rng.permutation(labels.size) % settings.folds)[index]


def _bootstrap(
    rows: Rows, choice: Choice, settings: Settings, found: Minimum, error: float
) -> Floats:
    """Parameters refitted to points, or groups, drawn with replacement (B, P)."""
    rng = np.random.default_rng(settings.seed + 1)
    unit = rows.point if rows.group is None else rows.group
    labels, index = np.unique(unit, return_inverse=True)
    repeats = []
    for _ in range(settings.bootstrap):
        drawn = np.bincount(rng.integers(labels.size, size=labels.size), minlength=labels.size)
        weighted = replace(rows, weight=rows.weight * np.sqrt(drawn)[index])
        repeats.append(_again(weighted, choice, settings, found, error).x)
    return np.array(repeats).reshape(settings.bootstrap, len(choice.free))
