"""Aerodynamic forces of a vehicle in MuJoCo; needs ``propmap[mujoco]``.

MuJoCo's callback for passive forces applies the forces.  MuJoCo calls it at every evaluation of the
forces: four times per step with RK4, in ``mj_forward`` and in the viewer.  ``xfrc_applied`` remains
free for other forces.  The rotor speeds are activations of actuators, which MuJoCo integrates,
stores and resets with its other states.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from propmap import core
from propmap.errors import InputError, quoted, require
from propmap.results import STATUSES
from propmap.rotor import Rotor
from propmap.table import STATUSES as TABLE_STATUSES
from propmap.table import LoadTable, TableLoads
from propmap.typing import Floats
from propmap.units import DEGREE
from propmap.vehicle.throttle import LAG, USUAL
from propmap.vehicle.vehicle import Mount, Vehicle
from propmap.vehicle.vehicle_forces import Rotors, VehicleForces, VehicleWrench, airframe
from propmap.vehicle.wakes import core_wakes, cross

require("mujoco")
import mujoco  # noqa: E402

MASS = 0.2  # maximum relative difference of mass between model and vehicle, for a payload
PLACE = 0.1  # maximum distance of a site from its hub, relative to the largest arm


class MujocoRotors:
    """Aerodynamic forces on a vehicle in MuJoCo, as a callback for passive forces.

    Register it with ``mujoco.set_mjcb_passive(MujocoRotors(model, vehicle, table))``.  Each rotor
    is a site, with the z axis along the thrust, and an actuator with the same name.  The actuator
    itself exerts no force (``gainprm="0"``).  Its ``ctrl`` is the commanded rotor speed [rad/s].
    With ``dyntype`` "filter" or "filterexact", its activation is the actual rotor speed, which
    follows with the time constant ``dynprm`` [s]; without ``dyntype`` there is no lag.

    Forces act at the sites, in air with the wind velocity ``model.opt.wind`` [m/s] and the density
    ``vehicle.air.density``.  If the vehicle has a ``rotor_inertia``, rotors also exert reaction
    torques when they change speed, and gyroscopic moments.

    A ``Rotor`` with uniform inflow or the inflow of Pitt and Peters has the loads and the inflow
    states of ``DynamicInflow``.  The inflow is steady at the first time of each MjData and after a
    jump of ``data.time``, such as a reset.  The inflow advances with the time steps.  Within a step
    of RK4, it is interpolated linearly.  With another inflow or a table, loads are quasi-static.

    Parameters
    ----------
    model : mujoco.MjModel
        Model in which the vehicle is a body with a free joint, x forward, y left and z up.
    vehicle : Vehicle
        The vehicle, with rotors in the order of ``names``, body, wing and wakes.
    loads : Rotor or LoadTable
        Source of the rotor loads.
    names : sequence of str
        Names of sites and actuators; by default "rotor_1", "rotor_2" and so on.
    clamp : bool
        Whether rotors outside a table use the loads of its nearest point, with the status
        "clamped", instead of an error.

    Attributes
    ----------
    vehicle : Vehicle
        The vehicle with its rotors at the sites, relative to the model's center of mass.

    Raises
    ------
    InputError
        If model and vehicle do not agree; in the callback, if a rotor has no loads or turns
        backward.
    """

    def __init__(
        self,
        model: Any,
        vehicle: Vehicle,
        loads: Rotor | LoadTable,
        *,
        names: Sequence[str] = (),
        clamp: bool = False,
    ) -> None:
        if not isinstance(loads, Rotor | LoadTable):
            raise InputError(
                f"loads is {type(loads).__name__}", "give a Rotor or a LoadTable of the rotors"
            )
        if not isinstance(vehicle, Vehicle) or not isinstance(model, mujoco.MjModel):
            found = f"model and vehicle are {type(model).__name__} and {type(vehicle).__name__}"
            remedy = "give an MjModel and propmap.read_vehicle(path).vehicle"
            raise InputError(f"{found}, not MjModel and Vehicle", remedy)
        if isinstance(names, str):
            raise InputError(f"names is {names!r}, one text", "give a list of names, one per rotor")
        self.model = model
        self.names = tuple(names) or tuple(f"rotor_{k + 1}" for k in range(len(vehicle.mounts)))
        _check_options(model)
        sites, body = _sites(model, self.names, vehicle, given=bool(names))
        _, self._pose, self._motion = free_body(model, body)
        mounts, self._center = _mounts(model, body, sites, vehicle, self.names)
        self.vehicle = replace(vehicle, mounts=mounts)
        self._speeds = _Speeds(model, self.names)
        if clamp and isinstance(loads, LoadTable):
            loads = _ClampedTable(loads.content)
        rotors, self._forces = Rotors.of(self.vehicle, loads), VehicleForces(self.vehicle, loads)
        of_rotor: dict[int, Any] = {k: one for one, mine in rotors.sources for k in mine.tolist()}
        self._core = core.FreeBody(
            np.column_stack([rotors.position, rotors.axis, rotors.spin]),
            airframe(vehicle.body, vehicle.wing, vehicle.air.density),
            [of_rotor[k]._core for k in range(len(rotors))],
            float(vehicle.rotor_inertia),
            self._center,
            clamp,
            *(core_wakes(self.vehicle, vehicle.wakes) if vehicle.wakes else (None, np.zeros(5))),
        )
        self._rotors = rotors
        self._words = np.array(STATUSES if isinstance(loads, Rotor) else TABLE_STATUSES)
        self._codes = np.zeros((2, len(rotors)), np.uint8)
        self._static = _Step(-np.inf, 1.0, np.zeros(0), np.zeros(0))
        self._steps: WeakKeyDictionary[Any, _Step] = WeakKeyDictionary()  # last step per MjData

    def __call__(self, model: Any, data: Any) -> None:
        """Add the forces to ``data.qfrc_passive`` if ``model`` is the vehicle's model or a copy."""
        if model is not self.model and model.names != self.model.names:
            return
        omega, change = self._speeds.of(data)
        pose, motion = data.qpos[self._pose], data.qvel[self._motion]
        wind, forces = model.opt.wind, data.qfrc_passive[self._motion]
        step = self._step(data, model.opt.timestep) if self._core.inflow_size else self._static
        lost = self._core.push(
            pose, motion, wind, omega, change, forces, self._codes,
            step.state, step.later, step.length, step.at_rest,
        )  # fmt: skip
        if lost is not None:
            # In a thread of mujoco.rollout, an exception would end the process.
            if threading.get_ident() not in {thread.ident for thread in threading.enumerate()}:
                forces[:] = np.nan
                return
            self._refuse(lost, omega, change, self._hubs(model, data)[lost], data.time)

    @property
    def status(self) -> tuple[str, ...]:
        """Return the status of each rotor at the last evaluation of the forces."""
        return tuple(self._words[self._codes[0]].tolist())

    @property
    def worst_status(self) -> tuple[str, ...]:
        """Return the worst status of each rotor since the start."""
        return tuple(self._words[self._codes[1]].tolist())

    def wrench(self, data: Any) -> VehicleWrench:
        """Return ``VehicleForces.wrench`` at the state of ``data``, in the vehicle frame.

        The inflow is steady.  Gyroscopic and reaction moments of the rotors are excluded.
        """
        velocity, rates, wind = self._flight(self.model, data)
        return self._forces.wrench(self._speeds.of(data)[0], velocity, rates, wind)

    def _step(self, data: Any, length: float) -> _Step:
        """Return the step that starts at the time of ``data``, or a part of the last step."""
        last = self._steps.get(data, self._static)
        share = round((data.time - last.start) / last.length, 6)  # data.time accumulates errors
        if not 0.0 <= share <= 1.0:  # first call for this data, or a jump of time
            share, state, later = 0.0, *np.zeros((2, self._core.inflow_size))
            last = self._steps[data] = _Step(data.time, length, state, later, at_rest=True)
        if share == 0.0:
            last.length = length
            return last
        state = last.state + share * (last.later - last.state)
        found = _Step(data.time, length, state, np.zeros(self._core.inflow_size))
        if share == 1.0:
            self._steps[data] = found
        return found

    def _flight(self, model: Any, data: Any) -> tuple[Floats, Floats, Floats]:
        """Return velocity of the center of mass, rates and wind in the vehicle frame, (3,) each."""
        turn, quaternion = np.empty(9), data.qpos[self._pose][3:].copy()
        mujoco.mju_normalize4(quaternion)
        mujoco.mju_quat2Mat(turn, quaternion)
        to_vehicle, motion = turn.reshape(3, 3).T, data.qvel[self._motion]
        rates = motion[3:].copy()
        velocity = to_vehicle @ motion[:3] + cross(rates, self._center)
        return velocity, rates, to_vehicle @ model.opt.wind

    def _hubs(self, model: Any, data: Any) -> Floats:
        """Return the velocities of the hubs through the air (k, 3) [m/s]."""
        velocity, rates, wind = self._flight(model, data)
        return velocity - wind + cross(rates, self._rotors.position)

    def _refuse(self, k: int, omega: Floats, change: Floats, hub: Floats, time: float) -> None:
        """Raise an error for rotor ``k`` without loads at the ``hub`` velocity (3,)."""
        along = float(hub @ self._rotors.axis[k])
        beta = np.arctan2(np.sqrt(max(float(hub @ hub) - along**2, 0.0)), along)
        if not np.isfinite(omega[k] + change[k]):
            found = f"at {time:.4g} s the command or the speed of {self.names[k]} is not finite"
            raise InputError(found, "set finite numbers in data.ctrl and data.act")
        if omega[k] < 0.0:
            found = f"at {time:.4g} s the speed of {self.names[k]} is {omega[k]:.4g} rad/s"
            raise InputError(found, "keep data.act and ctrlrange at 0 or more")
        tabulated = "build a larger table, keep the flight inside the table, or pass clamp=True"
        raise InputError(
            f"at {time:.4g} s {self.names[k]} has no loads ({self.status[k]}), at "
            f"{omega[k]:.4g} rad/s, {np.linalg.norm(hub):.3g} m/s and beta {beta / DEGREE:.0f} deg",
            tabulated if self.status[k] in TABLE_STATUSES else "see Rotor.explain for the cause",
        )


