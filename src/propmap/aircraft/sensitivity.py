"""Sensitivity of steady states: derivatives and standard deviations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.aircraft.trim import Aircraft, SteadyFlight, SteadyStates
from propmap.bands import errors_of_loads
from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.operating_points import FlowPoints
from propmap.rotor import Rotor
from propmap.table.query import LoadTable
from propmap.typing import Floats
from propmap.vehicle.vehicle_forces import Sources, load_rows

FLIGHT = ("speed", "climb")
AREAS = ("drag_area_x", "drag_area_y", "drag_area_z")
VEHICLE = (*FLIGHT, "mass", *AREAS)
"""Quantities of flight and vehicle for derivatives of steady states [m/s], [kg], [m^2].  Section
constants and ``GEOMETRY`` are further quantities."""

DIAMETER, GROWTH = "diameter_scale", 0.01  # factor on radius and chord, and its step


class StateChange(NamedTuple):
    """Changes of n steady states of k rotors: derivatives per unit, or standard deviations.

    All values are NaN for states that were not found.

    Attributes
    ----------
    pitch, roll : ndarray, shape (n,)
        Attitude [rad].
    rotor_speed : ndarray, shape (n, k)
        Rotor speeds [rad/s].
    shaft_power, electrical_power : ndarray, shape (n,)
        Powers [W]; ``electrical_power`` is NaN for a vehicle without a motor.
    used : dict of str to ndarray, shape (n,)
        Used shares of limits, as in ``SteadyStates``.
    """

    pitch: Floats
    roll: Floats
    rotor_speed: Floats
    shaft_power: Floats
    electrical_power: Floats
    used: dict[str, Floats]

    @property
    def power(self) -> Floats:
        """Change of the electrical power, or of the shaft power if there is no motor [W], (n,)."""
        return np.where(np.isfinite(self.electrical_power), self.electrical_power, self.shaft_power)


def _joined(changes: Sequence[StateChange], join: Callable[[list[Floats]], Floats]) -> StateChange:
    """Return the result of ``join`` for each array of the ``changes``."""
    used = {name: join([one.used[name] for one in changes]) for name in changes[0].used}
    names = StateChange._fields[:-1]
    arrays: Any = {name: join([getattr(one, name) for one in changes]) for name in names}
    return StateChange(**arrays, used=used)


def derivatives(
    aircraft: Aircraft, states: SteadyStates, names: Iterable[str]
) -> dict[str, StateChange]:
    """Return the derivatives of steady states with respect to named quantities.

    The aircraft is trimmed again: attitude and rotor speeds change with each quantity.
    Derivatives of the loads with respect to section constants, chord and twist come from the rotor.
    Derivatives with respect to flow and diameter are difference quotients.

    Parameters
    ----------
    aircraft, states : Aircraft, SteadyStates
        Aircraft and n of its states.
    names : iterable of str
        Quantities:

        - "speed" and "climb" [m/s], "mass" [kg];
        - "drag_area_x", "drag_area_y", "drag_area_z" [m^2];
        - section constants such as "c_l1";
        - "chord_scale" [-], a factor on the chord;
        - "twist_offset" [rad], added to the twist;
        - "diameter_scale" [-], a factor on radius and chord.

    Returns
    -------
    dict of str to StateChange
        Derivatives by name, per unit.

    Raises
    ------
    InputError
        For an unknown name, for a quantity of the propeller if the loads are from a table, and for
        "diameter_scale" if the vehicle has wakes.
    """
    wanted = list(names)
    own = tuple(name for name in wanted if name not in VEHICLE)
    responses = Responses(aircraft, states)
    of_loads = dict(zip(own, _to_parameters(responses, own), strict=True)) if own else {}
    found = {}
    for name in wanted:
        if name in FLIGHT:
            found[name] = responses.to_flight(name)
        elif name == "mass":
            found[name] = responses.to_mass()
        elif name in AREAS:
            found[name] = responses.to_drag_area(AREAS.index(name))
        else:
            found[name] = of_loads[name]
    return found


def spread(aircraft: Aircraft, states: SteadyStates) -> StateChange | None:
    """Return first-order standard deviations of steady states from those of the loads.

    Errors of the loads, see ``propmap.Loads.std_by_source``, are assumed to be equal at all rotors.
    Errors of the section constants are correlated by their covariance matrix.  Errors of model and
    tunnel, and errors of the loads of a table, are assumed to be independent between loads.

    Parameters
    ----------
    aircraft, states : Aircraft, SteadyStates
        Aircraft and n of its states.

    Returns
    -------
    StateChange or None
        Standard deviations; None for loads without standard deviations.
    """
    sources: list[Any] = [source for source, _ in aircraft.rotors.sources]
    if not states.found.any() or not all(map(_has_errors, sources)):
        return None
    responses = Responses(aircraft, states)
    uncertainty = sources[0].model.uncertainty if isinstance(sources[0], Rotor) else None
    covariance = None if uncertainty is None else uncertainty.covariance.determined
    names = () if covariance is None else covariance.names
    constants = _to_parameters(responses, names) if names else []
    # Responses to errors of one standard deviation, one load at a time.
    count = len(LOADS) * (2 if uncertainty and uncertainty.another_tunnel else 1)
    changes = [(_errors_of(source), which) for source, which in aircraft.rotors.sources]
    errors = responses.to_each(changes, count)

    def deviation(each: list[Floats]) -> Floats:
        variance: Any = sum(np.square(one) for one in each[: len(errors)])
        if covariance is not None and constants:
            by = np.stack(each[len(errors) :])
            variance = variance + np.einsum("p...,pq,q...->...", by, covariance.matrix, by)
        return np.asarray(np.sqrt(np.maximum(variance, 0.0)))

    return _joined([*errors, *constants], deviation)


def _has_errors(source: Any) -> bool:
    """Return whether a source of loads has standard deviations."""
    if isinstance(source, Rotor):
        return source.model.uncertainty is not None
    return isinstance(source, LoadTable) and source.content.deviations is not None


def _to_parameters(responses: Responses, names: tuple[str, ...]) -> list[StateChange]:
    """Return derivatives of the states with respect to section constants and geometry."""
    if DIAMETER in names and responses.aircraft.vehicle.wakes is not None:
        found = f"rotors with wakes on each other have no derivative for {DIAMETER!r}"
        raise InputError(found, "ignore the wakes: --no-wakes, or Vehicle(..., wakes=None)")
    changes = []
    for source, which in responses.aircraft.rotors.sources:
        if not isinstance(source, Rotor):
            found = f"loads from a table have no derivative for {names[0]!r}"
            raise InputError(found, f"give the aircraft a Rotor, or names of {', '.join(VEHICLE)}")
        known = (*(name for name in source.parameters if name not in FlowPoints._fields), DIAMETER)
        unknown = [name for name in names if name not in known]
        if unknown:
            found = f"there is no derivative for {unknown[0]!r}"
            raise InputError(found, f"choose from {', '.join((*VEHICLE, *known))}")
        changes.append((_slopes_of(source, names), which))
    return responses.to_each(changes, len(names))


def _slopes_of(rotor: Rotor, wanted: tuple[str, ...]) -> ChangesAt:
    """Return the derivatives of the loads of a rotor with respect to ``wanted``."""
    names = tuple(name for name in wanted if name != DIAMETER)

    def grown(factor: float, points: FlowPoints) -> Floats:
        model = replace(rotor.model, propeller=rotor.model.propeller.scaled(factor))
        return load_rows(rotor.with_model(model), *points[:3])[0]

    def at(points: FlowPoints) -> Floats:
        by_name = {}
        if names:
            slopes = rotor.gradients_at(names, points).slopes
            by_name = dict(zip(names, slopes.transpose(1, 0, 2), strict=True))
        if DIAMETER in wanted:
            change = grown(1.0 + GROWTH, points) - grown(1.0 - GROWTH, points)
            by_name[DIAMETER] = change / (2.0 * GROWTH)
        return np.stack([by_name[name] for name in wanted])

    return at


def _errors_of(source: Any) -> ChangesAt:
    """Return errors of one standard deviation of the loads from a source, one load at a time."""

    def at(points: FlowPoints) -> Floats:
        omega, along, across, *_ = points
        if isinstance(source, Rotor):
            rows, _ = load_rows(source, omega, along, across)
            found = list(errors_of_loads(source.model, points, rows).values())
        else:
            std = source.std(omega, np.hypot(across, along), np.arctan2(across, along))
            found = [np.stack([getattr(std, name) for name in LOADS])]
        return np.concatenate([np.eye(len(LOADS))[:, :, None] * rows for rows in found])

    return at


STEP = 1e-2
"""Steps of central differences: angles [rad], shares of squared rotor speeds and of torques, speeds
[m/s].  At isolated points, loads jump by some 1e-4 of their size, and with a much smaller step
these jumps would dominate the quotient."""

ChangesAt = Callable[[FlowPoints], Floats]  # D changes of the L loads at N points, (D, L, N)


class Responses:
    """Derivatives of steady states by the implicit function theorem: with unknowns x and unbalanced
    shares r(x, p) = 0, dx/dp = -(dr/dx)^-1 dr/dp.  dr/dx is a difference quotient.
    """

    def __init__(self, aircraft: Aircraft, states: SteadyStates) -> None:
        self.aircraft, self.count = aircraft, len(states)
        self.where = np.flatnonzero(states.found)
        every = SteadyFlight(states.speed, states.climb, states.bank)
        self.flight, balance = every.part(self.where), aircraft.balance
        attitude = states.pitch[self.where], states.roll[self.where]
        self.unknowns = balance.unknowns(*attitude, states.rotor_speed[self.where] ** 2)
        self.at = balance.evaluated(self.unknowns, self.flight)
        self._inverse, self._torque = self._by_unknowns()

    def to_flight(self, name: str) -> StateChange:
        """Return derivatives with respect to ``name``, "speed" or "climb" [m/s]."""
        ahead, behind = (
            self.aircraft.balance.evaluated(self.unknowns, self._perturbed(name, h))
            for h in (STEP, -STEP)
        )
        residual = (ahead.unbalanced - behind.unbalanced) / (2.0 * STEP)
        torque = (ahead.wrenches.torque - behind.wrenches.torque) / (2.0 * STEP)
        return self._implied(residual, torque, name)

    def to_mass(self) -> StateChange:
        """Return derivatives with respect to the mass [kg], for a constant center of mass."""
        balance = self.aircraft.balance
        specific = balance.motion(self.at.pitch, self.at.roll, self.flight)[2]
        return self._implied(balance.shares(-specific, np.zeros_like(specific)))

    def to_drag_area(self, axis: int) -> StateChange:
        """Return derivatives with respect to the drag area along ``axis`` 0, 1 or 2 [m^2]."""
        force = np.zeros_like(self.at.velocity)
        along = self.at.velocity[:, axis]
        force[:, axis] = -0.5 * self.aircraft.vehicle.air.density * np.abs(along) * along
        return self._implied(self.aircraft.balance.shares(force, np.zeros_like(force)))

    def to_each(
        self, changes: Sequence[tuple[ChangesAt, NDArray[np.intp]]], count: int
    ) -> list[StateChange]:
        """Return derivatives with respect to ``count`` changes of the loads of given rotors."""
        stores: list[tuple[ChangesAt, NDArray[np.intp], list[Floats]]] = [
            (at, which, []) for at, which in changes
        ]
        rotors, found = self.aircraft.rotors, []
        for d in range(count):
            own: Sources = [(LoadChange(at, known, d), which) for at, which, known in stores]
            change = rotors.changed(own, self.at.omega, self.at.hubs)
            force = change.force.sum(axis=-2)
            moment = rotors.moment(change.force, change.moment).sum(axis=-2)
            shares = self.aircraft.balance.shares(force, moment)
            found.append(self._implied(shares, change.torque))
        return found

    def _perturbed(self, name: str, by: Any) -> SteadyFlight:
        return self.flight._replace(**{name: getattr(self.flight, name) + by})

    def _by_unknowns(self) -> tuple[Floats, Floats]:
        """Return the inverse of dr/dx (n, u, r), and the torques' derivatives (n, k, u)."""
        n, u = self.unknowns.shape
        steps = STEP * np.concatenate([np.eye(u), -np.eye(u)])
        perturbed = self.unknowns + steps[:, None]
        flight = self.flight.part(np.tile(np.arange(n), 2 * u))
        found = self.aircraft.balance.evaluated(perturbed.reshape(-1, u), flight)

        def slopes(values: Floats) -> Floats:
            ahead, behind = values.reshape(2, u, n, values.shape[-1])
            return np.moveaxis((ahead - behind) / (2.0 * STEP), 0, -1)

        residual: Any = slopes(found.unbalanced)
        return np.linalg.pinv(residual, rcond=1e-12), slopes(found.wrenches.torque)

    def _implied(
        self, residual: Floats, torque: Floats | None = None, flown: str | None = None
    ) -> StateChange:
        """Return the response to a change.

        At constant unknowns, the change causes the unbalanced shares ``residual`` (n, u) and adds
        ``torque`` (n, k) [N m].  ``flown`` names the changed quantity of the flight, if any.
        """
        dx = -np.einsum("nur,nr->nu", self._inverse, residual)
        dq = np.einsum("nku,nu->nk", self._torque, dx)
        if torque is not None:
            dq = dq + torque
        now = self.at.wrenches.torque
        size = np.maximum(np.abs(dx).max(axis=1), (np.abs(dq) / np.abs(now)).max(axis=1))
        if flown is not None:
            size = np.maximum(size, 1.0)
        h = STEP / np.where(size > 0.0, size, 1.0)

        def at(by: Floats) -> StateChange:
            flight = self.flight if flown is None else self._perturbed(flown, by)
            unknowns, torque = self.unknowns + by[:, None] * dx, now + by[:, None] * dq
            return self._outcome(unknowns, flight, torque)

        def slope(both: list[Floats]) -> Floats:
            high, low = both
            found = np.full((self.count, *high.shape[1:]), np.nan)
            found[self.where] = (high - low) / (2.0 * h.reshape(-1, *[1] * (high.ndim - 1)))
            return found

        return _joined([at(h), at(-h)], slope)

    def _outcome(self, unknowns: Floats, flight: SteadyFlight, torque: Floats) -> StateChange:
        """Return the values of a ``StateChange`` for unknowns (n, u) and torques (n, k)."""
        aircraft, balance = self.aircraft, self.aircraft.balance
        (pitch, roll), omega = unknowns.T[:2], balance.omega(unknowns)
        hubs = balance.motion(pitch, roll, flight)[1]
        power = aircraft.vehicle.powertrain.driven(torque, omega, aircraft.charge).power
        used = aircraft.used(omega, hubs, torque)
        return StateChange(pitch, roll, omega, np.sum(torque * omega, axis=1), power, used)


# --- Changes of the loads by a parameter or by an error, as sources of loads ---------------------


class LoadChange:
    """Source of loads that returns load change number ``d``; ``known`` stores all load changes."""

    def __init__(self, at: ChangesAt, known: list[Floats], d: int) -> None:
        self.at, self.known, self.d = at, known, d

    def loads_at_velocity(self, omega: Floats, velocity: Floats) -> Any:
        """Return the change of each load by name, and a ``status``, of the shape of ``omega``."""
        if not self.known:
            across = np.hypot(velocity[:, 0], velocity[:, 1])
            self.known.append(self.at(FlowPoints(omega, velocity[:, 2], across)))
        loads = dict(zip(LOADS, self.known[0][self.d], strict=True))
        return SimpleNamespace(**loads, status=np.full(omega.shape, "ok"))
