"""What a planned flight would tell of the parameters, before it is flown."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from propmap.errors import InputError
from propmap.fit.flight import ForceModel, level_rows
from propmap.fit.least_squares import NOISE_FLOOR, Minimum
from propmap.fit.parameters import EVERY, MOUNT, PAPER_FOUR, Choice
from propmap.fit.uncertainty import AT_BOUND, Uncertainty, uncertainty
from propmap.flight.trim import true_values
from propmap.model.airfoil import Airfoil
from propmap.typing import Floats
from propmap.vehicle.log import FlightLog
from propmap.vehicle.vehicle import Vehicle


@dataclass(frozen=True)
class Expectation:
    """What a fit of planned flights would find.

    Attributes
    ----------
    choice : Choice
        The P free parameters.
    truth : ndarray, shape (P,)
        Their true values.
    uncertainty : Uncertainty
        Intervals about these.
    error : float
        Of the flights' vertical forces, as a share of the weight.
    """

    choice: Choice
    truth: Floats
    uncertainty: Uncertainty
    error: float


def expectation(
    vehicle: Vehicle,
    airfoil: Airfoil,
    points: FlightLog,
    *,
    free: tuple[str, ...] = PAPER_FOUR,
    error: float = 0.01,
) -> Expectation:
    """Gauss-Newton intervals at the truth for a fit of level flights, eq. (18).

    Parameters
    ----------
    vehicle, airfoil : Vehicle, Airfoil
        What is flown, and the true section law of its blades.
    points : FlightLog
        Operating points of ``trim``.
    free : tuple of str
        Parameters of the fit.
    error : float
        Standard deviation of the vertical force of a flight, as a share of the weight; at least
        the numerical error of the loads is assumed.

    Raises
    ------
    InputError
        For a true value outside the bounds of a fit.
    """
    truth = {name: EVERY[name].start for name in free if name in MOUNT}
    truth |= true_values(vehicle, airfoil)
    for name in EVERY.keys() & set(free):
        low, high = EVERY[name].lower, EVERY[name].upper
        if not low <= truth[name] <= high:
            raise InputError(
                f"{name} is {truth[name]:g}, a fit looks from {low:g} to {high:g}",
                "simulate another airfoil or leave it out of the free ones",
            )
    choice = Choice(free, start={name: truth[name] for name in free if name in EVERY})
    rows = level_rows(ForceModel(vehicle, points, airfoil), choice)
    _, slopes = rows.model(truth, free)
    x, error = choice.first, max(error, NOISE_FLOOR)
    # Residuals that give this standard error again, once the fitted ones are discounted.
    margin = AT_BOUND * choice.column("spread")
    inside = np.minimum(x - choice.column("lower"), choice.column("upper") - x) >= margin
    discount = max(len(rows.measured) - int(inside.sum()), 1) / len(rows.measured)
    residual = np.full(len(rows.measured), error * math.sqrt(discount))
    found = Minimum(x, residual, slopes / rows.scale[:, None], (), 0)
    return Expectation(choice, x, uncertainty(rows, choice, found), error)
