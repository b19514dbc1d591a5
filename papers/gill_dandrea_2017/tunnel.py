"""The paper's tunnel experiment with public data: measured, this model, the hover model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from propmap.baselines.hover import HoverModel
from propmap.catalogue.lookup import Measurement, measurement
from propmap.fit.least_squares import errors as errors_of
from propmap.loads import LOADS
from propmap.model.airfoil import Airfoil, parameter_set
from propmap.model.corrections import MODELS
from propmap.model.model import Air, Model
from propmap.papers.gill_dandrea_2017.blades import blade
from propmap.papers.gill_dandrea_2017.identified import AXIAL, OBLIQUE, OTHER_FORM, TunnelFits
from propmap.papers.gill_dandrea_2017.paper import TUNNEL_ERROR
from propmap.rotor import Rotor
from propmap.typing import Floats

MULTIROTOR = "davoudi-8x4.5mr-thrust"
DATA_SETS = {
    AXIAL: "UIUC tunnel, axial and static",
    OBLIQUE: "2019 campaign, oblique (polynomials)",
    MULTIROTOR: "8x4.5MR thrust at 0 and 5 m/s (digitised)",
}

DIGITISED = 0.025
"""Uncertainty of the digitised thrust as a share of the largest: 2-3 % of full scale."""

PRINTED, STIFF = "paper-apc", "paper-stiff"
HOVER_LABEL = "hover model"
RECOMMENDED_LABEL = "the same, recommended inflow"
OTHER_LABEL = "other form of the data"
"""Among the models of the oblique set: its loads by the blade-element model of 2019.  What they
are off the polynomials is what these data leave open."""


@dataclass(frozen=True, eq=False)
class Compared:
    """One data set of n points and every model's loads on it.

    Attributes
    ----------
    data : Measurement
        What was measured.
    laws : dict of str to Airfoil
        Section laws by label.
    predicted : dict of str to dict of str to ndarray, shape (n,)
        By label of the model, the laws', the hover model's and, of the oblique set, the other
        form's, then by load.
    """

    data: Measurement
    laws: dict[str, Airfoil]
    predicted: dict[str, dict[str, Floats]]

    @property
    def air(self) -> Air:
        """That of the measurement."""
        return Air(density=self.data.air_density)


@dataclass(frozen=True)
class LoadError:
    """Error of one model in one load of one data set, in the load's unit.

    Attributes
    ----------
    rms, worst : float
        Root mean square and largest magnitude.
    rms_share, worst_share : float
        These over the root mean square and over the largest magnitude of the measured load.
    within_nine : float
        Share of the points within the paper's 9 % of their own measured value.
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
    found = {AXIAL: _compared(AXIAL, laws)}
    found[OBLIQUE] = _compared(OBLIQUE, laws | {RECOMMENDED_LABEL: recommended(fits.oblique.law)})
    found[OBLIQUE].predicted[OTHER_LABEL] = dict(measurement(OTHER_FORM).loads)
    # Nothing was fitted to this propeller; the stiff propeller of Table I has its size and pitch.
    found[MULTIROTOR] = _compared(
        MULTIROTOR, {"Table I, HQP 8x4.5": parameter_set(STIFF), **identified}
    )
    return found


def recommended(law: Airfoil) -> Airfoil:
    """A law found with the paper's model, for use with the inflow that propmap recommends."""
    return law.with_corrections(MODELS["recommended"])


def errors(found: dict[str, Compared]) -> list[LoadError]:
    """Errors by data set, load and model; the hover model has thrust and torque alone."""
    return [
        _error(name, load, model, truth, loads[load])
        for name, one in found.items()
        for load, truth in one.data.loads.items()
        for model, loads in one.predicted.items()
        if load in loads
    ]


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
    return Compared(data, laws, predicted)


def _error(name: str, load: str, model: str, truth: Floats, found: Floats) -> LoadError:
    e = errors_of(found, truth)
    near = np.abs(found - truth) <= TUNNEL_ERROR * np.abs(truth)
    return LoadError(
        data_set=name,
        load=load,
        unit=LOADS[load].unit,
        model=model,
        points=truth.size,
        rms=e.rms,
        worst=abs(e.worst),
        rms_share=e.relative_rms,
        worst_share=abs(e.worst) / float(np.max(np.abs(truth))),
        within_nine=float(np.mean(near)),
    )
