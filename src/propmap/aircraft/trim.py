"""Trim of an aircraft by Newton's method: level, climbing, descending and turning states."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propmap.errors import InputError
from propmap.hover import REFERENCE_TIP_SPEED, HoverModel
from propmap.model.plausibility import FAST_TIP_MACH
from propmap.operating_points import broadcast
from propmap.rotor import Rotor
from propmap.table.query import LoadTable
from propmap.typing import Floats
from propmap.units import GRAVITY, RPM, SPEED_OF_SOUND
from propmap.vehicle.allocation import AXES, Allocation
from propmap.vehicle.log import in_vehicle_frame
from propmap.vehicle.vehicle import Vehicle, Wing
from propmap.vehicle.vehicle_forces import Rotors, RotorWrenches, free_stream_force, wing_lift
from propmap.vehicle.wakes import cross

STEEPEST_BANK = math.radians(80.0)

SOLVED, ACCEPTED = 1e-10, 1e-8
"""Imbalance at the end of a search, and largest one of a balanced state, divided by the weight."""

# Largest position of extrapolated initial values; two known states have the positions 0 and 1.
EXTRAPOLATED = 2.0
SLOWEST, FASTEST = 0.2, 20.0
"""Least and largest factor on rotor speeds in the search for the thrust margin."""

PIECES = (8, 4, 4, 4)
"""Number of intervals into which the range of the factor is divided at each level; in the last
interval, shares of limits are interpolated."""


class Aircraft:
    """An aircraft: a vehicle and the loads of its rotors.

    Parameters
    ----------
    vehicle : Vehicle
        Vehicle, from ``read_vehicle(path).vehicle``.
    loads : Rotor or LoadTable
        Source of the loads of the rotors.  With a table of propellers that turn backward, the
        vehicle flies upside down: the roll is that of upright flight plus pi.
    maximum_rotor_speed : float
        Largest rotor speed [rad/s], in addition to the limit of the motor.
    charge : float
        State of charge at which the limits of the powertrain are computed, above 0, at most 1.

    Raises
    ------
    InputError
        For loads with another propeller or other air than the vehicle, a charge outside 0 to 1,
        and a largest rotor speed that is not positive.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        loads: Rotor | LoadTable,
        *,
        maximum_rotor_speed: float = math.inf,
        charge: float = 1.0,
    ) -> None:
        self.vehicle, self.loads = vehicle, loads
        if not maximum_rotor_speed > 0.0:
            fault = f"the largest rotor speed is {maximum_rotor_speed:g} rad/s"
            raise InputError(fault, "give a value above 0")
        if not 0.0 < charge <= 1.0:
            raise InputError(f"charge is {charge:g}", "give a fraction, 1 for a full battery")
        self.maximum_rotor_speed, self.charge = maximum_rotor_speed, charge
        self.rotors = Rotors.of(vehicle, loads)
        self.balance = SteadyBalance(vehicle, self.rotors)
        self._lost = NOT_FOUND if isinstance(loads, Rotor) else OUTSIDE_TABLE

    @property
    def notes(self) -> list[str]:
        """Notes on axes that the rotor speeds do not command, and on missing limits."""
        notes = [*self.balance.allocation.notes, *([] if self.limited else [UNLIMITED])]
        return notes if self.balance.turn > 0.0 else [INVERTED, *notes]

    @property
    def limited(self) -> bool:
        """Whether a limit of the motors, of the battery or of the rotor speed is known."""
        motor, battery = self.vehicle.powertrain.motor, self.vehicle.powertrain.battery
        limits = (motor.maximum_current, motor.maximum_speed) if motor else ()
        return battery is not None or any(map(math.isfinite, (self.maximum_rotor_speed, *limits)))

    def with_hover_model(self) -> Aircraft:
        """Return this aircraft with the hover model of its rotors: static loads, no rotor drag."""
        other = copy.copy(self)
        omega = usual_omega(self.rotors)
        still = self.loads.loads(omega, 0.0, 0.0)
        hover = HoverModel(float(still.thrust) / omega**2, float(still.torque) / omega**2, omega)
        everyone = np.arange(len(self.rotors))
        # Loads of the hover model do not depend on the flow, so wakes have no effect.
        alone = replace(self.vehicle, wakes=None)
        other.rotors = Rotors(alone, [(hover, everyone)])
        other.balance = SteadyBalance(self.vehicle, other.rotors)
        other._lost = NOT_FOUND
        return other

    def steady(
        self,
        speed: ArrayLike,
        climb: ArrayLike = 0.0,
        bank: ArrayLike = 0.0,
        *,
        margin: bool = True,
        near: SteadyStates | None = None,
    ) -> SteadyStates:
        """Return the steady states of flight in the direction of the nose.

        An aircraft with a wing may have two states at one speed, with attached and with stalled
        flow.  The result is the state with less power.

        Parameters
        ----------
        speed : array_like
            Horizontal airspeed [m/s], >= 0.
        climb : array_like
            Climb rate relative to the air, negative in descent [m/s].
        bank : array_like
            Bank of a coordinated level turn, positive to the right [rad].  Speed, climb and bank
            broadcast to (n,).
        margin : bool
            Whether to compute the thrust margin, which takes up to three times as long.
        near : SteadyStates, optional
            Known states at increasing speeds.  The initial values of the solver are interpolated
            from them, which saves time.

        Returns
        -------
        SteadyStates
            n steady states.

        Raises
        ------
        InputError
            For negative speeds, a bank above 80 degrees, and a turn without speed or with climb.
        """
        v, w, turn = (np.atleast_1d(a) for a in broadcast(speed=speed, climb=climb, bank=bank))
        if v.ndim > 1:
            fault = f"speed, climb and bank broadcast to {v.ndim} axes"
            raise InputError(fault, "give arrays with one axis")
        if (v < 0.0).any():
            fault = f"speed is negative ({v.min():g})"
            raise InputError(fault, "give 0 or more, because flight is nose first")
        if (np.abs(turn) > STEEPEST_BANK).any():
            fault = f"bank is {math.degrees(np.abs(turn).max()):.0f} degrees"
            raise InputError(fault, "give at most 80 degrees (in Python: 1.39, in radians)")
        if ((turn != 0.0) & ((v == 0.0) | (w != 0.0))).any():
            raise InputError("a turn needs speed and no climb", "give speed above 0 and climb 0")
        flight = SteadyFlight(v, w, turn)
        first = None if near is None else self._between(near, v)
        found = self.balance.solve(flight, SOLVED, first)
        if self.vehicle.wing is not None:
            carried = on_the_wing(self.balance, self.vehicle.wing, flight)
            other = self.balance.solve(flight, SOLVED, carried)
            good, better = (each.residual <= ACCEPTED for each in (found, other))
            found = found.or_else(other, better & (~good | (other.power < found.power)))
        return self._states(flight, found, margin=margin)

    def _between(self, near: SteadyStates, speed: Floats) -> Floats | None:
        """Return unknowns (n, u) interpolated between known states; None for fewer than two."""
        known = np.flatnonzero(near.found)
        if known.size < 2:
            return None
        at = near.speed[known]
        squares = near.rotor_speed[known] ** 2
        values = self.balance.unknowns(near.pitch[known], near.roll[known], squares)
        k = np.clip(np.searchsorted(at, speed), 1, known.size - 1)
        share = ((speed - at[k - 1]) / (at[k] - at[k - 1]))[:, None]
        share = np.minimum(share, EXTRAPOLATED)
        return values[k - 1] + share * (values[k] - values[k - 1])

    def rotor_motion(self, states: SteadyStates) -> tuple[Floats, Floats]:
        """Return rotor speeds (m, k) [rad/s] and hub velocities (m, k, 3) [m/s] of the ``states``
        with a solution."""
        flown = np.flatnonzero(states.found)
        flight = SteadyFlight(states.speed, states.climb, states.bank).part(flown)
        _, hubs, _ = self.balance.motion(states.pitch[flown], states.roll[flown], flight)
        return states.rotor_speed[flown], hubs

    def used(self, omega: Floats, velocity: Floats, torque: Floats) -> dict[str, Floats]:
        """Return how much of each of ``LIMITS`` the n states use, as a fraction (n,).

        ``omega`` [rad/s] and ``torque`` [N m] are (n, k), and ``velocity`` (n, k, 3) is that of the
        hubs in the vehicle frame [m/s].  Unknown limits have the fraction 0.
        """
        axial = np.einsum("...kj,kj->...k", velocity, self.rotors.axis)
        across = np.sqrt(np.maximum(np.sum(velocity**2, axis=-1) - axial**2, 0.0))
        turning = np.abs(omega)
        tip = np.hypot(turning * self.rotors.radius + across, axial)
        powertrain = self.vehicle.powertrain
        motor, battery = powertrain.motor, powertrain.battery
        electric = powertrain.driven(torque, omega, self.charge)
        nothing = np.zeros(omega.shape[0])
        largest = min(self.maximum_rotor_speed, motor.maximum_speed if motor else math.inf)
        found = dict.fromkeys(LIMITS, nothing)
        found["rpm_limit"] = turning.max(axis=1) / largest
        found["tip_speed_limit"] = tip.max(axis=1) / (FAST_TIP_MACH * SPEED_OF_SOUND)
        if motor is not None:
            current = electric.motor_current.max(axis=1)
            found["motor_current_limit"] = current / motor.maximum_current
        if battery is not None:
            charge = np.full_like(nothing, self.charge)
            there = battery.voltage_or_least(electric.power, charge)
            found["voltage_limit"] = electric.controller_voltage.max(axis=1) / there
            found["battery_limit"] = battery.share_used(electric.power, charge)
        return found

    def _states(self, flight: SteadyFlight, found: Balanced, *, margin: bool) -> SteadyStates:
        omega, wrenches = found.omega, found.wrenches
        used = self.used(omega, found.hubs, wrenches.torque)
        lost = ~(found.residual <= JUMP)
        ring = (wrenches.status == VORTEX_RING).any(axis=1)
        over = [share > 1.0 for share in used.values()]
        rough = found.residual > ACCEPTED
        slow = np.zeros_like(lost)
        if self.vehicle.wing is not None and self._lost == NOT_FOUND:
            # Stall overrides the limits of forward-pulling rotors, but not of lifting rotors.
            gone = lost | np.any(over, axis=0) if self.rotors.forward else lost
            slow = gone & stalled(self.vehicle, self.vehicle.wing, flight)
        names = [STALL, self._lost, *used, VORTEX_RING, COARSE]
        status = np.select([slow, lost, *over, ring, rough], names, "ok")
        electric = self.vehicle.powertrain.driven(wrenches.torque, omega, self.charge)
        gone = ~np.isin(status, FLOWN)
        margins = np.full(len(gone), math.nan)
        if margin and self.limited and not lost.all():
            margins[~lost] = self._thrust_margin(omega[~lost], found.hubs[~lost])

        def known(values: Floats, where: NDArray[np.bool_] = gone) -> Floats:
            return np.where(where.reshape(-1, *[1] * (values.ndim - 1)), math.nan, values)

        return SteadyStates(
            *flight,
            used={name: known(share, lost) for name, share in used.items()},
            pitch=known(found.pitch),
            roll=known(found.roll),
            rotor_speed=known(omega),
            thrust=known(wrenches.thrust),
            torque=known(wrenches.torque),
            shaft_power=known(np.sum(wrenches.torque * omega, axis=1)),
            electrical_power=known(electric.power),
            motor_current=known(electric.motor_current),
            throttle=known(electric.controller_voltage / electric.battery_voltage[:, None]),
            battery_current=known(electric.battery_current),
            battery_voltage=known(electric.battery_voltage),
            moment=known(found.moment),
            thrust_margin=margins,
            residual=known(found.residual),
            status=status,
        )

    def _thrust_margin(self, omega: Floats, velocity: Floats) -> Floats:
        """Return maximum thrust / present thrust (n,) for a common factor on all rotor speeds."""
        count, rotors = omega.shape

        def at(factors: Floats) -> tuple[Floats, Floats]:
            """Return the largest used share of all limits, and the thrust, at factors (f, n)."""
            turning = omega * factors[..., None]
            moving = np.broadcast_to(velocity, (*turning.shape, 3))
            wrenches = self.rotors.wrenches(turning, moving)
            flat = turning.reshape(-1, rotors), moving.reshape(-1, rotors, 3)
            shares = self.used(*flat, wrenches.torque.reshape(-1, rotors))
            largest = np.max(list(shares.values()), axis=0)
            return largest.reshape(factors.shape), wrenches.thrust.sum(axis=-1)

        low, high = (np.full(count, math.log(factor)) for factor in (SLOWEST, FASTEST))
        share, thrust = at(np.exp([np.zeros(count), low, high]))
        needed, share, thrust = thrust[0], share[1:], thrust[1:]
        for pieces in PIECES:
            logs = np.linspace(low, high, pieces + 1)
            inner = at(np.exp(logs[1:-1]))
            share, thrust = (
                np.concatenate([ends[:1], between, ends[1:]])
                for ends, between in zip((share, thrust), inner, strict=True)
            )
            beyond = ~(share <= 1.0)
            beyond[0], beyond[-1] = False, True
            k = beyond.argmax(axis=0)
            around = np.stack([k - 1, k]), np.arange(count)
            (low, high), share, thrust = logs[around], share[around], thrust[around]
        (s0, s1), (t0, t1) = share, thrust
        found = (t0 + (1.0 - s0) / (s1 - s0) * (t1 - t0)) / needed
        return np.where(s0 <= 1.0, found, math.nan)


