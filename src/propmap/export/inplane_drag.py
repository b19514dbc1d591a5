"""The force across the rotors' axes in level flight, and the constants of drag that fit it best."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.aircraft.trim import STATUSES, Aircraft
from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.operating_points import split_velocity
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.log import in_vehicle_frame
from propmap.vehicle.vehicle import Body, Vector, Vehicle
from propmap.vehicle.vehicle_forces import mounted_rotors

if TYPE_CHECKING:
    from propmap.table.query import LoadTable


# -------------------------------------------------------------------------------------------------
# The specific force along a body axis in level flight along it: what drag models are fitted to.

AXES = {"x": "forward", "y": "sideways"}  # body axes, and how the vehicle flies along them
AT_REST = 0.1
"""Specific force along x or y at rest [m/s^2] up to which the thrust counts as along z; so much
is read as some 0.5 m/s of wind."""


@dataclass(frozen=True, eq=False)
class InplaneForces:
    """Level flights along a body axis at n speeds; arrays (n,)."""

    axis: str  # of ``AXES``
    speed: Floats  # through the air [m/s]
    pitch: Floats  # lean into the flight [rad]
    along: Floats  # component of the velocity along the axis [m/s]
    through: Floats  # size of the velocity [m/s]
    force: Floats  # specific force against the motion, as an accelerometer reads it [m/s^2]
    errors: Floats  # what each of E independent causes adds at one deviation (E, n) [m/s^2]
    arm: Floats  # torque over thrust, of all rotors together [m]
    hover_arm: float  # and at rest [m]
    hover_speed: float  # mean speed of the rotors at rest [rad/s]
    lost: tuple[tuple[float, str], ...]  # speeds [m/s] that are not flown, and why not


def inplane_forces(aircraft: Aircraft, axis: str, speeds: Floats) -> InplaneForces:
    """Trim an aircraft in level flight along a body axis at ``speeds`` (n,) above 0 [m/s].

    Along y it flies to the left; a symmetric one flies to the right the same way.  Raise
    ``InputError`` where it cannot hover, where its thrust is not along z at rest, and where fewer
    than two of the speeds are flown.
    """
    turned = aircraft if axis == "x" else _turned(aircraft)
    states = turned.steady(np.concatenate([[0.0], speeds]), margin=False)
    if not states.found[0]:
        raise InputError(
            f"the vehicle does not hover: {STATUSES[str(states.status[0])]}",
            "check mass, propeller and motor, or the table",
        )
    vehicle, moment = turned.vehicle, states.moment[0]
    if np.abs(moment).max() > 1e-3 * vehicle.mass * GRAVITY * vehicle.propeller.radius:
        left = ", ".join(f"{m:.2g}" for m in moment)
        raise InputError(
            f"the rotors cannot hover without a moment (about x, y, z: {left} N m)",
            "check position and spin of each rotor",
        )
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
    """Turn an aircraft so that its left is where the nose was."""
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
    largest, charge = aircraft.maximum_rotor_speed, aircraft.charge
    return Aircraft(other, aircraft.loads, maximum_rotor_speed=largest, charge=charge)


def _errors(aircraft: Aircraft, velocity: Floats, omega: Floats) -> Floats:
    """Find the errors (E, n) of the specific force against the motion along x.

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
    for k, mount in enumerate(vehicle.mounts, start=1):
        if mount.axis[2] < 0.5:
            raise InputError(
                f"rotor {k}: its axis {list(mount.axis)} is not upward",
                "the drag models of autopilots take all thrust to be along z",
            )
        for j, other in enumerate(vehicle.mounts[: k - 1], start=1):
            arm = np.subtract(mount.position, other.position)
            beside = float(np.hypot(arm[0], arm[1]))
            if beside < vehicle.propeller.radius:
                raise InputError(
                    f"rotors {j} and {k} are above each other ({beside:g} m apart), and the models "
                    "of autopilots know no wakes of rotors on each other",
                    "describe each pair as one rotor with a table of its own",
                )
    if vehicle.wakes is not None:
        raise InputError(
            "[wakes] is given, and the models of autopilots know no wakes of rotors on each other",
            "leave them out with --no-wakes, or remove [wakes]",
        )


# -------------------------------------------------------------------------------------------------
# Rotor drag by speed and body drag by its square: what the Kalman filters of autopilots know.
#
# The specific force along a body axis is taken to be m v + 1/2 rho b q, with v the component of the
# velocity along the axis, q a square of the velocity, m the same for both axes, and 1/b the
# ballistic coefficient of the axis.

CLOSE = 0.1  # share of the force up to which the simplification is said to hold


def fit_drag(
    flights: tuple[InplaneForces, InplaneForces],
    square: Callable[[InplaneForces], Floats],
    density: float,
    least: float,
) -> tuple[Floats, Floats]:
    """Fit m [1/s], b along x and b along y [m^2/kg] to all flights, none below zero.

    The ``square`` of n flights is q [m^2/s^2]; below ``least`` the filter has no b, and it is 0.
    Return the constants (3,) and what each of E independent causes adds to them (E, 3).
    """
    from scipy.optimize import nnls

    rows = []
    for k, flight in enumerate(flights):
        block = np.zeros((flight.speed.size, 3))
        block[:, 0], block[:, 1 + k] = flight.along, 0.5 * density * square(flight)
        rows.append(block)
    matrix = np.concatenate(rows)
    force = np.concatenate([flight.force for flight in flights])
    changes = np.concatenate([flight.errors for flight in flights], axis=1)
    kept = np.ones(3, dtype=bool)
    while True:
        found = np.zeros(3)
        found[kept] = nnls(matrix[:, kept], force)[0]
        small = kept & (found <= np.array([0.0, least, least]))
        if not small.any():
            break
        kept &= ~small
    errors = np.zeros((changes.shape[0], 3))
    errors[:, kept] = changes @ np.linalg.pinv(matrix[:, kept]).T
    return found, errors


