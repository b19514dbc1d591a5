"""Predicted against measured loads, with the hover model beside."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.baselines.hover import HoverModel
from propmap.fit.residuals import rms
from propmap.loads import LOADS

if TYPE_CHECKING:
    from propmap.catalogue.measurements import Measurement
    from propmap.rotor import Rotor


@dataclass(frozen=True)
class ErrorFigures:
    """Errors of one model in one load, in the load's unit.

    rms : root mean square.  worst : largest magnitude.  mean : predicted less measured.
    relative_rms : rms over the rms of the measured load [-]; None where nothing was measured
    but zero.
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
    """Loads by field of ``rotor.Loads``, each (n,) in SI; measured holds those published.

    status : (n,), of the prediction.
    """

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
        size = rms(truth)

        def figures(values: Floats) -> ErrorFigures:
            error = values[chosen] - truth
            left = rms(error)
            relative = left / size if size > 0.0 else None
            return ErrorFigures(left, relative, float(np.abs(error).max()), float(error.mean()))

        model, hover = figures(self.predicted[load]), figures(self.hover[load])
        mean = float(truth.mean())
        return LoadErrors(load, LOADS[load].unit, truth.size, size, mean, model, hover)


def compare(rotor: Rotor, measurement: Measurement) -> Comparison:
    """The rotor, and the hover model with its constants from this rotor, at measured points."""
    found: Any = rotor.loads(measurement.omega, measurement.speed, measurement.beta)
    return Comparison(
        measurement=measurement,
        measured=dict(measurement.loads),
        predicted={load: getattr(found, load) for load in LOADS},
        hover=HoverModel.of(rotor).loads(measurement.omega),
        status=found.status,
    )
