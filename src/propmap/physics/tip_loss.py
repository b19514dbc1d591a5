"""Prandtl's tip and hub loss: a factor on the momentum thrust for a finite number of blades."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from propmap.arrays.elementary import arctangent, power_of_two
from propmap.arrays.namespace import Array, xp
from propmap.physics.element import Annulus
from propmap.physics.velocities import floored_norm
from propmap.physics.wake import FactorBounds

LEAST_REACH = 5e-5
"""Least value of f sin(phi) [-].  Otherwise F would go to zero over the last 0.005 % of the blade,
which has hardly any load, and change there within some um/s of U_P."""


class PrandtlLoss(NamedTuple):
    """Prandtl's factor F for the loss at the tip, or at the hub.

    The thrust (10) of an annulus is multiplied by F = 2/pi arccos(exp(-f)).  At the tip
    f = N_b (R - y) / (2 y sin(phi)), at the hub f = N_b (y - r) / (2 r sin(phi)).  phi is the
    inflow angle with V sin(beta) left out, tan(phi) = |U_P| / (Omega y): an annulus has one inflow
    at all azimuths, hence one F.

    Attributes
    ----------
    hub_radius : Array or None
        r [m] for the loss at the hub, at most the radius at which integration starts; None for
        the loss at the tip.

    References
    ----------
    L. Prandtl, appendix to A. Betz, "Schraubenpropeller mit geringstem Energieverlust",
    Nachrichten von der Gesellschaft der Wissenschaften zu Goettingen, 1919.
    H. Glauert, "Airplane Propellers", in W. F. Durand, Aerodynamic Theory IV, 1935.
    """

    hub_radius: Array | None = None

    def factor_slope(self, at: Annulus, inflow: Array) -> tuple[Array, Array]:
        """F [-] ``at`` an annulus and its derivative by v_i [s/m]; shape of ``inflow``."""
        u, turning = at.v_axial + inflow, at.turning
        speed = floored_norm(u, turning)
        reach = self._reach(at)
        # f = reach / |sin(phi)|, capped where exp(-f) = 2^-100 is lost beside 1.
        f = xp.minimum(reach * speed / xp.maximum(xp.abs(u), 1e-9), 100.0 * math.log(2.0))
        decay = power_of_two(-f / math.log(2.0))
        root = xp.sqrt((1.0 - decay) * (1.0 + decay))
        # arccos(x) = 2 arctan(sqrt(1 - x^2) / (1 + x))
        factor = 4.0 / np.pi * arctangent(root / (1.0 + decay))
        # dF/df = 2/pi exp(-f) / sqrt(1 - exp(-2f)); df/dv_i = -f (Omega y)^2 / (speed^2 U_P).
        by_f = 2.0 / np.pi * decay / xp.maximum(root, 1e-12)
        across = turning / speed
        return factor, -by_f * f * across * across / xp.where(u == 0.0, 1.0, u)

    def bounds(self, at: Annulus, low: Array, high: Array) -> FactorBounds:
        """Bounds of F ``at`` an annulus for v_i between ``low`` and ``high`` [m/s]."""
        u_low, u_high = at.v_axial + low, at.v_axial + high
        turning, reach = at.turning, self._reach(at)
        u_max = xp.maximum(xp.abs(u_low), xp.abs(u_high))
        same_side = u_low * u_high > 0.0
        u_min = xp.where(same_side, xp.minimum(xp.abs(u_low), xp.abs(u_high)), 0.0)
        fastest, slowest = floored_norm(u_max, turning), floored_norm(u_min, turning)
        f_min = reach * fastest / xp.maximum(u_max, 1e-9)
        f_max = reach * slowest / xp.maximum(u_min, 1e-9)
        # With s = sin(phi): dF/ds = -first(f)/reach and d^2F/ds^2 = second(f)/reach^2.
        first, second = _largest_first(f_min, f_max), _largest_second(f_min, f_max)
        # ds/dv = (Omega y)^2 / speed^3 and its derivative.
        turn = turning * turning / slowest**3
        turn_slope = 3.0 * u_max * turn / (slowest * slowest)
        per_reach = 1.0 / reach
        return FactorBounds(
            least=_factor(f_min),
            slope=first * per_reach * turn,
            bend=second * (per_reach * turn) ** 2 + first * per_reach * turn_slope,
            # There f > 50, so that exp(-f) is lost beside 1.
            constant_below=0.02 * reach * turning,
        )

    def _reach(self, at: Annulus) -> Array:
        """f sin(phi) [-]."""
        if self.hub_radius is None:
            reach = 0.5 * at.blades * (at.tip / at.radius - 1.0)
        else:
            reach = 0.5 * at.blades * (at.radius / self.hub_radius - 1.0)
        return xp.maximum(reach, LEAST_REACH)


def _factor(f: Array) -> Array:
    decay = xp.exp(-f)
    return 4.0 / np.pi * arctangent(xp.sqrt((1.0 - decay) / (1.0 + decay)))


def _first(f: Array) -> Array:
    """f^2 |dF/df| [-], which has one maximum, 0.348 at f = 1.96."""
    decay = xp.exp(-f)
    root = xp.sqrt(xp.maximum((1.0 - decay) * (1.0 + decay), 1e-300))
    return 2.0 / np.pi * f * f * decay / root


def _largest_first(low: Array, high: Array) -> Array:
    return 1.001 * _first(xp.clip(1.96, low, high))


def _largest_second(low: Array, high: Array) -> Array:
    """An upper bound of |f^2 d/df(f^2 dF/df)| [-] between two f.

    It grows like 0.68 f^2.5 for small f, and falls like 2/pi f^4 exp(-f) for large ones.
    """
    rising = 0.70 * xp.minimum(high, 4.0) ** 2.5
    falling = 0.70 * xp.maximum(low, 4.0) ** 4 * xp.exp(-xp.maximum(low, 4.0))
    return xp.minimum(rising, falling)
