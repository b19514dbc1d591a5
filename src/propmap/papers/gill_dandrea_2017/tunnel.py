"""The paper's tunnel experiment with public data: measured, this model, the hover model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from propmap.arrays.types import Floats
from propmap.baselines.hover import HoverModel
from propmap.catalogue.measurements import Measurement, measurement
from propmap.fit.residuals import rms
from propmap.loads import LOADS
from propmap.model.air import Air
from propmap.model.airfoil import Airfoil, parameter_set
from propmap.model.model import Model
from propmap.papers.gill_dandrea_2017.blades import blade
from propmap.papers.gill_dandrea_2017.identified import AXIAL, OBLIQUE, TunnelFits
from propmap.papers.gill_dandrea_2017.paper import TUNNEL_ERROR
from propmap.rotor import Rotor

MULTIROTOR = "davoudi-8x4.5mr-thrust"
DATA_SETS = {
    AXIAL: "UIUC tunnel, axial and static",
    OBLIQUE: "2019 campaign, oblique (published fit)",
    MULTIROTOR: "8x4.5MR thrust at 0 and 5 m/s (digitised)",
}

DIGITISED = 0.025
"""Uncertainty of the digitised thrust as a share of the largest: 2-3 % of full scale."""

PRINTED, STIFF = "paper-apc", "paper-stiff"
HOVER_LABEL = "hover model"


@dataclass(frozen=True, eq=False)
class Compared:
    """One data set and every model's loads on it, (n,) each, in SI.

    laws : section laws by label.  measured : by load.  predicted : by label of the model, the
    laws' and the hover model's, then by load.
    """

    data: Measurement
    laws: dict[str, Airfoil]
    measured: dict[str, Floats]
    predicted: dict[str, dict[str, Floats]]


@dataclass(frozen=True)
class LoadError:
    """Error of one model in one load of one data set.

    points, rms, worst : number; in the load's unit.  rms_share : of the rms of the measured
    load.  worst_share : of the largest measured load.  within_nine : share of the points within
    the paper's 9 % of their own measured value.
    """

    data_set: str
    load: str
    unit: str
    model: str
    points: int
    rms: float
    worst: float
    rms_share: float
    worst_share: float
    within_nine: float


def compared(fits: TunnelFits) -> dict[str, Compared]:
    """The data sets by name.

    The hover model gets what it would get from a hover test: constants fitted to the static
    rows of the same data set.
    """
    identified = {one.label: one.law for one in (fits.axial, fits.oblique)}
    laws = {"Table I, APC 8x6": parameter_set(PRINTED), **identified}
    found = {name: _compared(name, laws) for name in (AXIAL, OBLIQUE)}
    # Nothing was fitted to this propeller; the stiff propeller of Table I has its size and pitch.
    found[MULTIROTOR] = _compared(
        MULTIROTOR, {"Table I, HQP 8x4.5": parameter_set(STIFF), **identified}
    )
    return found


def errors(found: dict[str, Compared]) -> list[LoadError]:
    """All data sets, loads and models; the hover model has thrust and torque alone."""
    rows = []
    for name, one in found.items():
        for load, truth in one.measured.items():
            for model, loads in one.predicted.items():
                rows.append(_error(name, load, model, truth, loads[load]))
    return rows


def static_constants(data: Measurement) -> HoverModel:
    """k_T and k_tau by least squares from the rows at rest; no k_tau (NaN) without torque."""
    still = data.speed == 0.0
    squares = data.omega[still] ** 2

    def constant(load: str) -> float:
        if load not in data.loads:
            return float("nan")
        return float(squares @ data.loads[load][still] / (squares @ squares))

    return HoverModel(constant("thrust"), constant("torque"), float(data.omega[still].max()))


def _compared(name: str, laws: dict[str, Airfoil]) -> Compared:
    data = measurement(name)
    shape, air = blade(data.propeller), Air(density=data.air_density)
    predicted = {}
    for label, law in laws.items():
        loads: Any = Rotor(Model(shape, law, air)).loads(data.omega, data.speed, data.beta)
        predicted[label] = {load: getattr(loads, load) for load in LOADS}
    predicted[HOVER_LABEL] = static_constants(data).loads(data.omega)
    return Compared(data, laws, dict(data.loads), predicted)


def _error(name: str, load: str, model: str, truth: Floats, found: Floats) -> LoadError:
    error = found - truth
    left, worst = rms(error), float(np.max(np.abs(error)))
    near = np.abs(error) <= TUNNEL_ERROR * np.abs(truth)
    return LoadError(
        data_set=name,
        load=load,
        unit=LOADS[load].unit,
        model=model,
        points=truth.size,
        rms=left,
        worst=worst,
        rms_share=left / rms(truth),
        worst_share=worst / float(np.max(np.abs(truth))),
        within_nine=float(np.mean(near)),
    )