# --- Forces and moments on a vehicle in steady flight, and the attitude that balances them -------

CHANGE = 1e-4  # step of difference quotients: angles [rad], logarithm of rotor speed [-]
LONGEST_TURN = 0.25  # largest step of pitch and of roll [rad]
LONGEST_CHANGE = 0.4  # largest relative step of a squared rotor speed [-]


class SteadyFlight(NamedTuple):
    """n steady flights; every array is (n,)."""

    speed: Floats  # horizontal airspeed toward the nose [m/s], >= 0
    climb: Floats  # climb rate relative to the air [m/s]
    bank: Floats  # bank of a coordinated turn, tan(bank) = V^2/(g R), positive to the right [rad]

    def part(self, which: NDArray[np.intp]) -> SteadyFlight:
        """Return the flights with the numbers ``which``."""
        return SteadyFlight(*(array[which] for array in self))


def usual_omega(rotors: Rotors) -> float:
    """Return the speed [rad/s] of ``rotors`` at the usual tip speed, or the nearest in a table."""
    omega, (loads, _) = REFERENCE_TIP_SPEED / rotors.radius, rotors.sources[0]
    if not isinstance(loads, LoadTable):
        return loads.omega if isinstance(loads, HoverModel) else omega
    low, high = loads.envelope["omega"]
    return min(max(math.copysign(omega, low), low), high)


