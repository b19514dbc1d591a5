"""Loads of a rotor with their independent errors, for what is computed from several of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.model.section_covariance import SectionCovariance
from propmap.operating_points import FlowPoints, split_velocity
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.vehicle.mounted_rotors import mounted_rotors
from propmap.vehicle.vehicle import Vehicle

if TYPE_CHECKING:
    from propmap.table.query import LoadTable

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
