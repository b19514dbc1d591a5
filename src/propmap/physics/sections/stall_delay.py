"""Lift beyond stall near the hub, where rotation holds the separated flow on the blade."""

from __future__ import annotations

import math
from dataclasses import dataclass

from jax.tree_util import register_dataclass

from propmap.arrays.namespace import Array, xp
from propmap.physics.sections.law import Coefficients, LawBounds, SectionFlow
from propmap.physics.sections.wrapped import WrappedLaw

FADE_FROM, FADE_TO = math.radians(30.0), math.radians(60.0)
"""Angles from zero lift [rad] between which the effect fades; Snel's method is for small ones."""

_WIDTH = FADE_TO - FADE_FROM
_STEEPEST, _BENT = 0.5 * math.pi / _WIDTH, 0.5 * (math.pi / _WIDTH) ** 2
_LARGEST_ANGLE = 0.57
"""Bound on the angle times its weight [rad]."""


@register_dataclass
@dataclass(frozen=True)
class StallDelayLaw(WrappedLaw):
    """The law in it with a share of the lift back that is lost by stall.

    C_L + min(k (c/y)^2, 1) w (s a - C_L), s being the attached lift's slope, a the angle from zero
    lift and w a weight, 1 up to ``FADE_FROM`` on either side and 0 from ``FADE_TO`` on.  Drag is
    left as it is.  Made for the slender blades of wind turbines: where c/y is large no stall is
    left.

    Attributes
    ----------
    law : SectionLaw
        The law in it.
    strength : Array
        k [-].

    References
    ----------
    H. Snel, R. Houwink, J. Bosschers, "Sectional Prediction of Lift Coefficients on Rotating Wind
    Turbine Blades in Stall", ECN-C--93-052, 1994, which has the lift of a thin plate for s a.
    """

    strength: Array

    def coefficients(self, flow: SectionFlow) -> Coefficients:
        """C_L, C_D and their derivatives in this ``flow``."""
        c = self.law.coefficients(flow)
        slope = self.law.bounds().attached_slope
        weight, weight_slope = _weight(flow.angle)
        share = xp.minimum(self.strength * (flow.chord / flow.radius) ** 2, 1.0)
        lost = slope * flow.angle - c.lift
        more, kept = share * weight, 1.0 - share * weight
        return c._replace(
            lift=c.lift + more * lost,
            lift_slope=kept * c.lift_slope + more * slope + share * weight_slope * lost,
            lift_by_log_re=kept * c.lift_by_log_re,
        )

    def bounds(self) -> LawBounds:
        """Bounds on the coefficients from those of the law in it, for any share up to 1.

        The lift of a section is periodic, so that |C_L'|^2 <= 2 max |C_L| max |C_L''| (Landau).
        In the attached range, here at most up to ``FADE_FROM``, the weight is 1: what is added to
        C_L is straight there, and C_L stays below its tangent.
        """
        old = self.law.bounds()
        slope = xp.abs(old.attached_slope)
        steepest = xp.sqrt(2.0 * old.lift * old.lift_bend)
        # Second derivative of the weight times what is lost, each term at its largest.
        fading = 2.0 * _STEEPEST * (steepest + slope) + _BENT * (old.lift + FADE_TO * slope)
        return old._replace(
            lift=old.lift + _LARGEST_ANGLE * slope,
            lift_bend=(1.0 + _STEEPEST) * old.lift_bend + fading,
            foot_bend=(1.0 + _STEEPEST) * old.foot_bend + fading,
            attached_from=xp.maximum(old.attached_from, -FADE_FROM),
            attached_to=xp.minimum(old.attached_to, FADE_FROM),
        )


def _weight(angle: Array) -> tuple[Array, Array]:
    """Half a cosine from 1 to 0, and its derivative [1/rad], at an ``angle`` from zero lift."""
    size = xp.clip(xp.abs(angle) - FADE_FROM, 0.0, _WIDTH)
    turn = size * (math.pi / _WIDTH)
    return 0.5 + 0.5 * xp.cos(turn), -xp.sign(angle) * _STEEPEST * xp.sin(turn)
