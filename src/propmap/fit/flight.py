"""Force balances of a flying vehicle as rows to fit, eqs. (16) and (17) and past them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from propmap.baselines.hover import HoverModel
from propmap.errors import InputError
from propmap.fit.force_model import ForceModel, hover_loads
from propmap.fit.parameters import MOUNT, SENSOR, TURNING, WAKES, WING, Choice, general
from propmap.fit.rows import Rows
from propmap.fit.tunnel import model_with
from propmap.fit.turning import measured_moment
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.vehicle.flight_log import GRAVITY, FlightLog

AXES, VERTICAL = ("force_x", "force_y", "force_z"), ("vertical_force",)
MOMENTS = ("moment_x", "moment_y", "moment_z")
ALIKE = 1.0
"""Time within which errors of a flight are taken to be alike [s]."""

UNITS = {**dict.fromkeys((*AXES, *VERTICAL), "N"), **dict.fromkeys(MOMENTS, "N m")}


def level_rows(model: ForceModel, choice: Choice) -> Rows:
    """A row per steady level flight, where the vertical forces sum up to m g: eqs. (16)(17).

    With V horizontal, the vertical parts of a rotor's forces are T sin(beta) and D cos(beta);
    here they come from the attitude, so that a trace of climb or of bank is no error.

    Parameters
    ----------
    model : ForceModel
        Of the vehicle, at its steady operating points.
    choice : Choice
        Which parameters are free.

    Raises
    ------
    InputError
        For free parameters that do not act.
    """
    weight = np.full((len(model.log), 1), model.vehicle.mass * GRAVITY)
    return _rows(model, choice, VERTICAL, weight)


def vertical_rows(model: ForceModel, choice: Choice, *, stretch: float = ALIKE) -> Rows:
    """A row per sample of a whole flight: the vertical forces alone, as in (16) and (17).

    Where the flight is not steady, mass times the vertical specific force stands for the weight.

    Parameters
    ----------
    model, choice, stretch
        As for ``balance_rows``.

    Raises
    ------
    InputError
        For free parameters that do not act.
    """
    log = model.log
    measured = model.vehicle.mass * np.sum(log.specific_force * log.up, axis=1, keepdims=True)
    return _rows(model, choice, VERTICAL, measured, log.stretches(stretch))


def balance_rows(model: ForceModel, choice: Choice, *, stretch: float = ALIKE) -> Rows:
    """Rows of a whole flight: all forces but gravity against m times the specific force.

    There are three per sample, and three more of moments where the vehicle file has moments of
    inertia and the log has time derivatives: moments of the air against what turns the vehicle.

    Parameters
    ----------
    model : ForceModel
        Of the vehicle, at the samples of its log.
    choice : Choice
        Which parameters are free.
    stretch : float
        Time within which errors are taken to be alike [s].

    Raises
    ------
    InputError
        Where the log has no specific force, and for free parameters that do not act.
    """
    log = model.log
    if not np.isfinite(log.specific_force).all():
        raise InputError(
            "there is no specific force (accelerometer) for all samples",
            "add it to the log, or fit steady stretches with --method level",
            log.source,
        )
    group = log.stretches(stretch)
    measured = model.vehicle.mass * log.specific_force
    turning = measured_moment(model.vehicle, log)
    if not np.isfinite(turning).all():
        return _rows(model, choice, AXES, measured, group)
    six = np.concatenate([measured, turning], axis=1)
    return _rows(model, choice, (*AXES, *MOMENTS), six, group)


def _rows(
    model: ForceModel,
    choice: Choice,
    names: tuple[str, ...],
    measured: Floats,
    group: NDArray[np.intp] | None = None,
) -> Rows:
    """A row per load ``measured`` (n, L), in units of the weight and of that at the hubs' mean
    distance from the centre of mass, or at a radius where that is none."""
    if names == VERTICAL:
        useless = [name for name in choice.free if general(name) in SENSOR | TURNING]
        if useless:
            raise InputError(
                f"{useless[0]} has no part in steady stretches", "fit it with --method balance"
            )
    elif MOMENTS[0] not in names:
        useless = [name for name in choice.free if name in TURNING]
        if useless:
            raise InputError(
                f"{useless[0]} is free but moments are not balanced",
                "add inertia = [about x, about y, about z] in kg m^2 to the vehicle file",
            )
    if any(mount.drag is not None for mount in model.vehicle.mounts):
        known = [name for name in (*choice.free, *choice.fixed) if name in MOUNT]
        if known:
            raise InputError(
                f"{known[0]} is given for a vehicle whose file has it as well",
                "remove the [mount] table, or leave the parameter to the file",
            )
    if len(model.vehicle.mounts) == 1:
        useless = [name for name in choice.free if name in WAKES]
        if useless:
            raise InputError(
                f"{useless[0]} is free but the vehicle has one rotor", "leave it out of --free"
            )
    if model.vehicle.wing is None:
        useless = [name for name in choice.free if name in WING]
        if useless:
            raise InputError(
                f"{useless[0]} is free but the vehicle has no wing", "add a [wing] table"
            )

    def forces(values: Mapping[str, float], free: tuple[str, ...]) -> tuple[Floats, Floats]:
        balance = model.at(values, free)
        slopes = _along(model.log, names, balance.slopes)
        return _along(model.log, names, balance.loads), np.moveaxis(slopes, 0, -1)

    weight = model.vehicle.mass * GRAVITY
    places = np.array([mount.position for mount in model.vehicle.mounts])
    arm = float(np.mean(np.linalg.norm(places, axis=1))) or model.vehicle.propeller.radius
    each = np.array([weight * (arm if name in MOMENTS else 1.0) for name in names])
    scale = np.broadcast_to(each, measured.shape)
    units = tuple(UNITS[name] for name in names)
    return Rows.of_points(names, units, measured, scale, model.log.speed, forces, group)


def _along(log: FlightLog, names: tuple[str, ...], loads: Floats) -> Floats:
    """The loads of these names (..., n, L) of forces and moments (..., n, 6)."""
    if names == VERTICAL:
        return np.asarray(np.sum(loads[..., :3] * log.up, axis=-1, keepdims=True))
    return loads[..., : len(names)]


def hover_rows(model: ForceModel, values: Mapping[str, float], rows: Rows) -> Floats:
    """What the hover model says of the rows (M,) made of ``model``.

    ``values``, all parameters by name, give the rotor whose constants are taken.
    """
    hover = HoverModel.of(Rotor(model_with(model.model, values)))
    return rows.picked(_along(model.log, rows.names, hover_loads(hover, model.flow)))
