"""Force of a body and a wing in the free stream: section III.A and footnote 4 of the paper."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from propmap.model.airfoil import Airfoil
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.vehicle.vehicle import Body, Wing


def free_stream_force(body: Body, wing: Wing | None, density: float, velocity: Floats) -> Floats:
    """Force of both in the vehicle's frame [N], of the velocity's shape.

    Parameters
    ----------
    body, wing : Body, Wing or None
        What is in the flow.
    density : float
        Of the air [kg/m^3].
    velocity : ndarray, shape (..., 3)
        Through the air, in the vehicle's frame [m/s].
    """
    force = body_force(body, density, velocity)
    return force if wing is None else force + wing_force(wing, density, velocity)


def body_force(body: Body, density: float, velocity: Floats) -> Floats:
    """Drag, lift and download of a ``body``; ``density`` and ``velocity`` as above."""
    angle, speed, across = _in_plane_of_symmetry(velocity)
    lift = body.lift_area * np.sin(angle) * np.cos(angle)
    drag = 0.5 * density * np.array(body.drag_area) * np.abs(velocity) * velocity
    pressed = np.square(velocity[..., :2]) @ np.array(body.download_area)
    down = 0.5 * density * pressed[..., None] * np.array([0.0, 0.0, 1.0])
    return np.asarray((0.5 * density * lift * speed)[..., None] * across - drag - down)


def wing_force(wing: Wing, density: float, velocity: Floats) -> Floats:
    """Lift of a ``wing`` and its induced drag; ``density`` and ``velocity`` as above."""
    angle, speed, across = _in_plane_of_symmetry(velocity)
    lift = wing_lift(wing, angle + wing.incidence)
    force = lift[..., None] * across
    if wing.span is not None:
        # Prandtl's D = L^2/(pi q b^2), of an elliptic lift.
        along = velocity * np.array([1.0, 0.0, 1.0])
        force = force - (lift**2 / (math.pi * wing.span**2))[..., None] * along
    return np.asarray((0.5 * density * speed)[..., None] * force)


def wing_lift(wing: Wing, angle: Floats) -> Floats:
    """Lift of a ``wing`` over the dynamic pressure [m^2] at an ``angle`` of attack [rad]."""
    section = Airfoil(c_l1=wing.c_l1, c_l2=wing.c_l2, c_d=0.0, alpha_0=wing.alpha_0)
    lift, _ = section.coefficients(angle, 1.0)  # eq. (3), which does not depend on Re
    return wing.area * lift


def _in_plane_of_symmetry(velocity: Floats) -> tuple[Floats, Floats, Floats]:
    """Angle of attack [rad], positive where the air comes from below, the speed V [m/s] there, and
    V times the unit vector across the flow (-v_z, 0, v_x)/V."""
    x, z = velocity[..., 0], velocity[..., 2]
    angle = np.arctan2(-z, x)
    return angle, np.hypot(x, z), np.stack([-z, np.zeros_like(angle), x], axis=-1)
