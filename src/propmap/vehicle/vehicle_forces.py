"""Force and moment of the air on a whole vehicle: rotors on their mounts, body and wing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propmap.errors import InputError
from propmap.operating_points import broadcast, rates_of
from propmap.typing import Floats
from propmap.vehicle.free_stream_force import body_force, wing_force
from propmap.vehicle.load_sources import LoadSource, worst
from propmap.vehicle.rotors import Rotors

if TYPE_CHECKING:
    from propmap.vehicle.vehicle import Vehicle


@dataclass(frozen=True, eq=False)
class VehicleWrench:
    """Force and moment of the air on a vehicle of k rotors at (...) states, in its frame.

    Weight, and what spinning rotors do to a vehicle that turns, are not among them.

    Attributes
    ----------
    force, moment : ndarray, shape (..., 3)
        [N], and about the centre of mass [N m]; NaN where a rotor's loads were not found.
    status : ndarray of str, shape (...)
        The worst of the rotors', in the words of ``propmap.Loads`` or of a table's loads.
    rotor_force, rotor_moment : ndarray, shape (..., k, 3)
        Of each rotor with its mount [N], and about the centre of mass [N m].
    body_force, wing_force : ndarray, shape (..., 3)
        [N], at the centre of mass; zero where there is none.
    thrust, torque : ndarray, shape (..., k)
        Of each rotor [N], [N m].
    added_flow : ndarray, shape (..., k)
        What the wakes of the other rotors add to V cos(beta) [m/s]; zero without [wakes].
    rotor_status : ndarray of str, shape (..., k)
        Of each rotor.
    power : ndarray, shape (...)
        Of all shafts, the sum of torque times omega [W].
    """

    force: Floats
    moment: Floats
    status: NDArray[np.str_]
    rotor_force: Floats
    rotor_moment: Floats
    body_force: Floats
    wing_force: Floats
    thrust: Floats
    torque: Floats
    added_flow: Floats
    rotor_status: NDArray[np.str_]
    power: Floats


class VehicleForces:
    """A vehicle with the loads of its rotors, ready to give force and moment of the air on it.

    Parameters
    ----------
    vehicle : Vehicle
        From ``propmap.read_vehicle(path).vehicle``.  Its rotors are in each other's wakes where it
        has ``wakes``.
    loads : Rotor or LoadTable
        Of its rotors, or what else has ``loads_at_velocity``.

    Raises
    ------
    InputError
        Where the loads are of another propeller or air than the vehicle's, where a table's rotors
        have mounts, and where two rotors in each other's wakes are in one place.
    """

    def __init__(self, vehicle: Vehicle, loads: LoadSource) -> None:
        self.vehicle = vehicle
        self._rotors = Rotors.of(vehicle, loads)

    def wrench(
        self,
        omegas: ArrayLike,
        velocity: ArrayLike,
        rates: ArrayLike = (0.0, 0.0, 0.0),
        wind: ArrayLike = (0.0, 0.0, 0.0),
    ) -> VehicleWrench:
        """Force and moment of the air on the vehicle.

        All vectors are in the vehicle's frame: x forward, y left, z up.  Leading axes broadcast.

        Parameters
        ----------
        omegas : array_like, shape (..., k)
            Speeds of the k rotors, in the order of the vehicle's mounts [rad/s], >= 0.
        velocity : array_like, shape (..., 3)
            Of the centre of mass over the ground [m/s].
        rates : array_like, shape (..., 3)
            Of turning [rad/s].
        wind : array_like, shape (..., 3)
            Velocity of the air over the ground [m/s], uniform; a wind that is known in the world's
            frame has to be turned into the vehicle's.

        Raises
        ------
        InputError
            For other shapes, for negative rotor speeds, and for what is not finite.
        """
        k = len(self._rotors)
        omega = _last_axis("omegas", rates_of("omegas", omegas), k, f"speeds of the {k} rotors")
        vectors = {"velocity": velocity, "rates": rates, "wind": wind}
        given = [
            _last_axis(name, broadcast(**{name: vector})[0], 3, "x, y, z")
            for name, vector in vectors.items()
        ]
        shape = _leading({"omegas": omega, **dict(zip(vectors, given, strict=True))})
        omega = np.broadcast_to(omega, (*shape, k))
        moving, turning, air = (np.broadcast_to(vector, (*shape, 3)) for vector in given)
        through = moving - air
        hubs = through[..., None, :] + np.cross(turning[..., None, :], self._rotors.position)
        found = self._rotors.wrenches(omega, hubs)
        moment = self._rotors.moment(found.force, found.moment)
        vehicle, density = self.vehicle, self.vehicle.air.density
        body, wing = body_force(vehicle.body, density, through), np.zeros_like(through)
        if vehicle.wing is not None:
            wing = wing_force(vehicle.wing, density, through)
        return VehicleWrench(
            force=found.force.sum(axis=-2) + body + wing,
            moment=moment.sum(axis=-2),
            status=worst(found.status),
            rotor_force=found.force,
            rotor_moment=moment,
            body_force=body,
            wing_force=wing,
            thrust=found.thrust,
            torque=found.torque,
            added_flow=found.added_flow,
            rotor_status=found.status,
            power=np.sum(found.torque * omega, axis=-1),
        )


def _last_axis(name: str, array: Floats, count: int, what: str) -> Floats:
    if array.ndim == 0 or array.shape[-1] != count:
        raise InputError(f"{name} has shape {array.shape}", f"its last axis must hold the {what}")
    return array


def _leading(arrays: dict[str, Floats]) -> tuple[int, ...]:
    try:
        return np.broadcast_shapes(*(array.shape[:-1] for array in arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise InputError(
            f"shapes do not fit together: {shapes}", "all axes but the last must broadcast"
        ) from None
