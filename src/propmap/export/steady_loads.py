"""Loads of a vehicle in level flight and at rest, and the constants that autopilots fit to them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propmap.aircraft.trim import STATUSES, Aircraft, SteadyStates
from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.operating_points import split_velocity
from propmap.rotor import Rotor
from propmap.table.query import LoadTable
from propmap.typing import Floats
from propmap.units import GRAVITY, RPM
from propmap.vehicle.log import in_vehicle_frame
from propmap.vehicle.powertrain import Motor
from propmap.vehicle.vehicle import Body, Vector, Vehicle
from propmap.vehicle.vehicle_forces import mounted_rotors

# -------------------------------------------------------------------------------------------------
# Specific force along a body axis in level flight along this axis, to which drag models are fitted.

AXES = {"x": "forward", "y": "sideways"}  # body axes, and the direction of flight along them
AT_REST = 0.1  # maximum specific force along x or y at rest [m/s^2], the drag in 0.5 m/s of wind


@dataclass(frozen=True, eq=False)
class InplaneForces:
    """Level flights along a body axis at n speeds; arrays (n,)."""

    axis: str  # of ``AXES``
    speed: Floats  # airspeed [m/s]
    pitch: Floats  # lean angle into the flight direction [rad]
    along: Floats  # component of the velocity along the axis [m/s]
    through: Floats  # magnitude of the velocity [m/s]
    force: Floats  # specific force against the motion, as an accelerometer reads it [m/s^2]
    errors: Floats  # changes by one standard deviation of E independent causes (E, n) [m/s^2]
    arm: Floats  # total torque over total thrust of the rotors [m]
    hover_arm: float  # torque over thrust at rest [m]
    hover_speed: float  # mean rotor speed at rest [rad/s]
    lost: tuple[tuple[float, str], ...]  # speeds [m/s] that cannot be flown, and the status


def inplane_forces(aircraft: Aircraft, axis: str, speeds: Floats) -> InplaneForces:
    """Trim an aircraft in level flight forward or to the left at ``speeds`` (n,) above 0 [m/s].

    Raises ``InputError`` if the aircraft cannot hover with thrust along z or fly two of them.
    """
    turned = aircraft if axis == "x" else _turned(aircraft)
    states = turned.steady(np.concatenate([[0.0], speeds]), margin=False)
    check_hover(turned, states)
    size = len(states)
    up = in_vehicle_frame(np.zeros(size), np.zeros(size), np.ones(size), states.pitch, states.roll)
    specific = -GRAVITY * up[:, 0]
    if abs(specific[0]) > AT_REST:
        raise InputError(
            f"at rest the accelerometer reads {specific[0]:.2f} m/s^2 along {axis}: the rotors' "
            f"thrust has a component along {axis}, but drag models of autopilots assume none",
            "check axis of the rotors",
        )
    flown = np.flatnonzero(states.found[1:]) + 1
    lost = [k for k in range(1, size) if k not in flown]
    if flown.size < 2:
        raise InputError(
            f"the vehicle can fly {flown.size} of the speeds ({speeds[lost[0] - 1]:g} m/s: "
            f"{STATUSES[str(states.status[lost[0]])]})",
            "give two or more possible speeds with --speed",
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


def check_hover(aircraft: Aircraft, states: SteadyStates) -> None:
    """Raise ``InputError`` unless the first of the ``states``, at rest, is a hover in which the
    rotors balance all moments."""
    vehicle, left = aircraft.vehicle, ""
    if states.found[0]:
        moment = states.moment[0]
        if np.abs(moment).max() <= 1e-3 * vehicle.mass * GRAVITY * vehicle.propeller.radius:
            return
        left = f" (about x, y, z: {', '.join(f'{m:.2g}' for m in moment)} N m)"
    elif _balances(aircraft):
        found = f"the vehicle does not hover: {STATUSES[str(states.status[0])]}"
        remedy = "or the table, which must include zero airspeed at the rotor speeds of hover"
        raise InputError(found, f"check mass, propeller and motor, {remedy}")
    found = f"the rotors cannot hover without a moment{left}"
    raise InputError(found, "check position and spin of each rotor")


def _balances(aircraft: Aircraft) -> bool:
    """Return whether positive thrusts could balance an aircraft without a moment.

    Each thrust is at least a tenth of the mean thrust; the maximum thrust of the rotors is ignored.
    """
    from scipy.optimize import nnls

    thrust_and_moments = aircraft.balance.allocation.matrix[:4]
    size = np.abs(thrust_and_moments).max(axis=1, keepdims=True)
    effect = thrust_and_moments / np.maximum(size, 0.01)
    least = np.full(effect.shape[1], 0.1 / effect.shape[1])
    return bool(nnls(effect, np.array([1.0, 0.0, 0.0, 0.0]) - effect @ least)[1] < 0.01)


def _turned(aircraft: Aircraft) -> Aircraft:
    """Turn an aircraft about z so that its left side points along x."""
    vehicle = aircraft.vehicle
    x, y, z = vehicle.body.drag_area
    down, plate = vehicle.body.download_area[::-1], vehicle.body.plate_area
    body = Body((y, x, z), download_area=down, plate_area=plate)

    def turn(vector: Vector) -> Vector:
        return (vector[1], -vector[0], vector[2])

    places = ((mount, turn(mount.position), turn(mount.axis)) for mount in vehicle.mounts)
    mounts = tuple(replace(mount, position=at, axis=axis) for mount, at, axis in places)
    # The body's lift acts in flight in the plane of symmetry, not in sideways flight.
    other = replace(vehicle, mounts=mounts, body=body, sensor=turn(vehicle.sensor))
    largest, charge = aircraft.maximum_rotor_speed, aircraft.charge
    return Aircraft(other, aircraft.loads, maximum_rotor_speed=largest, charge=charge)


def _errors(aircraft: Aircraft, velocity: Floats, omega: Floats) -> Floats:
    """Return the errors (E, n) of the specific force against the motion along x.

    For each error, all rotor speeds change at constant attitude and flow to keep the lift.
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
        # Directions of thrust and drag of each rotor, of which x and z are used.
        way = np.stack([np.broadcast_to(axis, aside.shape), -aside / across[..., None]])
        forward.append(np.einsum("elnk,lnk->en", both, way[..., 0]))
        upward.append(np.einsum("elnk,lnk->en", both, way[..., 2]))
        turning.append(np.einsum("lnk,lnkj->jn", pair, way[..., [0, 2]]))
    push, lift = np.sum(forward, axis=0), np.sum(upward, axis=0)
    faster = np.sum(turning, axis=0)
    return -(push - lift * faster[0] / faster[1]) / vehicle.mass


