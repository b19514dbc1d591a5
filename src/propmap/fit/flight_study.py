"""What each term of a flight fit is worth, and what a fit says of flights that it has not seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from propmap.fit.comparison import flight_forces
from propmap.fit.files import FitFile, Source
from propmap.fit.fit import Fitted, Settings, fit
from propmap.fit.flight import ALIKE, ForceModel, HoverScale, balance_rows, of_others, vertical_rows
from propmap.fit.least_squares import FlightErrors, rms_known
from propmap.fit.parameters import (
    BODY,
    EVERY,
    FIRST_GUESS,
    PER_FLIGHT,
    SENSOR,
    WAKES,
    Choice,
    constants_of,
    of_flight,
)
from propmap.fit.tunnel import model_with
from propmap.model.airfoil import Airfoil
from propmap.model.model import Model
from propmap.typing import Floats
from propmap.vehicle.log import FlightLog, flight_names, joined
from propmap.vehicle.vehicle import Vehicle

# -------------------------------------------------------------------------------------------------
# What each term of a whole-flight fit is worth, on flights that the fit has not seen.

SURE = 2.0
"""Standard errors by which a term has to change the mean square error to be said to pay."""


@dataclass(frozen=True, eq=False)
class Flight:
    """One flight, its signals low-passed and as they were recorded.

    Attributes
    ----------
    name : str
        What it is called.
    passed, raw : FlightLog
        The samples in flight, low-passed and not.
    prediction : ndarray, shape (n, 3), or None
        Forces [N] that something else predicts at the samples of ``passed``, low-passed alike.
    raw_prediction : ndarray, shape (m, 3), or None
        The same, not low-passed, at those of ``raw``.
    """

    name: str
    passed: FlightLog
    raw: FlightLog
    prediction: Floats | None = None
    raw_prediction: Floats | None = None


@dataclass(frozen=True)
class Step:
    """A model with one term more than the one before it.

    Attributes
    ----------
    name : str
        Of what is added.
    choice : Choice
        What is free.
    vertical : bool
        Whether the vertical forces alone are fitted.
    """

    name: str
    choice: Choice
    vertical: bool = False


@dataclass(frozen=True, eq=False)
class Off:
    """Errors of forces on one flight along x, y and z [N].

    Attributes
    ----------
    passed : ndarray, shape (n, 3)
        Model minus measurement of low-passed signals.
    raw : ndarray, shape (m, 3)
        Of signals as they were recorded.
    """

    passed: Floats
    raw: Floats

    @property
    def rms(self) -> Floats:
        """Root mean squares of the low-passed errors, (3,)."""
        return _rms(self.passed)

    @property
    def raw_rms(self) -> Floats:
        """Those of the others, (3,)."""
        return _rms(self.raw)


@dataclass(frozen=True, eq=False)
class FittedStep:
    """One step fitted to all flights but one, or to a single flight.

    Attributes
    ----------
    step : str
        Its name.
    left_out : int or None
        Number of the flight that was not fitted to; None where there is one flight alone.
    values : dict of str to float
        The free parameters.
    off, hover : tuple of Off
        Errors of this model and of the hover model with its blade, one per flight.
    """

    step: str
    left_out: int | None
    values: dict[str, float]
    off: tuple[Off, ...]
    hover: tuple[Off, ...]


def fit_terms(
    vehicle: Vehicle,
    flights: Sequence[Flight],
    steps: Sequence[Step],
    law: Airfoil,
    *,
    samples: int,
    tell: Callable[[str], None] | None = None,
) -> list[FittedStep]:
    """Fit all steps, each flight in turn left out and the others joined.

    Parameters
    ----------
    vehicle : Vehicle
        What flew.
    flights : sequence of Flight
        One or more.
    steps : sequence of Step
        Models, in order.
    law : Airfoil
        Section law for what no step frees.
    samples : int
        Of the flights that are fitted to, at most.
    tell : callable, optional
        Called with a line after each fit.

    Returns
    -------
    list of Fitted
        In the order of the steps, then of the flights left out.
    """
    found = []
    for step in steps:
        for left_out in range(len(flights)) if len(flights) > 1 else (None,):
            seen = joined([f.passed for k, f in enumerate(flights) if k != left_out])
            picked = np.unique(np.linspace(0, len(seen) - 1, min(samples, len(seen))).astype(int))
            model = ForceModel(vehicle, seen.picked(picked), law)
            rows = (vertical_rows if step.vertical else balance_rows)(model, step.choice)
            values = fit(rows, step.choice, Settings(starts=1, folds=0)).values
            pairs = [_off(vehicle, flight, law, values) for flight in flights]
            off, hover = zip(*pairs, strict=True)
            free = {name: values[name] for name in step.choice.free}
            found.append(FittedStep(step.name, left_out, free, off, hover))
            if tell is not None:
                unseen = found[-1].off[left_out or 0].rms
                tell(f"{step.name}: {', '.join(f'{x:.3f}' for x in unseen)} N")
    return found


def gain(old: Sequence[Off], new: Sequence[Off], flights: Sequence[Flight]) -> tuple[float, float]:
    """By how much the mean square error falls from one model to another, and its standard error.

    Errors within a second of each other count as one, as they are alike.

    Parameters
    ----------
    old, new : sequence of Off
        Of the same flights.
    flights : sequence of Flight
        Those.

    Returns
    -------
    tuple of float
        Fall of the mean square of the force's error [N^2], and its standard deviation.
    """
    means = []
    for a, b, flight in zip(old, new, flights, strict=True):
        fall = np.sum(a.passed**2 - b.passed**2, axis=1)
        block = flight.passed.stretches(ALIKE)
        known = np.isfinite(fall)
        total = np.bincount(block[known], fall[known])
        count = np.bincount(block[known])
        means += (total[count > 0] / count[count > 0]).tolist()
    each = np.array(means)
    deviation = float(np.std(each, ddof=1)) / np.sqrt(each.size) if each.size > 1 else np.inf
    return float(np.mean(each)), float(deviation)


def judged(fall: float, deviation: float) -> str:
    """Whether a term with such a ``gain`` pays, in a word or two."""
    if fall > SURE * deviation:
        return "pays"
    if fall < -SURE * deviation:
        return "makes it worse"
    return "no sure gain"


def measured_off(vehicle: Vehicle, flight: Flight) -> Off | None:
    """Errors of the prediction that comes with a flight; None where there is none."""
    if flight.prediction is None or flight.raw_prediction is None:
        return None
    return Off(
        flight.prediction - vehicle.mass * flight.passed.specific_force,
        flight.raw_prediction - vehicle.mass * flight.raw.specific_force,
    )


def _off(
    vehicle: Vehicle, flight: Flight, base: Airfoil, values: dict[str, float]
) -> tuple[Off, Off]:
    """Errors of a fit's model and of the hover model."""
    found = model_with(Model(vehicle.propeller, base, vehicle.air), values)
    law = replace(constants_of(found.airfoil), corrections=tuple(found.correction_texts))
    others = {n: values[n] for n in (BODY | SENSOR | WAKES) if n in values}
    logs = (flight.passed, flight.raw)
    forces = [flight_forces(vehicle, log, law, FIRST_GUESS | others) for log in logs]
    measured = [vehicle.mass * log.specific_force for log in logs]
    model = (f.model[:, :3] - m for f, m in zip(forces, measured, strict=True))
    hover = (f.hover[:, :3] - m for f, m in zip(forces, measured, strict=True))
    return Off(*model), Off(*hover)


