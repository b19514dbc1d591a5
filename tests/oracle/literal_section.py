"""The paper's section law, eqs (3) and (4), as printed: the literal reference's own copy.

`section` holds c_l1, c_l2, c_d, alpha_0 [rad] and, if they differ from the paper's, M, c_p, c_d0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def stall_blend(alpha: ArrayLike, alpha_0: float, sharpness: float) -> Array:
    """sigma of eq. (3) as printed: 0 attached, 1 stalled; alpha and alpha_0 in rad."""
    # The clip changes nothing before both exponentials would overflow together.
    falling = np.exp(np.clip(-sharpness * (np.asarray(alpha) - alpha_0), -340.0, 340.0))
    rising = np.exp(np.clip(sharpness * (np.asarray(alpha) + alpha_0), -340.0, 340.0))
    sigma: Array = (1.0 + falling + rising) / ((1.0 + falling) * (1.0 + rising))
    return sigma


def lift_coefficient(alpha: ArrayLike, section: dict[str, float]) -> Array:
    """C_L of eq. (3) at alpha [rad], in (-pi, pi]."""
    a = np.asarray(alpha, dtype=float)
    sigma = stall_blend(a, section["alpha_0"], section.get("M", 50.0))
    attached = section["c_l1"] * a
    stalled = section["c_l2"] * np.sin(a) * np.cos(a)
    blended: Array = (1.0 - sigma) * attached + sigma * stalled
    return blended


def drag_coefficient(alpha: ArrayLike, reynolds: ArrayLike, section: dict[str, float]) -> Array:
    """C_D of eq. (4) at alpha [rad] and chord Reynolds number."""
    # Re = 0 only where U = 0 or c = 0, and there the force is zero whatever C_D is.
    re = np.maximum(np.asarray(reynolds, dtype=float), 1e-12)
    friction = 2.0 * 1.02 * section.get("c_p", 1.328) / np.sqrt(re)
    whole: Array = section["c_d"] * np.sin(alpha) ** 2 + friction + section.get("c_d0", 0.01)
    return whole


def wrap(angle: Array) -> Array:
    """The same angle [rad] in (-pi, pi]."""
    wrapped: Array = angle - 2.0 * np.pi * np.ceil((angle - np.pi) / (2.0 * np.pi))
    return wrapped
