"""The rotors' wakes on each other as parameters of a fit: axial flow added, and its derivatives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict

from propmap.fit.parameters import WAKES
from propmap.vehicle.vehicle import Vehicle, Wakes

PREFIX = "wake_"


def wakes_with(vehicle: Vehicle, values: Mapping[str, float]) -> Wakes | None:
    """The vehicle's wakes with those parameters of ``WAKES`` that are among ``values``.

    Parameters
    ----------
    vehicle : Vehicle
        Gives what is not among the values, or else ``Wakes`` as it is by default.
    values : mapping of str to float
        Parameters by name.

    Returns
    -------
    Wakes or None
        None where neither tells of wakes: the rotors then do not act on each other.
    """
    given = {name.removeprefix(PREFIX): values[name] for name in WAKES if name in values}
    if not given:
        return vehicle.wakes
    return Wakes(**(asdict(vehicle.wakes or Wakes()) | given))
