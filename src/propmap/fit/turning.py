"""What turns a vehicle, beside the air's moment on its rotors, and what that amounts to.

About a vehicle's centre of mass, with its inertia J and with rotors of inertia I_r and spin s_i
about axes a_i, the air's moment is

    M = J dw/dt + w x J w + I_r sum_i s_i (dOmega_i/dt a_i + Omega_i w x a_i) .

A force F acts on a centre of mass that is at c in the vehicle file's frame with M - c x F.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from propmap.typing import Floats
from propmap.vehicle.flight_log import FlightLog
from propmap.vehicle.hub_flow import HubFlow
from propmap.vehicle.vehicle import Vehicle

CENTRE = ("centre_x", "centre_y", "centre_z")
ROTOR_INERTIA = "rotor_inertia"


def measured_moment(vehicle: Vehicle, log: FlightLog) -> Floats:
    """Moment that turns the frame, J dw/dt + w x J w [N m]; (n, 3), NaN where it is not known.

    Parameters
    ----------
    vehicle, log : Vehicle, FlightLog
        With its moments of inertia; with time derivatives, see ``time_derivatives``.
    """
    if vehicle.inertia is None:
        return np.full_like(log.rates, np.nan)
    inertia = np.array(vehicle.inertia)
    turning = np.cross(log.rates, inertia * log.rates)
    return np.asarray(inertia * log.angular_acceleration + turning)


def added_moment(
    vehicle: Vehicle,
    log: FlightLog,
    flow: HubFlow,
    force: Floats,
    slopes: Floats,
    values: Mapping[str, float],
    free: tuple[str, ...],
) -> tuple[Floats, Floats]:
    """Moment of a shifted centre of mass and of the spinning rotors on the frame.

    Parameters
    ----------
    vehicle, log, flow : Vehicle, FlightLog, HubFlow
        What flies, how, and the flow at its m rotors.
    force, slopes : ndarray, shape (n, 3) and (P, n, 3)
        Of the air on the vehicle [N], and its derivatives.
    values : mapping of str to float
        The parameters of ``TURNING`` by name; they add to the vehicle file's.
    free : tuple of str
        Names of the P parameters.

    Returns
    -------
    moment, slopes : ndarray, shape (n, 3) and (P, n, 3)
        [N m], and per unit of each parameter.
    """
    centre = np.array([values.get(name, 0.0) for name in CENTRE])
    spun = flow.spin[:, None] * flow.axis
    momentum = flow.omega @ spun
    reaction = -(np.nan_to_num(log.rotor_acceleration) @ spun + np.cross(log.rates, momentum))
    heavy = vehicle.rotor_inertia + values.get(ROTOR_INERTIA, 0.0)
    moment = heavy * reaction - np.cross(centre, force)
    by = -np.cross(centre, slopes)
    for row, name in enumerate(free):
        if name in CENTRE:
            by[row] -= np.cross(np.eye(3)[CENTRE.index(name)], force)
        elif name == ROTOR_INERTIA:
            by[row] += reaction
    return moment, by
