"""Which variables still explain something of a flight fit's residuals, in words."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.fit.fitted import Fitted
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
        "time since the flight's start [s]": log.time - _begins(log),
    }


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
    variables = candidates(log)
    for k, (load, unit) in enumerate(zip(rows.names, rows.units, strict=True)):
        mine = rows.of_load(k) & np.isfinite(fitted.residual)
        residual, block = fitted.residual[mine], rows.group[mine]
        found = []
        for name, variable in variables.items():
            slope, error, share = _slope(variable[rows.point[mine]], residual, block)
            if share >= LEAST_SHARE and abs(slope) >= CERTAIN * error:
                found.append((share, name, slope))
        for share, name, slope in sorted(found, reverse=True)[:MOST]:
            way, per = "grows" if slope > 0.0 else "falls", name.partition(" [")
            told.append(
                f"the error of {load} {way} with {per[0]}: {slope:+.2g} {unit} per "
                f"{per[2].rstrip(']')}, {100.0 * share:.0f} % of its variance"
            )
    return told


def _slope(variable: Floats, residual: Floats, block: NDArray[np.intp]) -> tuple[float, ...]:
    """Slope of the residual, its block-wise standard error, and the share of its variance."""
    x, y = variable - variable.mean(), residual - residual.mean()
    size, spread = float(x @ x), float(y @ y)
    if size <= 1e-12 * max(float(variable @ variable), 1e-300) or spread == 0.0:
        return 0.0, np.inf, 0.0
    slope = float(x @ y) / size
    _, index = np.unique(block, return_inverse=True)
    scores = np.bincount(index, weights=x * (y - slope * x))
    return slope, float(np.sqrt(scores @ scores)) / size, slope**2 * size / spread


def _begins(log: FlightLog) -> Floats:
    """When the flight of each sample begins [s]; (n,)."""
    first = {number: log.time[log.flight == number].min() for number in np.unique(log.flight)}
    return np.array([first[number] for number in log.flight])
