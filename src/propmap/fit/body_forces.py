"""Forces of the body and the wing on the vehicle: section III.A and footnote 4."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from propmap.fit.parameters import WING
from propmap.typing import Floats
from propmap.vehicle.flight_log import FlightLog
from propmap.vehicle.free_stream_force import free_stream_force
from propmap.vehicle.vehicle import Body, Vehicle

STEPS = {"drag_area_x": 1e-3, "drag_area_y": 1e-3, "drag_area_z": 1e-3, "lift_area": 1e-3}
STEPS |= {"download_area_x": 1e-3, "download_area_y": 1e-3}
STEPS |= {"wing_c_l1": 1e-4, "wing_c_l2": 1e-4, "wing_alpha_0": 1e-5}
"""Of central differences, by parameter; the forces are linear in all but the last."""


def wing_values(vehicle: Vehicle) -> dict[str, float]:
    """The wing's parameters by name, as the vehicle file gives them; none without a wing."""
    if vehicle.wing is None:
        return {}
    return {name: getattr(vehicle.wing, name.removeprefix("wing_")) for name in WING}


def body_force(
    vehicle: Vehicle, log: FlightLog, values: Mapping[str, float], free: tuple[str, ...]
) -> tuple[Floats, Floats]:
    """Force of body and wing in the vehicle's frame, and its derivatives.

    Parameters
    ----------
    vehicle, log : Vehicle, FlightLog
        What flies, and how.
    values : mapping of str to float
        The body's and the wing's parameters by name; the body's add to the vehicle file's.
    free : tuple of str
        Names of the P parameters by which to differentiate, by central differences.

    Returns
    -------
    force, slopes : ndarray, shape (n, 3) and (P, n, 3)
        [N], and per unit of each parameter.
    """
    force = _force(vehicle, log, values)
    slopes = np.zeros((len(free), *force.shape))
    for k, name in enumerate(free):
        if name in STEPS:
            h = STEPS[name]
            up, down = (_force(vehicle, log, {**values, name: values[name] + d}) for d in (h, -h))
            slopes[k] = (up - down) / (2.0 * h)
    return force, slopes


def _force(vehicle: Vehicle, log: FlightLog, values: Mapping[str, float]) -> Floats:
    area = np.array([values[f"drag_area_{a}"] for a in "xyz"]) + vehicle.body.drag_area
    down = np.array([values[f"download_area_{a}"] for a in "xy"]) + vehicle.body.download_area
    lift = values["lift_area"] + vehicle.body.lift_area
    body = Body(tuple(area.tolist()), lift, tuple(down.tolist()))
    wing = vehicle.wing
    if wing is not None:
        wing = replace(wing, **{n.removeprefix("wing_"): values[n] for n in WING})
    return free_stream_force(body, wing, vehicle.air.density, log.velocity)
