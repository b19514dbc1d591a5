"""What each term of a flight fit is worth, and what a fit says of flights that it has not seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from propmap.fit.comparison import flight_forces
from propmap.fit.files import DataSource, FitFile
from propmap.fit.fit import Fitted, Settings, fit
from propmap.fit.flight import (
    CORRELATED,
    ForceModel,
    HoverScale,
    balance_rows,
    of_others,
    vertical_rows,
)
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
class RecordedFlight:
    """One flight, its signals low-passed and as they were recorded.

    A prediction is of forces [N] by something else, (n, 3) at the samples of ``passed`` and
    low-passed like these, and (m, 3) at those of ``raw``; None where there is none.
    """

    name: str
    passed: FlightLog  # low-passed
    raw: FlightLog  # not low-passed
    prediction: Floats | None = None
    raw_prediction: Floats | None = None


@dataclass(frozen=True)
class Step:
    """A model with one term more than the one before it."""

    name: str  # of what is added
    choice: Choice  # what is free
    vertical: bool = False  # whether the vertical forces alone are fitted


@dataclass(frozen=True, eq=False)
class AxisErrors:
    """Errors of forces on one flight along x, y and z, model minus measurement [N]."""

    passed: Floats  # of low-passed signals, (n, 3)
    raw: Floats  # of signals as they were recorded, (m, 3)

    @property
    def rms(self) -> Floats:
        """Root mean squares of the low-passed errors, (3,)."""
        return _rms(self.passed)

    @property
    def raw_rms(self) -> Floats:
        """Root mean squares of the errors as recorded, (3,)."""
        return _rms(self.raw)


@dataclass(frozen=True, eq=False)
class FittedStep:
    """One step fitted to all flights but one, or to a single flight."""

    step: str  # its name
    left_out: int | None  # number of the flight that was not fitted to; None for a single flight
    values: dict[str, float]  # the free parameters
    off: tuple[AxisErrors, ...]  # errors of this model, one per flight
    hover: tuple[AxisErrors, ...]  # errors of the hover model with its blade


def fit_terms(
    vehicle: Vehicle,
    flights: Sequence[RecordedFlight],
    steps: Sequence[Step],
    law: Airfoil,
    *,
    samples: int,
    tell: Callable[[str], None] | None = None,
) -> list[FittedStep]:
    """Fit all steps, each flight in turn left out and the others joined.

    The section ``law`` gives what no step frees; of the flights that are fitted to, ``samples`` are
    taken at most. After each fit ``tell`` is called with a line of text. The results are in the
    order of the steps, then of the flights left out.
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


def gain(
    old: Sequence[AxisErrors], new: Sequence[AxisErrors], flights: Sequence[RecordedFlight]
) -> tuple[float, float]:
    """Fall of the mean square of the force error from one model to another [N^2]; its deviation.

    Errors within a second of each other count as one, as they are correlated.
    """
    means = []
    for a, b, flight in zip(old, new, flights, strict=True):
        fall = np.sum(a.passed**2 - b.passed**2, axis=1)
        block = flight.passed.stretches(CORRELATED)
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


def measured_off(vehicle: Vehicle, flight: RecordedFlight) -> AxisErrors | None:
    """Errors of the prediction that comes with a flight; None where there is none."""
    if flight.prediction is None or flight.raw_prediction is None:
        return None
    return AxisErrors(
        flight.prediction - vehicle.mass * flight.passed.specific_force,
        flight.raw_prediction - vehicle.mass * flight.raw.specific_force,
    )


def _off(
    vehicle: Vehicle, flight: RecordedFlight, base: Airfoil, values: dict[str, float]
) -> tuple[AxisErrors, AxisErrors]:
    """Errors of a fit's model and of the hover model."""
    found = model_with(Model(vehicle.propeller, base, vehicle.air), values)
    law = replace(constants_of(found.airfoil), corrections=tuple(found.correction_texts))
    others = {n: values[n] for n in (BODY | SENSOR | WAKES) if n in values}
    logs = (flight.passed, flight.raw)
    forces = [flight_forces(vehicle, log, law, FIRST_GUESS | others) for log in logs]
    measured = [vehicle.mass * log.specific_force for log in logs]
    model = (f.model[:, :3] - m for f, m in zip(forces, measured, strict=True))
    hover = (f.hover[:, :3] - m for f, m in zip(forces, measured, strict=True))
    return AxisErrors(*model), AxisErrors(*hover)


def _rms(off: Floats) -> Floats:
    found: Floats = np.sqrt(np.nanmean(off**2, axis=0))
    return found


# -------------------------------------------------------------------------------------------------
# What a fit's parameters are for flights, of which it may have seen some.


def values_for(
    file: FitFile, vehicle: Vehicle, log: FlightLog, paths: Sequence[Path]
) -> tuple[dict[str, float], list[str]]:
    """Parameters for the flights of a ``log`` with these ``paths``, and what is to be said of them.

    A flight of the fit keeps its own. Of any other, the thrust scale is what its own hover has
    beside the hover of the fit's flights, where that is sure; else it is the mean of the fit's
    flights, as its clock is.
    """
    logs = file.record.data[:-1]  # The vehicle's file is the last.
    names = flight_names([source.file for source in logs])
    seen = {source.sha256: name for source, name in zip(logs, names, strict=True)}
    values, remarks = of_others(file.values), []
    by_hover, applied = dict[str, float](), dict[str, float]()
    if file.hover_reference:
        hovers = HoverScale.of(vehicle, log, file.hover_reference)
        by_hover, applied = hovers.scales, hovers.remarkable
    for flight, path in zip(log.flights, paths, strict=True):
        name = seen.get(DataSource.of(path).sha256)
        for one in PER_FLIGHT:
            here = of_flight(one, flight)
            values.pop(here, None)
            if name is not None:
                common = values.get(one, EVERY[one].start)
                values[here] = file.values.get(of_flight(one, name), common)
        scale = of_flight("thrust_scale", flight)
        if name is None and scale in by_hover:
            values |= {scale: applied[scale]} if scale in applied else {}
            why = "so much is applied" if scale in applied else "too near to 1 to be applied"
            remarks.append(
                f"in its hover flight {flight} has {by_hover[scale]:.3f} times the thrust of the "
                f"fit's flights at the same rotor speeds: {why}"
            )
    return values, remarks


# -------------------------------------------------------------------------------------------------
# Errors of a fit to several flights, flight by flight.


def by_flight(fitted: Fitted, log: FlightLog) -> dict[str, dict[str, FlightErrors]]:
    """Errors by load and by flight of a fit to the samples of ``log``; none of one flight alone."""
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
