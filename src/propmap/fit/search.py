"""Bounded nonlinear least squares from several starts; eq. (18)."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import msgspec
import numpy as np

from propmap.errors import InputError
from propmap.fit.parameters import Choice
from propmap.fit.rows import Rows
from propmap.typing import Floats

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

FINE = 1e-6, 1e-8
"""Steps and gains, relative, with which the polishing ends.  Smaller steps are within the errors of
the derivatives, and are all refused."""

REFIT_EVALUATIONS = 6
"""The same where a known minimum is only followed, as in cross-validation."""

FAR = 1.5
"""Standard deviations of a prior within which searches start."""

MOST_UNSOLVED = 0.05
"""Share of the rows that may have no solution in the model."""

ONE_OF_FEW = 0.2
"""The same where they are of one operating point."""


class End(msgspec.Struct, frozen=True):
    """Where a search from one start ended.

    Attributes
    ----------
    start, x : ndarray, shape (P,)
        First and last parameters.
    cost : float
        Half the sum of squares [-].
    minimum : int
        The number of its minimum, from 1 for the best.
    """

    start: Floats
    x: Floats = msgspec.field(name="end")
    cost: float
    minimum: int = 1


@dataclass(frozen=True)
class Minimum:
    """The best end of a search.

    Attributes
    ----------
    x : ndarray, shape (P,)
        Parameters.
    residual, slopes : ndarray, shape (M,) and (M, P)
        Residuals as shares of their scales, and their derivatives.
    ends : tuple of End
        All ends, best first.
    unsolved : int
        Rows that the model gave no value for.
    """

    x: Floats
    residual: Floats
    slopes: Floats
    ends: tuple[End, ...]
    unsolved: int


class Evaluator:
    """Residuals of a fit and their derivatives."""

    def __init__(self, rows: Rows, choice: Choice, error: float) -> None:
        self.rows, self.choice = rows, choice
        self.weight = weight_of_priors(rows, choice, error)
        self.unsolved = 0

    def at(self, x: Floats) -> tuple[Floats, Floats]:
        """Residuals (M,) as shares of their scales and derivatives (M, P), without priors."""
        rows = self.rows
        value, slope = rows.model(self.choice.values(x), self.choice.free)
        lost = ~np.isfinite(value) | ~np.isfinite(slope).all(axis=1)
        self.unsolved = int(lost.sum())
        keep = np.where(lost, 0.0, rows.weight / rows.scale)
        residual = keep * np.where(lost, 0.0, value - rows.measured)
        return residual, keep[:, None] * np.where(lost[:, None], 0.0, slope)

    def residual(self, x: Floats) -> Floats:
        """The same with priors' residuals below."""
        return np.concatenate([self.at(x)[0], self.weight * self.choice.apart(x)[0]])

    def jacobian(self, x: Floats) -> Floats:
        """Derivatives of ``residual``."""
        return np.concatenate([self.at(x)[1], self.weight * self.choice.apart(x)[1]])

    def difference_quotients(self, x: Floats) -> Floats:
        """The Jacobian of the residuals as computed.

        Where inflow rises steeply it differs from ``jacobian`` by up to some per cent; see
        docs/theory.md, known limits.
        """
        from scipy.optimize import approx_fprime

        step = DIFFERENCE * self.choice.column("spread")
        inwards = np.where(x + step <= self.choice.column("upper"), step, -step)
        return np.asarray(approx_fprime(x, self.residual, inwards))


def weight_of_priors(rows: Rows, choice: Choice, error: float) -> float:
    """By which deviations from priors are multiplied to count beside residuals.

    This is the standard deviation ``error`` of a residual, where every row is a number of its own.
    Of whole flights, and beside what is known of propellers in general, rows are worth
    ``rows.independent``.
    """
    if choice.expected is None and rows.group is None:
        return error
    return error * float(np.sqrt(rows.counts.sum() / max(float(rows.independent.sum()), 1.0)))


def starts(choice: Choice, count: int, seed: int) -> list[Floats]:
    """The first guess and ``count`` - 1 more, at random within three spreads of it.

    None is further than ``FAR`` standard deviations from what other propellers let expect.
    """
    away = np.random.default_rng(seed).uniform(-3.0, 3.0, (count - 1, len(choice.free)))
    away = away * choice.column("spread")
    if choice.expected is not None:
        known = [choice.expected.of_constant(name) or (0.0, np.inf) for name in choice.free]
        most = FAR * np.array([deviation for _, deviation in known])
        away = np.clip(away, -most, most)
    return [
        choice.first,
        *np.clip(choice.first + away, choice.column("lower"), choice.column("upper")),
    ]