class _ClampedTable(LoadTable):
    """A table that clamps points outside to its nearest point."""

    def loads_at_velocity(
        self, omega: ArrayLike, velocity: ArrayLike, *, clamp: bool = True
    ) -> TableLoads:
        """Interpolate the loads, by default at the nearest point of the table."""
        return super().loads_at_velocity(omega, velocity, clamp=clamp)


@dataclass(slots=True)
class _Step:
    """Inflow states of all rotors at the ``start`` of a time step of this ``length`` [s]."""

    start: float
    length: float
    state: Floats
    later: Floats  # states at the end of the step, which the core computes with the forces
    at_rest: bool = False  # whether the core first sets ``state`` to the steady inflow


class _Speeds:
    """Reader of the rotor speeds in the state of a model, from the actuators with these names."""

    def __init__(self, model: Any, names: Sequence[str]) -> None:
        kinds = mujoco.mjtDyn
        lags = {int(kinds.mjDYN_FILTER), int(kinds.mjDYN_FILTEREXACT)}
        found = [_find(model, mujoco.mjtObj.mjOBJ_ACTUATOR, "actuator", name) for name in names]
        for name, k in zip(names, found, strict=True):
            if model.actuator_gainprm[k].any() or model.actuator_biasprm[k].any():
                raise InputError(
                    f"the actuator {name!r} itself exerts a force on the vehicle",
                    'set gainprm="0" and no bias: the activation is a rotor speed',
                )
            if int(model.actuator_dyntype[k]) not in {int(kinds.mjDYN_NONE), *lags}:
                raise InputError(
                    f"the actuator {name!r} has an unsupported dyntype",
                    'set dyntype="filter", with the lag [s] as dynprm, or "none"',
                )
        limited, ends = model.actuator_ctrllimited[found] > 0, model.actuator_ctrlrange[found].T
        self._ctrl = np.array(found)
        self._low, self._high = np.where(limited, ends, [[0.0], [np.inf]])
        lagging = {int(model.actuator_dyntype[k]) in lags for k in found}
        if len(lagging) > 1:
            fault = "some of the rotors' actuators have a lag, others have none"
            raise InputError(fault, "give all of them a lag, or none")
        self._act = model.actuator_actadr[found] if lagging == {True} else None
        limited = model.actuator_actlimited[found] > 0
        self._rate = 1.0 / np.maximum(model.actuator_dynprm[found, 0], mujoco.mjMINVAL)
        if self._act is not None and limited.any():
            name = names[int(np.argmax(limited))]
            fault = f"the activation of the actuator {name!r} is limited"
            raise InputError(fault, "limit ctrl instead: the rotor speed then stays in this range")
        exact = model.actuator_dyntype[found] == int(kinds.mjDYN_FILTEREXACT)
        step = model.opt.timestep
        self._rate = np.where(exact, -np.expm1(-step * self._rate) / step, self._rate)
        self._steady = np.zeros(len(found))

    def of(self, data: Any) -> tuple[Floats, Floats]:
        """Return the rotor speeds (k,) [rad/s] and their rates of change [rad/s^2]."""
        wanted = np.minimum(np.maximum(data.ctrl[self._ctrl], self._low), self._high)
        if self._act is None:
            return wanted, self._steady
        omega = data.act[self._act]
        return omega, (wanted - omega) * self._rate


