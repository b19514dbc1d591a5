"""The flow at each rotor of a moving vehicle, and the rotors' forces and moments back on it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.loads import LOADS
from propmap.results import spin_sign
from propmap.typing import Floats
from propmap.vehicle.vectors import cross

if TYPE_CHECKING:
    from propmap.vehicle.flight_log import FlightLog
    from propmap.vehicle.vehicle import Vehicle


class HubFlow(NamedTuple):
    """Operating points of n samples of m rotors, in the vehicle's frame.

    ``omega`` [rad/s], ``axial`` = V_i cos(beta_i) and ``inplane`` = V_i sin(beta_i) >= 0 [m/s] are
    (n, m).  Unit vectors: ``axis`` (m, 3) along the thrust; ``downstream`` (n, m, 3) against the
    in-plane velocity, along the rotor drag; zero where there is none.  ``position`` (m, 3) of the
    hubs from the centre of mass [m]; ``spin`` (m,), 1 for counter-clockwise, else -1.
    """

    omega: Floats
    axial: Floats
    inplane: Floats
    axis: Floats
    downstream: Floats
    position: Floats
    spin: Floats

    @property
    def velocity(self) -> Floats:
        """Of the hubs through the air, in the vehicle's frame [m/s]; (n, m, 3)."""
        along: Floats = self.axial[..., None] * self.axis
        return along - self.inplane[..., None] * self.downstream

    def part(self, which: NDArray[np.intp] | slice) -> HubFlow:
        """Some samples."""
        return self._replace(
            omega=self.omega[which],
            axial=self.axial[which],
            inplane=self.inplane[which],
            downstream=self.downstream[which],
        )

    def moved(self, added: Floats) -> HubFlow:
        """The same with ``added`` (n, m) to the axial velocity [m/s]."""
        return self._replace(axial=self.axial + added)


def hub_flow(vehicle: Vehicle, log: FlightLog) -> HubFlow:
    """The flow at the hubs, V_i = V_vehicle + omega x r_i.

    Parameters
    ----------
    vehicle : Vehicle
        Where its m rotors are.
    log : FlightLog
        n samples of its motion.

    Returns
    -------
    HubFlow
        ``omega`` [rad/s], ``axial`` and ``inplane`` velocity [m/s], shape (n, m), and the
        directions of thrust and drag.
    """
    return hub_flow_at(vehicle, log.rotor_speed, log.velocity, log.rates)


def hub_flow_at(vehicle: Vehicle, omega: Floats, velocity: Floats, rates: Floats) -> HubFlow:
    """The same of motions that are in no log.

    Parameters
    ----------
    vehicle : Vehicle
        Where its m rotors are.
    omega : ndarray, shape (n, m)
        Rotor speeds [rad/s].
    velocity, rates : ndarray, shape (n, 3)
        Of the centre of mass through the air [m/s], and of turning [rad/s], in its frame.
    """
    position = np.array([mount.position for mount in vehicle.mounts])
    return flow_of_hubs(vehicle, omega, velocity[:, None] + cross(rates[:, None], position))


def flow_of_hubs(vehicle: Vehicle, omega: Floats, hubs: Floats) -> HubFlow:
    """The same of hubs whose velocities are known.

    Parameters
    ----------
    vehicle : Vehicle
        Where its m rotors are.
    omega : ndarray, shape (n, m)
        Rotor speeds [rad/s].
    hubs : ndarray, shape (n, m, 3)
        Velocities of the hubs through the air, in the vehicle's frame [m/s].
    """
    position = np.array([mount.position for mount in vehicle.mounts])
    axis = np.array([mount.axis for mount in vehicle.mounts])
    spin = np.array([spin_sign(mount.spin) for mount in vehicle.mounts])
    axial = np.sum(hubs * axis, axis=-1)
    across = hubs - axial[..., None] * axis
    inplane = np.linalg.norm(across, axis=-1)
    still = inplane < 1e-12
    downstream = -across / np.where(still, 1.0, inplane)[..., None]
    inplane = np.where(still, 0.0, inplane)
    return HubFlow(omega, axial, inplane, axis, downstream, position, spin)


def rotor_forces(flow: HubFlow, thrust: Floats, drag: Floats) -> Floats:
    """Sum of the rotors' forces on the vehicle [N], (..., n, 3), from loads (..., n, m) [N]."""
    along = np.einsum("...nm,mk->...nk", thrust, flow.axis)
    return along + np.einsum("...nm,nmk->...nk", drag, flow.downstream)


def hub_wrenches(flow: HubFlow, loads: Floats) -> tuple[Floats, Floats]:
    """Force [N] and moment about its hub [N m] of each rotor on the vehicle, in its frame.

    They are linear in the loads: derivatives of these give derivatives of forces and moments.

    Parameters
    ----------
    flow : HubFlow
        Of n samples of m rotors.
    loads : ndarray, shape (L, ..., n, m)
        In the order of ``LOADS`` [N], [N m].

    Returns
    -------
    tuple of ndarray, shape (..., n, m, 3)
        Forces and moments.
    """
    by_name = dict(zip(LOADS, loads[..., None], strict=True))
    ahead = -flow.downstream
    left, spin = cross(flow.axis, ahead), flow.spin[:, None]
    force = by_name["thrust"] * flow.axis - by_name["drag"] * ahead
    force = force + spin * by_name["side_force"] * left
    turning = by_name["torque"] * flow.axis + by_name["roll_moment"] * ahead
    return force, -spin * turning - by_name["pitch_moment"] * left


def rotor_wrench(flow: HubFlow, loads: Floats) -> tuple[Floats, Floats]:
    """Force [N] of all rotors on the vehicle and their moment about its centre of mass [N m].

    Parameters
    ----------
    flow, loads : HubFlow, ndarray
        As for ``hub_wrenches``.

    Returns
    -------
    tuple of ndarray, shape (..., n, 3)
        Force and moment, arms included.
    """
    force, moment = hub_wrenches(flow, loads)
    return force.sum(axis=-2), (moment + cross(flow.position, force)).sum(axis=-2)
