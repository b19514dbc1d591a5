"""Drag of what is mounted in a rotor's slipstream: a motor, a stand, an arm."""

from __future__ import annotations

from typing import NamedTuple

from propmap.arrays.namespace import Array
from propmap.physics.velocities import floored_norm


class Mounted(NamedTuple):
    """What is mounted in a rotor's slipstream, as arrays; a pytree.

    Attributes
    ----------
    area : Array
        Drag coefficient times area across the flow [m^2].
    wake : Array
        Inflow where it is mounted over that at the disk, k [-].
    """

    area: Array
    wake: Array

    def drag(self, density: Array, v_axial: Array, v_inplane: Array, inflow: Array) -> Array:
        """D = 1/2 rho f V_inplane sqrt(V_inplane^2 + (V_axial + k v_i)^2).

        It is the part in the disk plane of a drag along the air's velocity, so that the slipstream
        raises it: in slow flight it grows with the in-plane velocity itself, not with its square.

        Parameters
        ----------
        density : Array
            rho [kg/m^3].
        v_axial, v_inplane : Array, shape (B,)
            V cos(beta) and V sin(beta) [m/s].
        inflow : Array, shape (B,)
            v_i averaged over the disk's area [m/s].

        Returns
        -------
        Array, shape (B,)
            [N], against the in-plane velocity.
        """
        speed = floored_norm(v_inplane, v_axial + self.wake * inflow)
        return 0.5 * density * self.area * v_inplane * speed
