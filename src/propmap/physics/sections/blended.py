"""Lift and drag of a blade section, eqs. (3) and (4)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from propmap.arrays.elementary import arctangent, power_of_two
from propmap.arrays.namespace import Array, xp
from propmap.physics.parameters import Medium, Section


class StallBlend(NamedTuple):
    """What the blend of eq. (3) takes from the section; all scalars.

    attached [-], sharpness [1/rad], alpha_0 [rad] : see ``Section``.
    doublings : M / ln 2 [1/rad].  far : exp(-2 M alpha_0) [-].  Once and not for each element.
    """

    attached: Array
    sharpness: Array
    alpha_0: Array
    doublings: Array
    far: Array


def stall_blend(section: Section) -> StallBlend:
    """The blend of eq. (3) for a section's parameters."""
    far = xp.exp(-2.0 * section.sharpness * section.alpha_0)
    doublings = section.sharpness * (1.0 / math.log(2.0))
    return StallBlend(section.attached, section.sharpness, section.alpha_0, doublings, far)


def attached_share(alpha: Array, blend: StallBlend) -> Array:
    """1 - sigma(alpha) [-]: the share of attached flow in the blend of eq. (3).

    alpha : any shape [rad], angle of attack from zero lift, in [-pi, pi].
    blend : of the section, by ``stall_blend``.

    The paper writes sigma as (1 + A + B) / ((1 + A)(1 + B)) with A = exp(-M (a - a0)) and
    B = exp(M (a + a0)), which overflows in float32 near 1.4 rad.  For a >= 0 the same
    function, which is even, is 1 - x / ((1 + x)(x + e)) with x = 1/A and e = exp(-2 M a0):
    one exponential, and with a cap on its argument no overflow and no lost derivative.
    """
    rise, inverse = _stall_rise(alpha, blend)
    return blend.attached * rise * inverse


def attached_share_and_slope(alpha: Array, blend: StallBlend) -> tuple[Array, Array]:
    """``attached_share`` [-], eq. (3), and its derivative by the angle [1/rad]; shape of alpha.

    alpha [rad], blend : as in ``attached_share``.
    """
    rise, inverse = _stall_rise(alpha, blend)
    share = blend.attached * rise * inverse
    steepness = (rise * rise - blend.far) * inverse
    return share, xp.where(alpha < 0.0, blend.sharpness, -blend.sharpness) * share * steepness


def _stall_rise(alpha: Array, blend: StallBlend) -> tuple[Array, Array]:
    """x and 1 / ((1 + x)(x + e)), see ``attached_share``."""
    angle = blend.doublings * (xp.abs(alpha) - blend.alpha_0)
    # Not ``clip``, whose derivative divides; at 2^58 the square does not overflow in float32.
    rise = power_of_two(xp.where(angle > -58.0, xp.where(angle < 58.0, angle, 58.0), -58.0))
    return rise, 1.0 / ((1.0 + rise) * (rise + blend.far))


def angle_of_attack(along: Array, across: Array, speed: Array) -> Array:
    """Angle of attack from zero lift [rad], wrapped to [-pi, pi], without ``atan2``.

    along, across : U cos(alpha) and U sin(alpha) [m/s]; speed : U > 0 [m/s].

    XLA evaluates ``atan2`` on a CPU one element at a time (24 ns) and ``atan`` hardly faster
    (9 ns); the half-angle form needs the arctangent between -1 and 1 alone, for which a ratio
    of polynomials does (1.2 ns).
    """
    # Not a quotient of two arrays: XLA would make a kernel of its own of that, and of ``speed``.
    half = arctangent(across * (1.0 / (speed + xp.abs(along))))
    behind = xp.where(across < 0.0, -np.pi, np.pi) - 2.0 * half
    return xp.where(along < 0.0, behind, 2.0 * half)


def lift_coefficient(alpha: Array, section: Section) -> Array:
    """C_L [-], eq. (3).

    alpha : any shape [rad], geometric angle of attack.  section : parameters of the law.

    With ``section.attached = 0`` it is the simplified lift of footnote 1,
    C_L = c_l2 sin(a) cos(a).  The zero-lift angle is this project's one addition.
    """
    sine, cosine = (
        xp.sin(alpha - section.zero_lift_angle),
        xp.cos(alpha - section.zero_lift_angle),
    )
    a = angle_of_attack(cosine, sine, xp.ones_like(sine))
    share = attached_share(a, stall_blend(section))
    return share * section.c_l1 * a + (1.0 - share) * section.c_l2 * sine * cosine  # Eq. (3)


