"""A whole identification: search, uncertainty, residuals, cross-validation, bootstrap."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from propmap.fit.parameters import Choice
from propmap.fit.residuals import rms_known
from propmap.fit.rows import Rows
from propmap.fit.rows_elsewhere import RowsElsewhere
from propmap.fit.search import NOISE_FLOOR, Minimum, search, starts
from propmap.fit.section_prior import LEAST_ERROR
from propmap.fit.uncertainty import Uncertainty, residual_errors, uncertainty
from propmap.tasks import InTurn, Workers, in_order
from propmap.typing import Floats

MEDIAN_TO_DEVIATION = 1.4826
"""Standard deviation over median size, of normal errors."""


@dataclass(frozen=True)
class Settings:
    """How a fit is done.

    Attributes
    ----------
    starts : int
        Searches, the first from the first guess.
    loss : str
        "linear" or "soft_l1".
    folds : int
        Of the cross-validation, 0 for none.
    bootstrap : int
        Repetitions, 0 for none.
    seed : int
        Of the random starts, folds and draws.
    """

    starts: int = 4
    loss: str = "linear"
    folds: int = 5
    bootstrap: int = 0
    seed: int = 2017


@dataclass(frozen=True)
class Fitted:
    """What came out of a fit of P parameters to M rows of L loads.

    Attributes
    ----------
    choice, settings, rows : Choice, Settings, Rows
        What went in.
    minimum : Minimum
        Where the search ended.
    uncertainty : Uncertainty
        Of the free parameters.
    residual : ndarray, shape (M,)
        Model minus measurement, in the units of the measurement.
    left_out : ndarray, shape (M,)
        Model minus measurement of rows left out of the fit to the others; NaN if not done.
    bootstrapped : ndarray, shape (B, P)
        Repeated fits to operating points drawn with replacement.
    seconds : float
        Duration of the whole identification [s].
    error : float
        Standard deviation of a residual, as a share of its scale, against which priors counted.
    """

    choice: Choice
    settings: Settings
    rows: Rows
    minimum: Minimum
    uncertainty: Uncertainty
    residual: Floats
    left_out: Floats
    bootstrapped: Floats
    seconds: float
    error: float

    @property
    def x(self) -> Floats:
        """The free parameters at the minimum (P,)."""
        return self.minimum.x

    @property
    def values(self) -> dict[str, float]:
        """All parameters by name."""
        return self.choice.values(self.x)

    @property
    def cross_validated(self) -> Floats:
        """Root mean square error of each load (L,) on rows left out; NaN if not done."""
        parts = (self.left_out[self.rows.of_load(k)] for k in range(len(self.rows.names)))
        return np.array([rms_known(part) for part in parts])

    def compared(self, load: int) -> tuple[Floats, Floats]:
        """Modelled and measured values of the ``load`` of this index, in its unit."""
        mine = self.rows.of_load(load)
        measured = self.rows.measured[mine]
        return measured + self.residual[mine], measured


def fit(
    rows: Rows,
    choice: Choice,
    settings: Settings | None = None,
    fewer: Rows | None = None,
    *,
    workers: Workers | None = None,
    remake: Callable[[], Rows] | None = None,
) -> Fitted:
    """Identify the free parameters; for level flights this is eq. (18).

    Parameters
    ----------
    rows : Rows
        What was measured, with its model.
    choice : Choice
        Which parameters are free.
    settings : Settings, optional
        How to search.
    fewer : Rows, optional
        A part of the rows, to search from several starts at less cost; the best end is followed
        on all rows.
    workers : Workers, optional
        Who makes the refits of the bootstrap; by default this process.
    remake : callable, optional
        Gives the rows again in another process, where workers are others.

    Raises
    ------
    InputError
        Where the data cannot determine anything.
    """
    settings = settings or Settings()
    begin = time.perf_counter()
    error = NOISE_FLOOR if choice.expected is None else LEAST_ERROR
    again = choice.priors or choice.expected is not None or settings.loss != "linear"
    begin_at = starts(choice, settings.starts, settings.seed)
    alone = fewer is None and not again
    found = search(fewer or rows, choice, begin_at, error=error, polish=alone)
    if fewer is not None and not again:
        better = search(rows, choice, [found.x], error=error)
        found = replace(better, ends=found.ends)
    if again:
        # Only now is known how large errors are, against which priors and outliers count.
        error = _typical_error(fewer or rows, choice, settings, found, error)
        if choice.expected is not None:
            error = max(error, LEAST_ERROR)
        better = search(rows, choice, [found.x], loss=settings.loss, error=error)
        found = replace(better, ends=found.ends)
    sure = uncertainty(rows, choice, found, error)

    refit = _Refit(rows, remake, choice, found.x, settings.loss, error)
    residual = found.residual * rows.scale / np.where(rows.weight > 0.0, rows.weight, 1.0)
    crossed = _cross_validate(rows, choice, settings, refit)
    bootstrapped = _bootstrap(refit, settings, workers or InTurn())
    seconds = time.perf_counter() - begin
    return Fitted(
        choice, settings, rows, found, sure, residual, crossed, bootstrapped, seconds, error
    )


def _typical_error(
    rows: Rows, choice: Choice, settings: Settings, found: Minimum, error: float
) -> float:
    """Standard deviation of a residual as a share of its scale, whatever the outliers."""
    if settings.loss == "linear":
        return float(np.median(residual_errors(rows, choice, found, error)))
    sizes = np.abs(found.residual[rows.weight > 0.0])
    return max(MEDIAN_TO_DEVIATION * float(np.median(sizes)), NOISE_FLOOR)


def _cross_validate(
    rows: Rows, choice: Choice, settings: Settings, refit: Callable[[Rows], Floats]
) -> Floats:
    """Model minus measurement (M,) where a row's unit was left out of the fit."""
    left_out = np.full(rows.measured.size, np.nan)
    if settings.folds < 2 or np.unique(rows.point).size < 2 * settings.folds:
        return left_out
    labels, index = np.unique(rows.unit, return_inverse=True)
    rng = np.random.default_rng(settings.seed)
    fold = (rng.permutation(labels.size) % settings.folds)[index]
    for k in range(settings.folds):
        value, _ = rows.model(choice.values(refit(rows.left(fold != k))), choice.free)
        out = (fold == k) & (rows.weight > 0.0)
        left_out[out] = (value - rows.measured)[out]
    return left_out


