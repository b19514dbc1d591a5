"""Loads of an annulus from its blade elements, eqs. (5)-(7), averaged over azimuth."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from propmap.arrays.elementary import sine_and_cosine
from propmap.arrays.namespace import Array, in_one_kernel, mean_of_each, settled, xp
from propmap.physics.geometry import StationShape
from propmap.physics.parameters import Blade, Medium, Section
from propmap.physics.sections.blended import (
    StallBlend,
    angle_of_attack,
    attached_share,
    attached_share_and_slope,
    friction_chord,
    stall_blend,
)
from propmap.physics.velocities import (
    AzimuthNodes,
    floored_norm,
    normal_velocity,
    tangential_velocity,
)


class Annulus(NamedTuple):
    """All that the forces on an annulus need except its inflow; arrays that broadcast.

    radius [m], chord [m], friction_chord (``section_law``), sine and cosine of the angle of
    the zero-lift line to the disk plane [-], omega [rad/s], v_axial and v_inplane [m/s],
    blades [-], section, blend (``section_law``).
    """

    radius: Array
    chord: Array
    friction_chord: Array
    sine: Array
    cosine: Array
    omega: Array
    v_axial: Array
    v_inplane: Array
    blades: Array
    section: Section
    blend: StallBlend


class AnnulusLoads(NamedTuple):
    """Loads per radius and density of an annulus, eqs. (5)-(7) and the rolling moment.

    thrust, drag [m^3/s^2], torque, roll_moment [m^4/s^2]; multiply by rho for N/m and N.
    """

    thrust: Array
    drag: Array
    torque: Array
    roll_moment: Array


def annulus(
    shape: StationShape,
    blade: Blade,
    section: Section,
    medium: Medium,
    omega: Array,
    v_axial: Array,
    v_inplane: Array,
) -> Annulus:
    """Collect an annulus; shape (S, 1) or (S, B), omega and velocities (B,) or scalar."""
    sine, cosine = settled(
        lambda: sine_and_cosine(shape.twist - section.zero_lift_angle), blade.root
    )
    return Annulus(
        radius=shape.radius,
        chord=shape.chord,
        friction_chord=friction_chord(shape.chord, section, medium),
        sine=sine,
        cosine=cosine,
        omega=omega,
        v_axial=v_axial,
        v_inplane=v_inplane,
        blades=blade.blades,
        section=section,
        blend=stall_blend(section),
    )


def _velocities(at: Annulus, inflow: Array, sine: Array) -> tuple[Array, Array]:
    u_t = tangential_velocity(at.omega, at.radius, at.v_inplane, sine)
    u_p = normal_velocity(at.v_axial, inflow)
    return in_one_kernel(u_t, at.blades), in_one_kernel(u_p, at.blades)


def element_forces(at: Annulus, inflow: Array, sine: Array) -> tuple[Array, Array]:
    """Normal and tangential force of one blade element per radius and density [m^3/s^2].

    at : annulus; inflow : v_i [m/s]; sine : sin(psi) [-]; broadcast.
    Normal is along the thrust, tangential against the rotation (dL sin(phi) + dD cos(phi)).
    sin(phi) = U_P/U and cos(phi) = U_T/U, so that reverse flow needs no case of its own.
    """
    u_t, u_p = _velocities(at, inflow, sine)
    u = floored_norm(u_t, u_p)
    across = at.sine * u_t - at.cosine * u_p  # U sin(alpha)
    along = at.cosine * u_t + at.sine * u_p  # U cos(alpha)
    alpha = angle_of_attack(along, across, u)
    law = at.section
    share = attached_share(alpha, at.blend)
    # U C_L and U C_D times the chord, eqs. (3)(4): sin and cos of alpha come without
    # trigonometry from the velocities.
    per_u = 1.0 / u
    lift = share * law.c_l1 * alpha * u + (1.0 - share) * law.c_l2 * across * along * per_u
    drag = law.c_d * across * across * per_u + law.c_d0 * u
    lift, drag = at.chord * lift, at.chord * drag + at.friction_chord * xp.sqrt(u)
    normal = 0.5 * (lift * u_t - drag * u_p)
    tangential = 0.5 * (lift * u_p + drag * u_t)
    return normal, tangential


def element_thrust_slope(at: Annulus, inflow: Array, sine: Array) -> tuple[Array, Array]:
    """``element_forces``' normal force [m^3/s^2] and its derivative by the inflow [m^2/s].

    Written out because the search for the root spends its time here: automatic
    differentiation evaluates the same expressions at 1.5 times the cost.  A test holds it
    to ``element_forces`` and its derivative.
    """
    law = at.section
    u_t, u_p = _velocities(at, inflow, sine)
    u = floored_norm(u_t, u_p)
    per_u = 1.0 / u
    across = at.sine * u_t - at.cosine * u_p
    along = at.cosine * u_t + at.sine * u_p
    alpha = angle_of_attack(along, across, u)
    share, share_slope = attached_share_and_slope(alpha, at.blend)
    root = xp.sqrt(u)

    # Sine and cosine of the inflow angle, of which the sine is dU/dv, and of the angle of attack.
    rising, turning = u_p * per_u, u_t * per_u
    sine_alpha, cosine_alpha = across * per_u, along * per_u
    attached = law.c_l1 * alpha * u
    d_attached = law.c_l1 * (alpha * rising - turning)
    separated = law.c_l2 * sine_alpha * along
    d_separated = law.c_l2 * (
        sine_alpha * (at.sine - cosine_alpha * rising) - at.cosine * cosine_alpha
    )
    excess = attached - separated
    lift = separated + share * excess
    d_lift = (
        d_separated + share * (d_attached - d_separated) - share_slope * turning * per_u * excess
    )
    pressure = law.c_d * sine_alpha
    drag = at.chord * (pressure * across + law.c_d0 * u) + at.friction_chord * root
    d_drag = (
        at.chord * (law.c_d0 * rising - pressure * (2.0 * at.cosine + sine_alpha * rising))
        + 0.5 * at.friction_chord * root * per_u * rising
    )
    normal = 0.5 * (at.chord * lift * u_t - drag * u_p)
    return normal, 0.5 * (at.chord * d_lift * u_t - d_drag * u_p - drag)


def _over_azimuth(term: Callable[[Array], Any], azimuth: AzimuthNodes) -> Any:
    """Mean over the azimuth nodes of term(sin(psi)), an array or a tree of arrays."""
    sines = xp.asarray(azimuth.sines)
    if isinstance(azimuth.count, int) and azimuth.count == 1:
        return settled(lambda: term(sines[0]), sines[0])
    return mean_of_each(term, sines, azimuth.count)


def annulus_thrust(at: Annulus, inflow: Array, azimuth: AzimuthNodes) -> Array:
    """Thrust of the blade elements per radius and density [m^3/s^2], eq. (5), shape of inflow.

    at : annuli.  inflow : v_i [m/s], broadcast with them.  azimuth : nodes to average over.
    """
    mean: Array = _over_azimuth(lambda s: element_forces(at, inflow, s)[0], azimuth)
    return at.blades * mean


def annulus_thrust_slope(at: Annulus, inflow: Array, azimuth: AzimuthNodes) -> tuple[Array, Array]:
    """``annulus_thrust`` and its derivative by the inflow [m^2/s]; shape of inflow."""
    thrust, slope = _over_azimuth(lambda s: element_thrust_slope(at, inflow, s), azimuth)
    return at.blades * thrust, at.blades * slope


def annulus_loads(at: Annulus, inflow: Array, azimuth: AzimuthNodes) -> AnnulusLoads:
    """All loads of an annulus per radius and density, eqs. (5)-(7); shape of inflow.

    at, inflow, azimuth : as in ``annulus_thrust``.
    """

    def terms(sine: Array) -> tuple[Array, ...]:
        normal, tangential = settled(lambda: element_forces(at, inflow, sine), at.blades)
        return normal, tangential * sine, tangential, normal * sine

    thrust, drag, turning, rolling = _over_azimuth(terms, azimuth)
    n = at.blades
    in_plane = n * at.section.drag_factor * drag
    return AnnulusLoads(  # Eqs. (5)-(7)
        n * thrust, in_plane, n * at.radius * turning, n * at.radius * rolling
    )
