"""Which variables still explain something of a flight fit's residuals, in words."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.fit.fitted import Fitted
from propmap.typing import Floats
from propmap.vehicle.flight_log import FlightLog

LEAST_SHARE = 0.05
"""Share of the residuals' variance from which a variable is worth a sentence."""

CERTAIN = 3.0
"""Slope over its block-wise standard error from which it is no chance."""

MOST = 2
"""Sentences per load."""


def candidates(log: FlightLog) -> dict[str, Floats]:
    """Variables (n,) of a log that residuals may depend on, by their names with units.

    Parameters
    ----------
    log : FlightLog
        n samples.
    """
    forward, left, up = log.velocity.T
    roll, pitch, yaw = log.rates.T
    rotor = np.sqrt(np.mean(np.square(log.rotor_speed), axis=1))
    return {
        "speed [m/s]": log.speed,
        "forward velocity [m/s]": forward,
        "sideways velocity to the left [m/s]": left,
        "velocity along the body's z axis [m/s]": up,
        "square of the forward velocity [m^2/s^2]": forward**2,
        "square of the sideways velocity [m^2/s^2]": left**2,
        "climb rate [m/s]": log.climb_rate,
        "speed of descent along z [m/s]": np.maximum(-up, 0.0),
        "roll rate [rad/s]": roll,
        "pitch rate [rad/s]": pitch,
        "yaw rate [rad/s]": yaw,
        "square of the roll rate [rad^2/s^2]": roll**2,
        "square of the pitch rate [rad^2/s^2]": pitch**2,
        "rotor speed [rad/s]": rotor,
        "time since the flight's start [s]": log.since_start,
    }


@dataclass(frozen=True, eq=False)
class Trend:
    """How the residual of one load goes with one variable, over n samples.

    Attributes
    ----------
    load, unit, variable : str
        Names; that of the variable with its unit.
    at, residual : ndarray, shape (n,)
        The variable, and model minus measurement.
    block : ndarray, shape (n,)
        Stretches within which errors may be alike.
    slope, error : float
        By least squares, and its block-wise standard error.
    share : float
        Of the residual's variance that the slope explains [-].
    """

    load: str
    unit: str
    variable: str
    at: Floats
    residual: Floats
    block: NDArray[np.intp]
    slope: float
    error: float
    share: float

    @property
    def tells(self) -> bool:
        """Whether it is worth a sentence and no chance."""
        return self.share >= LEAST_SHARE and abs(self.slope) >= CERTAIN * self.error

    @property
    def sentence(self) -> str:
        """What the slope says."""
        way, per = "grows" if self.slope > 0.0 else "falls", self.variable.partition(" [")
        return (
            f"the error of {self.load} {way} with {per[0]}: {self.slope:+.2g} {self.unit} per "
            f"{per[2].rstrip(']')}, {100.0 * self.share:.0f} % of its variance"
        )


def trends(
    log: FlightLog, load: str, unit: str, residual: Floats, block: NDArray[np.intp]
) -> list[Trend]:
    """The residual of a load against every candidate, the strongest first.

    Parameters
    ----------
    log : FlightLog
        n samples.
    load, unit : str
        Of the residual.
    residual : ndarray, shape (n,)
        Model minus measurement; samples that are not finite are left out.
    block : ndarray, shape (n,)
        Stretches within which errors may be alike.
    """
    known = np.isfinite(residual)
    off, stretch, found = residual[known], block[known], []
    for name, variable in candidates(log).items():
        at = variable[known]
        found.append(Trend(load, unit, name, at, off, stretch, *_slope(at, off, stretch)))
    return sorted(found, key=lambda trend: -trend.share)


def still_explained(fitted: Fitted, log: FlightLog) -> list[str]:
    """Sentences on what residuals still depend on, the strongest first, two per load at most.

    Parameters
    ----------
    fitted : Fitted
        A fit of rows made of the samples of ``log``.
    log : FlightLog
        The n samples.
    """
    rows, told = fitted.rows, []
    if rows.group is None:
        return []
    for k, (load, unit) in enumerate(zip(rows.names, rows.units, strict=True)):
        mine = rows.of_load(k)
        residual, block = np.full(len(log), np.nan), np.zeros(len(log), dtype=np.intp)
        residual[rows.point[mine]], block[rows.point[mine]] = (
            fitted.residual[mine],
            rows.group[mine],
        )
        telling = [one for one in trends(log, load, unit, residual, block) if one.tells]
        told += [one.sentence for one in telling[:MOST]]
    return told


def _slope(
    variable: Floats, residual: Floats, block: NDArray[np.intp]
) -> tuple[float, float, float]:
    """Slope of the residual, its block-wise standard error, and the share of its variance."""
    x, y = variable - variable.mean(), residual - residual.mean()
    size, spread = float(x @ x), float(y @ y)
    if size <= 1e-12 * max(float(variable @ variable), 1e-300) or spread == 0.0:
        return 0.0, np.inf, 0.0
    slope = float(x @ y) / size
    _, index = np.unique(block, return_inverse=True)
    scores = np.bincount(index, weights=x * (y - slope * x))
    return slope, float(np.sqrt(scores @ scores)) / size, slope**2 * size / spread
