"""Bounded nonlinear least squares from several starts, eq. (18), and the rows that it sees."""

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

NOISE_FLOOR = 1e-3  # least deviation of a residual over its scale, that of the computed loads
SAME_MINIMUM = 1e-3  # distance of two ends of one minimum, in spreads
DIFFERENCE = 1e-5  # step of difference quotients, in spreads

ON_BOUND = 1e-9  # distance from a bound, in spreads, that is none: searches stay inside
EVALUATIONS, FINAL_EVALUATIONS = 20, 30  # at most, from each start and to polish
FINE = 1e-6, 1e-8  # last relative steps and gains, above the derivatives' errors
REFIT_EVALUATIONS = 6  # at most where a known minimum is followed, as in cross-validation
FAR = 1.5  # standard deviations of a prior within which searches start
MOST_UNSOLVED = 0.05  # share of the rows that may have no solution in the model
ONE_OF_FEW = 0.2  # share of few rows that may have none where they are of one operating point


class End(msgspec.Struct, frozen=True):
    """Where a search from one start ended."""

    start: Floats  # first and last parameters (P,)
    x: Floats = msgspec.field(name="end")
    cost: float  # half the sum of squares [-]
    minimum: int = 1  # number of its minimum, from 1 for the best


@dataclass(frozen=True)
class Minimum:
    """The best end of a search over M rows and P free parameters."""

    x: Floats
    residual: Floats  # (M,) as shares of their scales
    slopes: Floats  # derivatives (M, P) of the residuals
    ends: tuple[End, ...]  # all ends, best first
    unsolved: int  # rows that the model gave no value for


class Evaluator:
    """Residuals of a fit and their derivatives; ``unsolved`` rows at the last parameters."""

    def __init__(self, rows: Rows, choice: Choice, error: float) -> None:
        self.rows, self.choice = rows, choice
        self.weight = weight_of_priors(rows, choice, error)
        self.unsolved = 0

    def at(self, x: Floats, free: tuple[str, ...] | None = None) -> Evaluation:
        """Residuals (M,) over scales, without priors, and derivatives (M, P) by ``free``."""
        rows = self.rows
        value, slope = rows.model(self.choice.values(x), self.choice.free if free is None else free)
        lost = ~np.isfinite(value) | ~np.isfinite(slope).all(axis=1)
        self.unsolved = int(lost.sum())
        keep = np.where(lost, 0.0, rows.weight / rows.scale)
        residual = keep * np.where(lost, 0.0, value - rows.measured)
        return residual, keep[:, None] * np.where(lost[:, None], 0.0, slope)

    def residual(self, x: Floats) -> Floats:
        """Residuals (M,), with the priors' below."""
        return np.concatenate([self.at(x)[0], self.weight * self.choice.prior_residuals(x)[0]])

    def jacobian(self, x: Floats) -> Floats:
        """Derivatives of ``residual`` (M + K, P)."""
        return np.concatenate([self.at(x)[1], self.weight * self.choice.prior_residuals(x)[1]])

    def computed(self, x: Floats) -> Floats:
        """What ``residual`` gives, without derivatives, which take three times as long."""
        return np.concatenate([self.at(x, ())[0], self.weight * self.choice.prior_residuals(x)[0]])

    def difference_quotients(self, x: Floats) -> Floats:
        """Difference quotients (M + K, P) of ``computed``; where inflow rises steeply they differ
        from ``jacobian`` by some per cent, see docs/theory.md, known limits."""
        from scipy.optimize import approx_fprime

        step = DIFFERENCE * self.choice.column("spread")
        inwards = np.where(x + step <= self.choice.column("upper"), step, -step)
        return np.asarray(approx_fprime(x, self.computed, inwards))


def weight_of_priors(rows: Rows, choice: Choice, error: float) -> float:
    """Factor on the residuals of priors beside those of rows: the standard deviation ``error`` of a
    residual where each row is a number of its own; whole flights, and rows beside what propellers
    have in common, are worth ``rows.independent``."""
    if choice.expected is None and rows.group is None:
        return error
    return error * float(np.sqrt(rows.counts.sum() / max(float(rows.independent.sum()), 1.0)))


def starts(choice: Choice, count: int, seed: int) -> list[Floats]:
    """The first guess, and ``count`` - 1 random starts within three spreads of it and ``FAR``
    standard deviations from the mean of other propellers."""
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
    """Find the best minimum over all starts, by ``loss`` "linear" or "soft_l1"; priors are weighed
    against the ``error`` of a residual, twice it is an outlier. ``follow`` takes few steps from a
    known minimum, else ``polish`` follows the best end to the last digit. ``InputError`` for too
    few numbers and too many rows without solution."""
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
        # At the end of a search many steps are refused, whose derivatives nobody needs.
        often_refused = step <= FINE[0]
        with warnings.catch_warnings():
            # At a bound SciPy divides by a zero distance and goes on.
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
            # So near to a perfect fit the errors of the derivatives would end the search early.
            # Where priors or noise leave more than those errors, the first step gains little.
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
    """SciPy's ``soft_l1`` of so many first squares; priors, which follow, are no outliers."""
    more = 1.0 + squares
    found = np.array([2.0 * (more**0.5 - 1.0), more**-0.5, -0.5 * more**-1.5])
    found[:, rows:] = [squares[rows:], np.ones(squares.size - rows), np.zeros(squares.size - rows)]
    return found


_cost = operator.attrgetter("cost")


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


Evaluation = tuple[Floats, Floats]
RowModel = Callable[[Mapping[str, float], tuple[str, ...]], Evaluation]