class Balanced(NamedTuple):
    """Best result for n flights with k rotors, balanced or not."""

    pitch: Floats  # positive nose down, (n,) [rad]
    roll: Floats  # positive right side down, (n,) [rad]
    omega: Floats  # (n, k) [rad/s]
    velocity: Floats  # velocity of the center of mass in the vehicle frame, (n, 3) [m/s]
    hubs: Floats  # velocities of the hubs, (n, k, 3) [m/s]
    wrenches: RotorWrenches
    moment: Floats  # moment that control surfaces have to balance, (n, 3) [N m]
    unbalanced: Floats  # forces / weight, moments / (weight times arm), (n, u) [-]

    @property
    def residual(self) -> Floats:
        """Largest unbalanced share (n,)."""
        return np.abs(self.unbalanced).max(axis=1)

    @property
    def power(self) -> Floats:
        """Power of all shafts [W], (n,)."""
        return np.sum(self.wrenches.torque * self.omega, axis=1)

    def or_else(self, other: Balanced, where: NDArray[np.bool_]) -> Balanced:
        """Return the results of ``other`` for the flights ``where`` (n,), own results elsewhere."""

        def pick(own: Any, its: Any) -> Any:
            if isinstance(own, RotorWrenches):
                return RotorWrenches(*map(pick, own, its))
            return np.where(where.reshape(-1, *[1] * (own.ndim - 1)), its, own)

        return Balanced(*map(pick, self, other))