def check_vehicle(vehicle: Vehicle) -> None:
    """Raise ``InputError`` for a ``vehicle`` to which the drag models do not apply."""
    count = len(vehicle.mounts)
    if count < 3:
        found = f"the vehicle has {count} rotor{'s' if count > 1 else ''}"
        raise InputError(found, "these parameters need a multirotor with 3 rotors or more")
    if vehicle.wing is not None:
        raise InputError(
            "the vehicle has a wing, and the drag model of a multirotor has no wing lift",
            "remove [wing], or tune these parameters in flight as the autopilot's guide describes",
        )
    for k, mount in enumerate(vehicle.mounts, start=1):
        if mount.axis[2] < 0.5:
            found = f"rotor {k}: its axis {list(mount.axis)} is not upward"
            raise InputError(found, "the drag models of autopilots assume all thrust along z")
        for j, other in enumerate(vehicle.mounts[: k - 1], start=1):
            arm = np.subtract(mount.position, other.position)
            beside = float(np.hypot(arm[0], arm[1]))
            if beside < vehicle.propeller.radius:
                raise InputError(
                    f"rotors {j} and {k} are above each other ({beside:g} m apart), but the models "
                    "of autopilots have no wakes of rotors on each other",
                    "describe each pair as one rotor, with its own table",
                )
    if vehicle.wakes is not None:
        raise InputError(
            "[wakes] is given, but the models of autopilots have no wakes of rotors on each other",
            "pass --no-wakes, or remove [wakes]",
        )


# -------------------------------------------------------------------------------------------------
# The drag model of autopilot Kalman filters: linear rotor drag and quadratic body drag.
#
# The specific force along a body axis is m v + 1/2 rho b q, where v is the component of the
# velocity along the axis, and q is a square of the velocity.  Both axes have the same m; 1/b is the
# ballistic coefficient of the axis.

CLOSE = 0.1  # maximum relative error of the force at which the model counts as valid


