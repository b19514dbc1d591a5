"""Bounded nonlinear least squares from several starts; eq. (18)."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from propmap.arrays.types import Floats
from propmap.errors import InputError
from propmap.fit.parameters import Choice
from propmap.fit.rows import Rows

Jacobian = Callable[[Floats], Floats]

NOISE_FLOOR = 1e-3
"""Smallest standard deviation assumed for a residual, relative to its scale: the accuracy of the
computed loads."""

SAME_MINIMUM = 1e-3
"""Distance, in units of the parameters' spreads, within which two ends are one minimum."""

DIFFERENCE = 1e-5
"""Step of difference quotients, in spreads."""

ON_BOUND = 1e-9
"""Distance from a bound, in spreads, that is no distance: the search stays inside the bounds."""

EVALUATIONS, FINAL_EVALUATIONS = 20, 30
"""Evaluations of the model at most: from each start, and to polish the best end."""

REFIT_EVALUATIONS = 6
"""The same where a known minimum is only followed, as in cross-validation."""

MOST_UNSOLVED = 0.05
"""Share of the rows that may have no solution in the model."""


@dataclass(frozen=True)
class End:
    """Where a search from one start ended: x (P,) with half the sum of squares as cost [-]."""

    start: Floats
    x: Floats
    cost: float
    evaluations: int


@dataclass(frozen=True)
class Minimum:
    """The best end x (P,), residuals (M,) as shares of their scales and their derivatives (M, P);
    all ends, best first; how many rows the model gave no value for.
    """

    x: Floats
    residual: Floats
    slopes: Floats
    ends: tuple[End, ...]
    unsolved: int


class Evaluator:
    """Residuals of a fit and their derivatives together, kept for the x asked for last."""

    def __init__(self, rows: Rows, choice: Choice, error: float) -> None:
        self.rows, self.choice, self.error, self.count = rows, choice, error, 0
        self._x: Floats | None = None
        self.mean, self.deviation = choice.prior_columns
        self.known = np.isfinite(self.deviation)
        self.unsolved = 0

    def at(self, x: Floats) -> tuple[Floats, Floats]:
        """Residuals (M,) as shares of their scales and derivatives (M, P), without priors."""
        if self._x is None or not np.array_equal(x, self._x):
            self.count += 1
            rows = self.rows
            value, slope = rows.model(self.choice.values(x), self.choice.free)
            lost = ~np.isfinite(value) | ~np.isfinite(slope).all(axis=1)
            self.unsolved = int(lost.sum())
            keep = np.where(lost, 0.0, rows.weight / rows.scale)
            self._residual = keep * np.where(lost, 0.0, value - rows.measured)
            self._slope = keep[:, None] * np.where(lost[:, None], 0.0, slope)
            self._x = x.copy()
        return self._residual, self._slope

    def residual(self, x: Floats) -> Floats:
        """The same with priors' residuals below."""
        prior = (x - self.mean) / self.deviation
        return np.concatenate([self.at(x)[0], self.error * prior[self.known]])

    def difference_quotients(self, x: Floats) -> Floats:
        """The Jacobian of the residuals as computed.

        Where inflow rises steeply it differs from ``jacobian`` by up to some per cent; see
        docs/theory.md, known limits.
        """
        here = self.residual(x)
        columns = []
        for k, (spread, upper) in enumerate(
            zip(self.choice.column("spread"), self.choice.column("upper"), strict=True)
        ):
            step = DIFFERENCE * spread * (1.0 if x[k] + DIFFERENCE * spread <= upper else -1.0)
            moved = x.copy()
            moved[k] += step
            columns.append((self.residual(moved) - here) / step)
        return np.stack(columns, axis=1)

    def jacobian(self, x: Floats) -> Floats:
        """Derivatives of ``residual``."""
        prior = np.diag(1.0 / self.deviation)[self.known]
        return np.concatenate([self.at(x)[1], self.error * prior])


