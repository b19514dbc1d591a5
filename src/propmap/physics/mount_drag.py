"""Drag of what is mounted in a rotor's slipstream: a motor, a stand, an arm."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from propmap.arrays.namespace import Array
from propmap.errors import InputError
from propmap.physics.velocities import floored_norm

if TYPE_CHECKING:
    from propmap.physics.rotor import RotorArrays

MOTOR_DIAMETER, MOTOR_HEIGHT = 28.0 / 101.6, 30.0 / 101.6
"""Of a motor, over the radius of its propeller [-]: 28 mm x 30 mm below one of 8 inches."""

MOTOR_DRAG_COEFFICIENT = 1.0
"""Of a motor across the flow [-], between a smooth cylinder as high as it is wide, 0.63, and a long
one, 1.2: S. F. Hoerner, Fluid-Dynamic Drag, 1965, chapter III."""


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


@dataclass(frozen=True)
class MountDrag:
    """The drag of what is mounted in the slipstream, as a correction of a ``Model``.

    It adds to the rotor drag alone, at the hub: no moment comes from it; see ``Mounted.drag``.

    Attributes
    ----------
    area_m2 : float or None
        f, drag coefficient times area across the flow [m^2]; None for ``typical_area``.
    wake : float
        k, the share of the disk's inflow in the air that it meets [-]: 1 at the disk, where a
        motor sits, towards 2 far below, 0 outside the slipstream.

    Raises
    ------
    InputError
        For an area below zero and a share that is not from 0 to 2.
    """

    area_m2: float | None = None
    wake: float = 1.0

    def __post_init__(self) -> None:
        if self.area_m2 is not None and not 0.0 <= self.area_m2 < math.inf:
            raise InputError(f"area_m2 is {self.area_m2}: give an area of 0 m^2 or more")
        if not 0.0 <= self.wake <= 2.0:
            raise InputError(
                f"wake is {self.wake}: give a share of the inflow, 1 at the disk to 2 far below"
            )

    def applied(self, rotor: RotorArrays) -> RotorArrays:
        """The ``rotor`` with this drag."""
        area = typical_area(float(rotor.blade.tip)) if self.area_m2 is None else self.area_m2
        numbers: Any = (np.float64(area), np.float64(self.wake))
        return rotor._replace(mount=Mounted(*numbers))


def typical_area(radius: float) -> float:
    """f [m^2] of a motor in proportion to a propeller of this ``radius`` [m].

    8.4 cm^2 for one of 8 inches.
    """
    return MOTOR_DRAG_COEFFICIENT * MOTOR_DIAMETER * MOTOR_HEIGHT * radius**2
