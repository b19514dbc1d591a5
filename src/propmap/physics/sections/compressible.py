"""Lift that grows with the Mach number, by the rule of Prandtl and Glauert."""

from __future__ import annotations

import math
from dataclasses import dataclass

from jax.tree_util import register_dataclass

from propmap.arrays.namespace import Array, xp
from propmap.physics.sections.law import Coefficients, LawBounds, SectionFlow
from propmap.physics.sections.wrapped import WrappedLaw

EXACT_BELOW = 0.6
"""Mach number [-] up to which the rule is used as it is."""

LARGEST_MACH = 0.7
"""Mach number [-] that is put into the rule above some 0.79, where shocks would end it; between the
two it goes over smoothly."""

_FIRST = EXACT_BELOW**2
_LAST = 2.0 * LARGEST_MACH**2 - _FIRST

LARGEST_FACTOR = 1.0 / math.sqrt(1.0 - LARGEST_MACH**2)
LARGEST_SLOPE, LARGEST_BEND = 0.75, 8.3
"""Bounds on the factor [-] and on its first and second derivative by the logarithm of speed."""


@register_dataclass
@dataclass(frozen=True)
class CompressibleLaw(WrappedLaw):
    """The law in it with its lift divided by sqrt(1 - M^2), M being the local Mach number.

    The lift of separated flow is raised with the rest; drag is left as it is, without the rise
    that shocks bring.

    Attributes
    ----------
    law : SectionLaw
        The law in it.
    speed_of_sound : Array
        [m/s].

    References
    ----------
    H. Glauert, "The Effect of Compressibility on the Lift of an Aerofoil", Proc. R. Soc. A
    118(779), 1928, doi 10.1098/rspa.1928.0039.
    """

    speed_of_sound: Array

    def coefficients(self, flow: SectionFlow) -> Coefficients:
        """C_L, C_D and their derivatives in this ``flow``."""
        c = self.law.coefficients(flow)
        factor, slope = mach_factor(flow.speed / self.speed_of_sound)
        return c._replace(
            lift=factor * c.lift,
            lift_slope=factor * c.lift_slope,
            # At a section the logarithms of Re and of the speed differ by a constant.
            lift_by_log_re=factor * c.lift_by_log_re + slope * c.lift,
        )

    def bounds(self) -> LawBounds:
        """Bounds on the coefficients, from those of the law in it.

        The lift of a section is periodic, so that |C_L'|^2 <= 2 max |C_L| max |C_L''| (Landau).
        """
        old = self.law.bounds()
        steepest = xp.sqrt(2.0 * old.lift * old.lift_bend)

        def raised(bend: Array) -> Array:
            # Each derivative of the product of factor and C_L, every term at its largest.
            first = old.lift + steepest + 2.0 * bend
            return LARGEST_FACTOR * bend + LARGEST_SLOPE * first + LARGEST_BEND * old.lift

        return old._replace(
            lift=LARGEST_FACTOR * old.lift,
            lift_bend=raised(old.lift_bend),
            foot_bend=raised(old.foot_bend),
            attached_bend=raised(old.attached_bend),
            attached_slope=LARGEST_FACTOR * old.attached_slope,
        )


def mach_factor(mach: Array) -> tuple[Array, Array]:
    """1/sqrt(1 - M^2) [-] and its derivative by ln M, with M limited; shape of ``mach`` [-]."""
    square = mach * mach
    # The limited square rises with slope 1, then ever more slowly, a parabola, up to its end.
    inside = xp.minimum(square, _LAST)
    past = xp.maximum(inside - _FIRST, 0.0)
    width = _LAST - _FIRST
    limited = inside - past * past * (0.5 / width)
    factor = 1.0 / xp.sqrt(1.0 - limited)
    return factor, factor * factor * factor * inside * (1.0 - past / width)