def starts(choice: Choice, count: int, seed: int) -> list[Floats]:
    """The first guess and ``count`` - 1 more, at random within three spreads of it."""
    rng = np.random.default_rng(seed)
    low, high, spread = choice.column("lower"), choice.column("upper"), choice.column("spread")
    more = [
        np.clip(choice.first + rng.uniform(-3.0, 3.0, low.size) * spread, low, high)
        for _ in range(count - 1)
    ]
    return [choice.first, *more]


def search(
    rows: Rows,
    choice: Choice,
    begin: list[Floats],
    *,
    loss: str = "linear",
    error: float = NOISE_FLOOR,
    follow: bool = False,
) -> Minimum:
    """The best minimum over all starts, each (P,).

    ``loss`` is "linear", or "soft_l1" so that a few outliers do not decide.  ``error`` is the
    standard deviation of a residual as a share of its scale: priors are weighed against it, and
    twice it is an outlier.  ``follow`` says that the start is a minimum of much the same data, so
    that few steps do.

    Raises ``InputError`` where there are fewer numbers than parameters, or where the model has
    no solution for more than one row in twenty.
    """
    from scipy.optimize import least_squares

    used = int(np.count_nonzero(rows.weight))
    if used + len(choice.priors) < len(choice.free):
        raise InputError(
            f"{used} measured numbers for {len(choice.free)} free parameters",
            "give more data or free fewer parameters",
        )
    evaluator = Evaluator(rows, choice, error)
    bounds = (choice.column("lower"), choice.column("upper"))

    def run(
        x0: Floats,
        evaluations: int,
        step: float,
        gain: float,
        jacobian: Jacobian = evaluator.jacobian,
    ) -> tuple[Floats, float]:
        inside = np.clip(x0, *bounds)
        with warnings.catch_warnings():
            # At a bound SciPy divides by a zero distance and goes on.
            warnings.simplefilter("ignore", RuntimeWarning)
            found = least_squares(
                evaluator.residual,
                inside,
                jacobian,
                bounds=bounds,
                x_scale=choice.column("spread"),
                loss=loss,
                f_scale=2.0 * error,
                ftol=gain,
                xtol=step,
                gtol=1e-15,
                max_nfev=evaluations,
            )
        return np.asarray(found.x), float(found.cost)

    allowance = (REFIT_EVALUATIONS, 1e-4, 1e-4) if follow else (EVALUATIONS, 1e-5, 1e-5)
    ends = []
    for x0 in begin:
        before = evaluator.count
        x, cost = run(x0, *allowance)
        ends.append(End(x0, x, cost, evaluator.count - before))
    ends.sort(key=lambda end: end.cost)
    x = ends[0].x
    if not follow:
        best = ends[0].cost
        polished, cost = run(x, FINAL_EVALUATIONS, 1e-9, 1e-9)
        x, best = (polished, cost) if cost <= best else (x, best)
        if np.sqrt(2.0 * best / used) < NOISE_FLOOR:
            # So near to a perfect fit the errors of the derivatives would end the search early.
            # Where priors or noise leave more than those errors, the first step gains little.
            exact = evaluator.difference_quotients
            polished, cost = run(x, FINAL_EVALUATIONS, 1e-12, 1e-4, exact)
            x = polished if cost <= best else x
    for bound in bounds:
        x = np.where(np.abs(x - bound) < ON_BOUND * choice.column("spread"), bound, x)
    residual, slopes = (a.copy() for a in evaluator.at(x))
    if evaluator.unsolved > MOST_UNSOLVED * rows.measured.size:
        raise InputError(
            f"the model has no solution at {evaluator.unsolved} of {rows.measured.size} rows",
            "check the units of the operating points",
        )
    return Minimum(x, residual, slopes, tuple(ends), evaluator.unsolved)


def minima(ends: tuple[End, ...], spread: Floats) -> list[list[int]]:
    """Indices of ``ends`` that are the same minimum, best first."""
    groups: list[list[int]] = []
    for k, end in enumerate(ends):
        for group in groups:
            best = ends[group[0]]
            near = np.max(np.abs(end.x - best.x) / spread) < SAME_MINIMUM
            if near or abs(end.cost - best.cost) <= 1e-6 * best.cost:
                group.append(k)
                break
        else:
            groups.append([k])
    return groups
