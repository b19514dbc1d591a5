"""How sure steady states are, and their derivatives by what a designer may choose."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from propmap.aircraft.load_changes import LoadChanges
from propmap.aircraft.response import Response, Responses
from propmap.aircraft.steady import Aircraft
from propmap.aircraft.steady_states import SteadyStates
from propmap.bands import errors_of_loads
from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.model.section_covariance import SectionCovariance
from propmap.operating_points import FlowPoints
from propmap.rotor import Rotor
from propmap.table.query import LoadTable
from propmap.typing import Floats

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
