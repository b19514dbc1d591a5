"""What an accelerometer away from the centre of mass, on a clock of its own, adds to a balance.

It reads a = a_cm + dw/dt x r + w x (w x r) of the vehicle that turns at w, r from the centre of
mass; and where its stamps are late by d, a(t - d), here a - d da/dt.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from propmap.errors import InputError
from propmap.fit.flight_parameters import at_samples, samples_of
from propmap.fit.parameters import general
from propmap.typing import Floats
from propmap.vehicle.flight_log import FlightLog
from propmap.vehicle.vehicle import Vehicle

OFFSET = ("sensor_x", "sensor_y", "sensor_z")
CLOCK = "clock_offset"


def sensor_force(
    vehicle: Vehicle, log: FlightLog, values: Mapping[str, float], free: tuple[str, ...]
) -> tuple[Floats, Floats]:
    """Mass times what the sensor reads beyond the acceleration of the centre of mass.

    Of steady operating points, which have no time derivatives, the vehicle file's place of the
    sensor plays no part.

    Parameters
    ----------
    vehicle, log : Vehicle, FlightLog
        What flies, and how; with time derivatives, see ``propmap.vehicle.time_derivatives``.
    values : mapping of str to float
        The sensor's parameters by name; its place adds to the vehicle file's.
    free : tuple of str
        Names of the P parameters by which to differentiate.

    Returns
    -------
    force, slopes : ndarray, shape (n, 3) and (P, n, 3)
        [N], and per unit of each parameter; zero of parameters that are not the sensor's.

    Raises
    ------
    InputError
        Where a parameter acts and the log has no time derivatives.
    """
    own = np.array([values.get(name, 0.0) for name in OFFSET])
    place, late = own + vehicle.sensor, at_samples(CLOCK, values, log)
    force, slopes = np.zeros((len(log), 3)), np.zeros((len(free), len(log), 3))
    fitted = own.any() or late.any() or any(general(name) in (*OFFSET, CLOCK) for name in free)
    points = not np.isfinite(log.angular_acceleration).any()
    if not fitted and (points or not place.any()):
        return force, slopes
    if not np.isfinite(log.angular_acceleration).all():
        raise InputError(
            "a sensor's place or clock acts on a log without time derivatives",
            "fit whole flights with --method balance, or leave the sensor's parameters out",
            log.source,
        )
    rates, turning = log.rates, log.angular_acceleration
    by_place = [
        vehicle.mass * (np.cross(turning, e) + np.cross(rates, np.cross(rates, e)))
        for e in np.eye(3)
    ]
    by_clock = -vehicle.mass * log.specific_force_rate
    force = np.einsum("k,knj->nj", place, np.stack(by_place)) + late[:, None] * by_clock
    for row, name in enumerate(free):
        if name in OFFSET:
            slopes[row] = by_place[OFFSET.index(name)]
        elif general(name) == CLOCK:
            slopes[row] = by_clock * samples_of(name, values, log)[:, None]
    return force, slopes
