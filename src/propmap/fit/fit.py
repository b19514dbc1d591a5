"""Complete fits (search, uncertainty, cross-validation, bootstrap) and the coverage of data."""

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
    errors,
    rms_known,
    search,
    starts,
)
from propmap.fit.parameters import LEAST_ERROR, LEAST_IN_FLIGHT, SECTION, Choice
from propmap.fit.uncertainty import Uncertainty, residual_errors, uncertainty
from propmap.model.envelope import Range
from propmap.tasks import InTurn, Workers, in_order
from propmap.typing import Floats
from propmap.units import RPM

OF_THRUST, OF_TORQUE = ("thrust", "force_z", "vertical_force"), ("torque",)
"""Loads whose relative errors estimate the errors of static thrust and of static torque."""

MOST_LEFT = 1.0 / 3.0  # largest rms error of a plausible fit, over the measured rms
MEDIAN_TO_DEVIATION = 1.4826  # standard deviation over median magnitude, for normal errors


@dataclass(frozen=True)
class Settings:
    """Settings of a fit.

    Attributes
    ----------
    starts : int
        Number of searches; the first begins at the first guess.
    loss : str
        Loss function, "linear" or "soft_l1".
    folds : int
        Number of folds of the cross-validation; 0 for no cross-validation.
    bootstrap : int
        Number of refits of the bootstrap; 0 for no bootstrap.
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
    """Result of a fit of P parameters to M rows of L loads.

    Attributes
    ----------
    choice, settings, rows : Choice, Settings, Rows
        Inputs of the fit.
    minimum : Minimum
        Best minimum of the searches.
    uncertainty : Uncertainty
        Uncertainty of the free parameters.
    residual : ndarray, shape (M,)
        Model minus measurement, in the unit of each measurement.
    left_out : ndarray, shape (M,)
        Model minus measurement, for a fit without the row; NaN without cross-validation.
    bootstrapped : ndarray, shape (B, P)
        Parameters from fits to operating points drawn with replacement.
    seconds : float
        Duration of the fit [s].
    error : float
        Standard deviation of a residual as a share of its scale, which sets the weight of priors.
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
        """Free parameters at the minimum (P,)."""
        return self.minimum.x

    @property
    def values(self) -> dict[str, float]:
        """All parameters by name."""
        return self.choice.values(self.x)

    @property
    def cross_validated(self) -> Floats:
        """Cross-validated root mean square error of each load (L,); NaN if not computed."""
        parts = (self.left_out[self.rows.of_load(k)] for k in range(len(self.rows.names)))
        return np.array([rms_known(part) for part in parts])

    @property
    def implausible(self) -> str:
        """Reason to reject the fit: an rms error above ``MOST_LEFT`` for thrust, vertical force or
        torque, or two section constants at their bounds; empty for a plausible fit."""
        found = []
        for k, name in enumerate(self.rows.names):
            left = errors(*self.compared(k)).relative_rms
            if name in (*OF_THRUST, *OF_TORQUE) and left > MOST_LEFT:
                found.append(f"the rms error is {left:.0%} of the {name.replace('_', ' ')} (rms)")
        held = (self.x == self.choice.column("lower")) | (self.x == self.choice.column("upper"))
        at_end = [n for n, on in zip(self.choice.free, held, strict=True) if on and n in SECTION]
        if len(at_end) > 1:
            found.append(f"{', '.join(at_end)} are at their bounds")
        return ", and ".join(found)

    def compared(self, load: int) -> tuple[Floats, Floats]:
        """Return the modeled and measured values of the load with index ``load``, in its unit."""
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
    """Identify the free parameters; for level flights, this is eq. (18).

    Parameters
    ----------
    rows : Rows
        Measurements with their model.
    choice : Choice
        Free parameters, fixed parameters and priors.
    settings : Settings, optional
        Settings of the fit.
    fewer : Rows, optional
        Selection of the rows.  All starts use these rows to save time; then one search continues
        with all rows from the best result.
    workers : Workers, optional
        Workers for the refits of the bootstrap; by default this process.
    remake : callable, optional
        Function that makes the rows again in the process of a worker.

    Raises
    ------
    InputError
        For fewer measurements than free parameters, and for too many rows without a solution.
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
        # The first search gives the size of the errors, which sets the weight of priors and
        # the limit of outliers.
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
    """Return a robust standard deviation of a residual, as a share of its scale."""
    if settings.loss == "linear":
        return float(np.median(residual_errors(rows, choice, found, error)))
    sizes = np.abs(found.residual[rows.weight > 0.0])
    return max(MEDIAN_TO_DEVIATION * float(np.median(sizes)), NOISE_FLOOR)


def _cross_validate(
    rows: Rows, choice: Choice, settings: Settings, refit: Callable[[Rows], Floats]
) -> Floats:
    """Return model minus measurement (M,), from fits without the segment or point of each row."""
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
    """Refit to a selection of the rows; ``remake`` makes the rows in another process."""

    choice: Choice
    start: Floats
    loss: str
    error: float

    def __call__(self, part: Rows) -> Floats:
        """Return the parameters (P,) from a fit to the rows ``part``."""
        start = [self.start]
        return search(part, self.choice, start, loss=self.loss, error=self.error, follow=True).x


def _bootstrap(refit: _Refit, settings: Settings, workers: Workers) -> Floats:
    """Return the parameters (B, P) from refits to segments or points drawn with replacement."""
    rng = np.random.default_rng(settings.seed + 1)
    labels, index = np.unique(refit.rows.unit, return_inverse=True)
    drawn = [
        np.bincount(rng.integers(labels.size, size=labels.size), minlength=labels.size)[index]
        for _ in range(settings.bootstrap)
    ]
    repeats = in_order(workers.results(_refit_to, refit, drawn))
    return np.array(repeats).reshape(settings.bootstrap, len(refit.choice.free))


def _refit_to(refit: _Refit, drawn: NDArray[np.intp]) -> Floats:
    """Return the parameters from a refit in which row m counts ``drawn[m]`` times."""
    rows = replace(refit.rows, weight=refit.rows.weight * np.sqrt(drawn))
    return refit(rows.left(drawn > 0))


# --- Operating points that the data of a fit cover, and warnings about narrow ranges -------------

STANDSTILL = 0.1  # speed [m/s] below which the angle beta is meaningless
BAND = 15.0  # width of the bands of the angle beta [deg]; the center of the first band is 0
FEW = 0.02  # smallest share of the points in motion that covers a band of beta

HOVER_BELOW, NARROW = 1.0, 2.0  # largest speed in hover, least speed range without warning [m/s]


class _CoveredPoints(msgspec.Struct, frozen=True, omit_defaults=True):
    """Number and ranges of operating points, with the median rotational speed."""

    points: int
    rpm: Range
    typical_rpm: Annotated[float, msgspec.Meta(gt=0.0)]
    speed: Range = msgspec.field(name="speed_mps")

    def __post_init__(self) -> None:
        for value in (getattr(self, name) for name in self.__struct_fields__):
            if isinstance(value, tuple) and not -math.inf < value[0] <= value[1] < math.inf:
                raise ValueError(f"{value[0]:g} to {value[1]:g} is no range")


class Covered(_CoveredPoints, frozen=True):
    """Number and ranges of operating points, with the advance ratio V/(Omega R) [-]."""

    advance: Range = msgspec.field(name="advance_ratio")


class CoveredAngle(Covered, frozen=True):
    """Operating points in a band of the angle beta, with range and median of beta [deg]."""

    beta: Range = msgspec.field(name="beta_deg")
    typical_beta: float = msgspec.field(name="typical_beta_deg")


class Coverage(_CoveredPoints, frozen=True):
    """Operating points with a turning propeller in the data of a fit: all points, points at rest,
    and points in motion in each band of beta, in the order of beta."""

    angles: list[CoveredAngle]
    at_rest: Covered | None = None

    @property
    def main_angles(self) -> list[CoveredAngle]:
        """Bands of beta with at least the share ``FEW`` of the points in motion."""
        moving = sum(one.points for one in self.angles)
        return [one for one in self.angles if one.points >= FEW * moving]


def coverage(omega: Floats, speed: Floats, beta: Floats, radius: float) -> Coverage:
    """Return the coverage of n operating points, with beta in 0...pi [rad] and ``radius`` R [m].

    Raise an ``InputError`` if the propeller turns at no point.
    """
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
    """Return warnings for rows with a range of speeds that is too small to fit parameters."""
    speed = rows.speed[rows.weight > 0.0]
    low, high = _ends(speed)
    if high < HOVER_BELOW:
        return [
            "all data are from hover: they determine only the static loads, not individual "
            "parameters; add data at airspeeds above zero"
        ]
    if high - low < NARROW:
        return [
            f"all data are from one speed, {low:.1f} to {high:.1f} m/s: they hardly separate the "
            "parameters; add data at other speeds"
        ]
    return []


def _ends(values: Floats) -> Range:
    return float(np.min(values)), float(np.max(values))


def _spread(values: Floats) -> tuple[Range, float]:
    """Return range and median."""
    return _ends(values), float(np.median(values))