@dataclass(frozen=True, eq=False)
class DragComparison:
    """The force along an axis in n flights, by the full model and by the filter's equation."""

    flight: InplaneForces
    full: Floats  # by the model (n,) [N]
    filtered: Floats  # by the filter with the constants as they are written (n,) [N]
    std: Floats  # standard deviation of the first (n,) [N]; NaN where it is not known
    wind: Floats  # the error of the wind that the filter makes of the difference (n,) [m/s]

    @property
    def share(self) -> Floats:
        """Difference over the full model's force (n,)."""
        return np.asarray((self.filtered - self.full) / self.full)

    @property
    def holds(self) -> tuple[float, float] | None:
        """The longest run of speeds [m/s] with differences up to ``CLOSE``; None without one."""
        best: tuple[float, float] | None = None
        first = None
        for speed, share in zip(self.flight.speed.tolist(), self.share.tolist(), strict=True):
            if abs(share) > CLOSE:
                first = None
                continue
            first = speed if first is None else first
            if best is None or speed - first > best[1] - best[0]:
                best = (first, speed)
        return best


# -------------------------------------------------------------------------------------------------
# Loads of a rotor with their independent errors, for what is computed from several of them.

USED = ("thrust", "drag", "torque")  # loads that are looked at, in this order
FASTER = 0.02
"""Share by which a rotor speed is changed up and down in a difference quotient: large beside what
loads jump by where their nodes change with the speed."""


class UncertainLoads(NamedTuple):
    """Loads at N operating points, in the order of ``USED`` [N], [N], [N m]."""

    loads: Floats  # of a rotor (3, N)
    by_speed: Floats  # their derivatives by the logarithm of the rotor speed (3, N)
    errors: Floats  # what each of E independent causes adds at one deviation (E, 3, N)


def rotor_sources(
    vehicle: Vehicle, loads: Rotor | LoadTable
) -> list[tuple[Rotor | LoadTable, NDArray[np.intp]]]:
    """List what gives loads, and of which rotors of a ``vehicle`` whose ``loads`` are these."""
    if not isinstance(loads, Rotor):
        return [(loads, np.arange(len(vehicle.mounts)))]
    return [(loads.with_model(own), k) for own, k in mounted_rotors(vehicle, loads.model)]


def load_errors(source: Rotor | LoadTable, omega: Floats, velocity: Floats) -> UncertainLoads:
    """Return loads with their independent errors at omega (N,) [rad/s] and velocity (N, 3) [m/s].

    The velocity is in the rotor frame, z along the thrust.  It is not known which errors of a
    table its loads have in common: each load has its own.
    """
    # Points that differ: half the rotors see what the others see.
    once, where = np.unique(
        np.column_stack([omega, velocity]).round(9), axis=0, return_inverse=True
    )
    omega, velocity, where = once[:, 0], once[:, 1:], where.ravel()
    here, slower, faster = (
        _stacked(source.loads_at_velocity(omega * factor, velocity))
        for factor in (1.0, 1.0 - FASTER, 1.0 + FASTER)
    )
    by_speed = (faster - slower) / (2.0 * FASTER)
    errors = (_rotor_errors if isinstance(source, Rotor) else _table_errors)(
        source,  # type: ignore[arg-type]
        omega,
        velocity,
    )
    return UncertainLoads(here[:, where], by_speed[:, where], errors[..., where])


def _rotor_errors(rotor: Rotor, omega: Floats, velocity: Floats) -> Floats:
    """Find the errors (E, 3, N) by the constants, along the principal axes of their covariance, and
    by each further source that the model states."""
    known = rotor.model.uncertainty
    if known is None:
        return np.zeros((0, len(USED), omega.size))
    by_source = rotor.loads_at_velocity(omega, velocity).std_by_source
    others = [
        _one_cause_each(_stacked(by_source[name]))
        for name in ("discrepancy", "tunnel")
        if name in by_source
    ]
    determined = known.covariance.determined
    by_constants = np.zeros((0, len(USED), omega.size))
    if determined.names:
        at, _ = split_velocity(omega, velocity)
        slopes = rotor.gradients_at(determined.names, at).slopes
        size, axes = np.linalg.eigh(determined.matrix)
        root = axes * np.sqrt(np.maximum(size, 0.0))
        rows = [list(LOADS).index(name) for name in USED]
        by_constants = np.einsum("lpn,pq->qln", slopes[rows], root)
    return np.concatenate([by_constants, *others])


def _table_errors(table: LoadTable, omega: Floats, velocity: Floats) -> Floats:
    """Find the errors (3, 3, N) by a table's standard deviations; (0, 3, N) where it has none."""
    speed = np.linalg.norm(velocity, axis=-1)
    beta = np.arctan2(np.hypot(velocity[:, 0], velocity[:, 1]), velocity[:, 2])
    try:
        return _one_cause_each(_stacked(table.std(omega, speed, beta)))
    except InputError:
        return np.zeros((0, len(USED), omega.size))


def _stacked(loads: object) -> Floats:
    return np.stack([np.asarray(getattr(loads, name)) for name in USED])


def _one_cause_each(deviations: Floats) -> Floats:
    """Turn deviations (3, N) into those of one cause for each load (3, 3, N)."""
    return np.eye(len(USED))[:, :, None] * deviations