class SteadyBalance:
    """Force and moment balances of a vehicle with given rotors.

    The unknowns are pitch, roll and the amplitudes of ``patterns`` (k, c) of squared rotor speeds.
    The first pattern is equal for all rotors; the others command the moments ``axes`` (c - 1,).
    Gyroscopic moments of a steady turn, a few percent of thrust times arm, are neglected.
    """

    def __init__(self, vehicle: Vehicle, rotors: Rotors) -> None:
        self.vehicle, self.rotors = vehicle, rotors
        self.weight = vehicle.mass * GRAVITY
        reach = np.linalg.norm(rotors.position, axis=1).max()
        self.arm = float(max(reach, vehicle.propeller.radius))
        turning = usual_omega(rotors)
        omega = np.full((1, len(rotors)), turning)
        still = rotors.wrenches(omega, np.zeros((*omega.shape, 3)))
        thrust = float(still.thrust.mean())
        if np.isnan(thrust):
            lost = still.status[0, 0]
            found = f"at rest, at {turning / RPM:.0f} rpm, the rotors have no loads ({lost})"
            raise InputError(found, "give loads that cover hover: speed from 0, beta up to 180 deg")
        torque = rotors.spin * float(still.torque.mean()) / thrust
        self.allocation = Allocation.of(rotors.position, rotors.axis, torque)
        moments = [k for k in self.allocation.commanded if 0 < k < len(AXES)]
        self.axes = np.array(moments, np.intp) - 1
        self.patterns = np.vstack([np.ones(len(rotors)), self.allocation.matrix[moments]]).T
        upward = max(float(rotors.axis[:, 2].mean()), 0.2)
        lifted = self.weight / (len(rotors) * upward)
        self.turn = math.copysign(1.0, turning)  # -1 for rotors that turn backward, else 1
        # Approximate squared rotor speed in hover [rad^2/s^2].
        self.reference = turning**2 * lifted / (self.turn * thrust)

    def solve(
        self, flight: SteadyFlight, tolerance: float, first: Floats | None = None
    ) -> Balanced:
        """Return attitude and rotor speeds of n flights, unbalanced by at most ``tolerance``.

        The search starts from the unknowns ``first`` (n, u), by default from hover and body drag.
        """
        if first is None:
            area = self.vehicle.body.drag_area[0]
            push = 0.5 * self.vehicle.air.density * area * flight.speed**2 / self.weight
            first = np.zeros((flight.speed.size, 2 + self.patterns.shape[1]))
            first[:, 0] = np.minimum(np.arctan(push), 0.6)
            first[:, 1] = flight.bank + (math.pi if self.turn < 0.0 else 0.0)
            first[:, 2] = np.hypot(1.0 / np.cos(flight.bank), push)

        def linearized(unknowns: Floats, which: NDArray[np.intp]) -> tuple[Floats, Floats]:
            return self._linearized(unknowns, flight.part(which))

        def residuals(unknowns: Floats, which: NDArray[np.intp]) -> Floats:
            return self.evaluated(unknowns, flight.part(which)).unbalanced

        found = solve(linearized, residuals, self._bounded, first, flight.speed, tolerance)
        return self.evaluated(found, flight)

    def unknowns(self, pitch: Floats, roll: Floats, squares: Floats) -> Floats:
        """Return the unknowns (n, u) for attitudes (n,) [rad] and squared rotor speeds (n, k)."""
        shares = squares @ np.linalg.pinv(self.patterns).T / self.reference
        return np.column_stack([pitch, roll, shares])

    def _bounded(self, unknowns: Floats, step: Floats) -> Floats:
        """Return the step (n, u), shortened to the largest allowed change."""
        turn = np.abs(step[:, :2]).max(axis=1) / LONGEST_TURN
        squares = self.squares(unknowns)
        change = (step[:, 2:] @ self.patterns.T) * self.reference
        grow = (np.abs(change) / squares).max(axis=1) / LONGEST_CHANGE
        return step / np.maximum(np.maximum(turn, grow), 1.0)[:, None]

    def squares(self, unknowns: Floats) -> Floats:
        """Return squared rotor speeds (n, k) [rad^2/s^2] of ``unknowns`` (n, u)."""
        squares = self.reference * (unknowns[:, 2:] @ self.patterns.T)
        return np.maximum(squares, 1e-4 * self.reference)

    def omega(self, unknowns: Floats) -> Floats:
        """Return rotor speeds (n, k) [rad/s] of ``unknowns`` (n, u)."""
        return self.turn * np.sqrt(self.squares(unknowns))

    def motion(
        self, pitch: Floats, roll: Floats, flight: SteadyFlight
    ) -> tuple[Floats, Floats, Floats]:
        """Return velocities of the center of mass (..., n, 3) and of the hubs (..., n, k, 3) [m/s],
        and the specific force (..., n, 3) [m/s^2], in the vehicle frame, at ``pitch`` and ``roll``
        (..., n) [rad]."""
        velocity = in_vehicle_frame(flight.speed, 0.0, flight.climb, pitch, roll)
        up = in_vehicle_frame(0.0, 0.0, 1.0, pitch, roll)
        aside = -GRAVITY * np.tan(flight.bank)
        turning = np.divide(aside, flight.speed, out=np.zeros_like(aside), where=flight.speed > 0.0)
        rates = turning[:, None] * up
        hubs = velocity[..., None, :] + cross(rates[..., None, :], self.rotors.position)
        return velocity, hubs, in_vehicle_frame(0.0, aside, GRAVITY, pitch, roll)

    def _residual(
        self, velocity: Floats, specific: Floats, wrenches: RotorWrenches
    ) -> tuple[Floats, Floats]:
        """Return unbalanced shares (..., u) and the moment (..., 3) [N m]."""
        vehicle = self.vehicle
        body = free_stream_force(vehicle.body, vehicle.wing, vehicle.air.density, velocity)
        force = wrenches.force.sum(axis=-2) + body - vehicle.mass * specific
        moment = self.rotors.moment(wrenches.force, wrenches.moment).sum(axis=-2)
        return self.shares(force, moment), moment

    def shares(self, force: Floats, moment: Floats) -> Floats:
        """Return the unbalanced shares (..., u) of a force [N] and a moment [N m] (..., 3)."""
        turned = moment[..., self.axes] / (self.weight * self.arm)
        return np.concatenate([force / self.weight, turned], axis=-1)

    def _linearized(self, unknowns: Floats, flight: SteadyFlight) -> tuple[Floats, Floats]:
        """Return residuals (n, u) and their derivatives (n, u, u)."""
        pitch, roll = unknowns[:, 0], unknowns[:, 1]
        omega = self.omega(unknowns)
        turned = CHANGE * np.array([[0.0], [1.0], [0.0]]), CHANGE * np.array([[0.0], [0.0], [1.0]])
        velocity, hubs, specific = self.motion(pitch + turned[0], roll + turned[1], flight)
        found, force, moment = self.rotors.around(omega, hubs, CHANGE)
        residual, _ = self._residual(velocity, specific, found)
        by_angles = (residual[1:] - residual[0]) / CHANGE
        # Derivatives with respect to the squared speed of each rotor.
        each = self.shares(force, moment) / (2.0 * omega[..., None])
        by_controls = self.reference * np.einsum("nku,kc->nuc", each, self.patterns)
        slopes = np.concatenate([np.moveaxis(by_angles, 0, -1), by_controls], axis=-1)
        return residual[0], slopes

    def evaluated(self, unknowns: Floats, flight: SteadyFlight) -> Balanced:
        """Return the result for the ``unknowns`` (n, u) of n flights, balanced or not."""
        pitch, roll = unknowns[:, 0], unknowns[:, 1]
        velocity, hubs, specific = self.motion(pitch, roll, flight)
        omega = self.omega(unknowns)
        wrenches = self.rotors.wrenches(omega, hubs)
        residual, moment = self._residual(velocity, specific, wrenches)
        return Balanced(pitch, roll, omega, velocity, hubs, wrenches, moment, residual)


