"""Moment balance of a vehicle in flight: measured moments, and the moments of a fit.

The vehicle has the inertia J and rotors of inertia I_r with spin s_i about the axes a_i.  The
aerodynamic moment about its center of mass is

    M = J dw/dt + w x J w + I_r sum_i s_i (dOmega_i/dt a_i + Omega_i w x a_i) .

For a center of mass at c in the frame of the vehicle file, a force F changes M by -c x F.  One
factor scales the modeled moment about x and y, a second factor the moment about z.  The factors
lump errors of arms and inertia with unmodeled aerodynamic moments that the rotors balance.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from propmap.typing import Floats
from propmap.vehicle.log import FlightLog
from propmap.vehicle.vehicle import Vehicle
from propmap.vehicle.wakes import HubFlow

CENTER = ("center_x", "center_y", "center_z")
ROTOR_INERTIA = "rotor_inertia"
FACTORS = {
    "moment_scale_xy": np.array([1.0, 1.0, 0.0]),
    "moment_scale_z": np.array([0.0, 0.0, 1.0]),
}
"""Axes on which the factors act."""


def measured_moment(vehicle: Vehicle, log: FlightLog) -> Floats:
    """Return the measured moment J dw/dt + w x J w [N m] (n, 3), without the spin of the rotors.

    NaN for a vehicle without moments of inertia and for a log without time derivatives.
    """
    if vehicle.inertia is None:
        return np.full_like(log.rates, np.nan)
    inertia = np.array(vehicle.inertia)
    turning = np.cross(log.rates, inertia * log.rates)
    return np.asarray(inertia * log.angular_acceleration + turning)


def moment_of_all(
    vehicle: Vehicle,
    log: FlightLog,
    flow: HubFlow,
    loads: Floats,
    slopes: Floats,
    values: Mapping[str, float],
    free: tuple[str, ...],
) -> tuple[Floats, Floats]:
    """Return the modeled counterpart (n, 3) [N m] of ``measured_moment``, and slopes (P, n, 3).

    Center of mass and rotor inertia in ``values`` add to those of the vehicle file.  ``loads``
    (n, 6) contains the aerodynamic force on the vehicle [N] and the moment of the rotors about the
    center of mass of the file [N m].  ``slopes`` (P, n, 6) contains the derivatives of ``loads``.
    """
    force, by_force = loads[:, :3], slopes[..., :3]
    center = np.array([values.get(name, 0.0) for name in CENTER])
    spun = flow.spin[:, None] * flow.axis
    momentum = flow.omega @ spun
    reaction = -(np.nan_to_num(log.rotor_acceleration) @ spun + np.cross(log.rates, momentum))
    heavy = vehicle.rotor_inertia + values.get(ROTOR_INERTIA, 0.0)
    moment = loads[:, 3:] - np.cross(center, force) + heavy * reaction
    scale = sum(values.get(name, 1.0) * axes for name, axes in FACTORS.items())
    by = slopes[..., 3:] - np.cross(center, by_force)
    for row, name in enumerate(free):
        if name in CENTER:
            by[row] -= np.cross(np.eye(3)[CENTER.index(name)], force)
        elif name == ROTOR_INERTIA:
            by[row] += reaction
    by = scale * by
    for row, name in enumerate(free):
        if name in FACTORS:
            by[row] = FACTORS[name] * moment
    return scale * moment, by
