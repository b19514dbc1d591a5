"""Section laws of the literal reference: eqs (3) and (4) as printed, and a table.

`section` holds c_l1, c_l2, c_d, alpha_0 [rad] and, if they differ from the paper's, M, c_p, c_d0.
Extensions: attached = 0 is the lift of footnote 1, plate = 0.44 that of a plate past stall; the
rotor applies reynolds_camber, drag_angle [rad], reynolds_lift and reynolds_drag [-].
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

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
    stalled = section["c_l2"] * np.sin(a) * np.cos(a)
    if section.get("attached", 1.0) == 0.0:
        return stalled
    plate = section.get("plate", 0.0)
    stalled = stalled / (1.0 - plate + plate * np.abs(np.sin(a)))
    sigma = stall_blend(a, section["alpha_0"], section.get("M", 50.0))
    attached = section["c_l1"] * a
    blended: Array = (1.0 - sigma) * attached + sigma * stalled
    return blended


def drag_coefficient(
    alpha: ArrayLike,
    reynolds: ArrayLike,
    section: dict[str, float],
    growth: ArrayLike = 1.0,
) -> Array:
    """C_D of eq. (4) at alpha [rad] and chord Reynolds number.

    `growth` is a factor on the drag except friction.
    """
    # Re = 0 only where U = 0 or c = 0, and there the force is zero whatever C_D is.
    re = np.maximum(np.asarray(reynolds, dtype=float), 1e-12)
    friction = 2.0 * 1.02 * section.get("c_p", 1.328) / np.sqrt(re)
    whole: Array = growth * (section["c_d"] * np.sin(alpha) ** 2 + section.get("c_d0", 0.01))
    return whole + friction


def wrap(angle: Array) -> Array:
    """Wrap an angle [rad] to (-pi, pi]."""
    wrapped: Array = angle - 2.0 * np.pi * np.ceil((angle - np.pi) / (2.0 * np.pi))
    return wrapped


@dataclass(frozen=True)
class LiteralTable:
    """C_L and C_D over the angle of attack and the Reynolds number, shape (Re, angle).

    At each Reynolds number PCHIP over the angle.  Between two, the cubic in ln Re with the values
    and the slopes by ln Re of both, these slopes being those of PCHIP over ln Re at the table's
    angles (zero at the first and the last Reynolds number), and PCHIP over the angle between them.
    Outside the table's Reynolds numbers the nearest one holds.
    """

    angle: Array  # [rad] from the chord line, -pi to pi
    reynolds: Array
    lift: Array
    drag: Array

    @cached_property
    def curves(self) -> PchipInterpolator:
        """C_L, C_D and their slopes by ln Re over the angle: (..., 4, Re)."""
        log_re = np.log(self.reynolds)
        slopes = [np.zeros_like(self.lift), np.zeros_like(self.drag)]
        if log_re.size > 2:
            for slope, values in zip(slopes, (self.lift, self.drag), strict=True):
                found = PchipInterpolator(log_re, values, axis=0).derivative()(log_re)
                slope[1:-1] = found[1:-1]
        stacked = np.stack([self.lift, self.drag, *slopes])
        return PchipInterpolator(self.angle, np.moveaxis(stacked, -1, 0), axis=0)

    def coefficients(self, alpha: Array, reynolds: Array) -> tuple[Array, Array]:
        """C_L and C_D at alpha [rad], in (-pi, pi], and the chord Reynolds number."""
        log_re = np.log(self.reynolds)
        x = np.clip(np.log(np.maximum(reynolds, 1e-12)), log_re[0], log_re[-1])
        value_and_slope = self.curves(np.broadcast_to(alpha, x.shape))
        if log_re.size == 1:
            return value_and_slope[..., 0, 0], value_and_slope[..., 1, 0]
        r = np.clip(np.searchsorted(log_re, x, side="right") - 1, 0, log_re.size - 2)
        width = log_re[r + 1] - log_re[r]
        t = (x - log_re[r]) / width

        def at(which: Array) -> Array:
            return np.take_along_axis(value_and_slope, which[..., None, None], axis=-1)[..., 0]

        below, above = at(r), at(r + 1)
        found = []
        for value, slope in ((0, 2), (1, 3)):  # Hermite's basis
            found.append(
                below[..., value] * (1.0 + 2.0 * t) * (1.0 - t) ** 2
                + above[..., value] * t**2 * (3.0 - 2.0 * t)
                + width * below[..., slope] * t * (1.0 - t) ** 2
                + width * above[..., slope] * t**2 * (t - 1.0)
            )
        return found[0], found[1]


Section = dict[str, float] | LiteralTable


def coefficients(alpha: Array, reynolds: Array, section: Section) -> tuple[Array, Array]:
    """C_L and C_D of either kind of section at alpha [rad] and chord Reynolds number."""
    if isinstance(section, LiteralTable):
        return section.coefficients(alpha, reynolds)
    return lift_coefficient(alpha, section), drag_coefficient(alpha, reynolds, section)


def largest_lift(section: Section) -> float:
    """Largest absolute C_L at any angle of attack; of a table no cubic of PCHIP exceeds it."""
    if isinstance(section, LiteralTable):
        # Between two Reynolds numbers the cubic may pass both by a little.
        return 1.1 * float(np.abs(section.lift).max())
    every_angle = np.linspace(-np.pi, np.pi, 8001)
    return float(np.abs(lift_coefficient(every_angle, section)).max())
