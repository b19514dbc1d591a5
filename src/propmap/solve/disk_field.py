"""What happens over the disk: inflow, angle of attack, loads along the blade."""

from __future__ import annotations

from typing import NamedTuple

from propmap.arrays.namespace import Array, xp
from propmap.physics import element, vortex_ring
from propmap.physics.element import AnnulusLoads
from propmap.physics.parameters import Blade, Medium, Section
from propmap.physics.sections.blended import angle_of_attack
from propmap.physics.velocities import (
    AzimuthNodes,
    floored_norm,
    normal_velocity,
    tangential_velocity,
)
from propmap.solve.disk import Case, question
from propmap.solve.inflow import MAX_STEPS, inflow_root


class DiskField(NamedTuple):
    """Fields over stations (S,) and azimuths (P,); units as in SI.

    inflow v_i (S,) [m/s]; per_radius : loads per radius (S,) [N/m], [N]; alpha : geometric
    angle of attack (S, P) [rad]; u_t, u_p : velocities (1)(2) (S, P) [m/s].
    """

    inflow: Array
    per_radius: AnnulusLoads
    alpha: Array
    u_t: Array
    u_p: Array


def disk_field(
    blade: Blade,
    section: Section,
    medium: Medium,
    flow: tuple[Array, Array, Array, Array],
    radius: Array,
    sines: Array,
    azimuth: AzimuthNodes,
) -> DiskField:
    """Fields at one operating point.

    flow : omega [rad/s], v_axial, v_inplane and v_hover [m/s], each of shape (1,).
    radius (S,) [m]; sines : sin(psi) (P,) at which alpha is wanted; azimuth : nodes over which
    the loads are averaged.
    """
    omega, v_axial, v_inplane, v_hover = flow
    windmill = vortex_ring.on_windmill_branch(v_axial, v_hover)
    case = Case(blade, section, medium, omega, v_axial, v_inplane, windmill)
    ask = question(case, radius[:, None])
    ring = vortex_ring.vortex_ring_weight(v_axial, v_inplane, v_hover)
    solved = inflow_root(ask, xp.asarray(xp.inf), xp.asarray(MAX_STEPS), azimuth)
    inflow = (1.0 - ring) * solved + ring * vortex_ring.vortex_ring_inflow(v_axial, v_hover)
    loads = element.annulus_loads(ask.at, inflow, azimuth)
    at = ask.at
    u_t = tangential_velocity(at.omega, at.radius, at.v_inplane, sines[None, :])
    u_p = normal_velocity(at.v_axial, inflow) * xp.ones_like(u_t)
    across, along = at.sine * u_t - at.cosine * u_p, at.cosine * u_t + at.sine * u_p
    alpha = angle_of_attack(along, across, floored_norm(u_t, u_p)) + section.zero_lift_angle
    dimensional = AnnulusLoads(*(medium.density * part[:, 0] for part in loads))
    return DiskField(inflow[:, 0], dimensional, alpha, u_t, u_p)
