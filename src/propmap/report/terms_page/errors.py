"""Errors of each step on each flight, as numbers for tables, files and the picture."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from propmap.fit.flight_terms import Fitted, Flight, Off, gain, judged, measured_off
from propmap.typing import Floats
from propmap.vehicle.vehicle import Vehicle

HOVER, PREDICTION = "hover model", "prediction in the file"


@dataclass(frozen=True, eq=False)
class Row:
    """Errors of one model on one flight, root mean squares along x, y and z [N].

    Attributes
    ----------
    model, flight : str
        Which.
    seen, unseen, raw_seen, raw_unseen : ndarray, shape (3,), or None
        Of fits to the flight and of the fit without it, low-passed and as recorded; None where
        there is none.
    """

    model: str
    flight: str
    seen: Floats | None
    unseen: Floats | None
    raw_seen: Floats | None
    raw_unseen: Floats | None


@dataclass(frozen=True)
class Worth:
    """What one step changes on flights that it has not seen, or on the only one.

    Attributes
    ----------
    step, word : str
        Which, and whether it pays.
    fall, deviation : float
        By how much the mean square of the force's error falls, and its standard deviation [N^2].
    """

    step: str
    word: str
    fall: float
    deviation: float


def rows(vehicle: Vehicle, flights: Sequence[Flight], found: Sequence[Fitted]) -> list[Row]:
    """Hover model, steps in order, and the prediction that comes with the data, flight by flight.

    Parameters
    ----------
    vehicle : Vehicle
        What flew.
    flights : sequence of Flight
        What was fitted.
    found : sequence of Fitted
        From ``fit_terms``.
    """
    told = []
    for k, flight in enumerate(flights):
        hover = _own(found[-1].hover[k])
        told.append(Row(HOVER, flight.name, None, hover[0], None, hover[1]))
        for step in steps_of(found):
            fits = [f for f in found if f.step == step]
            seen = [f.off[k] for f in fits if f.left_out != k]
            unseen = [f.off[k] for f in fits if f.left_out == k]
            told.append(
                Row(
                    step,
                    flight.name,
                    _mean([off.rms for off in seen]),
                    _mean([off.rms for off in unseen]),
                    _mean([off.raw_rms for off in seen]),
                    _mean([off.raw_rms for off in unseen]),
                )
            )
        own = measured_off(vehicle, flight)
        if own is not None:
            told.append(Row(PREDICTION, flight.name, None, own.rms, None, own.raw_rms))
    return told


def worth(flights: Sequence[Flight], found: Sequence[Fitted]) -> list[Worth]:
    """What each step but the first changes, on flights that its fits have not seen.

    Parameters
    ----------
    flights, found : sequence of Flight, sequence of Fitted
        As for ``rows``.
    """
    steps = steps_of(found)
    told = []
    for old, new in itertools.pairwise(steps):
        fall, deviation = gain(_unseen(old, found), _unseen(new, found), flights)
        told.append(Worth(new, judged(fall, deviation), fall, deviation))
    return told


def steps_of(found: Sequence[Fitted]) -> list[str]:
    """Names of the steps of ``found``, in order."""
    return list(dict.fromkeys(f.step for f in found))


def _unseen(step: str, found: Sequence[Fitted]) -> list[Off]:
    """One per flight."""
    fits = [f for f in found if f.step == step]
    return [f.off[f.left_out or 0] for f in fits]


def _own(off: Off) -> tuple[Floats, Floats]:
    return off.rms, off.raw_rms


def _mean(rms: Sequence[Floats]) -> Floats | None:
    """The root of the mean square of several; None of none."""
    if not rms:
        return None
    found: Floats = np.sqrt(np.mean(np.square(rms), axis=0))
    return found