class _Refit(RowsElsewhere):
    """Fits much the same rows again; what is sent to another process remakes the rows there."""

    def __init__(
        self,
        rows: Rows,
        remake: Callable[[], Rows] | None,
        choice: Choice,
        start: Floats,
        loss: str,
        error: float,
    ) -> None:
        self.rows, self.remake = rows, remake
        self.choice, self.start, self.loss, self.error = choice, start, loss, error

    def __call__(self, part: Rows) -> Floats:
        """The parameters (P,) that fit some rows."""
        start = [self.start]
        return search(part, self.choice, start, loss=self.loss, error=self.error, follow=True).x


def _bootstrap(refit: _Refit, settings: Settings, workers: Workers) -> Floats:
    """Parameters refitted to units drawn with replacement (B, P)."""
    rng = np.random.default_rng(settings.seed + 1)
    labels, index = np.unique(refit.rows.unit, return_inverse=True)
    drawn = [
        np.bincount(rng.integers(labels.size, size=labels.size), minlength=labels.size)[index]
        for _ in range(settings.bootstrap)
    ]
    repeats = in_order(workers.results(_refit_to, refit, drawn))
    return np.array(repeats).reshape(settings.bootstrap, len(refit.choice.free))


def _refit_to(refit: _Refit, drawn: NDArray[np.intp]) -> Floats:
    """The parameters by rows that count as often as they were drawn (M,)."""
    rows = refit.rows
    return refit(replace(rows, weight=rows.weight * np.sqrt(drawn)))
