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

HOVER = "hover"  # the hover model's name among the models


@dataclass(frozen=True)
class ErrorFigures:
    """Errors of one model in one load, predicted less measured, in the load's unit."""

    rms: float
    relative_rms: float | None  # over the rms of the measured load; None for zeros alone
    worst: float  # the largest magnitude
    mean: float
    predicted_rms: float  # of the predicted load


@dataclass(frozen=True)
class LoadErrors:
    """Errors in one load over a group of points."""

    load: str
    unit: str
    points: int
    measured_rms: float
    measured_mean: float
    models: dict[str, ErrorFigures]  # by the name of the model
    # Rms difference of both forms of the data over the rms of the measured load [-]; None where
    # there is one form alone, or only zeros.
    band: float | None


@dataclass(frozen=True, eq=False)
class Comparison:
    """Predicted and measured loads at n measured points."""

    measurement: Measurement
    models: dict[str, dict[str, Floats]]  # (n,) by the name of the model, then by load
    status: NDArray[np.str_]  # (n,), of the first model's loads
    other: Mapping[str, Floats]  # by another evaluation of the same measurements; may be empty

    @property
    def measured(self) -> Mapping[str, Floats]:
        """Give the measured loads (n,) by name."""
        return self.measurement.loads

    def errors(self, chosen: NDArray[np.bool_]) -> list[LoadErrors]:
        """Compute the errors in each measured load over the points ``chosen`` (n,)."""
        found = []
        for load, values in self.measured.items():
            truth = values[chosen]

            def figures(values: Floats, truth: Floats = truth) -> ErrorFigures:
                e = errors(values[chosen], truth)
                relative = e.relative_rms if truth.any() else None
                return ErrorFigures(e.rms, relative, abs(e.worst), e.bias, rms(values[chosen]))

            found.append(
                LoadErrors(
                    load=load,
                    unit=LOADS[load].unit,
                    points=truth.size,
                    measured_rms=rms(truth),
                    measured_mean=float(truth.mean()),
                    models={name: figures(loads[load]) for name, loads in self.models.items()},
                    band=figures(self.other[load]).relative_rms if load in self.other else None,
                )
            )
        return found


def compare(
    rotors: Mapping[str, Rotor], measurement: Measurement, other: Measurement | None = None
) -> Comparison:
    """Predict loads at measured points by ``rotors``, and by the hover model of the first of them.

    ``other`` is another evaluation of the same measurements, at the same operating points.
    """
    at = (measurement.omega, measurement.speed, measurement.beta)
    found: dict[str, Any] = {name: rotor.loads(*at) for name, rotor in rotors.items()}
    models = {name: {load: getattr(loads, load) for load in LOADS} for name, loads in found.items()}
    first = next(iter(rotors))
    models[HOVER] = HoverModel.of(rotors[first]).loads(measurement.omega)
    return Comparison(
        measurement, models, found[first].status, {} if other is None else other.loads
    )
