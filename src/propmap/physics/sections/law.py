"""The protocol of a section law: lift and drag of a blade section, and bounds on them.

A law is a pytree of arrays, so that loads can be differentiated with respect to its parameters.
How to add one: docs/architecture.md.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from propmap.arrays.namespace import Array, xp
from propmap.physics.velocities import angle_of


class SectionFlow(NamedTuple):
    """The flow at a section; arrays of one shape.

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
    drag_sine, drag_cosine : Array or None
        Sine and cosine of the angle of attack from ``SectionLaw.least_drag_angle`` [-]; None where
        that is None.
    speed : Array or float
        U [m/s]; 0 where it is not known, as for curves of a section by itself.
    chord, radius : Array or float
        c and y [m]; by default a section that is far from the axis.
    """

    angle: Array
    sine: Array
    cosine: Array
    reynolds: Array
    inverse_root_reynolds: Array
    drag_sine: Array | None = None
    drag_cosine: Array | None = None
    speed: Array | float = 0.0
    chord: Array | float = 0.0
    radius: Array | float = 1.0

    @property
    def from_least_drag(self) -> tuple[Array, Array]:
        """Sine and cosine of the angle from that of least pressure drag [-]."""
        if self.drag_sine is None or self.drag_cosine is None:
            return self.sine, self.cosine
        return self.drag_sine, self.drag_cosine


class Coefficients(NamedTuple):
    """Lift and drag coefficients with their derivatives.

    Attributes
    ----------
    lift, drag : Array
        C_L and C_D [-].
    lift_slope, drag_slope : Array
        Derivatives with respect to the angle of attack [1/rad].
    lift_by_log_re, drag_by_log_re : Array or float
        Derivatives with respect to ln Re [-]; at a section that is the logarithm of the speed, so
        they include whatever else depends on the speed.
    """

    lift: Array
    drag: Array
    lift_slope: Array
    drag_slope: Array
    lift_by_log_re: Array | float
    drag_by_log_re: Array | float


class LawBounds(NamedTuple):
    """Bounds on a law over all angles of attack and Reynolds numbers, for ``solve.bounds``.

    A prime is a derivative with respect to the angle; an index l, one with respect to ln Re, which
    like the angle depends on the inflow.

    Attributes
    ----------
    lift : Array
        Largest |C_L| [-].
    lift_bend : Array
        Largest |C_L''| + |C_L,l| + |C_L,l'| + |C_L,ll| [-].
    foot_bend : Array
        The same for alpha > ``attached_from``, with max(C_L'', 0) in place of |C_L''| [-].
    attached_bend : Array
        ``foot_bend`` between ``attached_from`` and ``attached_to`` [-]; zero for a concave C_L that
        depends on alpha alone.
    drag_bend : Array
        Largest |k^2 s (C_D + C_D'')| + 2 |s C_D - k C_D'| for any k^2 + s^2 = 1, and
        3 (|C_D,l| + |C_D,l'| + |C_D,ll|) [-]; without friction.
    friction : Array or float
        f, where C_D has a term f / sqrt(Re) [-].
    attached_from, attached_to : Array
        Angles from zero lift [rad] between which the section is far from stall.
    attached_slope : Array
        c such that in attached flow, for alpha > 0, C_L is little less than c alpha and never more
        [1/rad]; 0 if there is no such c.
    least_stall_angle, stall_width : Array
        Angle from zero lift at which the section stalls, and width of that range [rad].
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

    def zero_lift_at(self, reynolds: Array) -> Array:
        """Angle of attack, from the chord line, at which ``SectionFlow.angle`` is zero [rad].

        Parameters
        ----------
        reynolds : Array
            Re of the rotation alone, rho Omega y c / mu [-].  The result is broadcast with it, or a
            scalar where it does not depend on it.
        """
        ...

    @property
    def least_drag_angle(self) -> Array | None:
        """Angle of attack, from the chord line, about which ``SectionFlow.drag_sine`` is [rad].

        None where the law knows no other angle than that from zero lift.
        """
        ...

    @property
    def drag_factor(self) -> Array | float:
        """Factor on the rotor drag (14) [-]; 1 in the paper."""
        ...

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters with respect to which loads can be differentiated."""
        ...

    def plus(self, **changes: Array) -> SectionLaw:
        """The law with ``changes`` added to its parameters of these names."""
        ...

    def coefficients(self, flow: SectionFlow) -> Coefficients:
        """C_L, C_D and their derivatives in this ``flow``."""
        ...

    def attached_share(self, angle: Array) -> Array:
        """Share of attached flow [-], 1 below stall; ``angle`` is from zero lift [rad]."""
        ...

    def stall_angle(self, reynolds: Array, side: Array) -> Array:
        """Angle from zero lift at which the section stalls [rad].

        Parameters
        ----------
        reynolds : Array
            Re [-].
        side : Array
            1 for stall at positive angles, -1 at negative ones; the result has this sign.
        """
        ...

    def bounds(self) -> LawBounds:
        """Bounds on the coefficients."""
        ...


def coefficients_at(law: SectionLaw, alpha: Array, reynolds: Array) -> Coefficients:
    """C_L and C_D of a law at an angle from the chord line and a Reynolds number.

    Parameters
    ----------
    law : SectionLaw
        The law.
    alpha : Array
        Angle of attack from the chord line [rad].
    reynolds : Array
        Re [-], also that of the rotation; broadcast with ``alpha``.
    """
    chord, reynolds = xp.broadcast_arrays(alpha, reynolds)
    alpha = chord - law.zero_lift_at(reynolds)
    sine, cosine = xp.sin(alpha), xp.cos(alpha)
    angle = angle_of(cosine, sine, xp.ones_like(sine))
    flow = SectionFlow(angle, sine, cosine, reynolds, 1.0 / xp.sqrt(reynolds))
    if law.least_drag_angle is not None:
        tilt = chord - law.least_drag_angle
        flow = flow._replace(drag_sine=xp.sin(tilt), drag_cosine=xp.cos(tilt))
    return law.coefficients(flow)
