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
from propmap.model.airfoil import SectionCovariance
from propmap.model.corrections import MOUNT_DRAG
from propmap.operating_points import FlowPoints, split_velocity
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.vehicle.log import GRAVITY, in_vehicle_frame
from propmap.vehicle.rotors import mounted_rotors
from propmap.vehicle.vehicle import Body, Vector, Vehicle

if TYPE_CHECKING:
    from propmap.table.query import LoadTable


# -------------------------------------------------------------------------------------------------
# The specific force along a body axis in level flight along it: what drag models are fitted to.

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
            "check mass, propeller and motor, or the table",
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
    """This aircraft with its left where the nose was."""
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
                    "describe each pair as one rotor with a table of its own",
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


# -------------------------------------------------------------------------------------------------
# Rotor drag by speed and body drag by its square: what the Kalman filters of autopilots know.
#
# The specific force along a body axis is taken to be m v + 1/2 rho b q, with v the component of the
# velocity along the axis, q a square of the velocity, m the same for both axes, and 1/b the
# ballistic coefficient of the axis.

CLOSE = 0.1
"""Share of the force up to which the simplification is said to hold."""


@dataclass(frozen=True, eq=False)
class DragFit:
    """The constants with their errors, and what they leave.

    Attributes
    ----------
    momentum : float
        m, in the air of the vehicle [1/s].
    inverse : tuple of 2 float
        b along x and y [m^2/kg]; 0 where there is too little for the filter.
    errors : ndarray, shape (E, 3)
        What each of E independent causes, at one standard deviation, adds to m and to b.
    """

    momentum: float
    inverse: tuple[float, float]
    errors: Floats

    @property
    def std(self) -> tuple[float, float, float] | None:
        """Standard deviations of m and b; None where nothing is known of the errors."""
        if not self.errors.size:
            return None
        m, x, y = np.sqrt(np.sum(self.errors**2, axis=0)).tolist()
        return m, x, y


