"""Force balances of a flying vehicle as rows to fit, eqs. (16) and (17) and past them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.baselines.hover import HoverModel
from propmap.engine.accuracy import accuracy
from propmap.engine.evaluation import prepare
from propmap.engine.gradients import load_gradients
from propmap.errors import InputError
from propmap.fit.body_forces import body_force
from propmap.fit.coverage import Coverage, coverage
from propmap.fit.parameters import MOUNT, ROTOR, SENSOR, WAKES, WING, Choice
from propmap.fit.rows import Rows
from propmap.fit.sensor_forces import sensor_force
from propmap.fit.thrust_scale import HoverScale
from propmap.fit.tunnel import model_with
from propmap.fit.wake_parameters import PREFIX, wakes_with
from propmap.loads import LOADS
from propmap.model.airfoil import Airfoil
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.vehicle.flight_log import GRAVITY, FlightLog
from propmap.vehicle.hub_flow import HubFlow, hub_flow, rotor_forces
from propmap.vehicle.interference import check_apart, wake_flow
from propmap.vehicle.mounted_rotors import mounted_rotors
from propmap.vehicle.vehicle import Vehicle

AXES, VERTICAL = ("force_x", "force_y", "force_z"), ("vertical_force",)


@dataclass(frozen=True)
class Balance:
    """Aerodynamic force on the vehicle at n samples, in its frame.

    Attributes
    ----------
    force : ndarray, shape (n, 3)
        [N], NaN where the loads were not found.
    slopes : ndarray, shape (P, n, 3)
        By the parameters asked for.
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
    scaled : bool
        Whether the rotors' forces are scaled for each flight by its own hover, see
        ``thrust_scale``.

    Raises
    ------
    InputError
        Where the log has not one rotor speed per rotor.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        log: FlightLog,
        base: Airfoil,
        setting: str = "standard",
        *,
        scaled: bool = False,
    ) -> None:
        if log.rotor_speed.shape[1] != len(vehicle.mounts):
            raise InputError(
                f"{log.rotor_speed.shape[1]} rotor speeds for {len(vehicle.mounts)} rotors",
                "give the vehicle file one [[rotors]] table per rotor of the log",
                log.source,
            )
        self.vehicle, self.log, self.setting = vehicle, log, setting
        self.model = Model(vehicle.propeller, base, vehicle.air)
        self.flow = hub_flow(vehicle, log)
        self.scale = HoverScale.of(log, vehicle.mass, self.flow.axis) if scaled else None

    def at(self, values: Mapping[str, float], free: tuple[str, ...]) -> Balance:
        """Forces and their derivatives.

        Parameters
        ----------
        values : mapping of str to float
            All parameters by name.
        free : tuple of str
            Names of the P by which to differentiate.
        """
        rotors = self._rotors(values, free)
        others = self._others(values, free)
        force, slopes = rotors.force, rotors.slopes
        if self.scale is not None:
            force, slopes = self.scale.applied(force, slopes, others.force, others.slopes)
        return Balance(force + others.force, slopes + others.slopes)

    def scales(self, values: Mapping[str, float], free: tuple[str, ...] = ()) -> dict[int, float]:
        """Thrust scales by number of flight, none where there are none.

        They are those at ``values``; ``free`` is as in ``at``, whose programs this uses.
        """
        if self.scale is None:
            return {}
        others = self._others(values, ())
        return self.scale.scales(self._rotors(values, free).force, others.force)

    def _others(self, values: Mapping[str, float], free: tuple[str, ...]) -> Balance:
        """Forces of the body and the wing, and what the accelerometer's place adds."""
        force, slopes = body_force(self.vehicle, self.log, values, free)
        sensed, by_sensor = sensor_force(self.vehicle, self.log, values, free)
        return Balance(force + sensed, slopes + by_sensor)

    def _rotors(self, values: Mapping[str, float], free: tuple[str, ...]) -> Balance:
        """Forces of all rotors, in each other's wakes where there are any."""
        section = tuple(name for name in free if name in ROTOR)
        at_section = [name in section for name in free]
        slopes = np.zeros((len(free), len(self.log), 3))
        wakes = wakes_with(self.vehicle, values)
        if wakes is None:
            loads, by_section = self._loads(values, section, self.flow.axial)
            slopes[at_section] = rotor_forces(self.flow, *by_section[:2])
            return Balance(rotor_forces(self.flow, *loads[:2]), slopes)
        check_apart(self.vehicle)
        named = (*section, "v_axial")
        alone, by_named = self._loads(values, named, self.flow.axial)
        wake = wake_flow(self.vehicle, wakes, self.flow, alone[0])
        loads, by_here = self._loads(values, named, self.flow.axial + wake.known)
        loads = np.where(np.isfinite(wake.added), loads, np.nan)
        by_axial = by_here[:2, -1]
        # The wakes change with the thrusts that they are computed from.
        followed = np.einsum("nts,pns->pnt", wake.by_thrust, by_named[0, :-1])
        by_section = by_here[:2, :-1] + by_axial[:, None] * followed
        slopes[at_section] = rotor_forces(self.flow, *by_section)
        for row, name in enumerate(free):
            if name in WAKES:
                added = wake.by_gain[name.removeprefix(PREFIX)]
                slopes[row] = rotor_forces(self.flow, *(by_axial * added))
        return Balance(rotor_forces(self.flow, *loads[:2]), slopes)

    def _loads(
        self, values: Mapping[str, float], names: tuple[str, ...], axial: Floats
    ) -> tuple[Floats, Floats]:
        """Loads (L, n, m) of the rotors at V cos(beta) = ``axial`` (n, m), and their derivatives
        (L, P, n, m) by the P of these ``names``."""
        flow, shape = self.flow, self.flow.omega.shape
        loads = np.empty((len(LOADS), *shape))
        slopes = np.empty((len(LOADS), len(names), *shape))
        for model, mine in mounted_rotors(self.vehicle, model_with(self.model, values)):
            some = [a[:, mine] for a in (flow.omega, axial, flow.inplane)]
            points = (a.ravel() for a in some)
            rotor = prepare(model.arrays())
            found = load_gradients(rotor, accuracy(self.setting), names, *points)
            loads[..., mine] = found.loads.reshape(-1, *some[0].shape)
            slopes[..., mine] = found.slopes.reshape(len(LOADS), -1, *some[0].shape)
        return loads, slopes

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
    weight = np.full((len(model.log), 1), model.vehicle.mass * GRAVITY)
    return _rows(model, choice, VERTICAL, weight)


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
    log = model.log
    if not np.isfinite(log.specific_force).all():
        raise InputError(
            "there is no specific force (accelerometer) for all samples",
            "add it to the log, or fit steady stretches with --method level",
            log.source,
        )
    begins = {k: log.time[log.flight == k].min() for k in np.unique(log.flight)}
    since = log.time - np.array([begins[k] for k in log.flight])
    # Stretches of different flights are different, whatever their clocks say.
    _, group = np.unique(np.stack([log.flight, since // stretch]), axis=1, return_inverse=True)
    return _rows(model, choice, AXES, model.vehicle.mass * log.specific_force, group)


def _rows(
    model: ForceModel,
    choice: Choice,
    names: tuple[str, ...],
    measured: Floats,
    group: NDArray[np.intp] | None = None,
) -> Rows:
    """A row per force ``measured`` (n, L) [N], in units of the weight."""
    if names == VERTICAL:
        useless = [name for name in choice.free if name in SENSOR]
        if useless:
            raise InputError(
                f"{useless[0]} has no part in steady stretches", "fit it with --method balance"
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
        return _along(model.log, names, balance.force), np.moveaxis(slopes, 0, -1)

    scale = np.full_like(measured, model.vehicle.mass * GRAVITY)
    units = ("N",) * len(names)
    return Rows.of_points(names, units, measured, scale, model.log.speed, forces, group)


def _along(log: FlightLog, names: tuple[str, ...], force: Floats) -> Floats:
    """The forces of these names (..., n, L) of forces (..., n, 3) in the vehicle's frame."""
    return np.sum(force * log.up, axis=-1, keepdims=True) if names == VERTICAL else force


def hover_force(hover: HoverModel, flow: HubFlow) -> Floats:
    """The hover model's force of all rotors on the vehicle [N] (n, 3)."""
    thrust = hover.thrust(flow.omega)
    return rotor_forces(flow, thrust, np.zeros_like(thrust))


def hover_rows(model: ForceModel, values: Mapping[str, float], rows: Rows) -> Floats:
    """What the hover model says of the rows (M,) made of ``model``.

    ``values``, all parameters by name, give the rotor whose constants are taken.
    """
    # One point by NumPy, without waiting for the compiler.
    hover = HoverModel.of(Rotor(model_with(model.model, values), compiled=False))
    return rows.picked(_along(model.log, rows.names, hover_force(hover, model.flow)))