# --- Newton's method for many small systems of equations at once ---------------------------------

ITERATIONS = 40

SHORTEST = 1.0 / 32.0  # share of a step below which the search of a system ends
NEAR = 1e-2
"""Norm of residuals below which Broyden's rule updates the derivatives, because computing them
costs as much as three residuals."""

RESTARTS = 10  # most restarts of systems without a solution, from solutions of neighbors

Linearized = Callable[[Floats, NDArray[np.intp]], tuple[Floats, Floats]]
"""Function of the unknowns (m, u) and numbers (m,) of systems: residuals (m, u) and derivatives
(m, u, u), NaN without loads."""

Residuals = Callable[[Floats, NDArray[np.intp]], Floats]
"""Function of the same arguments: only the residuals."""

Bounded = Callable[[Floats, Floats], Floats]
"""Function of unknowns (m, u) and a step (m, u): the step, shortened to the allowed change."""


def solve(
    linearized: Linearized,
    residuals: Residuals,
    bounded: Bounded,
    first: Floats,
    order: Floats,
    tolerance: float,
) -> Floats:
    """Return the best unknowns (n, u) of n systems, searched from ``first``.

    A system with a residual above the ``tolerance`` starts again from the solution of the system
    that is nearest in ``order`` (n,).
    """
    functions = linearized, residuals, bounded
    best, size = _newton(*functions, first, np.arange(len(first)), tolerance)
    for _ in range(RESTARTS):
        good, lost = np.flatnonzero(size <= tolerance), np.flatnonzero(size > tolerance)
        if not (lost.size and good.size):
            break
        nearest = good[np.abs(order[lost][:, None] - order[good]).argmin(axis=1)]
        found, left_over = _newton(*functions, best[nearest], lost, tolerance)
        better = left_over < size[lost]
        best[lost[better]], size[lost[better]] = found[better], left_over[better]
        if not (left_over <= tolerance).any():
            break
    return best


