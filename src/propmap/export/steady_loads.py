"""A vehicle's loads in level flight and at rest, and the constants that autopilots make of them."""

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
# The specific force along a body axis in level flight along it: what drag models are fitted to.

AXES = {"x": "forward", "y": "sideways"}  # body axes, and how the vehicle flies along them
AT_REST = 0.1  # specific force along x or y at rest [m/s^2] of thrust along z; 0.5 m/s of wind


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
    """Trim an aircraft in level flight forward or to the left at ``speeds`` (n,) above 0 [m/s];
    ``InputError`` where it cannot hover, with thrust along z, or flies fewer than two."""
    turned = aircraft if axis == "x" else _turned(aircraft)
    states = turned.steady(np.concatenate([[0.0], speeds]), margin=False)
    check_hover(turned, states)
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


def check_hover(aircraft: Aircraft, states: SteadyStates) -> None:
    """Raise ``InputError`` where the first of an aircraft's ``states``, at rest, is no hover in
    which the rotors balance all moments."""
    vehicle, left = aircraft.vehicle, ""
    if states.found[0]:
        moment = states.moment[0]
        if np.abs(moment).max() <= 1e-3 * vehicle.mass * GRAVITY * vehicle.propeller.radius:
            return
        left = f" (about x, y, z: {', '.join(f'{m:.2g}' for m in moment)} N m)"
    elif _balances(aircraft):
        found = f"the vehicle does not hover: {STATUSES[str(states.status[0])]}"
        remedy = "or the table: it needs rest, at the rotor speeds that carry the mass"
        raise InputError(found, f"check mass, propeller and motor, {remedy}")
    found = f"the rotors cannot hover without a moment{left}"
    raise InputError(found, "check position and spin of each rotor")


def _balances(aircraft: Aircraft) -> bool:
    """Return whether thrusts of a tenth of their mean or more, with torques of the usual arm, would
    hold an aircraft without a moment, whatever the rotors can carry."""
    from scipy.optimize import nnls

    rotors = aircraft.rotors
    turning = np.cross(rotors.position, rotors.axis)
    turning = turning - 0.1 * rotors.radius * rotors.spin[:, None] * rotors.axis
    turning /= np.maximum(np.abs(turning).max(axis=0), 0.01 * rotors.radius)
    effect = np.vstack([rotors.axis @ rotors.axis.mean(axis=0), turning.T])
    least = np.full(len(rotors), 0.1 / len(rotors))
    return bool(nnls(effect, np.array([1.0, 0.0, 0.0, 0.0]) - effect @ least)[1] < 0.01)


def _turned(aircraft: Aircraft) -> Aircraft:
    """Turn an aircraft so that its left is where the nose was."""
    vehicle = aircraft.vehicle
    x, y, z = vehicle.body.drag_area
    down, plate = vehicle.body.download_area[::-1], vehicle.body.plate_area
    body = Body((y, x, z), download_area=down, plate_area=plate)

    def turn(vector: Vector) -> Vector:
        return (vector[1], -vector[0], vector[2])

    places = ((mount, turn(mount.position), turn(mount.axis)) for mount in vehicle.mounts)
    mounts = tuple(replace(mount, position=at, axis=axis) for mount, at, axis in places)
    # Lift of the body is that in its plane of symmetry: along the left there is none.
    other = replace(vehicle, mounts=mounts, body=body, sensor=turn(vehicle.sensor))
    largest, charge = aircraft.maximum_rotor_speed, aircraft.charge
    return Aircraft(other, aircraft.loads, maximum_rotor_speed=largest, charge=charge)


def _errors(aircraft: Aircraft, velocity: Floats, omega: Floats) -> Floats:
    """Find the errors (E, n) of the specific force against the motion along x; rotors change speed
    so that they carry as much as before, in the attitude and the flow of before."""
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
        found = f"the vehicle has {count} rotor{'s' if count > 1 else ''}"
        raise InputError(found, "these parameters are those of a multirotor with 3 rotors or more")
    if vehicle.wing is not None:
        raise InputError(
            "the vehicle has a wing, whose lift the drag model of a multirotor does not have",
            "remove [wing], or leave these parameters to the flights of the autopilot's own guide",
        )
    for k, mount in enumerate(vehicle.mounts, start=1):
        if mount.axis[2] < 0.5:
            found = f"rotor {k}: its axis {list(mount.axis)} is not upward"
            raise InputError(found, "the drag models of autopilots take all thrust to be along z")
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
    """Fit m [1/s], b along x and b along y [m^2/kg], none below zero, 0 below ``least``, to all
    flights, whose ``square`` is q [m^2/s^2]; with what each of E causes adds to them (E, 3)."""
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
FASTER = 0.02  # share of rotor speed in difference quotients, large beside jumps of the loads


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
    """Find loads with their independent errors at omega (N,) [rad/s] and velocity (N, 3) [m/s] in
    the rotor frame; each load of a table has errors of its own."""
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
    """Find errors (E, 3, N) along the constants' principal axes and by each further source."""
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


