"""A parameter set against measurements, beside the hover model of the same rotor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from propmap.baselines.hover import HoverModel
from propmap.errors import InputError
from propmap.fit.body_forces import body_force
from propmap.fit.flight import ALIKE, AXES, MOMENTS, UNITS
from propmap.fit.flight_parameters import at_samples
from propmap.fit.force_model import hover_loads
from propmap.fit.parameters import FIRST_GUESS, ROTOR_SPEED, SENSOR, general
from propmap.fit.residuals import Errors, by_band, errors
from propmap.fit.sensor_forces import sensor_force
from propmap.fit.still_explained import Trend, trends
from propmap.fit.tunnel import TunnelData
from propmap.fit.turning import added_moment, measured_moment
from propmap.fit.wake_parameters import wakes_with
from propmap.loads import LOADS
from propmap.model.model import Model, Section
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.vehicle.flight_log import GRAVITY, FlightLog
from propmap.vehicle.hub_flow import HubFlow, hub_flow, rotor_wrench
from propmap.vehicle.interference import in_wakes
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
    model, hover : ndarray, shape (n, 6)
        In the vehicle's frame: forces [N], as an accelerometer feels them where it sits, and
        moments about the centre of mass [N m].
    """

    model: Floats
    hover: Floats


def flight_forces(
    vehicle: Vehicle,
    log: FlightLog,
    law: Section,
    values: Mapping[str, float],
) -> FlightForces:
    """All forces but gravity on a vehicle, by a section law and what a fit found besides.

    Parameters
    ----------
    vehicle, log : Vehicle, FlightLog
        What flew, and how.
    law : Airfoil or SectionTable
        The section law to judge.
    values : mapping of str to float
        All parameters but the rotor's by name; first guesses, or the vehicle file's, where it has
        none.
    """
    model = Model(vehicle.propeller, law, vehicle.air)
    logged = hub_flow(vehicle, log)
    flow = logged._replace(omega=values.get(ROTOR_SPEED, 1.0) * logged.omega)
    wakes, near = wakes_with(vehicle, values), flow
    if wakes is not None:
        near = in_wakes(vehicle, wakes, model, flow)
    loads = _rotor_loads(vehicle, model, near)
    values = {**FIRST_GUESS, **values}
    force, moment = rotor_wrench(flow, loads)
    scale = at_samples("thrust_scale", values, log)[:, None]
    force, moment = scale * force, scale * moment
    force = force + body_force(vehicle, log, values, ())[0]
    none = np.zeros((0, len(log), 3))
    moment = moment + added_moment(vehicle, log, logged, force, none, values, ())[0]
    force = force + sensor_force(vehicle, log, values, ())[0]
    hover = hover_loads(HoverModel.of(Rotor(model)), logged)
    return FlightForces(np.concatenate([force, moment], axis=1), hover)


def _rotor_loads(vehicle: Vehicle, model: Model, flow: HubFlow) -> Floats:
    """In the order of ``LOADS`` [N], [N m]; (L, n, m)."""
    velocity = np.stack([flow.inplane, np.zeros_like(flow.inplane), flow.axial], axis=-1)
    found = np.empty((len(LOADS), *flow.omega.shape))
    for mounted, mine in mounted_rotors(vehicle, model):
        loads = Rotor(mounted).loads_at_velocity(flow.omega[:, mine], velocity[:, mine])
        found[..., mine] = [getattr(loads, name) for name in LOADS]
    return found


def compare_forces(vehicle: Vehicle, log: FlightLog, forces: FlightForces) -> dict[str, Comparison]:
    """Errors of forces and moments along the vehicle's axes.

    Forces are held against mass times specific force, and moments, where the vehicle file has
    moments of inertia, against what turns the vehicle.

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
    measured = np.concatenate(
        [vehicle.mass * log.specific_force, measured_moment(vehicle, log)], axis=1
    )
    if not np.isfinite(measured[:, :3]).any():
        raise InputError("there is no specific force to compare with", "log it", log.source)
    names = (*AXES, *MOMENTS) if np.isfinite(measured[:, 3:]).any() else AXES
    return {
        f"{name}_{UNITS[name].replace(' ', '')}": _compared(
            forces.model[:, k], measured[:, k], log.speed, forces.hover[:, k]
        )
        for k, name in enumerate(names)
    }


def force_trends(vehicle: Vehicle, log: FlightLog, forces: FlightForces) -> list[list[Trend]]:
    """What the error of each force still goes with, the strongest first.

    Parameters
    ----------
    vehicle, log, forces : Vehicle, FlightLog, FlightForces
        As for ``compare_forces``.
    """
    off = forces.model[:, :3] - vehicle.mass * log.specific_force
    block = log.stretches(ALIKE)
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
    values = {name: value for name, value in values.items() if general(name) not in SENSOR}
    here = replace(vehicle, sensor=(0.0, 0.0, 0.0))
    found = flight_forces(here, log, law, values)
    vertical = (np.sum(one[:, :3] * log.up, axis=1) for one in (found.model, found.hover))
    model, hover = vertical
    return model, hover


def _compared(model: Floats, measured: Floats, speed: Floats, hover: Floats) -> Comparison:
    return Comparison(errors(model, measured, hover), by_band(model, measured, speed, hover))
