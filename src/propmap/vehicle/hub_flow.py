"""The flow at each rotor of a moving vehicle, and the rotors' forces back on it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from propmap.arrays.types import Floats
from propmap.vehicle.flight_log import FlightLog
from propmap.vehicle.vehicle import Vehicle


class HubFlow(NamedTuple):
    """Operating points of n samples of m rotors, in the vehicle's frame.

    ``omega`` [rad/s], ``axial`` = V_i cos(beta_i) and ``inplane`` = V_i sin(beta_i) >= 0 [m/s] are
    (n, m).  Unit vectors: ``axis`` (m, 3) along the thrust; ``downstream`` (n, m, 3) against the
    in-plane velocity, along the rotor drag.
    """

    omega: Floats
    axial: Floats
    inplane: Floats
    axis: Floats
    downstream: Floats

    @property
    def velocity(self) -> Floats:
        """Of the hubs through the air, in the vehicle's frame [m/s]; (n, m, 3)."""
        along: Floats = self.axial[..., None] * self.axis
        return along - self.inplane[..., None] * self.downstream


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
    position = np.array([mount.position for mount in vehicle.mounts])
    axis = np.array([mount.axis for mount in vehicle.mounts])
    velocity = log.velocity[:, None, :] + np.cross(log.rates[:, None, :], position[None])
    axial = np.sum(velocity * axis, axis=-1)
    across = velocity - axial[..., None] * axis
    inplane = np.linalg.norm(across, axis=-1)
    still = inplane < 1e-12
    downstream = -across / np.where(still, 1.0, inplane)[..., None]
    return HubFlow(log.rotor_speed, axial, np.where(still, 0.0, inplane), axis, downstream)


def rotor_forces(flow: HubFlow, thrust: Floats, drag: Floats) -> Floats:
    """Sum of the rotors' forces on the vehicle [N], (..., n, 3), from loads (..., n, m) [N]."""
    along = np.einsum("...nm,mk->...nk", thrust, flow.axis)
    return along + np.einsum("...nm,nmk->...nk", drag, flow.downstream)