INDEPENDENT = 10.0
"""Independent numbers that the rows of one load are worth at most, beside what is known of
propellers in general: what a model or a stand gets wrong, neighbouring rows have in common."""

INDEPENDENT_AT_REST = 4.0  # at rest, where rows differ in rotational speed alone
REMEMBERED = 16  # evaluations that are kept: more than one refit takes


@dataclass(frozen=True, eq=False)
class Rows:
    """M measured numbers of one or several kinds of load, and a model of them.

    Attributes
    ----------
    names, units : tuple of str
        Names and units of each kind of load.
    measured : ndarray, shape (M,)
        In the unit of the load.
    load : ndarray, shape (M,)
        Index into ``names``.
    scale : ndarray, shape (M,)
        By which residuals are divided before they are squared.
    speed : ndarray, shape (M,)
        Flight speed [m/s].
    point : ndarray, shape (M,)
        Operating point of each number; points are drawn and left out as a whole.
    group : ndarray, shape (M,), or None
        Stretches within which errors may be correlated; None where every number errs by itself.
    model : callable
        From all parameters by name and the P free names: values (M,) and derivatives (M, P).
    weight : ndarray, shape (M,)
        1, or how a row counts.
    part : callable, optional
        From the indices of m rows a model of these alone; by default the rows of ``model``.
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
        """Make a row of each finite number in tables ``measured`` and ``scale`` (n, L) of loads
        with these ``names`` and ``units`` at n points of ``speed`` and ``group`` (n,). From indices
        of m points ``table`` gives a model: values (m, L) and derivatives (m, L, P)."""
        point, load = np.nonzero(np.isfinite(measured))
        # A search is polished where it ended, and refits of parts of the data begin there.
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
        """What is drawn and left out as a whole (M,): the group, or else the operating point."""
        return self.point if self.group is None else self.group

    def picked(self, table: Floats) -> Floats:
        """The numbers (M,) of these rows in a ``table`` (n, L) of loads at the operating points."""
        return np.asarray(table[self.point, self.load])

    def of_load(self, load: int) -> NDArray[np.bool_]:
        """Which rows (M,) are of the ``load`` of this index and have weight."""
        return (self.load == load) & (self.weight > 0.0)

    @property
    def counts(self) -> NDArray[np.intp]:
        """How many rows of each load (L,) have weight."""
        return np.array([np.count_nonzero(self.of_load(k)) for k in range(len(self.names))])

    @property
    def independent(self) -> Floats:
        """Independent numbers that each load's rows (L,) are worth: in flight one for each
        group."""
        parts = [self.of_load(k) for k in range(len(self.names))]
        if self.group is not None:
            return np.array([float(np.unique(self.group[part]).size) for part in parts])
        moving = [np.any(self.speed[part] > 0.0) for part in parts]
        return np.minimum(self.counts, np.where(moving, INDEPENDENT, INDEPENDENT_AT_REST))

    def left(self, kept: NDArray[np.bool_]) -> Rows:
        """Those rows that are ``kept``, shape (M,), with a model of these alone."""
        rows = np.flatnonzero(kept)
        names = ("measured", "load", "scale", "speed", "point", "weight")
        columns = {name: getattr(self, name)[rows] for name in names}
        group = None if self.group is None else self.group[rows]

        def some(values: Mapping[str, float], free: tuple[str, ...]) -> Evaluation:
            value, slope = self.model(values, free)
            return value[rows], slope[rows]

        model = some if self.part is None else self.part(rows)
        return replace(self, **columns, group=group, model=model, part=None)


# -------------------------------------------------------------------------------------------------
# How far a model is from measurements: over all rows and by speed.

BANDS = (0.0, 3.0, 6.0, 9.0, 12.0, 15.0, np.inf)  # edges of the bands of speed [m/s]


class ResidualErrors(msgspec.Struct, frozen=True):
    """Errors of one load, model minus measurement, in its unit; NaN where there is no number."""

    rows: int
    rms: float
    relative_rms: float  # over the root mean square of the measurements [-]
    bias: float  # mean
    worst: float  # the error of largest magnitude, with its sign
    hover_rms: float  # of the hover model's errors; NaN where it was not asked for


class FlightErrors(msgspec.Struct, frozen=True):
    """Errors of one load on one flight, model minus measurement, in its unit."""

    rows: int
    rms: float
    bias: float
    cross_validated_rms: float  # on stretches left out of the fit; NaN where it was not done


def rms(values: Floats) -> float:
    """Root mean square of all values, in their unit."""
    return float(np.sqrt(np.mean(np.square(values))))


def rms_known(values: Floats) -> float:
    """Root mean square of those values that are known; NaN where none is."""
    known = values[np.isfinite(values)]
    return rms(known) if known.size else float("nan")


def errors(model: Floats, measured: Floats, hover: Floats | None = None) -> ResidualErrors:
    """Statistics of the errors over all numbers (n,) that are both measured and modelled."""
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
    """Errors in each band of speed that has numbers, by a name such as "3-6 m/s"."""
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
    """``rows`` and what goes with them, to be sent to workers, where ``remake`` gives the rows
    again as models cannot be sent; None where no other process works."""

    rows: Rows
    remake: Callable[[], Rows] | None

    def __getstate__(self) -> dict[str, Any]:
        if self.remake is None:
            found = "workers in other processes cannot be sent the rows of a fit"
            raise InputError(found, "give remake, which makes the rows there")
        return {key: value for key, value in vars(self).items() if key != "rows"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        assert self.remake is not None
        self.rows = self.remake()