def drag_coefficient(alpha: Array, reynolds: Array, section: Section) -> Array:
    """C_D [-], eq. (4).

    alpha [rad], reynolds [-] : geometric angle of attack and Reynolds number; broadcast.
    section : parameters of the law.
    """
    sine = xp.sin(alpha - section.zero_lift_angle)
    friction = 2.0 * 1.02 * section.c_p / xp.sqrt(reynolds)
    return section.c_d * sine**2 + friction + section.c_d0  # Eq. (4)


def friction_chord(chord: Array, section: Section, medium: Medium) -> Array:
    """c * (2 * 1.02 c_p / sqrt(Re)) * sqrt(U) [m^1.5 s^-0.5], the friction term of (4) times chord.

    With Re = rho U c / mu the chord's own root stays in the numerator, so the term goes to
    zero at a pointed tip, where Re does too and the coefficient itself is infinite.
    """
    root = xp.sqrt(xp.maximum(medium.viscosity * chord / medium.density, 1e-30))
    return 2.0 * 1.02 * section.c_p * root


def largest_lift(section: Section) -> Array:
    """An upper bound of |C_L| [-] over all angles of attack, eq. (3)."""
    # alpha (1 - sigma) <= alpha / (1 + exp(M (alpha - a0))), whose largest value is w/M, where
    # w + ln(w) = M a0 - 1.  Newton's steps stay below w, and z - ln of what is below is above it.
    z = section.sharpness * section.alpha_0 - 1.0
    below = xp.maximum(z, 1.0)
    for _ in range(2):
        below = xp.maximum(below * (1.0 + z - xp.log(below)) / (1.0 + below), 1.0)
    knee = xp.where(z > 1.0, z - xp.log(below), 1.0) / section.sharpness
    return section.attached * section.c_l1 * knee + 0.5 * section.c_l2


def steepest_lift(section: Section) -> Array:
    """An upper bound of dC_L/dalpha [1/rad] over all angles of attack, eq. (3).

    Where c_l1 >= c_l2 the blend only takes lift away, so the larger slope bounds it.
    Otherwise the blend adds at most M/4 times the difference at the knee.
    """
    gain = xp.maximum(section.c_l2 - section.attached * section.c_l1, 0.0)
    knee = section.alpha_0 + 3.0 / section.sharpness
    return xp.maximum(section.c_l1, section.c_l2) + 0.25 * section.sharpness * gain * knee


def sharpest_lift(section: Section) -> Array:
    """An upper bound of |d^2 C_L/dalpha^2| [1/rad^2] over all angles of attack, eq. (3).

    The logistic blend has a second derivative of at most 0.0963 M^2 and a slope of at most
    M/4; they act on the difference of the attached and the separated lift about the knee.
    """
    m, attached, separated = section.sharpness, section.attached * section.c_l1, section.c_l2
    by_slope = 0.5 * m * xp.abs(attached + separated)
    return 0.0963 * m * m * _drop_at_knee(section) + by_slope + 2.0 * separated


def sharpest_foot(section: Section) -> Array:
    """An upper bound of d^2 C_L/dalpha^2 [1/rad^2], eq. (3), where alpha > -alpha_0 + 6/M.

    There the lift bends upwards only at the foot of its fall at positive stall, and the blend's
    slope, by which it falls, makes it bend downwards unless c_l2 exceeds c_l1.
    """
    m, attached, separated = section.sharpness, section.attached * section.c_l1, section.c_l2
    gain = xp.maximum(separated - attached, 0.0)
    return 0.0963 * m * m * _drop_at_knee(section) + 0.5 * m * gain + 2.0 * separated


def _drop_at_knee(section: Section) -> Array:
    """The attached lift coefficient less the separated one a little past stall [-], its size."""
    knee = section.alpha_0 + 3.0 / section.sharpness
    attached = section.attached * section.c_l1 * knee
    return xp.abs(attached - 0.5 * section.c_l2 * xp.sin(2.0 * knee))