def _rms(off: Floats) -> Floats:
    found: Floats = np.sqrt(np.nanmean(off**2, axis=0))
    return found


# -------------------------------------------------------------------------------------------------
# What a fit's parameters are for flights, of which it may have seen some.


def values_for(
    file: FitFile, vehicle: Vehicle, log: FlightLog, paths: Sequence[Path]
) -> tuple[dict[str, float], list[str]]:
    """Parameters for flights, and what is to be said of them.

    A flight of the fit keeps its own.  Of any other, the thrust scale is what its own hover has
    beside the hover of the fit's flights, where that tells; else it is the mean of the fit's
    flights, as its clock is.

    Parameters
    ----------
    file : FitFile
        The fit.
    vehicle, log : Vehicle, FlightLog
        What flew, and how.
    paths : sequence of Path
        The flights' files.
    """
    logs = file.record.data[:-1]  # The vehicle's file is the last.
    names = flight_names([source.file for source in logs])
    seen = {source.sha256: name for source, name in zip(logs, names, strict=True)}
    values, told = of_others(file.values), []
    by_hover, telling = dict[str, float](), dict[str, float]()
    if file.hover_reference:
        hovers = HoverScale.of(vehicle, log, file.hover_reference)
        by_hover, telling = hovers.scales, hovers.telling
    for flight, path in zip(log.flights, paths, strict=True):
        name = seen.get(Source.of(path).sha256)
        for one in PER_FLIGHT:
            here = of_flight(one, flight)
            values.pop(here, None)
            if name is not None:
                common = values.get(one, EVERY[one].start)
                values[here] = file.values.get(of_flight(one, name), common)
        scale = of_flight("thrust_scale", flight)
        if name is None and scale in by_hover:
            values |= {scale: telling[scale]} if scale in telling else {}
            why = "so much is applied" if scale in telling else "too near to 1 to be applied"
            told.append(
                f"in its hover flight {flight} has {by_hover[scale]:.3f} times the thrust of the "
                f"fit's flights at the same rotor speeds: {why}"
            )
    return values, told


# -------------------------------------------------------------------------------------------------
# Errors of a fit to several flights, flight by flight.


def by_flight(fitted: Fitted, log: FlightLog) -> dict[str, dict[str, FlightErrors]]:
    """Errors by load and by flight.

    Parameters
    ----------
    fitted : Fitted
        A fit of rows made of the samples of ``log``.
    log : FlightLog
        The samples.

    Returns
    -------
    dict of str to dict of str to FlightErrors
        By the name of the load and that of the flight; of one flight alone, nothing.
    """
    if len(log.flights) < 2:
        return {}
    rows = fitted.rows
    flight = log.flight[rows.point]

    def of(load: int, number: int) -> FlightErrors:
        mine = rows.of_load(load) & (flight == number) & np.isfinite(fitted.residual)
        off = fitted.residual[mine]
        bias = float(off.mean()) if off.size else float("nan")
        return FlightErrors(off.size, rms_known(off), bias, rms_known(fitted.left_out[mine]))

    return {
        load: {name: of(k, number) for number, name in enumerate(log.flights)}
        for k, load in enumerate(rows.names)
    }
