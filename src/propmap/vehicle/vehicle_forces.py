"""Force and moment of the air on a whole vehicle: rotors on their mounts, body and wing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propmap.errors import InputError
from propmap.model.airfoil import Airfoil
from propmap.operating_points import broadcast, rates_of
from propmap.typing import Floats
from propmap.vehicle.rotors import LoadSource, Rotors, worst

if TYPE_CHECKING:
    from propmap.vehicle.vehicle import Body, Vehicle, Wing


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
        vectors = {"velocity": velocity, "rates": rates, "wind": wind}
        given = {"omegas": rates_of("omegas", omegas)}
        given |= {name: broadcast(**{name: vector})[0] for name, vector in vectors.items()}
        for name, array in given.items():
            count, what = (3, "x, y, z") if name in vectors else (k, f"speeds of the {k} rotors")
            if array.ndim == 0 or array.shape[-1] != count:
                raise InputError(
                    f"{name} has shape {array.shape}", f"its last axis must hold the {what}"
                )
        try:
            shape = np.broadcast_shapes(*(array.shape[:-1] for array in given.values()))
        except ValueError:
            shapes = ", ".join(f"{name} {array.shape}" for name, array in given.items())
            raise InputError(
                f"shapes do not fit together: {shapes}", "all axes but the last must broadcast"
            ) from None
        omega, moving, turning, air = (
            np.broadcast_to(array, (*shape, array.shape[-1])) for array in given.values()
        )
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


# -------------------------------------------------------------------------------------------------
# Force of a body and a wing in the free stream: section III.A and footnote 4 of the paper.


def free_stream_force(body: Body, wing: Wing | None, density: float, velocity: Floats) -> Floats:
    """Return the force of body and wing [N] at a ``velocity`` (..., 3) through the air [m/s].

    Both are in the vehicle's frame; ``density`` is that of the air [kg/m^3].
    """
    force = body_force(body, density, velocity)
    return force if wing is None else force + wing_force(wing, density, velocity)


def body_force(body: Body, density: float, velocity: Floats) -> Floats:
    """Return drag, lift and download of a ``body``, as in ``free_stream_force``."""
    angle, speed, across = _in_plane_of_symmetry(velocity)
    lift = body.lift_area * np.sin(angle) * np.cos(angle)
    drag = 0.5 * density * np.array(body.drag_area) * np.abs(velocity) * velocity
    pressed = np.square(velocity[..., :2]) @ np.array(body.download_area)
    down = 0.5 * density * pressed[..., None] * np.array([0.0, 0.0, 1.0])
    return np.asarray((0.5 * density * lift * speed)[..., None] * across - drag - down)


def wing_force(wing: Wing, density: float, velocity: Floats) -> Floats:
    """Return lift of a ``wing`` and its induced drag, as in ``free_stream_force``."""
    angle, speed, across = _in_plane_of_symmetry(velocity)
    lift = wing_lift(wing, angle + wing.incidence)
    force = lift[..., None] * across
    if wing.span is not None:
        # Prandtl's D = L^2/(pi q b^2), of an elliptic lift.
        along = velocity * np.array([1.0, 0.0, 1.0])
        force = force - (lift**2 / (math.pi * wing.span**2))[..., None] * along
    return np.asarray((0.5 * density * speed)[..., None] * force)


def wing_lift(wing: Wing, angle: Floats) -> Floats:
    """Return lift over dynamic pressure [m^2] of a ``wing`` at an ``angle`` of attack [rad]."""
    section = Airfoil(c_l1=wing.c_l1, c_l2=wing.c_l2, c_d=0.0, alpha_0=wing.alpha_0)
    lift, _ = section.coefficients(angle, 1.0)  # eq. (3), which does not depend on Re
    return wing.area * lift


def _in_plane_of_symmetry(velocity: Floats) -> tuple[Floats, Floats, Floats]:
    """Return angle of attack [rad], speed V [m/s], and V times the unit vector across the flow.

    That is (-v_z, 0, v_x)/V; the angle is positive where the air comes from below.
    """
    x, z = velocity[..., 0], velocity[..., 2]
    angle = np.arctan2(-z, x)
    return angle, np.hypot(x, z), np.stack([-z, np.zeros_like(angle), x], axis=-1)
