"""The rotors of a vehicle as force and moment on it, from a rotor, a table or the hover model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.errors import InputError
from propmap.results import hub_wrench, spin_sign
from propmap.rotor import Rotor
from propmap.vehicle.mounted_rotors import mounted_rotors
from propmap.vehicle.vehicle import Vehicle

if TYPE_CHECKING:
    from propmap.table.query import LoadTable


FORWARD = 0.5
"""Upward part of the rotors' mean axis below which they pull forward."""


class LoadSource(Protocol):
    """What gives loads for a velocity in the rotor frame, as ``Rotor`` and ``LoadTable`` do."""

    def loads_at_velocity(self, omega: Any, velocity: Any) -> Any:
        """Loads with a ``status``."""
        ...


class RotorWrenches(NamedTuple):
    """What k rotors do at (...) states.

    Attributes
    ----------
    force, moment : ndarray, shape (..., k, 3)
        On the vehicle at the hub, in its frame [N], [N m].
    thrust, torque : ndarray, shape (..., k)
        [N], [N m].
    status : ndarray of str, shape (..., k)
        Of the loads.
    """

    force: Floats
    moment: Floats
    thrust: Floats
    torque: Floats
    status: NDArray[np.str_]

    def first(self, count: int) -> RotorWrenches:
        """The first ``count`` states."""
        return RotorWrenches(*(array[:count] for array in self))  # type: ignore[arg-type]


class Rotors:
    """All rotors of a vehicle.

    Parameters
    ----------
    vehicle : Vehicle
        Where they are.
    sources : list of (LoadSource, ndarray of int)
        What gives the loads of which rotors.
    """

    def __init__(
        self, vehicle: Vehicle, sources: list[tuple[LoadSource, NDArray[np.intp]]]
    ) -> None:
        mounts = vehicle.mounts
        self.sources = sources
        self.position = np.array([mount.position for mount in mounts])
        self.axis = np.array([mount.axis for mount in mounts])
        self.spin = np.array([spin_sign(mount.spin) for mount in mounts])
        self.frame = np.stack([_frame(axis) for axis in self.axis])
        self.radius = vehicle.propeller.radius

    def __len__(self) -> int:
        return len(self.spin)

    @property
    def forward(self) -> bool:
        """Whether they pull forward rather than up."""
        return float(self.axis[:, 2].mean()) < FORWARD

    @classmethod
    def of(cls, vehicle: Vehicle, loads: Rotor | LoadTable) -> Rotors:
        """The rotors with loads from a ``Rotor``, of whose model they are, or from a table.

        Raises
        ------
        InputError
            Where the propeller or the air is another than the vehicle's, or the rotors are in each
            other's wakes.
        """
        if vehicle.wakes is not None:
            raise InputError(
                "[wakes] is given, and in steady states the rotors do not act on each other",
                "remove the table [wakes]: fits, checks and simulated flights know of it",
            )
        everyone = np.arange(len(vehicle.mounts))
        if not isinstance(loads, Rotor):
            _check_table(vehicle, loads)
            return cls(vehicle, [(loads, everyone)])
        model = loads.model
        if model.propeller != vehicle.propeller or model.air != vehicle.air:
            raise InputError(
                "the rotor has another propeller or air than the vehicle",
                "give Rotor(Model(vehicle.propeller, airfoil, vehicle.air))",
            )
        return cls(
            vehicle, [(loads.with_model(own), k) for own, k in mounted_rotors(vehicle, model)]
        )

    def moment(self, force: Floats, moment: Floats) -> Floats:
        """About the centre of mass, (..., k, 3) [N m], of what acts at the hubs."""
        return moment + np.cross(self.position, force)

    def wrenches(self, omega: Floats, velocity: Floats) -> RotorWrenches:
        """Force and moment of each rotor.

        Parameters
        ----------
        omega : ndarray, shape (..., k)
            [rad/s].
        velocity : ndarray, shape (..., k, 3)
            Of the hubs through the air, in the vehicle's frame [m/s].
        """
        force, moment = np.empty(velocity.shape), np.empty(velocity.shape)
        thrust, torque = np.empty(omega.shape), np.empty(omega.shape)
        status = np.empty(omega.shape, dtype="<U16")
        seen = np.einsum("kij,...ki->...kj", self.frame, velocity)
        for source, mine in self.sources:
            turning, moving = omega[..., mine], seen[..., mine, :]
            # Half the rotors of a symmetric vehicle see what the other half sees.
            points = np.concatenate([turning[..., None], moving], axis=-1).reshape(-1, 4)
            once, where = _apart(points)
            found = source.loads_at_velocity(once[:, 0], once[:, 1:])
            across = np.hypot(once[:, 1], once[:, 2])
            direction = np.zeros((len(once), 3))
            direction[:, 0] = 1.0
            some = across > 0.0
            direction[some, :2] = once[some, 1:3] / across[some, None]
            sign = self.spin[mine]
            for turn in (1.0, -1.0):
                wrench = hub_wrench(found, direction, turn)
                kept = np.flatnonzero(sign == turn)
                if not kept.size:
                    continue
                which = where.reshape(turning.shape)[..., kept]
                frame = self.frame[mine[kept]]
                for target, vector in ((force, wrench.force), (moment, wrench.moment)):
                    target[..., mine[kept], :] = np.einsum("kij,...kj->...ki", frame, vector[which])
            which = where.reshape(turning.shape)
            thrust[..., mine], torque[..., mine] = found.thrust[which], found.torque[which]
            status[..., mine] = np.asarray(found.status)[which]
        return RotorWrenches(force, moment, thrust, torque, status)


def _apart(points: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """The distinct rows of points (n, 4), but for rounding, and which of them each one is."""
    size = np.maximum(np.abs(points).max(axis=0, initial=0.0), 1e-30)
    rounded = np.round(points / size, 11) + 0.0
    _, first, where = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    return points[first], where.ravel()


def _frame(axis: Floats) -> Floats:
    """Columns x, y, z of a right-handed rotor frame with z along ``axis`` (3,)."""
    nearest = np.array([1.0, 0.0, 0.0]) if abs(axis[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = nearest - np.dot(nearest, axis) * axis
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis], axis=1)


def _check_table(vehicle: Vehicle, table: LoadTable) -> None:
    described = table.info["propeller"]
    if described.get("geometry_sha256") != vehicle.propeller.fingerprint():
        raise InputError(
            f"the table is of {described.get('name')!r}, the vehicle has "
            f"{vehicle.propeller.name!r}, or the same with another geometry",
            "build a table for this propeller",
        )
    if abs(table.content.density - vehicle.air.density) > 1e-6 * vehicle.air.density:
        raise InputError(
            f"the table holds for {table.content.density:g} kg/m^3, the vehicle flies in "
            f"{vehicle.air.density:g}",
            "build a table with --rho, or change [air]",
        )
    if any(mount.drag is not None for mount in vehicle.mounts):
        raise InputError(
            "the vehicle file has [mount], of which a table knows nothing",
            "leave out [mount] and build the table with --correction mount-drag:area_m2=...",
        )
