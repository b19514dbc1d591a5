"""How sure steady states are, and how they change with the loads and with a designer's choices."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.aircraft.trim import Aircraft, Balanced, Flight, SteadyStates
from propmap.errors import InputError
from propmap.loads import FLOW, LOADS
from propmap.model.airfoil import SectionCovariance
from propmap.operating_points import FlowPoints
from propmap.rotor import Rotor, errors_of_loads
from propmap.table.query import LoadTable
from propmap.typing import Floats
from propmap.vehicle.rotors import LoadSource, Rotors

# -------------------------------------------------------------------------------------------------
# How sure steady states are, and their derivatives by what a designer may choose.

FLIGHT = ("speed", "climb")
AREAS = ("drag_area_x", "drag_area_y", "drag_area_z")
VEHICLE = (*FLIGHT, "mass", *AREAS)
"""What steady states can be differentiated by, besides the constants of the section law and
``GEOMETRY``: [m/s], [kg], [m^2]."""

DIAMETER, GROWTH = "diameter_scale", 0.01
"""A common factor on radius and chord, and the step of its differences."""

SCALES = {"chord_scale": 0.2, "twist_offset": 0.1}
"""Of the steps of differences, by parameter; else the constant itself."""


class Spread(NamedTuple):
    """Standard deviations of n steady states of k rotors; NaN where there is no state.

    Attributes
    ----------
    pitch, roll : ndarray, shape (n,)
        [rad].
    rotor_speed : ndarray, shape (n, k)
        [rad/s].
    shaft_power, electrical_power : ndarray, shape (n,)
        [W].
    used : dict of str to ndarray, shape (n,)
        Of the shares of limits.
    """

    pitch: Floats
    roll: Floats
    rotor_speed: Floats
    shaft_power: Floats
    electrical_power: Floats
    used: dict[str, Floats]

    @property
    def power(self) -> Floats:
        """Of the electrical power where it is known, else of the shaft power [W], (n,)."""
        return np.where(np.isfinite(self.electrical_power), self.electrical_power, self.shaft_power)


def derivatives(
    aircraft: Aircraft, states: SteadyStates, names: Iterable[str]
) -> dict[str, Response]:
    """Derivatives of steady states; the attitude and the rotor speeds follow each change.

    Those of the loads by the flow, by constants and by chord and twist are the rotor's own, and by
    the flow those of a table; by the diameter they are differences.

    Parameters
    ----------
    aircraft, states : Aircraft, SteadyStates
        What flies, and n states of it.
    names : iterable of str
        Of ``VEHICLE``, of the section law's constants such as "c_l1", and "chord_scale" [-], a
        common factor on the chord, "twist_offset" [rad], added to the twist, and "diameter_scale"
        [-], a common factor on radius and chord.

    Returns
    -------
    dict of str to Response
        By name, per unit.

    Raises
    ------
    InputError
        For another name, a constant where loads come from a table, and the diameter of rotors in
        each other's wakes.
    """
    wanted = list(names)
    own = tuple(name for name in wanted if name not in VEHICLE)
    responses = Responses(aircraft, states, exact=True)
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


def power_gradient(
    aircraft: Aircraft, states: SteadyStates, names: Iterable[str]
) -> dict[str, Floats]:
    """Derivatives of the power, electrical where it is known, else of the shafts.

    Parameters
    ----------
    aircraft, states, names : Aircraft, SteadyStates, iterable of str
        As for ``derivatives``.

    Returns
    -------
    dict of str to ndarray, shape (n,)
        [W] per unit; NaN where there is no state.

    Raises
    ------
    InputError
        As ``derivatives``.
    """
    electric = np.isfinite(states.electrical_power)
    return {
        name: np.where(electric, by.electrical_power, by.shaft_power)
        for name, by in derivatives(aircraft, states, names).items()
    }


def spread(aircraft: Aircraft, states: SteadyStates) -> Spread | None:
    """Standard deviations of steady states; None where nothing is known of the loads' errors.

    To first order, from those of the loads by their sources, see ``propmap.Loads.std_by_source``,
    which are alike at all rotors.  Constants of the section law vary together by their covariance;
    errors of the model and of the tunnel are independent from load to load.  Of a table the errors
    of all its loads are taken to be so.

    Parameters
    ----------
    aircraft, states : Aircraft, SteadyStates
        What flies, and n states of it.
    """
    if not states.found.any() or not all(map(_known, _sources(aircraft))):
        return None
    responses = Responses(aircraft, states)
    covariance = _covariance(aircraft)
    names = covariance.names if covariance is not None else ()
    constants = _to_parameters(responses, names) if names else []
    errors = _to_errors(responses)

    def deviation(values: Any) -> Floats:
        variance: Any = sum(np.square(values(one)) for one in errors)
        if covariance is not None and constants:
            each = np.stack([values(one) for one in constants])
            variance = variance + np.einsum("p...,pq,q...->...", each, covariance.matrix, each)
        return np.asarray(np.sqrt(np.maximum(variance, 0.0)))

    every: list[Any] = [
        deviation(lambda one, name=name: getattr(one, name)) for name in Spread._fields[:-1]
    ]
    every.append(
        {name: deviation(lambda one, name=name: one.used[name]) for name in errors[0].used}
    )
    return Spread(*every)


def _sources(aircraft: Aircraft) -> list[Any]:
    return [source for source, _ in aircraft.rotors.sources]


def _known(source: Any) -> bool:
    if isinstance(source, Rotor):
        return source.model.uncertainty is not None
    return isinstance(source, LoadTable) and source.content.deviations is not None


def _covariance(aircraft: Aircraft) -> SectionCovariance | None:
    first = _sources(aircraft)[0]
    known = first.model.uncertainty if isinstance(first, Rotor) else None
    return None if known is None else known.covariance.determined


def _to_parameters(responses: Responses, names: tuple[str, ...]) -> list[Response]:
    """By constants of the section law and geometry."""
    if DIAMETER in names and responses.aircraft.vehicle.wakes is not None:
        raise InputError(
            f"there is no derivative by {DIAMETER!r} where rotors are in each other's wakes",
            "leave [wakes] out for it: Vehicle(..., wakes=None)",
        )
    changes = []
    for source, which in responses.aircraft.rotors.sources:
        if not isinstance(source, Rotor):
            raise InputError(
                f"there is no derivative by {names[0]!r}: the loads are from a table",
                f"give the aircraft a Rotor, or names of {', '.join(VEHICLE)}",
            )
        known = (*(name for name in source.parameters if name not in FlowPoints._fields), DIAMETER)
        unknown = [name for name in names if name not in known]
        if unknown:
            raise InputError(
                f"there is no derivative by {unknown[0]!r}",
                f"choose from {', '.join((*VEHICLE, *known))}",
            )
        changes.append((LoadChanges(_slopes_of(source, names)), which))
    return _each(responses, changes, len(names))


def _slopes_of(rotor: Rotor, wanted: tuple[str, ...]) -> Any:
    names = tuple(name for name in wanted if name != DIAMETER)

    def at(points: FlowPoints) -> Floats:
        by_name = {}
        if names:
            slopes = rotor.gradients_at(names, points).slopes
            by_name = dict(zip(names, slopes.transpose(1, 0, 2), strict=True))
        if DIAMETER in wanted:
            by_name[DIAMETER] = _by_diameter(rotor, points)
        return np.stack([by_name[name] for name in wanted])

    return at


def _by_diameter(rotor: Rotor, points: FlowPoints) -> Floats:
    """Derivatives (L, N) of the loads by a common factor on radius and chord."""
    omega, along, across, _ = points
    velocity = np.stack([across, np.zeros_like(across), along], axis=1)
    rows = []
    for factor in (1.0 + GROWTH, 1.0 - GROWTH):
        blade = rotor.model.propeller.scaled(factor)
        loads = rotor.with_model(replace(rotor.model, propeller=blade)).loads_at_velocity(
            omega, velocity
        )
        rows.append(np.stack([getattr(loads, name) for name in LOADS]))
    return (rows[0] - rows[1]) / (2.0 * GROWTH)


def _to_errors(responses: Responses) -> list[Response]:
    """By errors of each load, of one standard deviation."""
    changes, count = [], 0
    for source, which in responses.aircraft.rotors.sources:
        at = _errors_of(source)
        changes.append((LoadChanges(at), which))
    first: Any = _sources(responses.aircraft)[0]
    known = first.model.uncertainty if isinstance(first, Rotor) else None
    count = len(LOADS) * (1 if known is None or not known.another_tunnel else 2)
    return _each(responses, changes, count)


def _errors_of(source: Any) -> Any:
    def at(points: FlowPoints) -> Floats:
        omega, along, across, _ = points
        if isinstance(source, Rotor):
            loads = source.loads_at_velocity(
                omega, np.stack([across, np.zeros_like(across), along], axis=1)
            )
            rows = np.stack([getattr(loads, name) for name in LOADS])
            found = list(errors_of_loads(source.model, points, rows).values())
        else:
            std = source.std(omega, np.hypot(across, along), np.arctan2(across, along))
            found = [np.stack([getattr(std, name) for name in LOADS])]
        # One load at a time.
        return np.concatenate([np.eye(len(LOADS))[:, :, None] * rows for rows in found])

    return at


def _each(
    responses: Responses, changes: list[tuple[LoadChanges, Any]], count: int
) -> list[Response]:
    return [
        responses.to_loads([(one.number(d), which) for one, which in changes]) for d in range(count)
    ]


# -------------------------------------------------------------------------------------------------
# How steady states change, to first order, with what they rest on.

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


# -------------------------------------------------------------------------------------------------
# Changes of a rotor's loads, where loads are wanted: by a parameter, or by an error of theirs.

ChangesAt = Callable[[FlowPoints], Floats]
"""D changes of the L loads at N operating points, (D, L, N)."""


class LoadChanges:
    """Several changes of the loads at one set of operating points, computed once.

    Parameters
    ----------
    at : callable
        See ``ChangesAt``.
    """

    def __init__(self, at: ChangesAt) -> None:
        self._at = at
        self._known: Floats | None = None

    def number(self, d: int) -> LoadChange:
        """Change number ``d`` where a source of loads is wanted."""
        return LoadChange(self, d)

    def rows(self, d: int, points: FlowPoints) -> Floats:
        """Change number ``d`` (L, N) at N ``points``, the same at every call."""
        if self._known is None:
            self._known = self._at(points)
        return np.asarray(self._known[d])


class LoadChange:
    """One of several changes as a source of loads.

    Parameters
    ----------
    changes : LoadChanges
        All of them.
    d : int
        Which.
    """

    def __init__(self, changes: LoadChanges, d: int) -> None:
        self.changes, self.d = changes, d

    def loads_at_velocity(self, omega: Floats, velocity: Floats) -> Any:
        """The change by the loads' names and a ``status``, of the shape of ``omega`` [rad/s]."""
        across = np.hypot(velocity[:, 0], velocity[:, 1])
        rows = self.changes.rows(self.d, FlowPoints(omega, velocity[:, 2], across))
        by_name = dict(zip(LOADS, rows, strict=True))
        return SimpleNamespace(**by_name, status=np.full(omega.shape, "ok"))