def _newton(
    linearized: Linearized,
    residuals: Residuals,
    bounded: Bounded,
    first: Floats,
    numbers: NDArray[np.intp],
    tolerance: float,
) -> tuple[Floats, Floats]:
    """Return the best unknowns (m, u) of the systems ``numbers``, and norms of residuals (m,)."""
    best, step = first.copy(), np.zeros_like(first)
    size, share = np.full(len(first), np.inf), np.ones(len(first))
    at_work, near = np.arange(len(first)), False
    left, inverse = np.zeros(0), np.zeros(0)
    for _ in range(ITERATIONS):
        change = share[at_work, None] * step[at_work]
        trial = best[at_work] + change
        if near:
            residual = residuals(trial, numbers[at_work])
            inverse = _followed(inverse, change, residual - left)
        else:
            residual, slopes = linearized(trial, numbers[at_work])
            known = np.isfinite(slopes).all(axis=(1, 2), keepdims=True)
            inverse = np.linalg.pinv(np.where(known, slopes, 0.0), rcond=1e-12)
        norm = np.nan_to_num(np.linalg.norm(residual, axis=1), nan=np.inf)
        better = norm < size[at_work]
        won = at_work[better]
        best[won], size[won], share[won] = trial[better], norm[better], 1.0
        share[at_work[~better]] *= 0.5
        onward = -np.einsum("mij,mj->mi", inverse[better], residual[better])
        step[won] = bounded(trial[better], onward)
        kept = (size[at_work] > tolerance) & (share[at_work] >= SHORTEST)
        at_work, left, inverse = at_work[kept], residual[kept], inverse[kept]
        if not at_work.size:
            break
        near = bool(better[kept].all() and (size[at_work] <= NEAR).all())
    return best, size


