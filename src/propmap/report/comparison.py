"""Predicted against measured loads: several models side by side, and what the data leave open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from propmap.baselines.hover import HoverModel
from propmap.fit.least_squares import errors, rms
from propmap.loads import LOADS
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.catalogue.lookup import Measurement
    from propmap.rotor import Rotor

HOVER = "hover"
"""The hover model's name among the models."""


@dataclass(frozen=True)
class ErrorFigures:
    """Errors of one model in one load, predicted less measured, in the load's unit.

    Attributes
    ----------
    rms, worst, mean : float
        Root mean square, largest magnitude, mean.
    relative_rms : float or None
        ``rms`` over that of the measured load [-]; None where only zeros were measured.
    predicted_rms : float
        Root mean square of the predicted load.
    """

    rms: float
    relative_rms: float | None
    worst: float
    mean: float
    predicted_rms: float


@dataclass(frozen=True)
class LoadErrors:
    """Errors in one load over a group of points.

    Attributes
    ----------
    load, unit, points : str, str, int
        Which, and over how many.
    measured_rms, measured_mean : float
        Of the measured load.
    models : dict of str to ErrorFigures
        By the name of the model.
    band : float or None
        Root mean square of the difference between both forms of the data, over that of the
        measured load [-]; None where there is one form alone, or only zeros.
    """

    load: str
    unit: str
    points: int
    measured_rms: float
    measured_mean: float
    models: dict[str, ErrorFigures]
    band: float | None


@dataclass(frozen=True, eq=False)
class Comparison:
    """Loads at n measured points.

    Attributes
    ----------
    measurement : Measurement
        What was measured.
    models : dict of str to dict of str to ndarray, shape (n,)
        Predicted loads by the name of the model, then by load.
    status : ndarray of str, shape (n,)
        Of the first model's loads.
    other : mapping of str to ndarray, shape (n,)
        Loads at the same points by another evaluation of the same measurements; empty for none.
    """

    measurement: Measurement
    models: dict[str, dict[str, Floats]]
    status: NDArray[np.str_]
    other: Mapping[str, Floats]

    @property
    def measured(self) -> Mapping[str, Floats]:
        """Measured loads (n,) by name."""
        return self.measurement.loads

    def errors(self, chosen: NDArray[np.bool_]) -> list[LoadErrors]:
        """One entry per measured load, over the points chosen (n,)."""
        return [self._errors(load, chosen) for load in self.measured]

    def _errors(self, load: str, chosen: NDArray[np.bool_]) -> LoadErrors:
        truth = self.measured[load][chosen]

        def figures(values: Floats) -> ErrorFigures:
            e = errors(values[chosen], truth)
            relative = e.relative_rms if truth.any() else None
            return ErrorFigures(e.rms, relative, abs(e.worst), e.bias, rms(values[chosen]))

        return LoadErrors(
            load=load,
            unit=LOADS[load].unit,
            points=truth.size,
            measured_rms=rms(truth),
            measured_mean=float(truth.mean()),
            models={name: figures(loads[load]) for name, loads in self.models.items()},
            band=figures(self.other[load]).relative_rms if load in self.other else None,
        )


def compare(
    rotors: Mapping[str, Rotor], measurement: Measurement, other: Measurement | None = None
) -> Comparison:
    """Rotors at measured points, and the hover model with constants from the first of them.

    Parameters
    ----------
    rotors : mapping of str to Rotor
        By the name of the model.
    measurement : Measurement
        What they are compared with.
    other : Measurement, optional
        Another evaluation of the same measurements, at the same operating points.
    """
    at = (measurement.omega, measurement.speed, measurement.beta)
    found: dict[str, Any] = {name: rotor.loads(*at) for name, rotor in rotors.items()}
    models = {name: {load: getattr(loads, load) for load in LOADS} for name, loads in found.items()}
    first = next(iter(rotors))
    models[HOVER] = HoverModel.of(rotors[first]).loads(measurement.omega)
    return Comparison(
        measurement, models, found[first].status, {} if other is None else other.loads
    )
