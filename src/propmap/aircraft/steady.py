"""An aircraft's steady states: level flight, climb, descent and coordinated turns."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propmap.aircraft.balance import Balance, Balanced, Flight
from propmap.aircraft.hover_loads import HoverLoads
from propmap.aircraft.limits import Limits
from propmap.aircraft.margin import thrust_margin
from propmap.aircraft.steady_states import (
    COARSE,
    FLOWN,
    JUMP,
    NOT_FOUND,
    OUTSIDE_TABLE,
    STALL,
    VORTEX_RING,
    SteadyStates,
)
from propmap.aircraft.wing_borne import of_less_power, on_the_wing, stalled
from propmap.baselines.hover import REFERENCE_TIP_SPEED, HoverModel
from propmap.errors import InputError
from propmap.operating_points import broadcast
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.vehicle.rotors import Rotors
from propmap.vehicle.vehicle import Vehicle

if TYPE_CHECKING:
    from propmap.table.query import LoadTable

STEEPEST_BANK = math.radians(80.0)

SOLVED, ACCEPTED = 1e-10, 1e-8
"""Unbalanced share of the weight at which the search ends, and up to which a state is balanced."""

EXTRAPOLATED = 2.0
"""Intervals of known states over which a search begins on their line, at most."""


class Aircraft:
    """A vehicle with the loads of its rotors: the face of this package.

    Parameters
    ----------
    vehicle : Vehicle
        What flies, from ``read_vehicle(path).vehicle``.
    loads : Rotor or LoadTable
        Of its rotors.
    maximum_rotor_speed : float
        [rad/s] besides what the vehicle's motor tells.
    charge : float
        State of charge, 0 to 1, at which the limits are taken.

    Raises
    ------
    InputError
        Where the loads are of another propeller or air than the vehicle's.
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
        self.limits = Limits(vehicle.powertrain, maximum_rotor_speed, charge)
        self.rotors = Rotors.of(vehicle, loads)
        self.balance = Balance(vehicle, self.rotors)
        self._lost = NOT_FOUND if isinstance(loads, Rotor) else OUTSIDE_TABLE

    def with_hover_model(self) -> Aircraft:
        """The same aircraft with the hover model of its rotors: no drag, loads as at rest."""
        other = copy.copy(self)
        omega = REFERENCE_TIP_SPEED / self.vehicle.propeller.radius
        if not isinstance(self.loads, Rotor):
            omega = min(
                max(omega, self.loads.envelope["omega"][0]), self.loads.envelope["omega"][1]
            )
        still = self.loads.loads(omega, 0.0, 0.0)
        hover = HoverModel(float(still.thrust) / omega**2, float(still.torque) / omega**2, omega)
        everyone = np.arange(len(self.rotors))
        # Its loads do not depend on the flow, nor then on the wakes.
        alone = replace(self.vehicle, wakes=None)
        other.rotors = Rotors(alone, [(HoverLoads(hover), everyone)])
        other.balance = Balance(self.vehicle, other.rotors)
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
        """Steady states, nose first.

        An aircraft with a wing may fly at one speed with the wing stalled and without: the state is
        that of less power.

        Parameters
        ----------
        speed : array_like
            Horizontal speed through the air [m/s], >= 0.
        climb : array_like
            Climb rate through the air, negative in descent [m/s].
        bank : array_like
            Of a coordinated level turn, positive to the right [rad]; all three broadcast to (n,).
        margin : bool
            Whether the thrust margin is wanted, which takes as long again.
        near : SteadyStates, optional
            States at rising speeds between and beyond which the search begins; it takes less time
            then.

        Raises
        ------
        InputError
            For negative speeds, a bank beyond 80 degrees, and a turn on the spot.
        """
        v, w, turn = (np.atleast_1d(a) for a in broadcast(speed=speed, climb=climb, bank=bank))
        if v.ndim > 1:
            raise InputError(f"speed, climb and bank have {v.ndim} axes together", "give one")
        if (v < 0.0).any():
            raise InputError(f"speed is negative ({v.min():g})", "the nose points into the flight")
        if (np.abs(turn) > STEEPEST_BANK).any():
            raise InputError("bank is beyond 80 degrees", "give radians, -1.39 to 1.39")
        if ((turn != 0.0) & ((v == 0.0) | (w != 0.0))).any():
            raise InputError("a turn is level and takes speed", "give speed above 0 and climb 0")
        flight = Flight(v, w, turn)
        first = None if near is None else self._between(near, v)
        found = self.balance.solve(flight, SOLVED, first)
        if self.vehicle.wing is not None:
            carried = on_the_wing(self.balance, flight)
            found = of_less_power(found, self.balance.solve(flight, SOLVED, carried), ACCEPTED)
        return self._states(flight, found, margin=margin)

    def _between(self, near: SteadyStates, speed: Floats) -> Floats | None:
        """Unknowns (n, u) on the lines through known states, None where there are too few."""
        known = np.flatnonzero(near.found)
        if known.size < 2:
            return None
        at = near.speed[known]
        values = self.balance.unknowns(
            near.pitch[known], near.roll[known], near.rotor_speed[known] ** 2
        )
        k = np.clip(np.searchsorted(at, speed), 1, known.size - 1)
        share = ((speed - at[k - 1]) / (at[k] - at[k - 1]))[:, None]
        share = np.minimum(share, EXTRAPOLATED)
        return values[k - 1] + share * (values[k] - values[k - 1])

    def rotor_motion(self, states: SteadyStates) -> tuple[Floats, Floats]:
        """Rotor speeds and the hubs' velocities of those ``states`` that have numbers.

        Returns
        -------
        omega : ndarray, shape (m, k)
            [rad/s].
        velocity : ndarray, shape (m, k, 3)
            Through the air, in the vehicle's frame [m/s].
        """
        flown = np.flatnonzero(states.found)
        flight = Flight(states.speed, states.climb, states.bank).part(flown)
        _, hubs, _ = self.balance.motion(states.pitch[flown], states.roll[flown], flight)
        return states.rotor_speed[flown], hubs

    def used(self, omega: Floats, velocity: Floats, torque: Floats) -> dict[str, Floats]:
        """Share of each of ``LIMITS`` that n states use, 1 at the limit, (n,).

        Parameters
        ----------
        omega, torque : ndarray, shape (n, k)
            Of the rotors [rad/s], [N m].
        velocity : ndarray, shape (n, k, 3)
            Of the hubs, in the vehicle's frame [m/s].
        """
        axial = np.einsum("...kj,kj->...k", velocity, self.rotors.axis)
        across = np.sqrt(np.maximum(np.sum(velocity**2, axis=-1) - axial**2, 0.0))
        tip = np.hypot(omega * self.rotors.radius + across, axial)
        electric = self.vehicle.powertrain.driven(torque, omega, self.limits.charge)
        return self.limits.used(omega, tip, electric)

    def _states(self, flight: Flight, found: Balanced, *, margin: bool) -> SteadyStates:
        omega, wrenches = found.omega, found.wrenches
        used = self.used(omega, found.hubs, wrenches.torque)
        lost = ~(found.residual <= JUMP)
        ring = (wrenches.status == VORTEX_RING).any(axis=1)
        over = [share > 1.0 for share in used.values()]
        rough = found.residual > ACCEPTED
        slow = np.zeros_like(lost)
        if self.vehicle.wing is not None and self._lost == NOT_FOUND:
            # What hangs on its rotors is told their limit; what hangs on a wing, that it stalls.
            gone = lost | np.any(over, axis=0) if self.rotors.forward else lost
            slow = gone & stalled(self.vehicle, flight)
        names = [STALL, self._lost, *used, VORTEX_RING, COARSE]
        status = np.select([slow, lost, *over, ring, rough], names, "ok")
        electric = self.vehicle.powertrain.driven(wrenches.torque, omega, self.limits.charge)
        gone = ~np.isin(status, FLOWN)
        nothing = np.full(len(gone), math.nan)
        margins = np.array(nothing)
        if margin and not lost.all():
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
        def at(factors: Floats) -> tuple[Floats, Floats]:
            turning = omega * factors[..., None]
            moving = np.broadcast_to(velocity, (*turning.shape, 3))
            wrenches = self.rotors.wrenches(turning, moving)
            flat = (-1, omega.shape[1])
            shares = self.used(
                turning.reshape(flat), moving.reshape(*flat, 3), wrenches.torque.reshape(flat)
            )
            largest = np.max(list(shares.values()), axis=0)
            return largest.reshape(factors.shape), wrenches.thrust.sum(axis=-1)

        return thrust_margin(at, len(omega))
