"""Forces and moments on a flying vehicle at the samples of a log, and their derivatives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from propmap.baselines.hover import HoverModel
from propmap.errors import InputError
from propmap.fit.body_forces import body_force
from propmap.fit.coverage import Coverage, coverage
from propmap.fit.flight_parameters import at_samples, check_flights, samples_of
from propmap.fit.parameters import EVERY, MOUNT, ROTOR, ROTOR_SPEED, WAKES, general
from propmap.fit.sensor_forces import sensor_force
from propmap.fit.tunnel import model_with
from propmap.fit.turning import added_moment
from propmap.fit.wake_parameters import PREFIX, wakes_with
from propmap.loads import LOADS
from propmap.model.airfoil import Airfoil
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.vehicle.flight_log import FlightLog
from propmap.vehicle.hub_flow import HubFlow, hub_flow, rotor_wrench
from propmap.vehicle.interference import check_apart, wake_flow
from propmap.vehicle.mounted_rotors import mounted_rotors
from propmap.vehicle.vehicle import Vehicle

LIFT = ("c_l1", "zero_lift_angle", "reynolds_camber", "untwist")
"""Parameters of attached lift, and so of the rotors' wakes."""

LIFT_STEP = 1e-4
"""Of the difference quotients by these, over the spread of each."""

SPEED_STEP = 1e-6
"""Of that by the rotor speed, over the speed."""


@dataclass(frozen=True)
class Balance:
    """What acts on the vehicle at n samples, in its frame.

    Attributes
    ----------
    loads : ndarray, shape (n, 6)
        Force [N] and moment about the centre of mass [N m], NaN where the rotors' loads were not
        found.
    slopes : ndarray, shape (P, n, 6)
        By the parameters asked for.
    """

    loads: Floats
    slopes: Floats

    @property
    def force(self) -> Floats:
        """[N], (n, 3)."""
        return self.loads[:, :3]

    @property
    def moment(self) -> Floats:
        """[N m], (n, 3)."""
        return self.loads[:, 3:]


