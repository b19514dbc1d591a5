"""Predicted against measured loads, with the hover model beside."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.baselines.hover import HoverModel
from propmap.fit.residuals import errors, rms
from propmap.loads import LOADS

if TYPE_CHECKING:
    from propmap.catalogue.measurements import Measurement
    from propmap.rotor import Rotor


@dataclass(frozen=True)
class ErrorFigures:
    """Errors of one model in one load, predicted less measured, in the load's unit.

    Attributes
    ----------
    rms, worst, mean : float
        Root mean square, largest magnitude, mean.
    relative_rms : float or None
        ``rms`` over that of the measured load [-]; None where only zeros were measured.
    """

    rms: float
    relative_rms: float | None
    worst: float
    mean: float


@dataclass(frozen=True)
class LoadErrors:
    """Errors in one load over a group of points, of this model and of the hover model."""

    load: str
    unit: str
    points: int
    measured_rms: float
    measured_mean: float
    model: ErrorFigures
    hover: ErrorFigures


@dataclass(frozen=True, eq=False)
class Comparison:
    """Loads at n measured points by name, and the status (n,) of the predicted ones."""

    measurement: Measurement
    measured: dict[str, Floats]
    predicted: dict[str, Floats]
    hover: dict[str, Floats]
    status: NDArray[np.str_]

    def errors(self, chosen: NDArray[np.bool_]) -> list[LoadErrors]:
        """One entry per measured load, over the points chosen (n,)."""
        return [self._errors(load, chosen) for load in self.measured]

    def _errors(self, load: str, chosen: NDArray[np.bool_]) -> LoadErrors:
        truth = self.measured[load][chosen]

        def figures(values: Floats) -> ErrorFigures:
            e = errors(values[chosen], truth)
            relative = e.relative_rms if truth.any() else None
            return ErrorFigures(e.rms, relative, abs(e.worst), e.bias)

        model, hover = figures(self.predicted[load]), figures(self.hover[load])
        size, mean = rms(truth), float(truth.mean())
        return LoadErrors(load, LOADS[load].unit, truth.size, size, mean, model, hover)


def compare(rotor: Rotor, measurement: Measurement) -> Comparison:
    """The rotor at measured points, and the hover model with constants from this rotor."""
    found: Any = rotor.loads(measurement.omega, measurement.speed, measurement.beta)
    return Comparison(
        measurement=measurement,
        measured=dict(measurement.loads),
        predicted={load: getattr(found, load) for load in LOADS},
        hover=HoverModel.of(rotor).loads(measurement.omega),
        status=found.status,
    )
