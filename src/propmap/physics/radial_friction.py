"""Skin friction of the yawed blade, along the air that actually passes over it."""

from __future__ import annotations

from dataclasses import dataclass

import jax

from propmap.arrays.namespace import Array, xp
from propmap.physics.element import Annulus, AnnulusLoads, loads_of_forces
from propmap.physics.sections.law import SectionFlow
from propmap.physics.velocities import (
    AzimuthNodes,
    floored_square,
    normal_velocity,
    tangential_velocity,
)


@jax.tree_util.register_static
@dataclass(frozen=True)
class RadialFriction:
    """Viscous drag along the flow with its part along the blade.

    In forward flight air also moves along the blade, outwards with U_R = V sin(beta) cos(psi).  By
    the independence principle lift and pressure drag do not feel it, as in the paper; friction
    does, and acts along the whole velocity, whose size is W = sqrt(U_T^2 + U_P^2 + U_R^2).  So the
    law's viscous drag 1/2 rho U C_v c (U_T, U_P) becomes 1/2 rho W C_v c (U_T, U_P, U_R), C_v being
    taken at the Reynolds number of W.  The part along the blade adds to the rotor drag, and the
    larger velocity to drag and torque.  In axial flow nothing changes.

    A law's drag at zero lift is taken to be viscous: c_d0 and the friction in eq. (4).

    Not taken into account: what friction adds to the forces along the axis, less than 1e-3 of the
    thrust, and hence to the inflow; and how it differs between the rear and the front of a disk
    whose inflow varies, which would give a force across.

    References
    ----------
    R. T. Jones, "Effects of Sweepback on Boundary Layer and Separation", NACA TR 884, 1947.
    W. Johnson, Helicopter Theory, 1980, section 5-12, on the radial drag of helicopter blades.
    """

    def annulus_loads(self, at: Annulus, inflow: Array, azimuth: AzimuthNodes) -> AnnulusLoads:
        """What it adds to the loads of annuli; the arguments as ``AddedLoads.annulus_loads``.

        ``at``, ``inflow`` and ``azimuth`` are annuli, v_i [m/s] (S, B) and azimuths.
        """

        def terms(sine: Array) -> tuple[Array, Array]:
            u_t = tangential_velocity(at.omega, at.radius, at.v_inplane, sine)
            square = floored_square(u_t, normal_velocity(at.v_axial, inflow))
            # cos^2(psi) once from U_R, and once from its part along the in-plane velocity.
            cosine_square = 1.0 - sine * sine
            u, w = xp.sqrt(square), xp.sqrt(square + at.v_inplane**2 * cosine_square)
            friction = w * _viscous_drag(at, w)
            tangential = (friction - u * _viscous_drag(at, u)) * u_t
            return tangential, tangential * sine + friction * at.v_inplane * cosine_square

        turning, along = azimuth.mean(terms)
        half, none = 0.5 * at.chord, xp.zeros_like(along)
        return loads_of_forces(at, (none, none, none), (half * turning, half * along, none))


def _viscous_drag(at: Annulus, speed: Array) -> Array:
    """The law's C_D [-] at zero lift, in air of this ``speed`` [m/s]."""
    still = xp.zeros_like(speed)
    flow = SectionFlow(
        angle=still,
        sine=still,
        cosine=still + 1.0,
        reynolds=at.station.reynolds_per_speed * speed,
        inverse_root_reynolds=at.station.inverse_root / xp.sqrt(speed),
        speed=speed,
        chord=at.chord,
        radius=at.radius,
    )
    return at.law.coefficients(flow).drag