def fit_drag(
    flights: tuple[InplaneForces, InplaneForces],
    square: Callable[[InplaneForces], Floats],
    density: float,
    least: float,
) -> tuple[Floats, Floats]:
    """Fit m [1/s], b along x and b along y [m^2/kg] to all flights, with their errors (E, 3).

    ``square`` returns q [m^2/s^2] of a flight.  No constant is negative; b below ``least`` is 0.
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
    """Force along an axis in n level flights, by the full model and by the filter's equation."""

    flight: InplaneForces
    full: Floats  # by the full model (n,) [N]
    filtered: Floats  # by the filter with the written, rounded constants (n,) [N]
    std: Floats  # standard deviation of ``full`` (n,) [N]; NaN where it is not known
    wind: Floats  # resulting error of the filter's wind estimate (n,) [m/s]

    @property
    def share(self) -> Floats:
        """Return the filter's error relative to the force of the full model (n,)."""
        return np.asarray((self.filtered - self.full) / self.full)

    @property
    def holds(self) -> tuple[float, float] | None:
        """Return the longest range of speeds [m/s] with errors up to ``CLOSE``, or None."""
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
# Loads of a rotor with their independent errors, so that errors of derived values can be computed.

USED = ("thrust", "drag", "torque")  # loads used here, in this order
FASTER = 0.02  # relative step of rotor speed in difference quotients, to bridge load jumps


class UncertainLoads(NamedTuple):
    """Loads at N operating points, in the order of ``USED`` [N], [N], [N m]."""

    loads: Floats  # of a rotor (3, N)
    by_speed: Floats  # derivatives with respect to the logarithm of the rotor speed (3, N)
    errors: Floats  # changes by one standard deviation of E independent causes (E, 3, N)


def rotor_sources(
    vehicle: Vehicle, loads: Rotor | LoadTable
) -> list[tuple[Rotor | LoadTable, NDArray[np.intp]]]:
    """List the sources of a vehicle's ``loads``, by mount, with the indices of the rotors."""
    if not isinstance(loads, Rotor):
        return [(loads, np.arange(len(vehicle.mounts)))]
    return [(loads.with_model(own), k) for own, k in mounted_rotors(vehicle, loads.model)]


def load_errors(source: Rotor | LoadTable, omega: Floats, velocity: Floats) -> UncertainLoads:
    """Return loads with their independent errors at omega (N,) [rad/s] and velocity (N, 3) [m/s]
    in the rotor frame; the errors of a table's loads are independent of each other."""
    # Compute equal points once: in symmetric flight half the rotors have the flow of another rotor.
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
    """Return errors (E, 3, N) by principal axis of the constants' covariance and by source."""
    known = rotor.model.uncertainty
    if known is None:
        return np.zeros((0, len(USED), omega.size))
    by_source = rotor.loads_at_velocity(omega, velocity).std_by_source
    given = [by_source[name] for name in ("discrepancy", "tunnel") if name in by_source]
    others = [_one_cause_each(_stacked(one)) for one in given]
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
    """Return errors (3, 3, N) from a table's standard deviations; (0, 3, N) without any."""
    speed = np.linalg.norm(velocity, axis=-1)
    beta = np.arctan2(np.hypot(velocity[:, 0], velocity[:, 1]), velocity[:, 2])
    try:
        return _one_cause_each(_stacked(table.std(omega, speed, beta)))
    except InputError:
        return np.zeros((0, len(USED), omega.size))


def _stacked(loads: object) -> Floats:
    return np.stack([np.asarray(getattr(loads, name)) for name in USED])


def _one_cause_each(deviations: Floats) -> Floats:
    """Expand standard deviations (3, N) to errors (3, 3, N) with one cause per load."""
    return np.eye(len(USED))[:, :, None] * deviations


# --- A vehicle's rotors at rest, with the errors of their loads ----------------------------------


@dataclass(frozen=True, eq=False)
class StaticLoads:
    """Thrust and torque at rest, averaged over the rotors."""

    thrust: float  # [N]
    torque: float  # [N m]
    errors: Floats  # changes of both by one standard deviation of E independent causes (E, 2)

    def std_of(self, by_thrust: float, by_torque: float) -> float | None:
        """Return the standard deviation of a value with these derivatives, or None if unknown."""
        if not self.errors.size:
            return None
        return float(np.linalg.norm(self.errors @ [by_thrust, by_torque]))


