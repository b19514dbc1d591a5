"""Bounded nonlinear least squares from several starts, eq. (18), and the rows of a fit."""

from __future__ import annotations

import functools
import itertools
import operator
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.fit.parameters import Choice
from propmap.typing import Floats

NOISE_FLOOR = 1e-3  # least error of a residual as a share of its scale: numerical error of loads
# In units of ``Parameter.spread``:
SAME_MINIMUM = 1e-3  # largest distance between end points of searches that found the same minimum
DIFFERENCE = 1e-5  # step of difference quotients
ON_BOUND = 1e-9  # a parameter closer to a bound is moved to the bound
EVALUATIONS, FINAL_EVALUATIONS = 20, 30  # most evaluations of each search, and of the finer one
# Relative step and gain that end a fine search.  Errors of the derivatives prevent smaller steps.
FINE = 1e-6, 1e-8
REFIT_EVALUATIONS = 6  # most evaluations from a known minimum, as in cross-validation
FAR = 1.5  # largest distance of initial values from the prior mean, in its standard deviations
MOST_UNSOLVED = 0.05  # largest share of rows without a solution of the model
ONE_OF_FEW = 0.2  # the same for few rows, if the rows without a solution are one operating point


class End(msgspec.Struct, frozen=True):
    """Start and end of one search."""

    start: Floats  # first parameters (P,)
    x: Floats = msgspec.field(name="end")  # last parameters (P,)
    cost: float  # half the sum of squares [-]
    minimum: int = 1  # number of the minimum; 1 is the best


@dataclass(frozen=True)
class Minimum:
    """Best minimum of the searches over M rows and P free parameters."""

    x: Floats
    residual: Floats  # (M,) as shares of the scales
    slopes: Floats  # derivatives (M, P) of the residuals
    ends: tuple[End, ...]  # ends of all searches, best first
    unsolved: int  # number of rows without a solution of the model


class Evaluator:
    """Residuals of a fit, their derivatives, and the number of ``unsolved`` rows."""

    def __init__(self, rows: Rows, choice: Choice, error: float) -> None:
        self.rows, self.choice = rows, choice
        self.weight = weight_of_priors(rows, choice, error)
        self.unsolved = 0

    def at(self, x: Floats, free: tuple[str, ...] | None = None) -> Evaluation:
        """Return residuals (M,) / scales, without priors, and derivatives (M, P) by ``free``."""
        rows = self.rows
        value, slope = rows.model(self.choice.values(x), self.choice.free if free is None else free)
        lost = ~np.isfinite(value) | ~np.isfinite(slope).all(axis=1)
        self.unsolved = int(lost.sum())
        keep = np.where(lost, 0.0, rows.weight / rows.scale)
        residual = keep * np.where(lost, 0.0, value - rows.measured)
        return residual, keep[:, None] * np.where(lost[:, None], 0.0, slope)

    def residual(self, x: Floats) -> Floats:
        """Return the residuals (M + K,): M rows, then K priors."""
        return np.concatenate([self.at(x)[0], self.weight * self.choice.prior_residuals(x)[0]])

    def jacobian(self, x: Floats) -> Floats:
        """Return the derivatives (M + K, P) of ``residual``."""
        return np.concatenate([self.at(x)[1], self.weight * self.choice.prior_residuals(x)[1]])

    def computed(self, x: Floats) -> Floats:
        """Return ``residual`` without computing derivatives, in a third of the time."""
        return np.concatenate([self.at(x, ())[0], self.weight * self.choice.prior_residuals(x)[0]])

    def difference_quotients(self, x: Floats) -> Floats:
        """Return difference quotients (M + K, P) of ``computed``.  Unlike
        ``jacobian``, they exclude the errors of gradients in docs/theory.md, "Known limits"."""
        from scipy.optimize import approx_fprime

        step = DIFFERENCE * self.choice.column("spread")
        inwards = np.where(x + step <= self.choice.column("upper"), step, -step)
        return np.asarray(approx_fprime(x, self.computed, inwards))