class ForceModel:
    """All forces but gravity on a vehicle and their moments, at the samples of a log.

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
        self,
        vehicle: Vehicle,
        log: FlightLog,
        base: Airfoil,
        setting: str = "standard",
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

    def at(self, values: Mapping[str, float], free: tuple[str, ...]) -> Balance:
        """Forces and moments, and their derivatives.

        Parameters
        ----------
        values : mapping of str to float
            All parameters by name.
        free : tuple of str
            Names of the P by which to differentiate.
        """
        check_flights(free, self.log)
        loads, slopes = self._rotors(values, free)
        scale = at_samples("thrust_scale", values, self.log)[:, None]
        slopes = scale * slopes
        for row, name in enumerate(free):
            if general(name) == "thrust_scale":
                slopes[row] = samples_of(name, values, self.log)[:, None] * loads
        loads = scale * loads
        body, by_body = body_force(self.vehicle, self.log, values, free)
        force, by_force = loads[:, :3] + body, slopes[..., :3] + by_body
        more, by_more = added_moment(
            self.vehicle, self.log, self.flow, force, by_force, values, free
        )
        sensed, by_sensor = sensor_force(self.vehicle, self.log, values, free)
        return Balance(
            np.concatenate([force + sensed, loads[:, 3:] + more], axis=-1),
            np.concatenate([by_force + by_sensor, slopes[..., 3:] + by_more], axis=-1),
        )

    def _rotors(self, values: Mapping[str, float], free: tuple[str, ...]) -> tuple[Floats, Floats]:
        """Loads (n, 6) of all rotors, in each other's wakes where there are any, and their
        derivatives (P, n, 6)."""
        section = tuple(name for name in free if name in (*ROTOR, ROTOR_SPEED))
        at_section = [name in section for name in free]
        slopes = np.zeros((len(free), len(self.log), 6))
        wakes = wakes_with(self.vehicle, values)
        if wakes is None:
            loads, by_section = self._loads(values, section, self.flow.axial)
            slopes[at_section] = _six(self.flow, by_section)
            return _six(self.flow, loads), slopes
        check_apart(self.vehicle)
        named = (*section, "v_axial")
        thrust, by_lift = self._attached(values, section)
        wake = wake_flow(self.vehicle, wakes, self.flow, thrust)
        loads, by_here = self._loads(values, named, self.flow.axial + wake.added)
        by_axial = by_here[:, -1]
        # The wakes change with the thrusts that they are computed from.
        followed = np.einsum("nts,pns->pnt", wake.by_thrust, by_lift)
        by_section = by_here[:, :-1] + by_axial[:, None] * followed
        slopes[at_section] = _six(self.flow, by_section)
        for row, name in enumerate(free):
            if name in WAKES:
                added = wake.by_gain[name.removeprefix(PREFIX)]
                slopes[row] = _six(self.flow, by_axial * added)
        return _six(self.flow, loads), slopes

    def _attached(
        self, values: Mapping[str, float], names: tuple[str, ...]
    ) -> tuple[Floats, Floats]:
        """Thrust (n, m) that the wakes are computed from, and its derivatives (P, n, m)."""
        flow = self.flow
        known = {name: value for name, value in values.items() if name not in MOUNT}
        lifting = [name for name in names if name in LIFT]
        steps = [LIFT_STEP * EVERY[name].spread for name in lifting]
        moved = [
            model_with(self.model, {**known, name: known[name] + step})
            for name, step in zip(lifting, steps, strict=True)
        ]
        scale = values.get(ROTOR_SPEED, 1.0)
        omega, along = scale * flow.omega, (flow.axial, flow.inplane)
        rotor = Rotor(model_with(self.model, known))
        thrust, more = rotor.attached_thrust(omega, *along, moved)
        slopes = np.zeros((len(names), *omega.shape))
        if ROTOR_SPEED in names:
            faster, _ = rotor.attached_thrust((1.0 + SPEED_STEP) * omega, *along)
            slopes[names.index(ROTOR_SPEED)] = (faster - thrust) / (SPEED_STEP * scale)
        for name, step, change in zip(lifting, steps, more, strict=True):
            slopes[names.index(name)] = change / step
        return thrust, slopes

    def _loads(
        self, values: Mapping[str, float], names: tuple[str, ...], axial: Floats
    ) -> tuple[Floats, Floats]:
        """Loads (L, n, m) of the rotors at V cos(beta) = ``axial`` (n, m), and their derivatives
        (L, P, n, m) by the P of these ``names``."""
        flow, shape = self.flow, self.flow.omega.shape
        omega = values.get(ROTOR_SPEED, 1.0) * flow.omega
        asked = tuple("omega" if name == ROTOR_SPEED else name for name in names)
        loads = np.empty((len(LOADS), *shape))
        slopes = np.empty((len(LOADS), len(names), *shape))
        for model, mine in mounted_rotors(self.vehicle, model_with(self.model, values)):
            rotor = Rotor(model, accuracy=self.setting)
            found = rotor.gradients(asked, *(a[:, mine] for a in (omega, axial, flow.inplane)))
            loads[..., mine] = found.loads
            slopes[..., mine] = found.slopes
        if ROTOR_SPEED in names:
            slopes[:, names.index(ROTOR_SPEED)] *= flow.omega
        return loads, slopes

    def coverage(self) -> Coverage:
        """What ``coverage`` says of the flow at all rotors."""
        flow = self.flow
        speed, beta = np.hypot(flow.axial, flow.inplane), np.arctan2(flow.inplane, flow.axial)
        radius = self.vehicle.propeller.radius
        return coverage(flow.omega.ravel(), speed.ravel(), beta.ravel(), radius)


def _six(flow: HubFlow, loads: Floats) -> Floats:
    """Force and moment (..., n, 6) of all rotors from loads (L, ..., n, m)."""
    return np.concatenate(rotor_wrench(flow, loads), axis=-1)


def hover_loads(hover: HoverModel, flow: HubFlow) -> Floats:
    """The hover model's force [N] and moment [N m] of all rotors on the vehicle; (n, 6)."""
    known = hover.loads(flow.omega)
    return _six(flow, np.stack([known[name] for name in LOADS]))
