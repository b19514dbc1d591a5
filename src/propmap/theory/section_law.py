"""Lift and drag of a blade section, eqs. (3) and (4)."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from propmap.theory.parameters import Array, Medium, Section


def attached_share(alpha: Array, section: Section) -> Array:
    """1 - sigma(alpha) [-]: the share of attached flow in the blend of eq. (3).

    alpha : any shape [rad], angle of attack from zero lift, in [-pi, pi].

    The paper writes sigma as (1 + A + B) / ((1 + A)(1 + B)) with A = exp(-M (a - a0)) and
    B = exp(M (a + a0)), which overflows in float32 near 1.4 rad.  The same function is
    1 - 1 / (1 + 1/A + 1/B + 1/(A B)); with one exponential and a cap on its argument it
    neither overflows nor loses its derivative.
    """
    m, a0 = section.sharpness, section.alpha_0
    rise = jnp.exp(jnp.minimum(m * (jnp.abs(alpha) - a0), 60.0))
    both = jnp.exp(-2.0 * m * a0)
    return section.attached / (1.0 + rise + both / rise + both)


def attached_share_slope(alpha: Array, share: Array, section: Section) -> Array:
    """Derivative of ``attached_share`` [1/rad] at alpha, given its value ``share`` there."""
    m = section.sharpness
    rise = jnp.exp(jnp.minimum(m * (jnp.abs(alpha) - section.alpha_0), 60.0))
    both = jnp.exp(-2.0 * m * section.alpha_0)
    return -jnp.sign(alpha) * m * share * share * (rise - both / rise)


def angle_of_attack(along: Array, across: Array, speed: Array) -> Array:
    """Angle of attack from zero lift [rad], wrapped to [-pi, pi], without ``atan2``.

    along, across : U cos(alpha) and U sin(alpha) [m/s]; speed : U > 0 [m/s].

    XLA evaluates ``atan2`` on a CPU one element at a time (24 ns); the half-angle form
    needs only ``atan``, which it vectorises (5 ns).
    """
    half = jnp.arctan(across / (speed + jnp.abs(along)))
    behind = jnp.where(across < 0.0, -np.pi, np.pi) - 2.0 * half
    return jnp.where(along < 0.0, behind, 2.0 * half)


def lift_coefficient(alpha: Array, section: Section) -> Array:
    """C_L [-] at the geometric angle of attack alpha [rad], any shape; eq. (3).

    With ``section.attached = 0`` it is the simplified lift of footnote 1,
    C_L = c_l2 sin(a) cos(a).  The zero-lift angle is this project's one addition.
    """
    sine, cosine = (
        jnp.sin(alpha - section.zero_lift_angle),
        jnp.cos(alpha - section.zero_lift_angle),
    )
    a = angle_of_attack(cosine, sine, jnp.ones_like(sine))
    share = attached_share(a, section)
    return share * section.c_l1 * a + (1.0 - share) * section.c_l2 * sine * cosine  # Eq. (3)


def drag_coefficient(alpha: Array, reynolds: Array, section: Section) -> Array:
    """C_D [-] at the geometric angle of attack alpha [rad] and Reynolds number [-]; eq. (4)."""
    sine = jnp.sin(alpha - section.zero_lift_angle)
    friction = 2.0 * 1.02 * section.c_p / jnp.sqrt(reynolds)
    return section.c_d * sine**2 + friction + section.c_d0  # Eq. (4)


def friction_chord(chord: Array, section: Section, medium: Medium) -> Array:
    """c * (2 * 1.02 c_p / sqrt(Re)) * sqrt(U) [m^1.5 s^-0.5], the friction term of (4) times chord.

    With Re = rho U c / mu the chord's own root stays in the numerator, so the term goes to
    zero at a pointed tip, where Re does too and the coefficient itself is infinite.
    """
    root = jnp.sqrt(jnp.maximum(medium.viscosity * chord / medium.density, 1e-30))
    return 2.0 * 1.02 * section.c_p * root


def largest_lift(section: Section) -> Array:
    """An upper bound of |C_L| [-] over all angles of attack, eq. (3)."""
    knee = jnp.maximum(section.alpha_0, 1.0 / section.sharpness)
    return section.attached * section.c_l1 * knee + 0.5 * section.c_l2


def steepest_lift(section: Section) -> Array:
    """An upper bound of dC_L/dalpha [1/rad] over all angles of attack, eq. (3).

    Where c_l1 >= c_l2 the blend only takes lift away, so the larger slope bounds it.
    Otherwise the blend adds at most M/4 times the difference at the knee.
    """
    gain = jnp.maximum(section.c_l2 - section.attached * section.c_l1, 0.0)
    knee = section.alpha_0 + 3.0 / section.sharpness
    return jnp.maximum(section.c_l1, section.c_l2) + 0.25 * section.sharpness * gain * knee


def sharpest_lift(section: Section) -> Array:
    """An upper bound of |d^2 C_L/dalpha^2| [1/rad^2] over all angles of attack, eq. (3).

    The logistic blend has a second derivative of at most 0.0963 M^2 and a slope of at most
    M/4; they act on the difference of the attached and the separated lift about the knee.
    """
    m = section.sharpness
    knee = section.alpha_0 + 3.0 / m
    attached, separated = section.attached * section.c_l1, section.c_l2
    drop = jnp.abs(attached * knee - 0.5 * separated * jnp.sin(2.0 * knee))
    return 0.0963 * m * m * drop + 0.5 * m * jnp.abs(attached + separated) + 2.0 * separated
