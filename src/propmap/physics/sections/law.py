"""What a section law is: lift and drag of a blade section, and bounds on them.

A law is a pytree of arrays, so that loads can be differentiated by its parameters.  To add one,
write a file beside this one and name it in ``propmap.physics.sections``.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from propmap.arrays.namespace import Array, xp
from propmap.physics.velocities import angle_of


class SectionFlow(NamedTuple):
    """The flow that a section meets; arrays of one shape.

    Attributes
    ----------
    angle : Array
        Angle of attack from zero lift [rad], in [-pi, pi].
    sine, cosine : Array
        Of that angle [-].
    reynolds : Array
        Re = rho U c / mu [-].
    inverse_root_reynolds : Array
        1 / sqrt(Re) [-].
    """

    angle: Array
    sine: Array
    cosine: Array
    reynolds: Array
    inverse_root_reynolds: Array


class Coefficients(NamedTuple):
    """Lift and drag coefficients and how they change.

    Attributes
    ----------
    lift, drag : Array
        C_L and C_D [-].
    lift_slope, drag_slope : Array
        Derivatives by the angle of attack [1/rad].
    lift_by_log_re, drag_by_log_re : Array or float
        Derivatives by the natural logarithm of Re [-].
    """

    lift: Array
    drag: Array
    lift_slope: Array
    drag_slope: Array
    lift_by_log_re: Array | float
    drag_by_log_re: Array | float


class LawBounds(NamedTuple):
    """Bounds over all angles of attack and Reynolds numbers, from which safe steps follow.

    A dash is a derivative by the angle, an l one by ln Re, which changes with the inflow too.

    Attributes
    ----------
    lift : Array
        Largest |C_L| [-].
    lift_bend : Array
        Largest |C_L''| + |C_L,l| + |C_L,l'| + |C_L,ll| [-].
    foot_bend : Array
        The same with C_L'' upwards alone, where alpha > ``attached_from`` [-].
    attached_bend : Array
        The same between ``attached_from`` and ``attached_to`` [-]; zero where C_L depends on alpha
        alone and bends downwards only.
    drag_bend : Array
        Largest |k^2 s (C_D + C_D'')| + 2 |s C_D - k C_D'| for any k^2 + s^2 = 1, and
        3 (|C_D,l| + |C_D,l'| + |C_D,ll|) [-]; without friction.
    friction : Array or float
        f of a part f / sqrt(Re) of C_D [-].
    attached_from, attached_to : Array
        Angles from zero lift [rad] between which no part of the section is near stall.
    attached_slope : Array
        c with C_L <= c alpha for attached flow, alpha > 0, and near it [1/rad]; 0 if there is
        no such slope.
    least_stall_angle, stall_width : Array
        Angle from zero lift about which lift breaks down, and over how much of it [rad].
    """

    lift: Array
    lift_bend: Array
    foot_bend: Array
    attached_bend: Array
    drag_bend: Array
    friction: Array | float
    attached_from: Array
    attached_to: Array
    attached_slope: Array
    least_stall_angle: Array
    stall_width: Array


class SectionLaw(Protocol):
    """Lift and drag of a section at any angle of attack and Reynolds number."""

    @property
    def zero_lift_angle(self) -> Array:
        """Angle of attack, from the chord line, at which ``SectionFlow.angle`` is zero [rad]."""
        ...

    @property
    def drag_factor(self) -> Array | float:
        """What the rotor drag (14) is multiplied by [-]; 1 in the paper."""
        ...

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the numbers by which loads can be differentiated."""
        ...

    def plus(self, **changes: Array) -> SectionLaw:
        """The law with ``changes`` added to its parameters of these names."""
        ...

    def coefficients(self, flow: SectionFlow) -> Coefficients:
        """C_L, C_D and their derivatives in this ``flow``."""
        ...

    def attached_share(self, angle: Array) -> Array:
        """Share of attached flow [-], 1 far from stall; ``angle`` from zero lift [rad]."""
        ...

    def stall_angle(self, reynolds: Array, side: Array) -> Array:
        """Angle from zero lift about which lift breaks down [rad].

        Parameters
        ----------
        reynolds : Array
            Re [-].
        side : Array
            1 for positive angles, -1 for negative ones, whose sign the result has.
        """
        ...

    def bounds(self) -> LawBounds:
        """Bounds on the coefficients."""
        ...


def coefficients_at(law: SectionLaw, alpha: Array, reynolds: Array) -> Coefficients:
    """C_L and C_D of a law, as an aerodynamicist asks for them.

    Parameters
    ----------
    law : SectionLaw
        The law.
    alpha : Array
        Angle of attack from the chord line [rad].
    reynolds : Array
        Re [-]; broadcast with ``alpha``.
    """
    alpha, reynolds = xp.broadcast_arrays(alpha - law.zero_lift_angle, reynolds)
    sine, cosine = xp.sin(alpha), xp.cos(alpha)
    angle = angle_of(cosine, sine, xp.ones_like(sine))
    return law.coefficients(SectionFlow(angle, sine, cosine, reynolds, 1.0 / xp.sqrt(reynolds)))
