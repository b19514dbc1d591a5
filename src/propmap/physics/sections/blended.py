"""The paper's section law, eqs. (3) and (4): attached and separated lift, blended at stall."""

from __future__ import annotations

import math
from typing import NamedTuple

from propmap.arrays.elementary import power_of_two
from propmap.arrays.namespace import Array, xp
from propmap.physics.sections.law import Coefficients, LawBounds, SectionFlow

PLATE_FRICTION = 2.0 * 1.02
"""The factor of c_p in (4): two sides of a plate, and 1.02 for its finite length."""

CAMBER_REYNOLDS = 5e4
"""Reynolds number of the rotation at which the zero-lift angle is ``zero_lift_angle`` [-]."""

CAMBER_RANGE = (1e4, 1.2e5)
"""Reynolds numbers between which the zero-lift angle changes; outside, that of the nearer [-]."""


class BlendedLaw(NamedTuple):
    """Eqs. (3) and (4), and two terms that are not in the paper; all parameters scalars.

    Attributes
    ----------
    c_l1 : Array
        Slope of the attached lift [1/rad].
    c_l2 : Array
        Amplitude of the separated lift [-].
    c_d : Array
        Amplitude of the pressure drag [-].
    alpha_0 : Array
        Angle of attack about which the stall blend is centred [rad].
    zero_lift_angle : Array
        Angle of attack of zero lift [rad]; (3) and (4) see alpha minus it.  Not in the paper,
        whose law has no camber.  See ``zero_lift_at``.
    c_d0 : Array
        Constant drag [-].
    c_p : Array
        Skin-friction constant of the 1/sqrt(Re) term [-].
    sharpness : Array
        M of the blend [1/rad].
    attached : Array
        1 for eq. (3); 0 for the simplified lift of footnote 1, with c_l2 as its c_l.
    drag_factor : Array or float
        Multiplies the rotor drag (14) [-]; 1 in the paper.
    reynolds_camber : Array or None
        h, the growth of the zero-lift angle by ln Re [rad], see ``zero_lift_at``.  None, like 0, is
        the paper's law, and leaves the term out of programs.
    drag_angle : Array or None
        How far above ``zero_lift_angle`` the pressure drag is least [rad], see
        ``least_drag_angle``.  None as above.
    """

    c_l1: Array
    c_l2: Array
    c_d: Array
    alpha_0: Array
    zero_lift_angle: Array
    c_d0: Array
    c_p: Array
    sharpness: Array
    attached: Array
    drag_factor: Array | float = 1.0
    reynolds_camber: Array | None = None
    drag_angle: Array | None = None

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters with respect to which loads can be differentiated."""
        off = [name for name in self._fields if getattr(self, name) is None]
        return tuple(name for name in self._fields if name not in (*off, "attached"))

    def plus(self, **changes: Array) -> BlendedLaw:
        """The law with ``changes`` added to its parameters of these names."""
        old = {name: getattr(self, name) for name in changes}
        return self._replace(**{n: d if old[n] is None else old[n] + d for n, d in changes.items()})

    def zero_lift_at(self, reynolds: Array) -> Array:
        """Angle of attack of zero lift [rad], ``zero_lift_angle`` + h ln(Re / 5e4).

        h is ``reynolds_camber``, and Re that of the rotation alone, rho Omega y c / mu, held
        between 1e4 and 1.2e5.  Not in the paper.  As the inflow is left out, the term turns the
        blade by an angle that is known before (11) is solved, and no bound on (11) changes.

        Parameters
        ----------
        reynolds : Array
            Re [-].
        """
        if self.reynolds_camber is None:
            return self.zero_lift_angle
        low, high = CAMBER_RANGE
        # Not ``clip``, whose derivative has a division.
        inside = xp.where(reynolds > low, xp.where(reynolds < high, reynolds, high), low)
        return self.zero_lift_angle + self.reynolds_camber * xp.log(inside / CAMBER_REYNOLDS)

    @property
    def least_drag_angle(self) -> Array | None:
        """Angle of attack from the chord line at which the pressure drag is least [rad].

        ``zero_lift_angle`` + ``drag_angle``, at any Reynolds number; None stands for the angle of
        zero lift, as in the paper.
        """
        if self.reynolds_camber is None and self.drag_angle is None:
            return None
        return self.zero_lift_angle + (0.0 if self.drag_angle is None else self.drag_angle)

    def coefficients(self, flow: SectionFlow) -> Coefficients:
        """C_L by eq. (3) and C_D by eq. (4) in a ``flow``, with their derivatives.

        The pressure drag is c_d sin^2 of the angle from ``least_drag_angle``.  With
        ``attached = 0``, C_L = c_l sin(a) cos(a) of footnote 1, where c_l is ``c_l2``.
        """
        share, share_slope = self._attached_share_and_slope(flow.angle)
        attached = self.c_l1 * flow.angle
        separated = self.c_l2 * flow.sine * flow.cosine
        separated_slope = self.c_l2 * (flow.cosine * flow.cosine - flow.sine * flow.sine)
        excess = attached - separated
        friction = PLATE_FRICTION * self.c_p * flow.inverse_root_reynolds
        sine, cosine = flow.from_least_drag
        pressure = self.c_d * sine
        return Coefficients(
            lift=separated + share * excess,  # Eq. (3)
            drag=pressure * sine + friction + self.c_d0,  # Eq. (4)
            lift_slope=separated_slope
            + share * (self.c_l1 - separated_slope)
            + share_slope * excess,
            drag_slope=2.0 * pressure * cosine,
            lift_by_log_re=0.0,
            drag_by_log_re=-0.5 * friction,
        )

    def attached_share(self, angle: Array) -> Array:
        """1 - sigma(alpha) of eq. (3) [-] at ``angle`` from zero lift [rad].

        The paper writes sigma as (1 + A + B) / ((1 + A)(1 + B)) with A = exp(-M (a - a0)) and
        B = exp(M (a + a0)), which overflows in float32 near 1.4 rad.  The function is even.  For
        a >= 0 it equals 1 - x / ((1 + x)(x + e)) with x = 1/A and e = exp(-2 M a0): a single
        exponential, which cannot overflow once its argument is limited.
        """
        return self._attached_share_and_slope(angle)[0]

    def _attached_share_and_slope(self, angle: Array) -> tuple[Array, Array]:
        """``attached_share``, and its derivative with respect to the angle [1/rad]."""
        far = xp.exp(-2.0 * self.sharpness * self.alpha_0)
        exponent = self.sharpness * (1.0 / math.log(2.0)) * (xp.abs(angle) - self.alpha_0)
        # Not ``clip``, whose derivative has a division; the square of 2^58 fits into float32.
        x = power_of_two(
            xp.where(exponent > -58.0, xp.where(exponent < 58.0, exponent, 58.0), -58.0)
        )
        inverse = 1.0 / ((1.0 + x) * (x + far))
        share = self.attached * x * inverse  # 1 - sigma of Eq. (3)
        steepness = (x * x - far) * inverse
        return share, xp.where(angle < 0.0, self.sharpness, -self.sharpness) * share * steepness

    def stall_angle(self, reynolds: Array, side: Array) -> Array:  # noqa: ARG002 - as every law
        """alpha_0 [rad] with the sign of ``side``, at any ``reynolds``."""
        return side * self.alpha_0

    def bounds(self) -> LawBounds:
        """Bounds on the coefficients, in closed form."""
        m, attached, separated = self.sharpness, self.attached * self.c_l1, self.c_l2
        largest = self._largest_lift()
        # The logistic blend has slopes up to M/4 and second derivatives up to 0.0963 M^2.  They
        # multiply the difference of attached and separated lift, taken a little past stall.
        knee = self.alpha_0 + 3.0 / m
        drop = xp.abs(attached * knee - 0.5 * separated * xp.sin(2.0 * knee))
        # Where c_l1 >= c_l2 separation only lowers the lift.
        gain = xp.maximum(separated - attached, 0.0)
        blend_bend = 0.0963 * m * m * drop + 2.0 * separated
        return LawBounds(
            lift=largest,
            lift_bend=blend_bend + 0.5 * m * xp.abs(attached + separated),
            foot_bend=blend_bend + 0.5 * m * gain,
            # (1 - sigma) c_l1 alpha has no inflection in the attached range.
            attached_bend=0.0 * largest,
            drag_bend=5.0 * self.c_d + 3.0 * self.c_d0,
            friction=PLATE_FRICTION * self.c_p,
            attached_from=-self.alpha_0 + 6.0 / m,
            attached_to=self.alpha_0,
            attached_slope=attached,
            least_stall_angle=self.alpha_0,
            stall_width=1.0 / m,
        )

    def _largest_lift(self) -> Array:
        # alpha (1 - sigma) <= alpha / (1 + exp(M (alpha - a0))), whose largest value is w/M with
        # w + ln(w) = z = M a0 - 1.  Newton's steps stay below w; from w' < w, z - ln(w') > w.
        z = self.sharpness * self.alpha_0 - 1.0
        below = xp.maximum(z, 1.0)
        for _ in range(2):
            below = xp.maximum(below * (1.0 + z - xp.log(below)) / (1.0 + below), 1.0)
        knee = xp.where(z > 1.0, z - xp.log(below), 1.0) / self.sharpness
        return self.attached * self.c_l1 * knee + 0.5 * self.c_l2