# --- Adding rotors to a model without rotors -----------------------------------------------------


def attach(
    spec: Any, vehicle: Vehicle, body: str, *, sites: Sequence[str] = (), keep: bool = False
) -> tuple[Vehicle, list[str]]:
    """Add a site and an actuator per rotor ("rotor_1", "rotor_2" ...) to an MJCF model.

    ``MujocoRotors`` then accepts the model.  The rotor speeds follow the commands with an assumed
    lag of 0.05 s (``dynprm``).  In keyframes, the rotor speeds are zero.  The function sets the
    density and the viscosity of MuJoCo's air to zero.

    Parameters
    ----------
    spec, vehicle : mujoco.MjSpec, Vehicle
        Model to change, such as ``mujoco.MjSpec.from_file(path)``, and vehicle with the rotors.
    body : str
        Name of the body with the rotors and a free joint; its axes are x forward, y left, z up.
    sites : sequence of str
        Existing sites at the hubs, in the order of the rotors (default: the positions of the
        vehicle file, relative to the model's center of mass).
    keep : bool
        Whether to keep the actuators at sites of the body (default: remove them).

    Returns
    -------
    tuple of Vehicle and list of str
        The vehicle with the mass and inertia of the model, and a line for each change.

    Raises
    ------
    InputError
        For an unknown body, for sites away from the hubs, and if actuators to be removed push
        against the thrust.
    """
    if not isinstance(spec, mujoco.MjSpec):
        raise InputError(f"spec is {type(spec).__name__}", "give mujoco.MjSpec.from_file(path)")
    if not isinstance(vehicle, Vehicle):
        remedy = "give propmap.read_vehicle(path).vehicle"
        raise InputError(f"vehicle is {type(vehicle).__name__}", remedy)
    # Compile before the actuators change: the compiler assigns the controls in keyframes to their
    # actuators, so the remaining actuators keep their controls.
    model, carrier = spec.compile(), spec.body(body)
    at, _, _ = free_body(model, body)
    if spec.site("rotor_1"):
        raise InputError("the model already has a site 'rotor_1'", "attach the rotors only once")
    data, to_vehicle, center = center_of_mass(model, at)
    mujoco.mj_crb(model, data)
    inertia = data.crb[at][[0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(3, 3)
    x, y, z = np.diag(to_vehicle @ inertia @ to_vehicle.T).tolist()
    flown = replace(vehicle, mass=float(model.body_subtreemass[at]), inertia=(x, y, z))
    if sites:
        hubs, there = _sites(model, sites, vehicle, given=True)
        if there != at:
            raise InputError(f"the sites are not on the body {body!r}", "give the sites' body")
        flown = replace(flown, mounts=_mounts(model, at, hubs, flown, sites)[0])
    on_body = np.flatnonzero(model.body_weldid[model.site_bodyid] == at)
    own = set() if keep else {model.site(k).name for k in on_body}
    at_site = [one for one in spec.actuators if one.trntype == mujoco.mjtTrn.mjTRN_SITE]
    old = [one for one in at_site if one.target in own]
    forces = [data.site(one.target).xmat.reshape(3, 3) @ one.gear[:3] for one in old]
    push = to_vehicle @ np.sum([np.zeros(3), *forces], axis=0)
    if (flown.rotor_axes @ push < 0.0).any():
        found = f"the actuators of {body!r} push along {_text(push)}, against the rotors"
        raise InputError(found, "give vehicle and body x forward, y left and z up")
    changes = [f"vehicle: mass {flown.mass:.4g} kg (vehicle file: {vehicle.mass:.4g} kg)"]
    changes += [f"vehicle: inertia {_text(flown.inertia)} kg m^2"]
    air = {name: getattr(spec.option, name) for name in ("density", "viscosity")}
    changes += [f"option {name}: 0 instead of {value:g}" for name, value in air.items() if value]
    changes += [f"actuator {one.name!r}: removed" for one in old]
    changes += [f"keyframe {key.name!r}: rotor speeds 0 rad/s" for key in spec.keys]
    spec.option.density = spec.option.viscosity = 0.0
    for one in old:
        spec.delete(one)
    settings = {
        "trntype": mujoco.mjtTrn.mjTRN_SITE,
        "dyntype": mujoco.mjtDyn.mjDYN_FILTER,
        "dynprm": [USUAL[LAG]] + [0.0] * 9,
        "gainprm": [0.0] * 10,
        "ctrllimited": mujoco.mjtLimited.mjLIMITED_FALSE,
    }
    for k, mount in enumerate(flown.mounts, start=1):
        name, place = f"rotor_{k}", center + mount.position
        carrier.add_site(name=name, pos=place, zaxis=mount.axis)
        spec.add_actuator(name=name, target=name, **settings)
        changes += [f"site and actuator {name!r}: {mount.spin} rotor at {_text(place)} m"]
    return flown, changes


# --- Checks that a model agrees with the vehicle -------------------------------------------------


def check_air(model: Any) -> None:
    """Refuse a ``model`` with air, which would apply body drag twice."""
    if model.opt.density or model.opt.viscosity:
        raise InputError(
            "the model's option density or viscosity is not 0: MuJoCo would apply drag as well",
            "remove both options: the vehicle file sets the air density and the body drag",
        )


def _check_options(model: Any) -> None:
    """Refuse options of a ``model`` that would falsify the simulation."""
    check_air(model)
    off = mujoco.mjtDisableBit.mjDSBL_SPRING | mujoco.mjtDisableBit.mjDSBL_DAMPER
    if model.opt.disableflags & off == off:
        raise InputError("passive forces are disabled in the model", "remove the disable flags")
    off = mujoco.mjtDisableBit.mjDSBL_ACTUATION | mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL
    if model.opt.disableflags & off or model.opt.disableactuator:
        raise InputError(
            "the model disables the actuators of the rotors, or their range",
            "remove the flags actuation, clampctrl and actuatorgroupdisable",
        )


def _find(model: Any, kind: Any, word: str, name: str) -> int:
    """Return the index of the object with a ``name`` in the model."""
    found = int(mujoco.mj_name2id(model, kind, name))
    if found < 0:
        fault = f"the model has no {word} {name!r}"
        raise InputError(fault, "each rotor needs a site and an actuator with the same name")
    return found


def _sites(
    model: Any, names: Sequence[str], vehicle: Vehicle, *, given: bool
) -> tuple[list[int], int]:
    """Return the sites of the rotors, and their body."""
    rotors = len(vehicle.mounts)
    for k, name in enumerate(names):
        if name in names[:k]:
            raise InputError(f"two rotors are named {name!r}", "give each its own name")
    if len(names) != rotors:
        fault = f"{len(names)} names are given, the vehicle has {rotors} rotors"
        raise InputError(fault, "give one for each, in the order of the vehicle file")
    if not given:
        every = [model.site(k).name for k in range(model.nsite)]
        more = [name for name in every if re.fullmatch(r"rotor_\d+", name) and name not in names]
        if more:
            fault = f"the site {more[0]!r} belongs to no rotor: the vehicle has {rotors}"
            raise InputError(fault, "remove the site, or add [[rotors]] to the vehicle file")
    found = [_find(model, mujoco.mjtObj.mjOBJ_SITE, "site", name) for name in names]
    bodies = model.body_weldid[model.site_bodyid[found]]
    if (bodies != bodies[0]).any():
        raise InputError(
            "the rotors' sites are on bodies that move relative to each other",
            "put all sites on one body: rotors that tilt in flight are not modeled",
        )
    return found, int(bodies[0])


def free_body(model: Any, body: str | int) -> tuple[int, slice, slice]:
    """Return the index of a free body, and the slices of its pose and motion in the state."""
    known = [model.body(k).name for k in range(1, model.nbody)]
    if body not in known and isinstance(body, str):
        found = f"the model has no body {quoted(body)}"
        raise InputError(found, f"choose one of {', '.join(known)}")
    at = model.body(body)
    # A body with a free joint has no other joint.
    joint = model.joint(at.jntadr[0]) if at.jntadr[0] >= 0 else None
    if joint is None or joint.type[0] != mujoco.mjtJoint.mjJNT_FREE:
        raise InputError(f"the body {quoted(at.name)} is not free", "give it a <freejoint/>")
    pose, motion = int(joint.qposadr[0]), int(joint.dofadr[0])
    return int(at.id), slice(pose, pose + 7), slice(motion, motion + 6)


def center_of_mass(model: Any, body: int) -> tuple[Any, Floats, Floats]:
    """Return the state at rest, the axes of the ``body`` (3, 3) as rows, and its center (3,)."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    axes = data.xmat[body].reshape(3, 3).T
    return data, axes, axes @ (data.subtree_com[body] - data.xpos[body])


def _mounts(
    model: Any, body: int, sites: list[int], vehicle: Vehicle, names: Sequence[str]
) -> tuple[tuple[Mount, ...], Floats]:
    """Return the rotors at their ``sites``, and the center of mass (3,) in the body frame.

    Raises ``InputError`` if these or the mass disagree with the ``vehicle``.
    """
    mass = float(model.body_subtreemass[body])
    if abs(mass - vehicle.mass) > MASS * vehicle.mass:
        fault = f"the body of the rotors has {mass:.4g} kg, the vehicle file {vehicle.mass:.4g} kg"
        grams = 300.0 < mass / vehicle.mass < 3000.0
        raise InputError(fault, "MJCF is in kg, not g" if grams else "give both the same mass")
    data, to_vehicle, center = center_of_mass(model, body)
    placed = []
    arm = np.linalg.norm(vehicle.hub_positions, axis=1).max()
    for mount, site, name in zip(vehicle.mounts, sites, names, strict=True):
        place = to_vehicle @ (data.site_xpos[site] - data.subtree_com[body])
        axis = to_vehicle @ data.site_xmat[site].reshape(3, 3)[:, 2]
        if np.linalg.norm(place - mount.position) > PLACE * max(arm, vehicle.propeller.radius):
            remedy = "give names in the vehicle's order, and a body with x forward, y left, z up"
            raise InputError(
                f"the site {name!r} is at {_text(place)} m from the center of mass, the vehicle's "
                f"rotor at {_text(mount.position)} m",
                "MJCF is in m, not mm" if np.linalg.norm(place) > 100.0 * arm else remedy,
            )
        if axis @ mount.axis < 1.0 - 0.5 * PLACE**2:
            fault = f"the site {name!r} points along {_text(axis)}, the rotor {_text(mount.axis)}"
            raise InputError(fault, "rotate the site so that its z axis is along the thrust")
        placed.append(replace(mount, position=tuple(place.tolist()), axis=tuple(axis.tolist())))
    return tuple(placed), center


def _text(vector: Any) -> str:
    return "(" + ", ".join(f"{x:.3g}" for x in np.round(vector, 6) + 0.0) + ")"
