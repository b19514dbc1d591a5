"""A parameter set against measurements, beside the hover model of the same rotor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from propmap.arrays.types import Floats
from propmap.baselines.hover import HoverModel
from propmap.errors import InputError
from propmap.fit.body_forces import body_force
from propmap.fit.flight import AXES, hover_force
from propmap.fit.parameters import FIRST_GUESS
from propmap.fit.residuals import Errors, by_band, errors
from propmap.fit.tunnel import TunnelData
from propmap.loads import LOADS
from propmap.model.model import Model, Section
from propmap.rotor import Rotor
from propmap.vehicle.flight_log import GRAVITY, FlightLog
from propmap.vehicle.hub_flow import hub_flow, rotor_forces
from propmap.vehicle.mounted_rotors import mounted_rotors
from propmap.vehicle.vehicle import Vehicle


@dataclass(frozen=True)
class Comparison:
    """Errors of one load: over all rows and per band of speed."""

    all: Errors
    by_speed: Mapping[str, Errors]


def compare_tunnel(model: Model, data: TunnelData) -> dict[str, Comparison]:
    """Errors of a model on loads measured in a tunnel or on a bench.

    Parameters
    ----------
    model : Model
        The section law to judge, with the propeller and the air of the test.
    data : TunnelData
        What was measured.

    Returns
    -------
    dict of str to Comparison
        Every measured load by its name with unit.  The hover model beside it has thrust and
        torque alone.
    """
    rotor = Rotor(model)
    loads = rotor.loads(data.omega, data.speed, data.beta)
    hovers = HoverModel.of(rotor).loads(data.omega)
    return {
        LOADS[name].column: _compared(getattr(loads, name), measured, data.speed, hovers[name])
        for name, measured in data.loads.items()
    }


def compare_flight(
    vehicle: Vehicle, log: FlightLog, law: Section, values: Mapping[str, float]
) -> dict[str, Comparison]:
    """Errors of the forces on a vehicle along its axes, against mass times specific force.

    Parameters
    ----------
    vehicle, log : Vehicle, FlightLog
        What flew, and how.
    law : Airfoil or SectionTable
        The section law to judge.
    values : mapping of str to float
        The body's and the wing's parameters by name; first guesses where it has none.

    Returns
    -------
    dict of str to Comparison
        By the name of the force with unit.

    Raises
    ------
    InputError
        Where the log has no specific force.
    """
    measured = vehicle.mass * log.specific_force
    if not np.isfinite(measured).any():
        raise InputError("there is no specific force to compare with", "log it", log.source)
    model, hover = _forces(vehicle, log, law, values)
    return {
        f"{name}_N": _compared(model[:, k], measured[:, k], log.speed, hover[:, k])
        for k, name in enumerate(AXES)
    }


def compare_level(
    vehicle: Vehicle, log: FlightLog, law: Section, values: Mapping[str, float]
) -> dict[str, Comparison]:
    """Errors of the vertical force of steady level flights against the weight, eqs. (16)(17).

    Arguments are those of ``compare_flight``; no specific force is needed.
    """
    model, hover = level_forces(vehicle, log, law, values)
    weight = np.full(len(log), vehicle.mass * GRAVITY)
    return {"vertical_force_N": _compared(model, weight, log.speed, hover)}


def level_forces(
    vehicle: Vehicle, log: FlightLog, law: Section, values: Mapping[str, float]
) -> tuple[Floats, Floats]:
    """Vertical forces [N] (n,) by this model and by the hover model; see ``compare_flight``."""
    model, hover = (np.sum(f * log.up, axis=1) for f in _forces(vehicle, log, law, values))
    return model, hover


def _forces(
    vehicle: Vehicle, log: FlightLog, law: Section, values: Mapping[str, float]
) -> tuple[Floats, Floats]:
    """All forces but gravity (n, 3) [N] by this model, and those of the hover model."""
    model = Model(vehicle.propeller, law, vehicle.air)
    flow = hub_flow(vehicle, log)
    velocity = np.stack([flow.inplane, np.zeros_like(flow.inplane), flow.axial], axis=-1)
    thrust, drag = np.empty_like(flow.omega), np.empty_like(flow.omega)
    for mounted, mine in mounted_rotors(vehicle, model):
        loads = Rotor(mounted).loads_at_velocity(flow.omega[:, mine], velocity[:, mine])
        thrust[:, mine], drag[:, mine] = loads.thrust, loads.drag
    body, _ = body_force(vehicle, log, {**FIRST_GUESS, **values}, ())
    force = rotor_forces(flow, thrust, drag) + body
    return force, hover_force(HoverModel.of(Rotor(model)), flow)


def _compared(model: Floats, measured: Floats, speed: Floats, hover: Floats) -> Comparison:
    return Comparison(errors(model, measured, hover), by_band(model, measured, speed, hover))
