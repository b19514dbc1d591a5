"""A whole identification: search, uncertainty, cross-validation, bootstrap, coverage of data."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.fit.least_squares import (
    NOISE_FLOOR,
    Minimum,
    Rows,
    RowsElsewhere,
    rms_known,
    search,
    starts,
)
from propmap.fit.parameters import LEAST_ERROR, LEAST_IN_FLIGHT, Choice
from propmap.fit.uncertainty import Uncertainty, residual_errors, uncertainty
from propmap.model.envelope import Range
from propmap.tasks import InTurn, Workers, in_order
from propmap.typing import Floats
from propmap.units import RPM

MEDIAN_TO_DEVIATION = 1.4826  # standard deviation over median size, of normal errors


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
        Folds of the cross-validation, 0 for none.
    bootstrap : int
        Repetitions, 0 for none.
    seed : int
        Seed of the random starts, folds and draws.
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
        Uncertainty of the free parameters.
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
    least = LEAST_ERROR if rows.group is None else LEAST_IN_FLIGHT
    error = NOISE_FLOOR if choice.expected is None else least
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
            error = max(error, least)
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
        out = (fold == k) & (rows.weight > 0.0)
        unseen = rows.left(out)
        value, _ = unseen.model(choice.values(refit(rows.left(fold != k))), ())
        left_out[out] = value - unseen.measured
    return left_out


@dataclass(eq=False)
class _Refit(RowsElsewhere):
    """Fits much the same rows again; ``remake`` gives the rows in another process."""

    choice: Choice
    start: Floats
    loss: str
    error: float

    def __call__(self, part: Rows) -> Floats:
        """The parameters (P,) that fit some rows."""
        start = [self.start]
        return search(part, self.choice, start, loss=self.loss, error=self.error, follow=True).x


def _bootstrap(refit: _Refit, settings: Settings, workers: Workers) -> Floats:
    """Parameters (B, P) refitted to units drawn with replacement."""
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
    rows = replace(refit.rows, weight=refit.rows.weight * np.sqrt(drawn))
    return refit(rows.left(drawn > 0))


# -------------------------------------------------------------------------------------------------
# Which operating points the data of a fit cover, and what these cannot determine.

STANDSTILL = 0.1  # speed [m/s] below which the direction of the flow means nothing
BAND = 15.0  # width of the bands of the angle beta [deg], the first one about 0
FEW = 0.02  # share of the points in motion below which an angle is hardly covered

HOVER_BELOW, NARROW = 1.0, 2.0  # speed [m/s] below which all hovers; range of one speed


class _CoveredPoints(msgspec.Struct, frozen=True, omit_defaults=True):
    """Number of operating points, their ranges, and the median rotational speed."""

    points: int
    rpm: Range
    typical_rpm: Annotated[float, msgspec.Meta(gt=0.0)]
    speed: Range = msgspec.field(name="speed_mps")

    def __post_init__(self) -> None:
        for value in (getattr(self, name) for name in self.__struct_fields__):
            if isinstance(value, tuple) and not -math.inf < value[0] <= value[1] < math.inf:
                raise ValueError(f"{value[0]:g} to {value[1]:g} is no range")


class Covered(_CoveredPoints, frozen=True):
    """Operating points of one kind; the advance ratio is V/(Omega R) [-]."""

    advance: Range = msgspec.field(name="advance_ratio")


class CoveredAngle(Covered, frozen=True):
    """Operating points in a band of the angle beta: its range and its median [deg]."""

    beta: Range = msgspec.field(name="beta_deg")
    typical_beta: float = msgspec.field(name="typical_beta_deg")


class Coverage(_CoveredPoints, frozen=True):
    """All operating points of a fit's data where the propeller turns: ranges, and those at rest and
    in each band of beta that holds points in motion, by rising angle."""

    angles: list[CoveredAngle]
    at_rest: Covered | None = None

    @property
    def main_angles(self) -> list[CoveredAngle]:
        """The angles with a share of the points that counts."""
        moving = sum(one.points for one in self.angles)
        return [one for one in self.angles if one.points >= FEW * moving]


def coverage(omega: Floats, speed: Floats, beta: Floats, radius: float) -> Coverage:
    """Ranges of n operating points, at rest and by angle, with beta in 0...pi [rad] and R [m];
    ``InputError`` where the propeller turns at none."""
    turning = omega > 0.0
    if not turning.any():
        raise InputError("the propeller stands still at all points", "give rpm above 0")
    omega, speed, beta = omega[turning], speed[turning], beta[turning]
    rpm, degrees, still = omega / RPM, np.degrees(beta), speed < STANDSTILL
    band = np.round(degrees / BAND).astype(int)

    def at(mine: NDArray[np.bool_]) -> tuple[int, Range, float, Range, Range]:
        advance = speed[mine] / (omega[mine] * radius)
        return int(mine.sum()), *_spread(rpm[mine]), _ends(speed[mine]), _ends(advance)

    bands = [~still & (band == k) for k in np.unique(band[~still])]
    angles = [CoveredAngle(*at(mine), *_spread(degrees[mine])) for mine in bands]
    at_rest = Covered(*at(still)) if still.any() else None
    return Coverage(int(omega.size), *_spread(rpm), _ends(speed), angles, at_rest)


def range_warnings(rows: Rows) -> list[str]:
    """Say what the range of speeds of the rows cannot determine; nothing where it is wide."""
    speed = rows.speed[rows.weight > 0.0]
    low, high = _ends(speed)
    if high < HOVER_BELOW:
        return [
            "all data are from hover: they fix the static loads alone and cannot tell one "
            "parameter from another; add data at speed"
        ]
    if high - low < NARROW:
        return [
            f"all data are from one speed, {low:.1f} to {high:.1f} m/s: the parameters can hardly "
            "be separated; add data at other speeds"
        ]
    return []


def _ends(values: Floats) -> Range:
    return float(np.min(values)), float(np.max(values))


def _spread(values: Floats) -> tuple[Range, float]:
    """Ends and median."""
    return _ends(values), float(np.median(values))
