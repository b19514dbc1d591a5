"""Flight on a wing: where a search for it begins, and the speed below which the wing stalls."""

from __future__ import annotations

from typing import Any

import numpy as np

from propmap.aircraft.balance import Balance, Balanced, Flight
from propmap.typing import Floats
from propmap.vehicle.flight_log import GRAVITY
from propmap.vehicle.free_stream_force import wing_lift
from propmap.vehicle.vehicle import Vehicle, Wing

ATTACHED = 0.6
"""Of ``alpha_0``: the largest angle of attack at which a search begins."""

ADVANCE = 0.2
"""Speed over tip speed at which it begins."""

ANGLES = 181
"""At which the largest lift is looked for, from 0 to twice ``alpha_0``."""


def on_the_wing(balance: Balance, flight: Flight) -> Floats:
    """Unknowns (n, u) of n flights whose wing is to carry them, for ``Balance.solve``.

    Parameters
    ----------
    balance : Balance
        Of a vehicle with a wing.
    flight : Flight
        Of n.
    """
    vehicle, wing = balance.vehicle, _wing_of(balance.vehicle)
    speed = np.maximum(np.hypot(flight.speed, flight.climb), 1e-3)
    slope = 0.5 * vehicle.air.density * speed**2 * wing.area * wing.c_l1
    alpha = np.minimum(_load(vehicle, flight) / slope, ATTACHED * wing.alpha_0)
    squares = np.square(speed / (ADVANCE * vehicle.propeller.radius))
    least = 0.05 * balance.reference
    every = np.repeat(np.maximum(squares, least)[:, None], len(balance.rotors), axis=1)
    path = np.arctan2(flight.climb, np.maximum(flight.speed, 1e-3))
    return balance.unknowns(wing.incidence - alpha - path, flight.bank, every)


def of_less_power(one: Balanced, other: Balanced, tolerance: float) -> Balanced:
    """Of two solutions of the same flights those that are balanced, and of these the cheaper.

    Parameters
    ----------
    one, other : Balanced
        Of n flights.
    tolerance : float
        Unbalanced share up to which a flight is balanced.
    """
    good, better = (found.residual <= tolerance for found in (one, other))
    return one.or_else(other, better & (~good | (other.power < one.power)))


def stalled(vehicle: Vehicle, flight: Flight) -> Any:
    """Whether n flights are slower than their wing's stall speed, (n,) bool.

    It is the speed at which the wing's largest lift is what there is to carry.

    Parameters
    ----------
    vehicle : Vehicle
        With a wing.
    flight : Flight
        Of n.
    """
    wing = _wing_of(vehicle)
    largest = wing_lift(wing, np.linspace(0.0, 2.0 * wing.alpha_0, ANGLES)).max()
    pressure = 0.5 * vehicle.air.density * (flight.speed**2 + flight.climb**2)
    return pressure * largest < _load(vehicle, flight)


def _load(vehicle: Vehicle, flight: Flight) -> Floats:
    return vehicle.mass * GRAVITY / np.cos(flight.bank)


def _wing_of(vehicle: Vehicle) -> Wing:
    assert vehicle.wing is not None
    return vehicle.wing