def search(
    rows: Rows,
    choice: Choice,
    begin: list[Floats],
    *,
    loss: str = "linear",
    error: float = NOISE_FLOOR,
    follow: bool = False,
    polish: bool = True,
) -> Minimum:
    """The best minimum over all starts.

    Parameters
    ----------
    rows, choice : Rows, Choice
        What was measured, and which parameters are free.
    begin : list of ndarray, shape (P,)
        The starts.
    loss : str
        "linear", or "soft_l1" so that a few outliers do not decide.
    error : float
        Standard deviation of a residual as a share of its scale: priors are weighed against it,
        and twice it is an outlier.
    follow : bool
        Whether the start is a minimum of much the same data, so that few steps do.
    polish : bool
        Whether the best end is followed to the last digit, where it is not ``follow``.

    Raises
    ------
    InputError
        Where there are fewer numbers than parameters, or where the model has no solution for more
        than one row in twenty, or of few rows for more than those of one operating point.
    """
    from scipy.optimize import least_squares

    used = int(np.count_nonzero(rows.weight))
    first = choice.first
    if used + choice.apart(first)[0].size < first.size:
        raise InputError(
            f"{used} measured numbers for {len(choice.free)} free parameters",
            "give more data or free fewer parameters",
        )
    evaluator = Evaluator(rows, choice, error)
    softened = functools.partial(_softened, rows.measured.size)
    lower, upper, spread = (choice.column(a) for a in ("lower", "upper", "spread"))

    def run(
        x0: Floats, most: int, step: float, gain: float, jacobian: Jacobian = evaluator.jacobian
    ) -> End:
        with warnings.catch_warnings():
            # At a bound SciPy divides by a zero distance and goes on.
            warnings.simplefilter("ignore", RuntimeWarning)
            found = least_squares(
                evaluator.residual,
                np.clip(x0, lower, upper),
                jacobian,
                bounds=(lower, upper),
                x_scale=spread,
                loss="linear" if loss == "linear" else softened,
                f_scale=2.0 * error,
                ftol=gain,
                xtol=step,
                gtol=1e-15,
                max_nfev=most,
            )
        return End(x0, np.asarray(found.x), float(found.cost))

    allowance = (REFIT_EVALUATIONS, 1e-4, 1e-4) if follow else (EVALUATIONS, 1e-5, 1e-5)
    if polish and not follow and len(begin) == 1:
        allowance = (FINAL_EVALUATIONS, *FINE)
    ends = minima([run(x0, *allowance) for x0 in begin], spread)
    best = ends[0]
    if polish and not follow:
        if len(begin) > 1:
            best = min(run(best.x, FINAL_EVALUATIONS, *FINE), best, key=_cost)
        if np.sqrt(2.0 * best.cost / used) < NOISE_FLOOR:
            # So near to a perfect fit the errors of the derivatives would end the search early.
            # Where priors or noise leave more than those errors, the first step gains little.
            exact = evaluator.difference_quotients
            best = min(run(best.x, FINAL_EVALUATIONS, 1e-12, 1e-4, exact), best, key=_cost)
    x = best.x
    for bound in (lower, upper):
        x = np.where(np.abs(x - bound) < ON_BOUND * spread, bound, x)
    residual, slopes = evaluator.at(x)
    size = rows.measured.size
    if evaluator.unsolved > max(MOST_UNSOLVED * size, min(len(rows.names), ONE_OF_FEW * size)):
        raise InputError(
            f"the model has no solution at {evaluator.unsolved} of {rows.measured.size} rows",
            "check the units of the operating points",
        )
    return Minimum(x, residual, slopes, ends, evaluator.unsolved)


def _softened(rows: int, squares: Floats) -> Floats:
    """SciPy's ``soft_l1`` of so many first squares; priors, which follow, are no outliers."""
    more = 1.0 + squares
    found = np.array([2.0 * (more**0.5 - 1.0), more**-0.5, -0.5 * more**-1.5])
    found[:, rows:] = [squares[rows:], np.ones(squares.size - rows), np.zeros(squares.size - rows)]
    return found


def _cost(end: End) -> float:
    return end.cost


def minima(ends: list[End], spread: Floats) -> tuple[End, ...]:
    """The ends by rising cost, each with the number of its minimum."""
    bests: list[End] = []
    found = []
    for end in sorted(ends, key=_cost):
        for best in bests:
            near = np.max(np.abs(end.x - best.x) / spread) < SAME_MINIMUM
            if near or abs(end.cost - best.cost) <= 1e-6 * best.cost:
                break
        else:
            best = msgspec.structs.replace(end, minimum=len(bests) + 1)
            bests.append(best)
        found.append(msgspec.structs.replace(end, minimum=best.minimum))
    return tuple(found)
