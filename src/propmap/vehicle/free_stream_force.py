"""Force of a body and a wing in the free stream: section III.A and footnote 4 of the paper."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from propmap.arrays.namespace import by_numpy
from propmap.arrays.types import Floats
from propmap.model.airfoil import Airfoil
from propmap.physics.sections.law import coefficients_at
from propmap.vehicle.vehicle import Body, Wing

PLAIN = Airfoil(c_l1=5.0, c_l2=1.0, c_d=0.0, alpha_0=0.3).law()
"""Eq. (3); a wing has three parameters of its own."""


def free_stream_force(body: Body, wing: Wing | None, density: float, velocity: Floats) -> Floats:
    """Force in the vehicle's frame [N], of the velocity's shape.

    Parameters
    ----------
    body, wing : Body, Wing or None
        What is in the flow.
    density : float
        Of the air [kg/m^3].
    velocity : ndarray, shape (..., 3)
        Through the air, in the vehicle's frame [m/s].
    """
    x, z = velocity[..., 0], velocity[..., 2]
    # In the plane of symmetry; the angle is positive where the air comes from below.
    angle, speed = np.arctan2(-z, x), np.hypot(x, z)
    lift, induced = body.lift_area * np.sin(angle) * np.cos(angle), np.zeros_like(angle)
    if wing is not None:
        own = wing_lift(wing, angle + wing.incidence)
        lift = lift + own
        if wing.span is not None:
            # Prandtl's D = L^2/(pi q b^2), of an elliptic lift.
            induced = own**2 / (math.pi * wing.span**2)
    # Across the flow: V^2 times the unit vector (-v_z, 0, v_x)/V.
    across = np.stack([-z, np.zeros_like(angle), x], axis=-1)
    drag = 0.5 * density * np.array(body.drag_area) * np.abs(velocity) * velocity
    pressed = np.square(velocity[..., :2]) @ np.array(body.download_area)
    down = 0.5 * density * pressed[..., None] * np.array([0.0, 0.0, 1.0])
    along = np.stack([x, np.zeros_like(angle), z], axis=-1)
    carried = lift[..., None] * across - induced[..., None] * along
    return 0.5 * density * speed[..., None] * carried - drag - down


def wing_lift(wing: Wing, angle: Floats) -> Floats:
    """Lift of a ``wing`` over the dynamic pressure [m^2] at an ``angle`` of attack [rad]."""
    own: Any = {name: np.float64(getattr(wing, name)) for name in ("c_l1", "c_l2", "alpha_0")}
    alpha: Any = angle
    with by_numpy():
        found = coefficients_at(PLAIN._replace(**own), alpha, np.ones_like(alpha))
    return wing.area * np.asarray(found.lift)
