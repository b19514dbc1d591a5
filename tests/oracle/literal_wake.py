"""The momentum side of the literal reference: eq. (10), descent, and Prandtl's losses, as printed.

Equation numbers are the paper's; what it leaves open is written from the page `docs/theory.md`
(windmill branch and vortex ring) and from the printed formula of Prandtl's factor.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.oracle.literal_section import Array

WINDMILL_BELOW = -0.95  # V cos(beta)/v_h at which the windmill branch takes over


@dataclass(frozen=True)
class LiteralWake:
    """Thrust that momentum theory gives an annulus, and the losses that a model asks for."""

    rho: float  # [kg/m^3]
    omega: float  # [rad/s]
    v_axial: float  # [m/s], V cos(beta)
    v_inplane: float  # [m/s], V sin(beta)
    blades: int
    tip: float  # [m], radius R
    tip_loss: bool = False
    hub_radius: float | None = None  # [m], of the hub loss; None: there is none
    windmill: bool = False  # on the windmill branch

    def thrust(self, y: float, v_i: Array) -> Array:
        """dT/dy [N/m] for each v_i [m/s]: eq. (10), mirrored where asked for, times the losses."""
        plain = self._windmill(y, v_i) if self.windmill else self._glauert(y, v_i)
        return self.loss(y, self.v_axial + v_i) * plain

    def _glauert(self, y: float, v_i: Array) -> Array:
        speed = np.sqrt(self.v_inplane**2 + (self.v_axial + v_i) ** 2)
        return 4.0 * self.rho * np.pi * y * v_i * speed  # Eq. (10)

    def _windmill(self, y: float, v_i: Array) -> Array:
        """Eq. (10) up to its first turning point; beyond it, what goes on rising."""
        v, p = self.v_axial, self.v_inplane
        flat = 8.0 * (p / v) ** 2  # 8 tan^2 of the descent's angle to the axis
        if flat >= 1.0:
            return self._glauert(y, v_i)
        # d(10)/dv_i = 0 where 2 v_i^2 + 3 V v_i + V^2 + p^2 = 0.
        first, second = np.sort(np.roots([2.0, 3.0 * v, v**2 + p**2]).real)
        here, top, foot = (self._glauert(y, np.asarray(a)) for a in (v_i, first, second))
        mirrored = np.where(v_i <= second, 2.0 * top - here, here + 2.0 * (top - foot))
        parabola = top + 4.0 * self.rho * np.pi * y * (v_i - first) ** 2
        return np.where(v_i <= first, here, flat * mirrored + (1.0 - flat) * parabola)

    def loss(self, y: float, u_p: Array) -> Array:
        """Prandtl's F [-], of the tip times that of the hub, by U_P [m/s] at radius y [m].

        F = 2/pi arccos(exp(-f)) with f = N_b/2 (R - y) / (y sin(phi)) at the tip and
        f = N_b/2 (y - r) / (r sin(phi)) at the hub; tan(phi) = |U_P| / (Omega y).
        """
        phi = np.arctan2(np.abs(u_p), self.omega * y)
        return self._factor(y, np.maximum(np.sin(phi), 1e-12))

    def least_loss(self, y: float) -> float:
        """The least F at radius y [m]: that of phi = pi/2."""
        return float(self._factor(y, np.ones(())))

    def _factor(self, y: float, sine: Array) -> Array:
        factor = np.ones_like(sine)
        if self.tip_loss:
            f = 0.5 * self.blades * (self.tip - y) / (y * sine)
            factor = factor * 2.0 / np.pi * np.arccos(np.exp(-f))
        if self.hub_radius is not None:
            f = 0.5 * self.blades * (y - self.hub_radius) / (self.hub_radius * sine)
            factor = factor * 2.0 / np.pi * np.arccos(np.exp(-f))
        return factor


def static_inflow(static_thrust: float, rho: float, radius: float) -> float:
    """v_i0 [m/s] of eq. (12)."""
    return float(np.sqrt(max(static_thrust, 0.0) / (2.0 * rho * np.pi * radius**2)))


def vortex_ring(v_axial: float, v_inplane: float, v_h: float) -> tuple[float, float]:
    """Share [-] of the measured inflow in the inflow used, and that inflow [m/s].

    The share rises and falls by 10 t^3 - 15 t^4 + 6 t^5, the step whose first two derivatives are
    zero at both ends.
    """

    def step(t: float) -> float:
        t = min(max(t, 0.0), 1.0)
        return 10.0 * t**3 - 15.0 * t**4 + 6.0 * t**5

    if v_h == 0.0 or v_axial >= 0.0:
        return 0.0, 0.0
    z, x = v_axial / v_h, v_inplane / v_h
    entered, left = step((-0.2 - z) / 0.25), step((-1.5 - z) / 0.5)
    swept = step((x - 0.5) / 0.45)
    share = entered * (1.0 - left) * (1.0 - swept)
    return share, v_h * (1.0 - 1.125 * z - 1.372 * z**2 - 1.718 * z**3 - 0.655 * z**4)