def fit_drag(
    flights: tuple[InplaneForces, InplaneForces],
    square: Callable[[InplaneForces], Floats],
    density: float,
    least: float,
) -> DragFit:
    """Least squares over all flights, none of the constants below zero.

    Parameters
    ----------
    flights : tuple of 2 InplaneForces
        Along x and y.
    square : callable
        Gives q of n flights [m^2/s^2].
    density : float
        Of the air [kg/m^3].
    least : float
        b below which the filter has none [m^2/kg].
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
    momentum, *inverse = found.tolist()
    return DragFit(momentum, (inverse[0], inverse[1]), _constants_errors(matrix, kept, changes))


def _constants_errors(matrix: Floats, kept: NDArray[np.bool_], changes: Floats) -> Floats:
    """What changes (E, n) of the forces change in the constants (E, 3)."""
    found = np.zeros((changes.shape[0], 3))
    found[:, kept] = changes @ np.linalg.pinv(matrix[:, kept]).T
    return found


@dataclass(frozen=True, eq=False)
class Comparison:
    """The force along an axis by the full model and by the filter's equation.

    Attributes
    ----------
    flight : InplaneForces
        n flights.
    full, filtered, std : ndarray, shape (n,)
        By the model, by the filter with the constants as they are written, and the standard
        deviation of the first [N]; NaN where it is not known.
    wind : ndarray, shape (n,)
        The error of the wind that the filter makes of the difference [m/s].
    """

    flight: InplaneForces
    full: Floats
    filtered: Floats
    std: Floats
    wind: Floats

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


def compare(flight: InplaneForces, mass: float, predicted: Floats, slope: Floats) -> Comparison:
    """A flight beside what a filter makes of it.

    Parameters
    ----------
    flight : InplaneForces
        n flights.
    mass : float
        Of the vehicle [kg].
    predicted, slope : ndarray, shape (n,)
        Specific force of the filter against the motion [m/s^2], and its derivative by the
        component of the velocity along the axis [1/s].
    """
    spread = np.sqrt(np.sum(flight.errors**2, axis=0))
    known = flight.errors.size > 0
    return Comparison(
        flight=flight,
        full=mass * flight.force,
        filtered=mass * predicted,
        std=mass * spread if known else np.full_like(spread, np.nan),
        wind=(predicted - flight.force) / slope,
    )


# -------------------------------------------------------------------------------------------------
# Loads of a rotor with their independent errors, for what is computed from several of them.

USED = ("thrust", "drag", "torque")
"""Loads that are looked at, in this order."""

FASTER = 0.02
"""Share by which a rotor speed is changed up and down in a difference quotient: large beside what
loads jump by where their nodes change with the speed."""


class LoadErrors(NamedTuple):
    """Loads at N operating points, in the order of ``USED`` [N], [N], [N m].

    Attributes
    ----------
    loads : ndarray, shape (3, N)
        Of a rotor.
    by_speed : ndarray, shape (3, N)
        Their derivatives by the logarithm of the rotor speed.
    errors : ndarray, shape (E, 3, N)
        What each of E independent causes, at one standard deviation, adds to them; no causes
        where nothing is known of the errors.
    """

    loads: Floats
    by_speed: Floats
    errors: Floats


def rotor_sources(
    vehicle: Vehicle, loads: Rotor | LoadTable
) -> list[tuple[Rotor | LoadTable, NDArray[np.intp]]]:
    """What gives the loads of which rotors of a ``vehicle``, whose ``loads`` are these."""
    if not isinstance(loads, Rotor):
        return [(loads, np.arange(len(vehicle.mounts)))]
    return [(loads.with_model(own), k) for own, k in mounted_rotors(vehicle, loads.model)]


def load_errors(source: Rotor | LoadTable, omega: Floats, velocity: Floats) -> LoadErrors:
    """Loads at N operating points with their independent errors.

    Parameters
    ----------
    source : Rotor or LoadTable
        Of the loads.  Of a table's errors it is not known which loads they have in common: each
        load has its own.
    omega : ndarray, shape (N,)
        [rad/s].
    velocity : ndarray, shape (N, 3)
        In the rotor frame, z along the thrust [m/s].
    """
    once, where = np.unique(
        np.column_stack([omega, velocity]).round(9), axis=0, return_inverse=True
    )
    found = _once(source, once[:, 0], once[:, 1:])
    return LoadErrors(*(array[..., where.ravel()] for array in found))


def _once(source: Rotor | LoadTable, omega: Floats, velocity: Floats) -> LoadErrors:
    """``load_errors`` at points that differ: half the rotors see what the others see."""
    here, slower, faster = (
        _stacked(source.loads_at_velocity(omega * factor, velocity))
        for factor in (1.0, 1.0 - FASTER, 1.0 + FASTER)
    )
    by_speed = (faster - slower) / (2.0 * FASTER)
    found = (
        _of_rotor(source, omega, velocity)
        if isinstance(source, Rotor)
        else _of_table(source, omega, velocity)
    )
    return LoadErrors(here, by_speed, found)


def _of_rotor(rotor: Rotor, omega: Floats, velocity: Floats) -> Floats:
    known = rotor.model.uncertainty
    if known is None:
        return np.zeros((0, len(USED), omega.size))
    at, _ = split_velocity(omega, velocity)
    parts = rotor.loads_at_velocity(omega, velocity).std_by_source
    each = [_apart(_stacked(parts[name])) for name in ("discrepancy", "tunnel") if name in parts]
    return np.concatenate([_of_constants(rotor, known.covariance, at), *each])


def _of_constants(rotor: Rotor, covariance: SectionCovariance, at: FlowPoints) -> Floats:
    """Along the principal axes of the covariance of the constants (P, 3, N)."""
    determined = covariance.determined
    names = determined.names
    if not names:
        return np.zeros((0, len(USED), at.omega.size))
    slopes = rotor.gradients_at(names, at).slopes
    size, axes = np.linalg.eigh(determined.matrix)
    root = axes * np.sqrt(np.maximum(size, 0.0))
    rows = [list(LOADS).index(name) for name in USED]
    return np.einsum("lpn,pq->qln", slopes[rows], root)


def _of_table(table: LoadTable, omega: Floats, velocity: Floats) -> Floats:
    speed = np.linalg.norm(velocity, axis=-1)
    beta = np.arctan2(np.hypot(velocity[:, 0], velocity[:, 1]), velocity[:, 2])
    try:
        return _apart(_stacked(table.std(omega, speed, beta)))
    except InputError:
        return np.zeros((0, len(USED), omega.size))


def _stacked(loads: object) -> Floats:
    return np.stack([np.asarray(getattr(loads, name)) for name in USED])


def _apart(deviations: Floats) -> Floats:
    """Deviations (3, N) as those of one cause for each load (3, 3, N)."""
    return np.eye(len(USED))[:, :, None] * deviations
