"""Forces of the body and the wing on the vehicle: section III.A and footnote 4."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from propmap.arrays.namespace import by_numpy
from propmap.arrays.types import Floats
from propmap.fit.parameters import WING
from propmap.model.airfoil import Airfoil
from propmap.physics.sections.law import coefficients_at
from propmap.vehicle.flight_log import FlightLog
from propmap.vehicle.vehicle import Vehicle

PLAIN = Airfoil(c_l1=5.0, c_l2=1.0, c_d=0.0, alpha_0=0.3).law()
"""Eq. (3); a wing has three parameters of its own."""

STEPS = {"drag_area_x": 1e-3, "drag_area_y": 1e-3, "drag_area_z": 1e-3, "lift_area": 1e-3}
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
    v, half_density = log.velocity, 0.5 * vehicle.air.density
    area = np.array([values[f"drag_area_{a}"] for a in "xyz"]) + vehicle.body.drag_area
    lift_area = values["lift_area"] + vehicle.body.lift_area
    # In the plane of symmetry; the angle is positive where the air comes from below.
    angle, speed = np.arctan2(-v[:, 2], v[:, 0]), np.hypot(v[:, 0], v[:, 2])
    lift = lift_area * np.sin(angle) * np.cos(angle)
    if vehicle.wing is not None:
        changed: Any = {n.removeprefix("wing_"): np.float64(values[n]) for n in WING}
        alpha: Any = angle + vehicle.wing.incidence
        with by_numpy():
            found = coefficients_at(PLAIN._replace(**changed), alpha, np.ones_like(alpha))
        lift = lift + vehicle.wing.area * np.asarray(found.lift)
    # Across the flow: V^2 times the unit vector (-v_z, 0, v_x)/V.
    across = np.stack([-v[:, 2], np.zeros_like(angle), v[:, 0]], axis=1)
    drag = half_density * area * np.abs(v) * v
    return (half_density * lift * speed)[:, None] * across - drag