def static_loads(aircraft: Aircraft, omega: float) -> StaticLoads:
    """Average the loads at rest of an ``aircraft``'s rotors at ``omega`` [rad/s]."""
    count, parts = len(aircraft.vehicle.mounts), []
    for source, mine in rotor_sources(aircraft.vehicle, aircraft.loads):
        found = load_errors(source, np.array([omega]), np.zeros((1, 3)))
        share = mine.size / count
        parts.append((share * found.loads[[0, 2], 0], share * found.errors[:, [0, 2], 0]))
    loads, errors = (np.sum(each, axis=0) for each in zip(*parts, strict=True))
    return StaticLoads(float(loads[0]), float(loads[1]), errors)


# -------------------------------------------------------------------------------------------------
# Static thrust as a function of the speed controller's signal, from motor, controller and battery.
#
# The signal is the fraction of the battery voltage that the controller passes on, as in
# ``propmap.vehicle.powertrain``.  It is equal for all rotors, and the battery voltage sags under
# the current of all of them.

KNOTS = 12  # rotor speeds at which loads at rest are computed; over omega^2 they vary slowly
SPEEDS = 2000  # rotor speeds at which the signal is computed


@dataclass(frozen=True, eq=False)
class SignalCurve:
    """Thrust of a rotor at rest as a function of the signal from 0 to 1."""

    signal: Floats  # rising (n,)
    thrust: Floats  # mean over the rotors (n,) [N]
    full_thrust: float  # [N]; the ``full`` values are at the signal 1
    full_torque: float  # [N m]
    full_speed: float  # [rad/s]
    full_current: float  # per motor [A]

    def at(self, signal: Floats) -> Floats:
        """Return the thrust [N] at a ``signal``."""
        return np.asarray(np.interp(signal, self.signal, self.thrust))

    def full_signal(self, motor: Motor | None) -> str:
        """Describe the full signal in a sentence, with a warning above a limit of the ``motor``."""
        rpm = self.full_speed / RPM
        words = f"At rest, full signal: {rpm:.0f} rpm, {self.full_current:.3g} A per motor."
        if motor is not None and self.full_current > motor.maximum_current:
            words += f" The motor's maximum is {motor.maximum_current:g} A."
        if motor is not None and self.full_speed > motor.maximum_speed:
            words += f" The motor's maximum is {motor.maximum_speed / RPM:.0f} rpm."
        return words


def known_curve(aircraft: Aircraft) -> tuple[SignalCurve | None, str]:
    """Return the thrust curve of an ``aircraft`` at its state of charge, or why there is none."""
    powertrain = aircraft.vehicle.powertrain
    parts = {"[motor]": powertrain.motor, "[battery]": powertrain.battery}
    missing = [name for name, part in parts.items() if part is None]
    if missing:
        return None, f"the vehicle file has no {' and no '.join(missing)}"
    curve = thrust_curve(aircraft, aircraft.charge)
    if curve is None:
        return None, "the battery cannot deliver the power of full throttle"
    if not isinstance(aircraft.loads, Rotor):
        fastest = aircraft.loads.envelope["omega"][1]
        if curve.full_speed > fastest:
            return None, (
                f"the table ends at {fastest / RPM:.0f} rpm, and full throttle is "
                f"{curve.full_speed / RPM:.0f}"
            )
    return curve, ""


def thrust_curve(aircraft: Aircraft, charge: float, more_torque: float = 0.0) -> SignalCurve | None:
    """Compute the thrust curve of a vehicle with motor and battery at a ``charge`` from 0 to 1.

    ``more_torque`` is a relative increase of the model's torque.  Return None if the battery cannot
    deliver the full signal.
    """
    powertrain, count = aircraft.vehicle.powertrain, len(aircraft.vehicle.mounts)
    motor, battery = powertrain.motor, powertrain.battery
    assert motor is not None and battery is not None
    unloaded = motor.speed_constant * float(battery.open_circuit_voltage(np.array(charge)))
    knots, thrust, torque = _over_square(aircraft, unloaded)
    omega = np.linspace(0.0, unloaded, SPEEDS)
    lift = np.interp(omega, knots, thrust) * omega**2
    turn = np.interp(omega, knots, torque) * omega**2 * (1.0 + more_torque)
    each = np.repeat(turn[:, None], count, axis=1), np.repeat(omega[:, None], count, axis=1)
    state = powertrain.driven(*each, charge)
    signal = state.controller_voltage[:, 0] / state.battery_voltage
    beyond = np.flatnonzero(~(signal < 1.0))
    if not beyond.size or np.isnan(signal[beyond[0]]):
        return None
    upto = slice(0, int(beyond[0]) + 1)
    full = (
        float(np.interp(1.0, signal[upto], values[upto]))
        for values in (lift, turn, omega, state.motor_current[:, 0])
    )
    # There is no thrust below the signal that overcomes the motor's friction.
    rising, lifting = (np.concatenate([[0.0], values[upto]]) for values in (signal, lift))
    return SignalCurve(rising, lifting, *full)