# -------------------------------------------------------------------------------------------------
# Loads to first order about operating points, by derivatives that need no differences.


def has_slopes(source: Any) -> bool:
    """Whether the loads of a ``source`` have exact derivatives by the flow.

    A rotor has, by the implicit function theorem, and a table; the hover model has not.
    """
    return isinstance(source, Rotor | LoadTable)


class LocalLoads:
    """Loads that are linear in rotor speed and in the velocity along and across the axis.

    They are linear about the operating points of the first call; a later one is about the nearest
    of these.  Where there is no velocity across the axis, drag and moments by it grow in whichever
    direction it does.

    Parameters
    ----------
    source : Rotor or LoadTable
        Has slopes, see ``has_slopes``.
    """

    def __init__(self, source: Any) -> None:
        self._source = source
        self._points = np.empty((3, 0))
        self._loads = np.empty((len(LOADS), 0))
        self._slopes = np.empty((len(LOADS), 3, 0))

    def loads_at_velocity(self, omega: Floats, velocity: Floats) -> Any:
        """Loads by name and a ``status``, of the shape of ``omega`` [rad/s]."""
        points = np.stack([omega, velocity[:, 2], np.hypot(velocity[:, 0], velocity[:, 1])])
        if not self._points.size:
            self._points = points
            self._loads, self._slopes = _loads_and_slopes(self._source, points)
        size = np.maximum(np.abs(self._points).max(axis=1), 1e-9)[:, None, None]
        apart = (points[:, :, None] - self._points[:, None]) / size
        k = np.argmin(np.sum(apart**2, axis=0), axis=1)
        change = points - self._points[:, k]
        rows = self._loads[:, k] + np.einsum("lpn,pn->ln", self._slopes[:, :, k], change)
        return SimpleNamespace(
            **dict(zip(LOADS, rows, strict=True)), status=np.full(omega.shape, "ok")
        )


def _loads_and_slopes(source: Any, points: Floats) -> tuple[Floats, Floats]:
    """Loads (L, N) at N points (3, N), and their derivatives (L, 3, N) by ``FLOW``."""
    if isinstance(source, Rotor):
        found = source.gradients(FLOW, *points)
        return found.loads, found.slopes
    omega, along, across = points
    velocity = np.stack([across, np.zeros_like(across), along], axis=1)
    loads = source.loads_at_velocity(omega, velocity)
    slopes = source.gradient_at_velocity(omega, velocity)
    each = np.stack([getattr(slopes, name) for name in LOADS])
    return np.stack([getattr(loads, name) for name in LOADS]), each[:, :, [0, 3, 1]].swapaxes(1, 2)
