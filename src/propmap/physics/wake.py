"""Thrust of an annulus by momentum theory times corrections, and bounds on it."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from propmap.arrays.namespace import Array, xp
from propmap.physics import momentum
from propmap.physics.element import Annulus
from propmap.physics.velocities import SPEED_FLOOR, floored_norm

NEARLY_AXIAL = 1e-4
"""V sin(beta) over Omega y + |V cos(beta)| [-] up to which the bounds of a wake tell the narrow
bend of (10) about U_P = 0, as wide as V sin(beta), from the rest of the curve."""


class FactorBounds(NamedTuple):
    """Bounds of a factor on the wake's thrust over a range of v_i.

    Attributes
    ----------
    least : Array
        The factor's least value [-]; its largest is at most 1.
    slope : Array
        Largest absolute value of its derivative by v_i [s/m].
    bend : Array
        Largest absolute value of its second derivative by v_i [s^2/m^2].
    constant_below : Array or float
        |U_P| [m/s] below which the factor is constant but for rounding; the same for all v_i.
    """

    least: Array
    slope: Array
    bend: Array
    constant_below: Array | float = 0.0


class WakeFactor(Protocol):
    """A correction that multiplies the momentum thrust by at most 1, such as tip loss."""

    def factor_slope(self, at: Annulus, inflow: Array) -> tuple[Array, Array]:
        """The factor [-] of the annulus ``at`` and its derivative by ``inflow`` [s/m]."""
        ...

    def bounds(self, at: Annulus, low: Array, high: Array) -> FactorBounds:
        """Bounds of the factor ``at`` an annulus for v_i between ``low`` and ``high`` [m/s]."""
        ...


class Wake(NamedTuple):
    """Momentum thrust of an annulus as a function of its inflow, with corrections; a pytree.

    Attributes
    ----------
    windmill : Array or None
        1 on the windmill branch, else 0, shape (B,); None where nothing descends.
    factors : tuple of WakeFactor
        Corrections, by which the momentum thrust is multiplied.
    """

    windmill: Array | None
    factors: tuple[WakeFactor, ...] = ()

    def thrust_slope(self, at: Annulus, inflow: Array) -> tuple[Array, Array]:
        """Thrust ``at`` an annulus, per radius and density [m^3/s^2]; its derivative [m^2/s].

        Eq. (10) times the factors; the derivative is that by the ``inflow`` [m/s].
        """
        flow = (at.radius, at.v_axial, at.v_inplane, inflow)
        thrust, slope = momentum.annulus_thrust_slope(*flow)
        if self.windmill is not None:
            down = self.windmill > 0.0
            other, other_slope = momentum.windmill_annulus_thrust_slope(*flow)
            thrust, slope = xp.where(down, other, thrust), xp.where(down, other_slope, slope)
        for factor in self.factors:
            f, f_slope = factor.factor_slope(at, inflow)
            thrust, slope = f * thrust, f * slope + f_slope * thrust
        return thrust, slope

    @property
    def is_plain(self) -> bool:
        """Whether the thrust is that of momentum theory alone."""
        return not self.factors

    def least_factor(self, at: Annulus, highest: Array) -> Array:
        """Lower bound of the product of the factors ``at`` an annulus [-].

        It holds for U_P >= 0 and v_i up to ``highest`` [m/s].
        """
        least = xp.ones_like(highest)
        for factor in self.factors:
            least = least * factor.bounds(at, -at.v_axial + 0.0 * highest, highest).least
        return least

    def shorter_reaches(self, at: Annulus, inflow: Array) -> list[Array]:
        """Distances [m/s] below ``inflow`` within which bounds ``at`` an annulus may be tighter.

        A factor bends most near U_P = 0: the distances are half of the way there, and the way to
        where the factor is constant.
        """
        u = xp.abs(at.v_axial + inflow)
        return [0.5 * u] * bool(self.factors) + [
            u + factor.bounds(at, inflow, inflow).constant_below for factor in self.factors
        ]

    def nearly_axial(self, at: Annulus) -> Array:
        """Whether V sin(beta) ``at`` an annulus is below ``NEARLY_AXIAL``."""
        return at.v_inplane <= NEARLY_AXIAL * (at.turning + xp.abs(at.v_axial))

    def above_axial(self, at: Annulus, inflow: Array) -> tuple[Array, Array]:
        """Thrust ``at`` an annulus less that with V sin(beta) = 0, and its derivative.

        The ``inflow`` and the units are as in ``thrust_slope``.  Both thrusts are those of the
        helicopter branch, which climb always is on.
        """
        radius, v_axial = at.radius, at.v_axial
        through = xp.abs(v_axial + inflow)
        oblique, oblique_slope = momentum.annulus_thrust_slope(
            radius, v_axial, at.v_inplane, inflow
        )
        per_radius = 4.0 * np.pi * radius
        signed = xp.where(v_axial + inflow < 0.0, -inflow, inflow)
        thrust = oblique - per_radius * inflow * through
        slope = oblique_slope - per_radius * (through + signed)
        for factor in self.factors:
            f, f_slope = factor.factor_slope(at, inflow)
            thrust, slope = f * thrust, f * slope + f_slope * thrust
        return thrust, slope

    def most_below_axial(self, at: Annulus, low: Array) -> Array:
        """Upper bound of the thrust with V sin(beta) = 0 less that ``at`` an annulus.

        It holds on the helicopter branch for every v_i from ``low`` [m/s] on; the unit is m^3/s^2.
        The mass flow of (10) exceeds that of axial flow by at most V sin(beta), and only for
        v_i < 0 makes that the thrust smaller.
        """
        return 4.0 * np.pi * at.radius * at.v_inplane * xp.maximum(-low, 0.0)

    def largest_bend(self, at: Annulus, low: Array, high: Array) -> Array:
        """Upper bound of -d^2T/dv_i^2 [m], T being the thrust ``at`` an annulus.

        It holds for v_i from ``low`` to ``high`` [m/s] as far as these are on the same side of
        U_P = 0 as ``high``.
        """
        u_low, u = at.v_axial + low, at.v_axial + high
        v_max = xp.maximum(xp.abs(high), xp.abs(low))
        # d^2T/dv^2 of (10) is 4 pi y (2 u/W + v (V sin(beta))^2 / W^3) with u = V cos(beta) + v.
        nearest = floored_norm(at.v_inplane, xp.where(u > 0.0, xp.maximum(u_low, 0.0), u))
        turn = at.v_inplane**2 / nearest**3
        # The second term is negative for v < 0 alone.  There |v| is at most V cos(beta) if u > 0,
        # and at most |u| more if u < 0; u (V sin(beta))^2 / W^3 is at most 2/sqrt(27).  Only nearly
        # axial flow, where ``turn`` is large, needs a bound as close as that.
        nearly_axial = self.nearly_axial(at)
        climb = xp.where(nearly_axial, xp.maximum(at.v_axial, 0.0), v_max) * turn
        negative = xp.maximum(-low, 0.0) * turn
        below = xp.minimum(negative, 0.385 + climb)
        if self.windmill is not None:
            # Where (10) is mirrored, its second derivative has the other sign; see
            # ``momentum.windmill_annulus_thrust_slope`` for its weight.
            steep = xp.maximum(at.v_axial**2, SPEED_FLOOR**2)
            weight = self.windmill * xp.minimum(8.0 * at.v_inplane**2 / steep, 1.0)
            below = below + weight * v_max * turn
        below = 2.0 + xp.where(nearly_axial, below, v_max * turn)
        bend = xp.where(u > 0.0, xp.minimum(negative, climb), below)
        if self.factors:
            along = floored_norm(at.v_inplane, xp.maximum(xp.abs(u), xp.abs(u_low)))
            slope, thrust = along + v_max, v_max * along
            if self.windmill is not None:
                # The mirrored curve exceeds (10) by at most twice its value at the turning point.
                down = self.windmill * xp.abs(at.v_axial)
                slope, thrust = slope + along + down, thrust + down * down
            for factor in self.factors:
                f = factor.bounds(at, low, high)
                # Second and first derivative of the product, each term at its largest.
                bend = bend + 2.0 * f.slope * slope + f.bend * thrust
                slope = slope + f.slope * thrust
        return 4.0 * np.pi * at.radius * bend
