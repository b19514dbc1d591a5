"""Forces of the body and the wing on the vehicle: section III.A and footnote 4."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from propmap.arrays.types import Floats
from propmap.fit.parameters import WING
from propmap.vehicle.flight_log import FlightLog
from propmap.vehicle.vehicle import Vehicle

SHARPNESS = 50.0
"""M of eq. (3) [1/rad]."""

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
    """Force of body and wing (n, 3) [N] in the vehicle's frame, and its derivatives (P, n, 3).

    ``values`` are the body's and the wing's parameters by name; the body's add to what the vehicle
    file gives.  Derivatives by the parameters ``free`` are central differences.
    """
    force = _force(vehicle, log, values)
    slopes = np.zeros((len(free), *force.shape))
    for k, name in enumerate(free):
        if name in STEPS:
            step = STEPS[name]
            up, down = (
                _force(vehicle, log, {**values, name: values[name] + h}) for h in (step, -step)
            )
            slopes[k] = (up - down) / (2.0 * step)
    return force, slopes


def _force(vehicle: Vehicle, log: FlightLog, values: Mapping[str, float]) -> Floats:
    v, density = log.velocity, vehicle.air.density
    area = np.array([values[f"drag_area_{a}"] for a in "xyz"]) + vehicle.body.drag_area
    drag = -0.5 * density * area * np.abs(v) * v
    forward, sideways = np.hypot(v[:, 0], v[:, 2]), v[:, 1]
    # Across the flow in the plane of symmetry, upwards for a positive angle of attack.
    across = np.stack([-v[:, 2], 0.0 * sideways, v[:, 0]], axis=1)
    angle = np.arctan2(-v[:, 2], v[:, 0])
    lift_area = values["lift_area"] + vehicle.body.lift_area
    # 1/2 rho V^2 A sin(a) cos(a), and the unit vector across/V.
    lift = 0.5 * density * lift_area * np.sin(angle) * np.cos(angle) * forward
    total = drag + lift[:, None] * across
    if vehicle.wing is None:
        return total
    wing = vehicle.wing
    a = (angle + wing.incidence + np.pi) % (2.0 * np.pi) - np.pi
    a0 = values["wing_alpha_0"]
    rise, both = np.exp(np.clip(SHARPNESS * (np.abs(a) - a0), -40, 40)), np.exp(-2 * SHARPNESS * a0)
    attached = rise / ((1.0 + rise) * (rise + both))  # Eq. (3)
    slope, separated = values["wing_c_l1"], values["wing_c_l2"]
    c_l = attached * slope * a + (1.0 - attached) * separated * np.sin(a) * np.cos(a)
    return total + (0.5 * density * wing.area * c_l * forward)[:, None] * across
