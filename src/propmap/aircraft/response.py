"""How steady states change, to first order, with what they rest on."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.aircraft.balance import Balanced, Flight
from propmap.aircraft.local_loads import LocalLoads, has_slopes
from propmap.aircraft.steady import Aircraft
from propmap.aircraft.steady_states import SteadyStates
from propmap.typing import Floats
from propmap.vehicle.load_sources import LoadSource
from propmap.vehicle.rotors import Rotors

STEP = 1e-2
"""Of difference quotients to either side: angles [rad], shares of squared rotor speeds and of
torques, speeds over 1 m/s.  Loads jump by some 1e-4 of their size at isolated points, which a much
smaller step would make the most of a quotient."""

SMOOTH_STEP = 1e-5
"""The same where the loads are linear: what is left is smooth."""

Changes = Sequence[tuple[LoadSource, NDArray[np.intp]]]
"""Changes of the loads at given operating points, and of which rotors they are."""


class Response(NamedTuple):
    """Derivatives of n steady states of k rotors by one quantity, per its unit.

    All are NaN where there is no state.

    Attributes
    ----------
    pitch, roll : ndarray, shape (n,)
        [rad].
    rotor_speed : ndarray, shape (n, k)
        [rad/s].
    shaft_power, electrical_power : ndarray, shape (n,)
        [W]; the second is NaN where the vehicle has no motor.
    used : dict of str to ndarray, shape (n,)
        Shares of limits, as in ``SteadyStates``.
    """

    pitch: Floats
    roll: Floats
    rotor_speed: Floats
    shaft_power: Floats
    electrical_power: Floats
    used: dict[str, Floats]


class Responses:
    """Steady states, ready to be differentiated.

    What balances the aircraft follows a change by the implicit function theorem: with unknowns x
    and the unbalanced shares r(x, p) = 0, dx/dp = -(dr/dx)^-1 dr/dp.

    Parameters
    ----------
    aircraft, states : Aircraft, SteadyStates
        What flies, and how.
    exact : bool
        Whether the loads' own derivatives by the flow are wanted where they have some, see
        ``local_loads.has_slopes``; else all are differences.
    """

    def __init__(self, aircraft: Aircraft, states: SteadyStates, *, exact: bool = False) -> None:
        self.aircraft, self.count = aircraft, len(states)
        self.where = np.flatnonzero(states.found)
        every = Flight(states.speed, states.climb, states.bank)
        self.flight, balance = every.part(self.where), aircraft.balance
        attitude = states.pitch[self.where], states.roll[self.where]
        self.unknowns = balance.unknowns(*attitude, states.rotor_speed[self.where] ** 2)
        self.at = balance.told(self.unknowns, self.flight)
        sources = aircraft.rotors.sources
        exact = exact and bool(self.where.size) and aircraft.vehicle.wakes is None
        exact = exact and all(has_slopes(source) for source, _ in sources)
        self._step, self._balance = (SMOOTH_STEP if exact else STEP), balance
        if exact:
            rotors = Rotors(aircraft.vehicle, [(LocalLoads(one), which) for one, which in sources])
            rotors.wrenches(self.at.omega, self.at.hubs)
            self._balance = copy.copy(balance)
            self._balance.rotors = rotors
        self._inverse, self._torque = self._by_unknowns()

    def to_flight(self, name: str) -> Response:
        """By the ``name`` "speed" or "climb" [m/s]."""
        ahead, behind = (
            self._balance.told(self.unknowns, self._moved(name, h))
            for h in (self._step, -self._step)
        )
        residual, torque = _slopes(ahead, behind, 2.0 * self._step)
        return self._implied(residual, torque, name)

    def to_mass(self) -> Response:
        """By the mass [kg], the centre of mass where it is."""
        balance = self.aircraft.balance
        specific = balance.motion(self.at.pitch, self.at.roll, self.flight)[2]
        return self._implied(balance.shares(-specific, np.zeros_like(specific)))

    def to_drag_area(self, axis: int) -> Response:
        """By the body's drag area along ``axis`` 0, 1 or 2 [m^2]."""
        force = np.zeros_like(self.at.velocity)
        along = self.at.velocity[:, axis]
        force[:, axis] = -0.5 * self.aircraft.vehicle.air.density * np.abs(along) * along
        return self._implied(self.aircraft.balance.shares(force, np.zeros_like(force)))

    def to_loads(self, changes: Changes) -> Response:
        """By what changes the loads of all rotors by ``changes`` per unit."""
        rotors = self.aircraft.rotors
        change = rotors.changed(list(changes), self.at.omega, self.at.hubs)
        force = change.force.sum(axis=-2)
        moment = rotors.moment(change.force, change.moment).sum(axis=-2)
        return self._implied(self.aircraft.balance.shares(force, moment), change.torque)

    def _moved(self, name: str, by: Any) -> Flight:
        return self.flight._replace(**{name: getattr(self.flight, name) + by})

    def _by_unknowns(self) -> tuple[Floats, Floats]:
        """The inverse of dr/dx (n, u, r), and the torques' derivatives (n, k, u)."""
        n, u = self.unknowns.shape
        steps = self._step * np.concatenate([np.eye(u), -np.eye(u)])
        moved = self.unknowns + steps[:, None]
        flight = self.flight.part(np.tile(np.arange(n), 2 * u))
        found = self._balance.told(moved.reshape(-1, u), flight)
        each = [
            values.reshape(2, u, n, values.shape[-1])
            for values in (found.unbalanced, found.wrenches.torque)
        ]
        residual, torque = (
            np.moveaxis((values[0] - values[1]) / (2.0 * self._step), 0, -1) for values in each
        )
        return np.linalg.pinv(residual, rcond=1e-12), torque

    def _implied(
        self, residual: Floats, torque: Floats | None = None, flown: str | None = None
    ) -> Response:
        """The response to a change that, were nothing to follow, left over ``residual`` (n, u) and
        changed torques (n, k) [N m]; ``flown`` is what of the flight changes itself."""
        dx = -np.einsum("nur,nr->nu", self._inverse, residual)
        dq = np.einsum("nku,nu->nk", self._torque, dx)
        if torque is not None:
            dq = dq + torque
        now = self.at.wrenches.torque
        size = np.maximum(np.abs(dx).max(axis=1), (np.abs(dq) / np.abs(now)).max(axis=1))
        if flown is not None:
            size = np.maximum(size, 1.0)
        h = self._step / np.where(size > 0.0, size, 1.0)
        ahead, behind = (
            self._outcome(
                self.unknowns + by[:, None] * dx,
                self.flight if flown is None else self._moved(flown, by),
                now + by[:, None] * dq,
            )
            for by in (h, -h)
        )

        def slope(high: Floats, low: Floats) -> Floats:
            shape = (-1, *[1] * (high.ndim - 1))
            found = np.full((self.count, *high.shape[1:]), np.nan)
            found[self.where] = (high - low) / (2.0 * h.reshape(shape))
            return found

        each: list[Any] = [slope(a, b) for a, b in zip(ahead[:-1], behind[:-1], strict=True)]
        each.append({name: slope(share, behind[-1][name]) for name, share in ahead[-1].items()})
        return Response(*each)

    def _outcome(self, unknowns: Floats, flight: Flight, torque: Floats) -> Any:
        """What ``Response`` is of, at torques (n, k) that are known."""
        aircraft, balance = self.aircraft, self.aircraft.balance
        omega = np.sqrt(balance.squares(unknowns))
        hubs = balance.motion(unknowns[:, 0], unknowns[:, 1], flight)[1]
        charge = aircraft.limits.charge
        return (
            unknowns[:, 0],
            unknowns[:, 1],
            omega,
            np.sum(torque * omega, axis=1),
            aircraft.vehicle.powertrain.driven(torque, omega, charge).power,
            aircraft.used(omega, hubs, torque),
        )


def _slopes(ahead: Balanced, behind: Balanced, apart: float) -> tuple[Floats, Floats]:
    """Of the unbalanced shares, and of the torques."""
    return (
        (ahead.unbalanced - behind.unbalanced) / apart,
        (ahead.wrenches.torque - behind.wrenches.torque) / apart,
    )