def _over_square(aircraft: Aircraft, fastest: float) -> tuple[Floats, Floats, Floats]:
    """Return rotor speeds, and mean thrust and torque at rest over the square of rotor speed."""
    omega = np.linspace(0.1, 1.0, KNOTS) * fastest
    if not isinstance(aircraft.loads, Rotor):
        low, high = aircraft.loads.envelope["omega"]
        omega = np.linspace(low, min(high, fastest), KNOTS)
    thrust, torque = mean_loads(aircraft, omega, 0.0) / omega**2
    return omega, thrust, torque


def mean_loads(aircraft: Aircraft, omega: Floats, speed: ArrayLike) -> Floats:
    """Average thrust [N] and torque [N m] of an ``aircraft``'s rotors (2, ...) in axial flow."""
    total, count = np.zeros(()), len(aircraft.vehicle.mounts)
    for source, mine in rotor_sources(aircraft.vehicle, aircraft.loads):
        found = source.loads(omega, speed, 0.0)
        total = total + mine.size / count * np.stack([found.thrust, found.torque])
    return total


# --- The factor with which an autopilot describes a thrust curve, and its standard deviation -----

DISCHARGED = 0.3  # second state of charge for which the factor is stated

Shares = Callable[[Callable[[Floats], Floats]], Floats]
"""Function of a thrust curve that returns thrust over maximum thrust at equally spaced x (n,)."""


@dataclass(frozen=True)
class CurveFactor:
    """Factor f of a thrust curve: thrust over maximum thrust = f x^2 + (1 - f) x, x from 0 to 1."""

    factor: float  # f [-]
    worst: float  # maximum error of the equation, over the maximum thrust [-]
    std: float | None  # standard deviation of f from that of the torque [-]; None if unknown
    charge: float  # state of charge of the battery
    discharged: float  # f at the charge ``DISCHARGED``; NaN if full throttle is not reached

    @property
    def holds(self) -> str:
        """Describe the range and the error in a sentence."""
        here = f"At rest, battery at {self.charge:.0%}: error {self.worst:.1%} of maximum thrust"
        if np.isfinite(self.discharged):
            return f"{here}. At {DISCHARGED:.0%} charge the value is {self.discharged:.3f}."
        return f"{here}. At {DISCHARGED:.0%} charge the battery cannot deliver full throttle."


def curve_factor(
    aircraft: Aircraft,
    curve: SignalCurve,
    still: StaticLoads,
    shares: Shares,
    limits: tuple[float, float],
) -> CurveFactor:
    """Fit f, within ``limits``, to the ``curve`` of an aircraft with the loads at rest ``still``.

    ``shares`` samples a curve at the autopilot's x.
    """
    charge = aircraft.charge

    def factor(found: SignalCurve | None) -> float:
        return float("nan") if found is None else fitted_factor(shares(found.at), limits)

    here, share = factor(curve), shares(curve.at)
    spread = still.std_of(0.0, 1.0 / still.torque)
    more = None if spread is None else factor(thrust_curve(aircraft, charge, spread))
    x = np.linspace(0.0, 1.0, share.size)
    worst = float(np.abs(x + here * (x**2 - x) - share).max())
    std = None if more is None else abs(more - here)
    return CurveFactor(here, worst, std, charge, factor(thrust_curve(aircraft, DISCHARGED)))


def fitted_factor(share: Floats, limits: tuple[float, float]) -> float:
    """Fit f, within ``limits``, to thrust over maximum thrust, ``share`` (n,)."""
    x = np.linspace(0.0, 1.0, share.size)
    bent = x**2 - x
    return float(np.clip(np.sum((share - x) * bent) / np.sum(bent**2), *limits))
