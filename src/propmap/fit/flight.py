"""Force balances of a flying vehicle as rows to fit, eqs. (16) and (17) and past them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from propmap.arrays.types import Floats
from propmap.baselines.hover import HoverModel
from propmap.engine.evaluation import prepare
from propmap.engine.gradients import load_gradients
from propmap.engine.plan import accuracy
from propmap.errors import InputError
from propmap.fit.body_forces import body_force
from propmap.fit.coverage import Coverage, coverage
from propmap.fit.parameters import BODY, SECTION, WING, Choice
from propmap.fit.rows import Rows
from propmap.fit.tunnel import hover_after_fit, rotor_with
from propmap.loads import LOADS
from propmap.model.airfoil import Airfoil
from propmap.vehicle.flight_log import GRAVITY, FlightLog
from propmap.vehicle.hub_flow import HubFlow, hub_flow, rotor_forces
from propmap.vehicle.vehicle import Vehicle

AXES = ("force_x", "force_y", "force_z")


@dataclass(frozen=True)
class Balance:
    """Aerodynamic force on the vehicle at n samples, in its frame: ``force`` (n, 3) [N], NaN where
    the loads were not found, and ``slopes`` (P, n, 3) by the parameters asked for.
    """

    force: Floats
    slopes: Floats


class ForceModel:
    """All forces but gravity on a vehicle, at the samples of a log.

    Parameters
    ----------
    vehicle : Vehicle
        Its rotors, body and wing.
    log : FlightLog
        How it moves.
    base : Airfoil
        Gives what no parameter of a fit does.
    setting : str
        Accuracy of the loads, as in ``Rotor``.

    Raises
    ------
    InputError
        Where the log has not one rotor speed per rotor.
    """

    def __init__(
        self, vehicle: Vehicle, log: FlightLog, base: Airfoil, setting: str = "standard"
    ) -> None:
        if log.rotor_speed.shape[1] != len(vehicle.mounts):
            raise InputError(
                f"{log.rotor_speed.shape[1]} rotor speeds for {len(vehicle.mounts)} rotors",
                "give the vehicle file one [[rotors]] table per rotor of the log",
                log.source,
            )
        self.vehicle, self.log, self.base, self.setting = vehicle, log, base, setting
        self.flow = hub_flow(vehicle, log)
        self._law = accuracy(setting)

    def at(self, values: Mapping[str, float], free: tuple[str, ...]) -> Balance:
        """Forces and their derivatives.

        Parameters
        ----------
        values : mapping of str to float
            All parameters by name.
        free : tuple of str
            Names of the P by which to differentiate.

        Returns
        -------
        Balance
            With ``force`` (n, 3) [N] and ``slopes`` (P, n, 3).
        """
        section = tuple(name for name in free if name in SECTION)
        vehicle, flow, shape = self.vehicle, self.flow, self.flow.omega.shape
        rotor = rotor_with(vehicle.propeller, vehicle.air, self.base, values, self.setting)
        points = (flow.omega.ravel(), flow.axial.ravel(), flow.inplane.ravel())
        found = load_gradients(prepare(rotor.arrays), self._law, section, *points)
        loads = found.loads.reshape(len(LOADS), *shape)
        slopes = found.slopes.reshape(len(LOADS), len(section), *shape)
        force = rotor_forces(flow, loads[0], loads[1])
        by_section = rotor_forces(flow, slopes[0], slopes[1])
        body, by_body = body_force(vehicle, self.log, values, free)
        slope = np.zeros((len(free), *force.shape))
        for k, name in enumerate(free):
            slope[k] = by_section[section.index(name)] if name in section else by_body[k]
        return Balance(force + body, slope)

    def coverage(self) -> Coverage:
        """What ``coverage`` says of the flow at all rotors."""
        flow = self.flow
        speed, beta = np.hypot(flow.axial, flow.inplane), np.arctan2(flow.inplane, flow.axial)
        radius = self.vehicle.propeller.radius
        return coverage(flow.omega.ravel(), speed.ravel(), beta.ravel(), radius)


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
    _acts(model, choice)
    log = model.log
    weight = model.vehicle.mass * GRAVITY
    n = len(log)

    def vertical(values: Mapping[str, float], free: tuple[str, ...]) -> tuple[Floats, Floats]:
        balance = model.at(values, free)
        along = np.sum(balance.force * log.up, axis=-1)
        return along, np.sum(balance.slopes * log.up, axis=-1).T

    return Rows(
        names=("vertical_force",),
        units=("N",),
        measured=np.full(n, weight),
        load=np.zeros(n, np.intp),
        scale=np.full(n, weight),
        speed=log.speed,
        point=np.arange(n),
        group=None,
        model=vertical,
        weight=np.ones(n),
    )


def balance_rows(model: ForceModel, choice: Choice, *, stretch: float = 1.0) -> Rows:
    """Three rows per sample: all forces but gravity against m times the specific force.

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
    _acts(model, choice)
    log = model.log
    mass = model.vehicle.mass
    measured = mass * log.specific_force
    if not np.isfinite(measured).all():
        raise InputError(
            "there is no specific force (accelerometer) for all samples",
            "add it to the log, or fit steady stretches with --method level",
            log.source,
        )
    n = len(log)
    sample, axis = np.divmod(np.arange(3 * n), 3)

    def forces(values: Mapping[str, float], free: tuple[str, ...]) -> tuple[Floats, Floats]:
        balance = model.at(values, free)
        return balance.force.ravel(), balance.slopes.reshape(len(free), -1).T

    return Rows(
        names=AXES,
        units=("N",) * 3,
        measured=measured.ravel(),
        load=axis,
        scale=np.full(3 * n, mass * GRAVITY),
        speed=log.speed[sample],
        point=sample,
        group=np.floor((log.time - log.time[0]) / stretch).astype(int)[sample],
        model=forces,
        weight=np.ones(3 * n),
    )


def hover_force(hover: HoverModel, flow: HubFlow) -> Floats:
    """The hover model's force of all rotors on the vehicle [N] (n, 3)."""
    thrust = hover.thrust(flow.omega)
    return rotor_forces(flow, thrust, np.zeros_like(thrust))


def hover_rows(model: ForceModel, values: Mapping[str, float], rows: Rows) -> Floats:
    """What the hover model says of the rows (M,) made of ``model``.

    ``values``, all parameters by name, give the rotor whose constants are taken.
    """
    vehicle = model.vehicle
    rotor = rotor_with(vehicle.propeller, vehicle.air, model.base, values, model.setting)
    force = hover_force(hover_after_fit(rotor), model.flow)
    if rows.names == AXES:
        return np.asarray(force.ravel())
    return np.asarray(np.sum(force * model.log.up, axis=-1))


def _acts(model: ForceModel, choice: Choice) -> None:
    if model.vehicle.wing is None:
        useless = [name for name in choice.free if name in WING]
        if useless:
            raise InputError(
                f"{useless[0]} is free but the vehicle has no wing", "add a [wing] table"
            )
    if not any(name in SECTION or name in BODY or name in WING for name in choice.free):
        raise InputError("no free parameter acts on the forces", "free some of the section's")
