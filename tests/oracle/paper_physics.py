"""The paper's equations written out in NumPy, with explicit angles, to compare with.

Nothing here comes from the package.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

RHO, MU = 1.225, 1.983e-5


@dataclass(frozen=True)
class Law:
    """Parameters of eqs. (3) and (4), in the order of ``Airfoil``."""

    c_l1: float
    c_l2: float
    c_d: float
    alpha_0: float
    zero_lift_angle: float = 0.0
    c_d0: float = 0.01
    c_p: float = 1.328
    sharpness: float = 50.0
    attached: float = 1.0
    plate: float = 0.0


TABLE_I = {
    "soft": Law(6.9, 2.0, 3.7, 20.4 * np.pi / 180.0),
    "stiff": Law(4.2, 2.0, 1.3, 27.5 * np.pi / 180.0),
    "apc": Law(5.3, 1.7, 1.8, 20.6 * np.pi / 180.0),
}


def lift_law(law: Law) -> str:
    """What ``Airfoil`` calls it."""
    return "simplified" if law.attached == 0.0 else "plate" if law.plate else "blended"


def wrapped(angle: Any) -> Any:
    return np.arctan2(np.sin(angle), np.cos(angle))


def sigma(alpha: Any, m: float, a0: float) -> Any:
    """The blend as printed; in float64 it overflows only where M (|alpha| + a0) > 700."""
    a, b = np.exp(-m * (alpha - a0)), np.exp(m * (alpha + a0))
    return (1.0 + a + b) / ((1.0 + a) * (1.0 + b))


def lift(alpha: Any, law: Law) -> Any:
    """Eq. (3), with a plate's lift past stall, or footnote 1 with attached = 0."""
    a = wrapped(alpha - law.zero_lift_angle)
    separated = law.c_l2 * np.sin(a) * np.cos(a)
    if law.attached == 0.0:
        return separated
    separated = separated / (1.0 - law.plate + law.plate * np.abs(np.sin(a)))
    s = sigma(a, law.sharpness, law.alpha_0)
    return (1.0 - s) * law.c_l1 * a + s * separated


def drag(alpha: Any, reynolds: Any, law: Law) -> Any:
    """Eq. (4)."""
    a = alpha - law.zero_lift_angle
    return law.c_d * np.sin(a) ** 2 + 2.0 * 1.02 * law.c_p / np.sqrt(reynolds) + law.c_d0


def forces(
    law: Law, element: tuple[Any, Any, Any], flow: tuple[Any, Any, Any], v_i: Any, sine: Any
) -> tuple[Any, Any]:
    """(dL cos phi - dD sin phi) and (dL sin phi + dD cos phi) of one blade, per rho dy.

    element : radius, chord, twist.  flow : omega, V cos(beta), V sin(beta).
    """
    radius, chord, twist = element
    omega, v_axial, v_inplane = flow
    u_t = omega * radius + v_inplane * sine  # (1)
    u_p = v_axial + v_i  # (2)
    u = np.hypot(u_t, u_p)
    phi = np.arctan2(u_p, u_t)
    alpha = twist - phi
    d_l = 0.5 * u**2 * lift(alpha, law) * chord
    d_d = 0.5 * u**2 * drag(alpha, RHO * u * chord / MU, law) * chord
    normal = d_l * np.cos(phi) - d_d * np.sin(phi)
    return normal, d_l * np.sin(phi) + d_d * np.cos(phi)


def turn(azimuths: int) -> Any:
    """sin(psi) at equally spaced azimuths of a whole turn, midway between the two sides."""
    return np.sin(-0.5 * np.pi + 2.0 * np.pi * (np.arange(azimuths) + 0.5) / azimuths)
