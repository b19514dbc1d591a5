"""What turns a vehicle, and what moments a fit makes of the air's forces and the rotors' spin.

About a vehicle's centre of mass, with its inertia J and with rotors of inertia I_r and spin s_i
about axes a_i, the air's moment is

    M = J dw/dt + w x J w + I_r sum_i s_i (dOmega_i/dt a_i + Omega_i w x a_i) .

A force F acts on a centre of mass that is at c in the vehicle file's frame with M - c x F.  What
arms and inertia are in truth, and what the air does to the differences of the rotors' thrusts and
torques, are factors on all of it: one about x and y, one about z.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from propmap.typing import Floats
from propmap.vehicle.log import FlightLog
from propmap.vehicle.vehicle import Vehicle
from propmap.vehicle.wakes import HubFlow

CENTRE = ("centre_x", "centre_y", "centre_z")
ROTOR_INERTIA = "rotor_inertia"
FACTORS = {
    "moment_scale_xy": np.array([1.0, 1.0, 0.0]),
    "moment_scale_z": np.array([0.0, 0.0, 1.0]),
}
"""About which axes they act."""


def measured_moment(vehicle: Vehicle, log: FlightLog) -> Floats:
    """Moment that turns the frame, J dw/dt + w x J w [N m]; (n, 3), NaN where it is not known.

    It takes moments of inertia and the log's time derivatives.
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
    """Moment (n, 3) [N m] about the centre of mass, as ``measured_moment`` has it; slopes.

    The parameters of ``TURNING`` among ``values`` add to the vehicle file's.  ``loads`` (n, 6) are
    the air's force on the vehicle [N] and the rotors' moment about the file's centre of mass [N m],
    ``slopes`` (P, n, 6) their derivatives, and those of the moment are (P, n, 3).
    """
    force, by_force = loads[:, :3], slopes[..., :3]
    centre = np.array([values.get(name, 0.0) for name in CENTRE])
    spun = flow.spin[:, None] * flow.axis
    momentum = flow.omega @ spun
    reaction = -(np.nan_to_num(log.rotor_acceleration) @ spun + np.cross(log.rates, momentum))
    heavy = vehicle.rotor_inertia + values.get(ROTOR_INERTIA, 0.0)
    moment = loads[:, 3:] - np.cross(centre, force) + heavy * reaction
    scale = sum(values.get(name, 1.0) * axes for name, axes in FACTORS.items())
    by = slopes[..., 3:] - np.cross(centre, by_force)
    for row, name in enumerate(free):
        if name in CENTRE:
            by[row] -= np.cross(np.eye(3)[CENTRE.index(name)], force)
        elif name == ROTOR_INERTIA:
            by[row] += reaction
    by = scale * by
    for row, name in enumerate(free):
        if name in FACTORS:
            by[row] = FACTORS[name] * moment
    return scale * moment, by