# -------------------------------------------------------------------------------------------------
# A vehicle's rotors at rest, with the errors of their loads.


@dataclass(frozen=True, eq=False)
class StaticLoads:
    """Thrust and torque of the mean rotor at rest."""

    thrust: float  # [N]
    torque: float  # [N m]
    errors: Floats  # what each of E independent causes adds to them at one deviation (E, 2)

    def std_of(self, by_thrust: float, by_torque: float) -> float | None:
        """Return the deviation of what has these derivatives; None where none is known."""
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
# Static thrust by the signal to the speed controller, from motor, controller and battery.
#
# The signal is the share of the battery's voltage that the controller passes on, as in
# ``propmap.vehicle.powertrain``; all rotors get the same, and the battery sags under all of them.

KNOTS = 12  # rotor speeds at which loads at rest over their square are computed; they vary slowly
SPEEDS = 2000  # rotor speeds at which the signal is computed


@dataclass(frozen=True, eq=False)
class SignalCurve:
    """Thrust of a rotor at rest by the signal, rising from 0 to 1."""

    signal: Floats  # (n,)
    thrust: Floats  # the mean of the rotors (n,) [N]
    full_thrust: float  # at the signal 1 [N]
    full_torque: float  # [N m]
    full_speed: float  # [rad/s]
    full_current: float  # of a motor [A]

    def at(self, signal: Floats) -> Floats:
        """Return the thrust [N] at ``signal``."""
        return np.asarray(np.interp(signal, self.signal, self.thrust))

    def full_signal(self, motor: Motor | None) -> str:
        """Say what the full signal asks of a ``motor``."""
        rpm = self.full_speed / RPM
        words = f"At rest, full signal: {rpm:.0f} rpm, {self.full_current:.3g} A per motor."
        if motor is not None and self.full_current > motor.maximum_current:
            words += f" That is above the motor's {motor.maximum_current:g} A."
        if motor is not None and self.full_speed > motor.maximum_speed:
            words += f" That is above the motor's {motor.maximum_speed / RPM:.0f} rpm."
        return words


def known_curve(aircraft: Aircraft) -> tuple[SignalCurve | None, str]:
    """Return the curve of an ``aircraft`` at its state of charge, or why there is none."""
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
    """Find the curve of a vehicle with motor and battery at a ``charge`` 0 to 1, None where it does
    not reach signal 1; ``more_torque`` is a share added to the model's."""
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
    # Below the signal that overcomes the motor's own friction there is no thrust.
    rising, lifting = (np.concatenate([[0.0], values[upto]]) for values in (signal, lift))
    return SignalCurve(rising, lifting, *full)


def _over_square(aircraft: Aircraft, fastest: float) -> tuple[Floats, Floats, Floats]:
    """Return rotor speeds, and mean thrust and torque at rest over their square there."""
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


# -------------------------------------------------------------------------------------------------
# The one number by which an autopilot describes a thrust curve, and how sure it is.

DISCHARGED = 0.3  # state of charge besides the given one for which factors are stated

Shares = Callable[[Callable[[Floats], Floats]], Floats]
"""Makes of a curve, thrust by signal, its thrust over the largest at equally spaced x (n,)."""


@dataclass(frozen=True)
class CurveFactor:
    """A curve as f x^2 + (1 - f) x, thrust over the largest and x from 0 to 1."""

    factor: float  # f [-]
    worst: float  # largest difference from the curve, over the largest thrust [-]
    std: float | None  # deviation of f by that of the torque [-]; None where it is not known
    charge: float  # state of charge of the battery
    discharged: float  # f at the charge ``DISCHARGED``; NaN where there is no full throttle then

    @property
    def holds(self) -> str:
        """Say what it is good for."""
        here = (
            f"At rest, battery at {self.charge:.0%}: within {self.worst:.1%} of the largest thrust."
        )
        if np.isfinite(self.discharged):
            return f"{here} At {DISCHARGED:.0%} it would be {self.discharged:.3f}."
        return f"{here} At {DISCHARGED:.0%} the battery does not deliver full throttle."


def curve_factor(
    aircraft: Aircraft,
    curve: SignalCurve,
    still: StaticLoads,
    shares: Shares,
    limits: tuple[float, float],
) -> CurveFactor:
    """Fit f, within ``limits``, to the ``curve`` of an aircraft, whose loads at rest are ``still``;
    ``shares`` are what the autopilot takes as x."""
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
    """Fit f within its ``limits`` to thrusts over the largest, ``share`` (n,)."""
    x = np.linspace(0.0, 1.0, share.size)
    bent = x**2 - x
    return float(np.clip(np.sum((share - x) * bent) / np.sum(bent**2), *limits))
