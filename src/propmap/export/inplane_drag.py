"""The specific force along a body axis in level flight along it: what drag models are fitted to."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from propmap.aircraft.steady import Aircraft
from propmap.aircraft.steady_states import STATUSES
from propmap.errors import InputError
from propmap.export.load_errors import load_errors, rotor_sources
from propmap.model.corrections import MOUNT_DRAG
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.vehicle.flight_log import GRAVITY, in_vehicle_frame
from propmap.vehicle.vehicle import Body, Vector, Vehicle

AXES = {"x": "forward", "y": "sideways"}
"""Body axes, and how the vehicle flies along them."""

AT_REST = 0.1
"""Specific force along x or y at rest [m/s^2] up to which the thrust counts as along z; so much
is read as some 0.5 m/s of wind."""


@dataclass(frozen=True, eq=False)
class InplaneForces:
    """Level flights along a body axis at n speeds.

    Attributes
    ----------
    axis : str
        Of ``AXES``.
    speed, pitch : ndarray, shape (n,)
        Through the air [m/s]; lean into the flight [rad].
    along, through : ndarray, shape (n,)
        Component of the velocity along the axis, and its size [m/s].
    force : ndarray, shape (n,)
        Specific force against the motion, as an accelerometer reads it along the axis [m/s^2].
    errors : ndarray, shape (E, n)
        What each of E independent causes, at one standard deviation, adds to it [m/s^2].
    arm : ndarray, shape (n,)
        Torque over thrust, of all rotors together [m].
    hover_arm, hover_speed : float
        The same at rest, and the mean speed of the rotors then [rad/s].
    lost : tuple of (float, str)
        Speeds [m/s] that were asked for and are not flown, and why not.
    """

    axis: str
    speed: Floats
    pitch: Floats
    along: Floats
    through: Floats
    force: Floats
    errors: Floats
    arm: Floats
    hover_arm: float
    hover_speed: float
    lost: tuple[tuple[float, str], ...]


def inplane_forces(aircraft: Aircraft, axis: str, speeds: Floats) -> InplaneForces:
    """Trim an aircraft in level flight along a body axis.

    Parameters
    ----------
    aircraft : Aircraft
        What flies.
    axis : str
        Of ``AXES``; along y to the left, for which the right is alike where the vehicle is.
    speeds : ndarray, shape (n,)
        Above 0 [m/s].

    Raises
    ------
    InputError
        Where it cannot hover, where its thrust is not along z at rest, and where fewer than two
        of the speeds are flown.
    """
    turned = aircraft if axis == "x" else _turned(aircraft)
    states = turned.steady(np.concatenate([[0.0], speeds]), margin=False)
    if not states.found[0]:
        raise InputError(
            f"the vehicle does not hover: {STATUSES[str(states.status[0])]}",
            "check mass, propeller and motor, or the map",
        )
    _check_moments(turned, states.moment[0])
    size = len(states)
    up = in_vehicle_frame(np.zeros(size), np.zeros(size), np.ones(size), states.pitch, states.roll)
    specific = -GRAVITY * up[:, 0]
    if abs(specific[0]) > AT_REST:
        raise InputError(
            f"at rest the accelerometer reads {specific[0]:.2f} m/s^2 along {axis}: the rotors' "
            "thrust is not along z, as the drag models of autopilots take it to be",
            "check axis of the rotors",
        )
    flown = np.flatnonzero(states.found[1:]) + 1
    lost = [k for k in range(1, size) if k not in flown]
    if flown.size < 2:
        raise InputError(
            f"of the speeds, {flown.size} can be flown ({speeds[lost[0] - 1]:g} m/s: "
            f"{STATUSES[str(states.status[lost[0]])]})",
            "give two or more that can, with --speed",
        )
    arm = states.torque.sum(axis=1) / states.thrust.sum(axis=1)
    velocity = in_vehicle_frame(states.speed, 0.0, 0.0, states.pitch, states.roll)[flown]
    return InplaneForces(
        axis=axis,
        speed=states.speed[flown],
        pitch=states.pitch[flown],
        along=velocity[:, 0],
        through=np.linalg.norm(velocity, axis=1),
        force=specific[flown],
        errors=_errors(turned, velocity, states.rotor_speed[flown]),
        arm=arm[flown],
        hover_arm=float(arm[0]),
        hover_speed=float(states.rotor_speed[0].mean()),
        lost=tuple((float(states.speed[k]), str(states.status[k])) for k in lost),
    )


def _turned(aircraft: Aircraft) -> Aircraft:
    """The same aircraft with its left where the nose was."""
    vehicle = aircraft.vehicle
    x, y, z = vehicle.body.drag_area
    body = Body((y, x, z), download_area=vehicle.body.download_area[::-1])

    def turn(vector: Vector) -> Vector:
        return (vector[1], -vector[0], vector[2])

    mounts = tuple(
        replace(mount, position=turn(mount.position), axis=turn(mount.axis))
        for mount in vehicle.mounts
    )
    # Lift of the body is that in its plane of symmetry: along the left there is none.
    other = replace(vehicle, mounts=mounts, body=body, sensor=turn(vehicle.sensor))
    limits = aircraft.limits
    return Aircraft(
        other, aircraft.loads, maximum_rotor_speed=limits.rotor_speed, charge=limits.charge
    )


def _check_moments(aircraft: Aircraft, moment: Floats) -> None:
    vehicle = aircraft.vehicle
    if np.abs(moment).max() > 1e-3 * vehicle.mass * GRAVITY * vehicle.propeller.radius:
        told = ", ".join(f"{m:.2g}" for m in moment)
        raise InputError(
            f"the rotors cannot hover without a moment (about x, y, z: {told} N m)",
            "check position and spin of each rotor",
        )


def _errors(aircraft: Aircraft, velocity: Floats, omega: Floats) -> Floats:
    """Errors (E, n) of the specific force against the motion along x, the weight carried as before.

    A cause that changes the thrust changes the speed of all rotors so that they carry as much as
    before; the attitude and the flow are those of the flight without it.
    """
    vehicle = aircraft.vehicle
    axes = np.array([mount.axis for mount in vehicle.mounts])
    forward, upward, turning = [], [], []
    for source, mine in rotor_sources(vehicle, aircraft.loads):
        axis = axes[mine]
        along = velocity @ axis.T
        aside = velocity[:, None] - along[..., None] * axis
        across = np.linalg.norm(aside, axis=-1)
        seen = np.stack([across, np.zeros_like(along), along], axis=-1).reshape(-1, 3)
        found = load_errors(source, omega[:, mine].ravel(), seen)
        both = found.errors[:, :2].reshape(-1, 2, *along.shape)
        pair = found.by_speed[:2].reshape(2, *along.shape)
        # Thrust and drag of each rotor, forward and up.
        way = np.stack([np.broadcast_to(axis, aside.shape), -aside / across[..., None]])
        forward.append(np.einsum("elnk,lnk->en", both, way[..., 0]))
        upward.append(np.einsum("elnk,lnk->en", both, way[..., 2]))
        turning.append(np.einsum("lnk,lnkj->jn", pair, way[..., [0, 2]]))
    push, lift = np.sum(forward, axis=0), np.sum(upward, axis=0)
    faster = np.sum(turning, axis=0)
    return -(push - lift * faster[0] / faster[1]) / vehicle.mass


def check_vehicle(vehicle: Vehicle) -> None:
    """Raise ``InputError`` for a ``vehicle`` that is no multirotor as drag models take it to be."""
    count = len(vehicle.mounts)
    if count < 3:
        raise InputError(
            f"the vehicle has {count} rotor{'s' if count > 1 else ''}",
            "these parameters are those of a multirotor with 3 rotors or more",
        )
    if vehicle.wing is not None:
        raise InputError(
            "the vehicle has a wing, whose lift the drag model of a multirotor does not have",
            "remove [wing], or leave these parameters to the flights of the autopilot's own guide",
        )
    if vehicle.wakes is not None:
        raise InputError(
            "[wakes] is given, and the models of autopilots know no wakes of rotors on each other",
            "leave them out with --no-wakes, or remove the table",
        )
    for k, mount in enumerate(vehicle.mounts, start=1):
        if mount.axis[2] < 0.5:
            raise InputError(
                f"rotor {k}: its axis {list(mount.axis)} is not upward",
                "the drag models of autopilots take all thrust to be along z",
            )
        for j, other in enumerate(vehicle.mounts[: k - 1], start=1):
            apart = np.subtract(mount.position, other.position)
            beside = float(np.hypot(apart[0], apart[1]))
            if beside < vehicle.propeller.radius:
                raise InputError(
                    f"rotors {j} and {k} are above each other ({beside:g} m apart), and what "
                    "one's wake does to the other is not in the loads",
                    "describe each pair as one rotor with a map of its own",
                )


def missing_drag(aircraft: Aircraft) -> list[str]:
    """What of an ``aircraft``'s drag is left out, a sentence without its full stop each."""
    vehicle, loads = aircraft.vehicle, aircraft.loads
    found = []
    if not any(vehicle.body.drag_area[:2]):
        found.append("the vehicle file has no [body] drag_area: the coefficients have no body drag")
    texts = (
        loads.model.correction_texts
        if isinstance(loads, Rotor)
        else loads.info.get("corrections") or []
    )
    mounted = any(mount.drag is not None for mount in vehicle.mounts)
    if not mounted and not any(text.startswith(MOUNT_DRAG) for text in texts):
        found.append(
            "rotor drag is that of bare blades, as there is neither [mount] nor the correction "
            f"{MOUNT_DRAG}: what is mounted in the slipstreams was measured to add as much again; "
            "fit it to a flight"
        )
    return found