def _followed(inverse: Floats, step: Floats, change: Floats) -> Floats:
    """Return inverses (m, u, u) updated by Broyden's rule for a ``step`` and its ``change``."""
    missed = step - np.einsum("mij,mj->mi", inverse, change)
    along = np.einsum("mi,mij->mj", step, inverse)
    size = np.einsum("mi,mi->m", along, change)[:, None, None]
    update = missed[:, :, None] * along[:, None, :]
    return inverse + np.divide(update, size, out=np.zeros_like(update), where=size != 0.0)


# --- Flight on a wing: initial values of a search, and the stall speed ---------------------------

ATTACHED = 0.6  # largest angle of attack of the initial values, divided by ``alpha_0``
ADVANCE = 0.2  # airspeed of the initial values, divided by the tip speed
ANGLES = 181  # number of angles from 0 to twice ``alpha_0`` in the search for the largest lift


def on_the_wing(balance: SteadyBalance, wing: Wing, flight: SteadyFlight) -> Floats:
    """Return initial values (n, u) of flights carried by the wing, for ``SteadyBalance.solve``."""
    vehicle = balance.vehicle
    speed = np.maximum(np.hypot(flight.speed, flight.climb), 1e-3)
    slope = 0.5 * vehicle.air.density * speed**2 * wing.area * wing.c_l1
    alpha = np.minimum(_load(vehicle, flight) / slope, ATTACHED * wing.alpha_0)
    squares = np.square(speed / (ADVANCE * vehicle.propeller.radius))
    least = 0.05 * balance.reference
    every = np.repeat(np.maximum(squares, least)[:, None], len(balance.rotors), axis=1)
    path = np.arctan2(flight.climb, np.maximum(flight.speed, 1e-3))
    return balance.unknowns(wing.incidence - alpha - path, flight.bank, every)


def stalled(vehicle: Vehicle, wing: Wing, flight: SteadyFlight) -> Any:
    """Return whether n flights are slower than the stall speed of the wing, (n,) bool."""
    largest = wing_lift(wing, np.linspace(0.0, 2.0 * wing.alpha_0, ANGLES)).max()
    pressure = 0.5 * vehicle.air.density * (flight.speed**2 + flight.climb**2)
    return pressure * largest < _load(vehicle, flight)


def _load(vehicle: Vehicle, flight: SteadyFlight) -> Floats:
    return vehicle.mass * GRAVITY / np.cos(flight.bank)


# --- Steady states of an aircraft, and their statuses --------------------------------------------

LIMITS = {
    "rpm_limit": "the largest rotor speed",
    "tip_speed_limit": f"a tip speed of Mach {FAST_TIP_MACH:g} (limit of the model)",
    "motor_current_limit": "the largest motor current",
    "voltage_limit": "full throttle at the battery voltage",
    "battery_limit": "the largest current or power of the battery",
}
"""Statuses of states beyond a limit, with a description of the limit."""

UNLIMITED = (
    "thrust margin and top speed are unknown: add [battery], or maximum_current or maximum_rpm in "
    "[motor], or pass --max-rpm"
)

INVERTED = (
    "the rotors turn backward and the vehicle flies upside down; no measurement confirms this"
)

JUMP = 2e-3
"""Largest permitted imbalance of a state, divided by the weight.  The loads jump at speeds at
which the number of nodes of a rotor changes."""