def weight_of_priors(rows: Rows, choice: Choice, error: float) -> float:
    """Return the factor on the residuals of priors.  For independent rows, the factor is ``error``,
    the standard deviation of a residual.  With groups or a prior from other propellers, the factor
    is larger, because the rows count as only ``rows.independent`` measurements."""
    if choice.expected is None and rows.group is None:
        return error
    return error * float(np.sqrt(rows.counts.sum() / max(float(rows.independent.sum()), 1.0)))


def starts(choice: Choice, count: int, seed: int) -> list[Floats]:
    """Return the first guess and ``count`` - 1 random starts, within three spreads of it and within
    ``FAR`` standard deviations of a prior from other propellers."""
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
    """Return the best minimum of the searches from all starts ``begin``.

    The ``loss`` is "linear" or "soft_l1".  ``error`` is the standard deviation of a residual, which
    sets the weight of priors; residuals above twice this value are outliers.  If ``follow`` is
    true, the search takes a few steps from a known minimum.  Otherwise, if ``polish`` is true, a
    finer search starts from the best end point.  Raise an ``InputError`` for too few measurements,
    and for too many rows without a solution.
    """
    from scipy.optimize import least_squares

    used = int(np.count_nonzero(rows.weight))
    first = choice.first
    if used + choice.prior_residuals(first)[0].size < first.size:
        fault = f"{used} measured numbers for {len(choice.free)} free parameters"
        raise InputError(fault, "give more data or free fewer parameters")
    evaluator = Evaluator(rows, choice, error)
    softened = functools.partial(_softened, rows.measured.size)
    lower, upper, spread = (choice.column(a) for a in ("lower", "upper", "spread"))

    def run(x0: Floats, most: int, step: float, gain: float, *, exact: bool = False) -> End:
        # A fine search rejects many steps; ``computed`` avoids their derivatives.
        often_refused = step <= FINE[0]
        with warnings.catch_warnings():
            # At a bound, SciPy divides by a distance of zero and continues correctly.
            warnings.simplefilter("ignore", RuntimeWarning)
            found = least_squares(
                evaluator.computed if often_refused else evaluator.residual,
                np.clip(x0, lower, upper),
                evaluator.difference_quotients if exact else evaluator.jacobian,
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
            # Near a perfect fit, errors of derivatives end a search early.  Difference quotients
            # continue it.  If priors or noise leave residuals, the limit 1e-4 soon ends the search.
            best = min(run(best.x, FINAL_EVALUATIONS, 1e-12, 1e-4, exact=True), best, key=_cost)
    x = best.x
    for bound in (lower, upper):
        x = np.where(np.abs(x - bound) < ON_BOUND * spread, bound, x)
    residual, slopes = evaluator.at(x)
    size = rows.measured.size
    if evaluator.unsolved > max(MOST_UNSOLVED * size, min(len(rows.names), ONE_OF_FEW * size)):
        fault = f"the model has no solution at {evaluator.unsolved} of {rows.measured.size} rows"
        raise InputError(fault, "check the units of the operating points")
    return Minimum(x, residual, slopes, ends, evaluator.unsolved)


def _softened(rows: int, squares: Floats) -> Floats:
    """Return SciPy's loss ``soft_l1`` of the first ``rows`` squares; priors have a linear loss."""
    more = 1.0 + squares
    found = np.array([2.0 * (more**0.5 - 1.0), more**-0.5, -0.5 * more**-1.5])
    found[:, rows:] = [squares[rows:], np.ones(squares.size - rows), np.zeros(squares.size - rows)]
    return found


_cost = operator.attrgetter("cost")


def minima(ends: list[End], spread: Floats) -> tuple[End, ...]:
    """Return the ends in the order of rising cost, each with the number of its minimum."""
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


Evaluation = tuple[Floats, Floats]
RowModel = Callable[[Mapping[str, float], tuple[str, ...]], Evaluation]

INDEPENDENT = 10.0
"""With a prior from other propellers, the rows of one load count as at most this number of
independent measurements.  Adjacent rows share the errors of the model and of the test stand."""

INDEPENDENT_AT_REST = 4.0  # the same for static rows, which differ only in rotational speed
REMEMBERED = 16  # number of stored evaluations; a refit needs fewer


@dataclass(frozen=True, eq=False)
class Rows:
    """M measured numbers of one or several loads, and a model of these numbers.

    Attributes
    ----------
    names, units : tuple of str
        Name and unit of each load.
    measured : ndarray, shape (M,)
        Measured numbers, in the unit of the load.
    load : ndarray, shape (M,)
        Index of the load in ``names``.
    scale : ndarray, shape (M,)
        Divisor of each residual.
    speed : ndarray, shape (M,)
        Flight speed [m/s].
    point : ndarray, shape (M,)
        Number of the operating point.  Bootstrap and cross-validation never split a point.
    group : ndarray, shape (M,), or None
        Number of the segment of a flight; errors within a segment may be correlated.  None for
        independent errors.
    model : callable
        Function of all parameters by name and of the P free names; it returns values (M,) and
        derivatives (M, P).
    weight : ndarray, shape (M,)
        Factor on each residual, usually 1.
    part : callable, optional
        Function that returns the model of the m rows with given indices.  By default, ``model`` is
        evaluated and the rows are selected.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    measured: Floats
    load: NDArray[np.intp]
    scale: Floats
    speed: Floats
    point: NDArray[np.intp]
    group: NDArray[np.intp] | None
    model: RowModel
    weight: Floats
    part: Callable[[NDArray[np.intp]], RowModel] | None = None

    @classmethod
    def of_points(
        cls,
        names: tuple[str, ...],
        units: tuple[str, ...],
        measured: Floats,
        scale: Floats,
        speed: Floats,
        table: Callable[[NDArray[np.intp]], RowModel],
        group: NDArray[np.intp] | None = None,
    ) -> Rows:
        """Return a row for each finite number in ``measured`` (n, L).

        ``names`` and ``units`` are those of the L loads; ``scale`` is (n, L), ``speed`` and
        ``group`` are (n,).  For the indices of m points, ``table`` returns a model with values
        (m, L) and derivatives (m, L, P).
        """
        point, load = np.nonzero(np.isfinite(measured))
        # Polish and refits begin at the end of a search, so stored values save evaluations.
        whole: dict[Any, Evaluation] = {}

        def model_of(rows: NDArray[np.intp], found: dict[Any, Evaluation]) -> RowModel:
            points, place = np.unique(point[rows], return_inverse=True)
            here = table(points)

            def model(values: Mapping[str, float], free: tuple[str, ...]) -> Evaluation:
                key = (tuple(values.items()), free)
                if key not in found:
                    if key in whole:
                        value, slope = (one[rows] for one in whole[key])
                    else:
                        value, slope = (one[place, load[rows]] for one in here(values, free))
                    found[key] = value, slope
                    if len(found) > REMEMBERED:
                        del found[next(iter(found))]
                return found[key]

            return model

        return cls(
            names=names,
            units=units,
            measured=measured[point, load],
            load=load,
            scale=scale[point, load],
            speed=speed[point],
            point=point,
            group=None if group is None else group[point],
            model=model_of(np.arange(point.size), whole),
            weight=np.ones(point.size),
            part=lambda rows: model_of(rows, {}),
        )

    @property
    def unit(self) -> NDArray[np.intp]:
        """Unit of bootstrap and cross-validation of each row (M,): its group or operating point."""
        return self.point if self.group is None else self.group

    def picked(self, table: Floats) -> Floats:
        """Return the values (M,) of these rows from a ``table`` (n, L) of loads at all points."""
        return np.asarray(table[self.point, self.load])

    def of_load(self, load: int) -> NDArray[np.bool_]:
        """Return whether each row (M,) has the load number ``load`` and a weight above 0."""
        return (self.load == load) & (self.weight > 0.0)

    @property
    def counts(self) -> NDArray[np.intp]:
        """Number of rows with a weight above 0, for each load (L,)."""
        return np.array([np.count_nonzero(self.of_load(k)) for k in range(len(self.names))])

    @property
    def independent(self) -> Floats:
        """Number of independent measurements of each load (L,); each group represents one."""
        parts = [self.of_load(k) for k in range(len(self.names))]
        if self.group is not None:
            return np.array([float(np.unique(self.group[part]).size) for part in parts])
        moving = [np.any(self.speed[part] > 0.0) for part in parts]
        return np.minimum(self.counts, np.where(moving, INDEPENDENT, INDEPENDENT_AT_REST))

    def left(self, kept: NDArray[np.bool_]) -> Rows:
        """Return the rows where ``kept`` (M,) is true, with a model of only these rows."""
        rows = np.flatnonzero(kept)
        names = ("measured", "load", "scale", "speed", "point", "weight")
        columns = {name: getattr(self, name)[rows] for name in names}
        group = None if self.group is None else self.group[rows]

        def some(values: Mapping[str, float], free: tuple[str, ...]) -> Evaluation:
            value, slope = self.model(values, free)
            return value[rows], slope[rows]

        model = some if self.part is None else self.part(rows)
        return replace(self, **columns, group=group, model=model, part=None)


# --- Statistics of model minus measurement, over all rows and by speed ---------------------------

BANDS = (0.0, 3.0, 6.0, 9.0, 12.0, 15.0, np.inf)  # edges of the bands of speed [m/s]


class ResidualErrors(msgspec.Struct, frozen=True):
    """Statistics of the errors of one load, model minus measurement; NaN without rows."""

    rows: int
    rms: float
    relative_rms: float  # divided by the root mean square of the measurements [-]
    bias: float  # mean
    worst: float  # error of largest magnitude, with its sign
    hover_rms: float  # error of the hover model; NaN if it was not computed


class FlightErrors(msgspec.Struct, frozen=True):
    """Statistics of the errors of one load in one flight, model minus measurement, in its unit."""

    rows: int
    rms: float
    bias: float
    cross_validated_rms: float  # from fits without the segment; NaN without cross-validation


def rms(values: Floats) -> float:
    """Return the root mean square of all values, in their unit."""
    return float(np.sqrt(np.mean(np.square(values))))


def rms_known(values: Floats) -> float:
    """Return the root mean square of the finite values; NaN if there are none."""
    known = values[np.isfinite(values)]
    return rms(known) if known.size else float("nan")


def errors(model: Floats, measured: Floats, hover: Floats | None = None) -> ResidualErrors:
    """Return the statistics of the errors where both ``model`` and ``measured`` (n,) are finite."""
    both = np.isfinite(model) & np.isfinite(measured)
    if not both.any():
        return ResidualErrors(0, *(5 * (np.nan,)))
    off = (model - measured)[both]
    size, left = rms(measured[both]), rms(off)
    return ResidualErrors(
        rows=int(both.sum()),
        rms=left,
        relative_rms=left / size if size > 0.0 else np.nan,
        bias=float(off.mean()),
        worst=float(off[np.argmax(np.abs(off))]),
        hover_rms=np.nan if hover is None else rms((hover - measured)[both]),
    )


def by_band(
    model: Floats, measured: Floats, speed: Floats, hover: Floats | None = None
) -> dict[str, ResidualErrors]:
    """Return the errors in each band of speed with rows, by a name such as "3-6 m/s"."""
    found = {}
    for low, high in itertools.pairwise(BANDS):
        mine = (speed >= low) & (speed < high)
        if mine.any():
            name = f"{low:g}-{high:g} m/s" if np.isfinite(high) else f"above {low:g} m/s"
            part = None if hover is None else hover[mine]
            found[name] = errors(model[mine], measured[mine], part)
    return found


@dataclass(eq=False)
class RowsElsewhere:
    """``rows`` for workers in other processes.

    Models cannot be sent, so ``remake`` makes the rows again there; None without other processes.
    """

    rows: Rows
    remake: Callable[[], Rows] | None

    def __getstate__(self) -> dict[str, Any]:
        if self.remake is None:
            found = "the rows of a fit cannot be sent to workers in other processes"
            raise InputError(found, "give remake, a function that makes the rows there")
        return {key: value for key, value in vars(self).items() if key != "rows"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        assert self.remake is not None
        self.rows = self.remake()
