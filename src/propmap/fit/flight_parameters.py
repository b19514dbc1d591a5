"""Parameters that each flight of a log may have for itself: its thrust scale, its clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError, quoted
from propmap.fit.parameters import EVERY, PER_FLIGHT, general, of_flight
from propmap.typing import Floats
from propmap.vehicle.flight_log import FlightLog


def of_each(name: str, log: FlightLog) -> tuple[str, ...]:
    """The parameter ``name`` of each flight of ``log``."""
    return tuple(of_flight(name, flight) for flight in log.flights)


def at_samples(name: str, values: Mapping[str, float], log: FlightLog) -> Floats:
    """The parameter of the flight of each sample; (n,).

    Parameters
    ----------
    name : str
        One of ``PER_FLIGHT``.
    values : mapping of str to float
        Parameters by name; what is not given for a flight is what is given for all.
    log : FlightLog
        n samples.
    """
    common = values.get(name, EVERY[name].start)
    each = [values.get(one, common) for one in of_each(name, log)]
    return np.array(each)[log.flight.astype(int)]


def samples_of(name: str, values: Mapping[str, float], log: FlightLog) -> NDArray[np.bool_]:
    """Which samples (n,) the parameter ``name`` acts on: those of its flight, or of all flights
    that have none of their own among the ``values``."""
    if general(name) == name:
        own = np.array([one in values for one in of_each(name, log)])
        return np.asarray(~own[log.flight.astype(int)])
    flights = [of_flight(general(name), flight) for flight in log.flights]
    return np.asarray(log.flight == flights.index(name))


def check_flights(names: Sequence[str], log: FlightLog) -> None:
    """Raise ``InputError`` where one of these ``names`` is of a flight that ``log`` has not."""
    here = [one for name in PER_FLIGHT for one in of_each(name, log)]
    for name in names:
        if general(name) != name and name not in here:
            raise InputError(
                f"{quoted(name)} is of no flight of these",
                f"name one of {', '.join(log.flights)}, or leave the brackets out for all",
            )


def of_others(values: Mapping[str, float]) -> dict[str, float]:
    """The ``values`` with those for flights that a fit has not seen: the means of its flights'."""
    found = dict(values)
    for name in PER_FLIGHT:
        mine = [value for one, value in values.items() if general(one) == name != one]
        if mine:
            found[name] = float(np.mean(mine))
    return found