NOT_FOUND, STALL, OUTSIDE_TABLE = "no_trim", "stall", "outside_table"
VORTEX_RING, COARSE = "vortex_ring", "coarse"
FLOWN = ("ok", COARSE, VORTEX_RING)  # statuses of states with numbers
STATUSES = {
    "ok": "found, within all limits",
    COARSE: f"found, but loads with jumps leave an imbalance of less than {JUMP:.1%} of the weight",
    VORTEX_RING: "found, but a rotor is in the vortex ring state, where loads are not reliable",
    **{name: f"beyond {words}" for name, words in LIMITS.items()},
    OUTSIDE_TABLE: "no state inside the envelope of the table balances the aircraft",
    STALL: "slower than the stall speed of the wing, and the rotors cannot carry the rest",
    NOT_FOUND: "no attitude and rotor speeds balance the aircraft",
}
"""Descriptions of the statuses."""


@dataclass(frozen=True, eq=False)
class SteadyStates:
    """n steady states of an aircraft with k rotors.

    States that were not found, or that are beyond a limit, have NaN values, except for ``speed``,
    ``climb`` and ``bank``.  States beyond a limit also have ``used`` and ``thrust_margin``.

    Attributes
    ----------
    speed, climb, bank : ndarray, shape (n,)
        Horizontal airspeed [m/s], climb rate [m/s], and bank of a coordinated level turn [rad],
        positive to the right.
    used : dict of str to ndarray, shape (n,)
        Used fraction of each limit: 1 at the limit, above 1 beyond it.  The keys are "rpm_limit",
        "tip_speed_limit", "motor_current_limit", "voltage_limit" and "battery_limit".
    thrust_margin : ndarray, shape (n,)
        Maximum thrust divided by the required thrust.  For the maximum, all rotor speeds are scaled
        by one factor until the first limit is reached.  The margin is below 1 beyond a limit, and
        NaN if no limit of motors, battery or rotor speed is known.
    pitch, roll : ndarray, shape (n,)
        Pitch, positive nose down, and roll, positive right side down [rad].
    rotor_speed, thrust, torque : ndarray, shape (n, k)
        Rotational speed, thrust and torque of each rotor [rad/s], [N], [N m].
    shaft_power : ndarray, shape (n,)
        Shaft power of all rotors [W].
    electrical_power : ndarray, shape (n,)
        Power at the terminals of the battery [W]; NaN for a vehicle without a motor.
    motor_current, throttle : ndarray, shape (n, k)
        Motor current [A], NaN without a motor; motor voltage as a share of the battery voltage [-],
        NaN without a battery.
    battery_current, battery_voltage : ndarray, shape (n,)
        Current [A] and voltage [V] of the battery; NaN without a battery.
    moment : ndarray, shape (n, 3)
        Moment about the center of mass that control surfaces have to balance [N m].
    residual : ndarray, shape (n,)
        Largest component of the unbalanced force and moment [-].  The force is divided by the
        weight, the moment by the product of weight and longest arm.
    status : ndarray of str, shape (n,)
        Status of each state, a key of ``propmap.aircraft.trim.STATUSES``: "ok", "coarse",
        "vortex_ring", "outside_table", "stall", "no_trim", or the key in ``used`` of an exceeded
        limit.
    """

    speed: Floats
    climb: Floats
    bank: Floats
    used: dict[str, Floats]
    thrust_margin: Floats
    pitch: Floats
    roll: Floats
    rotor_speed: Floats
    thrust: Floats
    torque: Floats
    shaft_power: Floats
    electrical_power: Floats
    motor_current: Floats
    throttle: Floats
    battery_current: Floats
    battery_voltage: Floats
    moment: Floats
    residual: Floats
    status: NDArray[np.str_]

    def __len__(self) -> int:
        return int(self.speed.size)

    @property
    def found(self) -> NDArray[np.bool_]:
        """Whether each state was found and is within all limits, (n,)."""
        return np.isfinite(self.shaft_power)

    @property
    def power(self) -> Floats:
        """Electrical power, or shaft power if the vehicle has no motor [W], (n,)."""
        known = np.isfinite(self.electrical_power)
        return np.where(known, self.electrical_power, self.shaft_power)

    def and_also(self, other: SteadyStates) -> SteadyStates:
        """Return these states and those of ``other``, in the order of speeds."""
        _, order = np.unique(np.concatenate([self.speed, other.speed]), return_index=True)

        def both(mine: Any, its: Any) -> Any:
            if isinstance(mine, dict):
                return {name: both(values, its[name]) for name, values in mine.items()}
            return np.concatenate([mine, its])[order]

        return SteadyStates(
            *(both(getattr(self, f.name), getattr(other, f.name)) for f in fields(self))
        )
