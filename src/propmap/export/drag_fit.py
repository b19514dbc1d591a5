"""Rotor drag by speed and body drag by its square: what the Kalman filters of autopilots know.

The specific force along a body axis is taken to be m v + 1/2 rho b q, with v the component of the
velocity along the axis, q a square of the velocity, m the same for both axes, and 1/b the
ballistic coefficient of the axis.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.export.inplane_drag import InplaneForces
from propmap.typing import Floats

CLOSE = 0.1
"""Share of the force up to which the simplification is said to hold."""


@dataclass(frozen=True, eq=False)
class DragFit:
    """The constants with their errors, and what they leave.

    Attributes
    ----------
    momentum : float
        m, in the air of the vehicle [1/s].
    inverse : tuple of 2 float
        b along x and y [m^2/kg]; 0 where there is too little for the filter.
    errors : ndarray, shape (E, 3)
        What each of E independent causes, at one standard deviation, adds to m and to b.
    """

    momentum: float
    inverse: tuple[float, float]
    errors: Floats

    @property
    def std(self) -> tuple[float, float, float] | None:
        """Standard deviations of m and b; None where nothing is known of the errors."""
        if not self.errors.size:
            return None
        m, x, y = np.sqrt(np.sum(self.errors**2, axis=0)).tolist()
        return m, x, y


def fit_drag(
    flights: tuple[InplaneForces, InplaneForces],
    square: Callable[[InplaneForces], Floats],
    density: float,
    least: float,
) -> DragFit:
    """Least squares over all flights, none of the constants below zero.

    Parameters
    ----------
    flights : tuple of 2 InplaneForces
        Along x and y.
    square : callable
        Gives q of n flights [m^2/s^2].
    density : float
        Of the air [kg/m^3].
    least : float
        b below which the filter has none [m^2/kg].
    """
    from scipy.optimize import nnls

    rows = []
    for k, flight in enumerate(flights):
        block = np.zeros((flight.speed.size, 3))
        block[:, 0], block[:, 1 + k] = flight.along, 0.5 * density * square(flight)
        rows.append(block)
    matrix = np.concatenate(rows)
    force = np.concatenate([flight.force for flight in flights])
    changes = np.concatenate([flight.errors for flight in flights], axis=1)
    kept = np.ones(3, dtype=bool)
    while True:
        found = np.zeros(3)
        found[kept] = nnls(matrix[:, kept], force)[0]
        small = kept & (found <= np.array([0.0, least, least]))
        if not small.any():
            break
        kept &= ~small
    momentum, *inverse = found.tolist()
    return DragFit(momentum, (inverse[0], inverse[1]), _errors(matrix, kept, changes))


def _errors(matrix: Floats, kept: NDArray[np.bool_], changes: Floats) -> Floats:
    """What changes (E, n) of the forces change in the constants (E, 3)."""
    found = np.zeros((changes.shape[0], 3))
    found[:, kept] = changes @ np.linalg.pinv(matrix[:, kept]).T
    return found


@dataclass(frozen=True, eq=False)
class Comparison:
    """The force along an axis by the full model and by the filter's equation.

    Attributes
    ----------
    flight : InplaneForces
        n flights.
    full, filtered, std : ndarray, shape (n,)
        By the model, by the filter with the constants as they are written, and the standard
        deviation of the first [N]; NaN where it is not known.
    wind : ndarray, shape (n,)
        The error of the wind that the filter makes of the difference [m/s].
    """

    flight: InplaneForces
    full: Floats
    filtered: Floats
    std: Floats
    wind: Floats

    @property
    def share(self) -> Floats:
        """Difference over the full model's force (n,)."""
        return np.asarray((self.filtered - self.full) / self.full)

    @property
    def holds(self) -> tuple[float, float] | None:
        """The longest run of speeds [m/s] with differences up to ``CLOSE``; None without one."""
        best: tuple[float, float] | None = None
        first = None
        for speed, share in zip(self.flight.speed.tolist(), self.share.tolist(), strict=True):
            if abs(share) > CLOSE:
                first = None
                continue
            first = speed if first is None else first
            if best is None or speed - first > best[1] - best[0]:
                best = (first, speed)
        return best


def compare(flight: InplaneForces, mass: float, predicted: Floats, slope: Floats) -> Comparison:
    """A flight beside what a filter makes of it.

    Parameters
    ----------
    flight : InplaneForces
        n flights.
    mass : float
        Of the vehicle [kg].
    predicted, slope : ndarray, shape (n,)
        Specific force of the filter against the motion [m/s^2], and its derivative by the
        component of the velocity along the axis [1/s].
    """
    spread = np.sqrt(np.sum(flight.errors**2, axis=0))
    known = flight.errors.size > 0
    return Comparison(
        flight=flight,
        full=mass * flight.force,
        filtered=mass * predicted,
        std=mass * spread if known else np.full_like(spread, np.nan),
        wind=(predicted - flight.force) / slope,
    )
