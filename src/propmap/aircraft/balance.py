"""Forces and moments on a vehicle in steady flight, and the attitude that balances them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.aircraft.controls import controls
from propmap.aircraft.newton import solve
from propmap.typing import Floats
from propmap.vehicle.flight_log import GRAVITY, in_vehicle_frame
from propmap.vehicle.free_stream_force import free_stream_force
from propmap.vehicle.rotors import Rotors, RotorWrenches
from propmap.vehicle.vectors import cross
from propmap.vehicle.vehicle import Vehicle

CHANGE = 1e-4
"""Step of a difference quotient, of angles [rad] and of the logarithm of rotor speed."""

REFERENCE_TIP_SPEED = 60.0
"""[m/s] at which the first guess takes static loads."""

LONGEST_TURN = 0.25
"""Largest change of pitch and of roll in one step [rad]."""

LONGEST_CHANGE = 0.4
"""Largest change in one step of a squared rotor speed, as a share."""


class Flight(NamedTuple):
    """n steady flights; every array is (n,).

    Attributes
    ----------
    speed, climb : ndarray
        Horizontal towards the nose, >= 0, and up, through the air [m/s].
    bank : ndarray
        Of a coordinated level turn [rad], positive to the right; tan(bank) = V^2/(g R).
    """

    speed: Floats
    climb: Floats
    bank: Floats

    def part(self, which: NDArray[np.intp]) -> Flight:
        """Some of them."""
        return Flight(*(array[which] for array in self))

    @property
    def turn_rate(self) -> Floats:
        """About the vertical, positive to the left [rad/s]."""
        rate = -GRAVITY * np.tan(self.bank)
        return np.divide(rate, self.speed, out=np.zeros_like(rate), where=self.speed > 0.0)


class Balanced(NamedTuple):
    """What was found for n flights of k rotors; numbers also where nothing was found.

    Attributes
    ----------
    pitch, roll : ndarray, shape (n,)
        Nose down, right side down [rad].
    omega : ndarray, shape (n, k)
        Rotor speeds [rad/s].
    velocity : ndarray, shape (n, 3)
        Of the centre of mass, in the vehicle's frame [m/s].
    hubs : ndarray, shape (n, k, 3)
        That of the hubs [m/s].
    wrenches : RotorWrenches
        Of the rotors.
    moment : ndarray, shape (n, 3)
        What is left for control surfaces where rotors cannot balance it [N m].
    unbalanced : ndarray, shape (n, u)
        Force over the weight along each axis, and moments over weight times arm [-].
    """

    pitch: Floats
    roll: Floats
    omega: Floats
    velocity: Floats
    hubs: Floats
    wrenches: RotorWrenches
    moment: Floats
    unbalanced: Floats

    @property
    def residual(self) -> Floats:
        """The largest share that is unbalanced (n,)."""
        return np.abs(self.unbalanced).max(axis=1)

    @property
    def power(self) -> Floats:
        """Of all shafts [W], (n,)."""
        return np.sum(self.wrenches.torque * self.omega, axis=1)

    def or_else(self, other: Balanced, where: NDArray[np.bool_]) -> Balanced:
        """Flights of the ``other`` in the places ``where`` (n,), of these elsewhere."""

        def pick(own: Any, its: Any) -> Any:
            return np.where(where.reshape(-1, *[1] * (own.ndim - 1)), its, own)

        wrenches = RotorWrenches(*map(pick, self.wrenches, other.wrenches))
        rest = {
            name: pick(getattr(self, name), getattr(other, name))
            for name in self._fields
            if name != "wrenches"
        }
        return Balanced(**rest, wrenches=wrenches)


class Balance:
    """Force and moment balances of a vehicle with given rotors.

    The unknowns are pitch, roll, and the amplitudes of ``controls``.  Moments of inertia play no
    part: in a steady turn their gyroscopic moments, of some per cent of a rotor's arm times its
    thrust, are left out.

    Parameters
    ----------
    vehicle : Vehicle
        What flies.
    rotors : Rotors
        Its rotors.
    """

    def __init__(self, vehicle: Vehicle, rotors: Rotors) -> None:
        self.vehicle, self.rotors = vehicle, rotors
        self.weight = vehicle.mass * GRAVITY
        reach = np.linalg.norm(rotors.position, axis=1).max()
        self.arm = float(max(reach, vehicle.propeller.radius))
        omega = np.full((1, len(rotors)), REFERENCE_TIP_SPEED / rotors.radius)
        still = rotors.wrenches(omega, np.zeros((*omega.shape, 3)))
        thrust = float(still.thrust.mean())
        self.controls = controls(rotors, float(still.torque.mean()) / thrust)
        upward = max(float(rotors.axis[:, 2].mean()), 0.2)
        lifted = self.weight / (len(rotors) * upward)
        self.reference = omega[0, 0] ** 2 * lifted / thrust
        """Squared rotor speed in hover, about [rad^2/s^2]."""

    def solve(self, flight: Flight, tolerance: float, first: Floats | None = None) -> Balanced:
        """The attitude and rotor speeds of n flights, to an unbalanced share of the weight.

        The search begins at ``first``, unknowns (n, u), by default at what hover and the body's
        drag make likely.
        """
        if first is None:
            first = self._likely(flight)

        def linearised(unknowns: Floats, which: NDArray[np.intp]) -> tuple[Floats, Floats]:
            return self._linearised(unknowns, flight.part(which))

        def residuals(unknowns: Floats, which: NDArray[np.intp]) -> Floats:
            return self.told(unknowns, flight.part(which)).unbalanced

        found = solve(linearised, residuals, self._bounded, first, flight.speed, tolerance)
        return self.told(found, flight)

    def unknowns(self, pitch: Floats, roll: Floats, squares: Floats) -> Floats:
        """Unknowns (n, u) of attitudes (n,) [rad] and squared rotor speeds (n, k)."""
        shares = squares @ np.linalg.pinv(self.controls.patterns).T / self.reference
        return np.column_stack([pitch, roll, shares])

    def _likely(self, flight: Flight) -> Floats:
        area = self.vehicle.body.drag_area[0]
        push = 0.5 * self.vehicle.air.density * area * flight.speed**2 / self.weight
        first = np.zeros((flight.speed.size, 2 + self.controls.patterns.shape[1]))
        first[:, 0] = np.minimum(np.arctan(push), 0.6)
        first[:, 1] = flight.bank
        first[:, 2] = np.hypot(1.0 / np.cos(flight.bank), push)
        return first

    def _bounded(self, unknowns: Floats, step: Floats) -> Floats:
        """The step (n, u), shortened to what may be trusted."""
        turn = np.abs(step[:, :2]).max(axis=1) / LONGEST_TURN
        squares = self.squares(unknowns)
        change = (step[:, 2:] @ self.controls.patterns.T) * self.reference
        grow = (np.abs(change) / squares).max(axis=1) / LONGEST_CHANGE
        return step / np.maximum(np.maximum(turn, grow), 1.0)[:, None]

    def squares(self, unknowns: Floats) -> Floats:
        """Squared rotor speeds (n, k) [rad^2/s^2] of ``unknowns`` (n, u)."""
        squares = self.reference * (unknowns[:, 2:] @ self.controls.patterns.T)
        return np.maximum(squares, 1e-4 * self.reference)

    def motion(self, pitch: Floats, roll: Floats, flight: Flight) -> tuple[Floats, Floats, Floats]:
        """Motion in the vehicle's frame.

        Parameters
        ----------
        pitch, roll : ndarray, shape (..., n)
            [rad].
        flight : Flight
            Of n.

        Returns
        -------
        velocity : ndarray, shape (..., n, 3)
            Of the centre of mass [m/s].
        hubs : ndarray, shape (..., n, k, 3)
            That of the hubs [m/s].
        specific : ndarray, shape (..., n, 3)
            Specific force [m/s^2].
        """
        velocity = in_vehicle_frame(flight.speed, 0.0, flight.climb, pitch, roll)
        up = in_vehicle_frame(0.0, 0.0, 1.0, pitch, roll)
        rates = flight.turn_rate[:, None] * up
        hubs = velocity[..., None, :] + cross(rates[..., None, :], self.rotors.position)
        aside = -GRAVITY * np.tan(flight.bank)
        return velocity, hubs, in_vehicle_frame(0.0, aside, GRAVITY, pitch, roll)

    def _residual(
        self, velocity: Floats, specific: Floats, wrenches: RotorWrenches
    ) -> tuple[Floats, Floats]:
        """Unbalanced shares (..., u) and the moment (..., 3) [N m]."""
        vehicle = self.vehicle
        body = free_stream_force(vehicle.body, vehicle.wing, vehicle.air.density, velocity)
        force = wrenches.force.sum(axis=-2) + body - vehicle.mass * specific
        moment = self.rotors.moment(wrenches.force, wrenches.moment).sum(axis=-2)
        return self.shares(force, moment), moment

    def shares(self, force: Floats, moment: Floats) -> Floats:
        """A force [N] and moment [N m] (..., 3) as what counts of them in a residual (..., u)."""
        turned = moment @ self.controls.moments.T / (self.weight * self.arm)
        return np.concatenate([force / self.weight, turned], axis=-1)

    def _linearised(self, unknowns: Floats, flight: Flight) -> tuple[Floats, Floats]:
        """Residuals (n, u) and their derivatives (n, u, u)."""
        pitch, roll = unknowns[:, 0], unknowns[:, 1]
        omega = np.sqrt(self.squares(unknowns))
        turned = CHANGE * np.array([[0.0], [1.0], [0.0]]), CHANGE * np.array([[0.0], [0.0], [1.0]])
        velocity, hubs, specific = self.motion(pitch + turned[0], roll + turned[1], flight)
        found, force, moment = self.rotors.around(omega, hubs, CHANGE)
        residual, _ = self._residual(velocity, specific, found)
        by_angles = (residual[1:] - residual[0]) / CHANGE
        # d/d(omega^2) by the square of each rotor's speed.
        each = self.shares(force, moment) / (2.0 * omega[..., None])
        by_controls = self.reference * np.einsum("nku,kc->nuc", each, self.controls.patterns)
        slopes = np.concatenate([np.moveaxis(by_angles, 0, -1), by_controls], axis=-1)
        return residual[0], slopes

    def told(self, unknowns: Floats, flight: Flight) -> Balanced:
        """What ``unknowns`` (n, u) mean in n flights, balanced or not."""
        pitch, roll = unknowns[:, 0], unknowns[:, 1]
        velocity, hubs, specific = self.motion(pitch, roll, flight)
        omega = np.sqrt(self.squares(unknowns))
        wrenches = self.rotors.wrenches(omega, hubs)
        residual, moment = self._residual(velocity, specific, wrenches)
        return Balanced(pitch, roll, omega, velocity, hubs, wrenches, moment, residual)
