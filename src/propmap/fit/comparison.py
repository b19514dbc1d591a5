"""A parameter set against measurements, beside the hover model of the same rotor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from propmap.arrays.types import Floats
from propmap.baselines.hover import HoverModel
from propmap.errors import InputError
from propmap.fit.body_forces import body_force
from propmap.fit.flight import AXES, hover_force
from propmap.fit.parameters import FIRST_GUESS, SENSOR
from propmap.fit.residuals import Errors, by_band, errors
from propmap.fit.sensor_forces import sensor_force
from propmap.fit.still_explained import Trend, stretches, trends
from propmap.fit.thrust_scale import HoverScale
from propmap.fit.tunnel import TunnelData
from propmap.fit.wake_parameters import wakes_with
from propmap.loads import LOADS
from propmap.model.model import Model, Section
from propmap.rotor import Rotor
from propmap.vehicle.flight_log import GRAVITY, FlightLog
from propmap.vehicle.hub_flow import HubFlow, hub_flow, rotor_forces
from propmap.vehicle.interference import check_apart, wake_flow
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


@dataclass(frozen=True, eq=False)
class FlightForces:
    """All forces but gravity on a vehicle at n samples, by a model and by the hover model.

    Attributes
    ----------
    model, hover : ndarray, shape (n, 3)
        In the vehicle's frame [N], as an accelerometer feels them where it sits.
    scales : mapping of int to float
        By which the rotors' forces were multiplied, by number of flight.
    """

    model: Floats
    hover: Floats
    scales: Mapping[int, float]


def flight_forces(
    vehicle: Vehicle,
    log: FlightLog,
    law: Section,
    values: Mapping[str, float],
    *,
    scaled: bool = False,
) -> FlightForces:
    """All forces but gravity on a vehicle, by a section law and what a fit found besides.

    Parameters
    ----------
    vehicle, log : Vehicle, FlightLog
        What flew, and how.
    law : Airfoil or SectionTable
        The section law to judge.
    values : mapping of str to float
        The body's, wing's, sensor's and wakes' parameters by name; first guesses, or the vehicle
        file's, where it has none.
    scaled : bool
        Whether to scale the rotors' forces of each flight by its own hover, see ``thrust_scale``.
    """
    model = Model(vehicle.propeller, law, vehicle.air)
    flow = hub_flow(vehicle, log)
    thrust, drag = _thrust_and_drag(vehicle, model, flow)
    wakes = wakes_with(vehicle, values)
    if wakes is not None:
        check_apart(vehicle)
        wake = wake_flow(vehicle, wakes, flow, thrust)
        near = flow._replace(axial=flow.axial + wake.known)
        thrust, drag = _thrust_and_drag(vehicle, model, near)
        thrust = np.where(np.isfinite(wake.added), thrust, np.nan)
    values = {**FIRST_GUESS, **values}
    others = body_force(vehicle, log, values, ())[0] + sensor_force(vehicle, log, values, ())[0]
    rotors, scales = rotor_forces(flow, thrust, drag), dict[int, float]()
    if scaled:
        scales = HoverScale.of(log, vehicle.mass, flow.axis).scales(rotors, others)
        each = np.array([scales.get(int(number), 1.0) for number in log.flight])
        rotors = each[:, None] * rotors
    hover = hover_force(HoverModel.of(Rotor(model)), flow)
    return FlightForces(rotors + others, hover, scales)


def _thrust_and_drag(vehicle: Vehicle, model: Model, flow: HubFlow) -> tuple[Floats, Floats]:
    """[N], (n, m) each."""
    velocity = np.stack([flow.inplane, np.zeros_like(flow.inplane), flow.axial], axis=-1)
    thrust, drag = np.empty_like(flow.omega), np.empty_like(flow.omega)
    for mounted, mine in mounted_rotors(vehicle, model):
        loads = Rotor(mounted).loads_at_velocity(flow.omega[:, mine], velocity[:, mine])
        thrust[:, mine], drag[:, mine] = loads.thrust, loads.drag
    return thrust, drag


def compare_forces(vehicle: Vehicle, log: FlightLog, forces: FlightForces) -> dict[str, Comparison]:
    """Errors of the forces along the vehicle's axes, against mass times specific force.

    Parameters
    ----------
    vehicle, log : Vehicle, FlightLog
        What flew, and how.
    forces : FlightForces
        Of the samples of the log.

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
    return {
        f"{name}_N": _compared(forces.model[:, k], measured[:, k], log.speed, forces.hover[:, k])
        for k, name in enumerate(AXES)
    }


def force_trends(vehicle: Vehicle, log: FlightLog, forces: FlightForces) -> list[list[Trend]]:
    """What the error of each force still goes with, the strongest first.

    Parameters
    ----------
    vehicle, log, forces : Vehicle, FlightLog, FlightForces
        As for ``compare_forces``.
    """
    off, block = forces.model - vehicle.mass * log.specific_force, stretches(log)
    return [trends(log, name, "N", off[:, k], block) for k, name in enumerate(AXES)]


def compare_flight(
    vehicle: Vehicle, log: FlightLog, law: Section, values: Mapping[str, float]
) -> dict[str, Comparison]:
    """``compare_forces`` of ``flight_forces`` with ``vehicle``, ``log``, ``law`` and ``values``."""
    return compare_forces(vehicle, log, flight_forces(vehicle, log, law, values))


def compare_level(
    vehicle: Vehicle, log: FlightLog, law: Section, values: Mapping[str, float]
) -> dict[str, Comparison]:
    """Errors of the vertical force of steady level flights against the weight, eqs. (16)(17).

    Arguments are those of ``flight_forces``; no specific force is needed.
    """
    model, hover = level_forces(vehicle, log, law, values)
    weight = np.full(len(log), vehicle.mass * GRAVITY)
    return {"vertical_force_N": _compared(model, weight, log.speed, hover)}


def level_forces(
    vehicle: Vehicle, log: FlightLog, law: Section, values: Mapping[str, float]
) -> tuple[Floats, Floats]:
    """Vertical forces [N] (n,) by this model and by the hover model; see ``flight_forces``.

    Where the accelerometer sits plays no part.
    """
    values = {name: value for name, value in values.items() if name not in SENSOR}
    here = replace(vehicle, sensor=(0.0, 0.0, 0.0))
    found = flight_forces(here, log, law, values)
    return np.sum(found.model * log.up, axis=1), np.sum(found.hover * log.up, axis=1)


def _compared(model: Floats, measured: Floats, speed: Floats, hover: Floats) -> Comparison:
    return Comparison(errors(model, measured, hover), by_band(model, measured, speed, hover))
