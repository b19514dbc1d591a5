"""Inflow, angle of attack and loads over the disk at one operating point."""

from __future__ import annotations

from typing import NamedTuple

from propmap.arrays.namespace import Array, xp
from propmap.physics import element, vortex_ring
from propmap.physics.added_loads import with_added
from propmap.physics.element import AnnulusLoads
from propmap.physics.velocities import (
    AzimuthNodes,
    angle_of,
    floored_norm,
    normal_velocity,
    tangential_velocity,
)
from propmap.solve.problem import Case, annulus_problem
from propmap.solve.root import MAX_STEPS, inflow_root


class DiskField(NamedTuple):
    """Fields over stations (S,) and azimuths (P,).

    Attributes
    ----------
    inflow : Array
        v_i [m/s], (S,).
    per_radius : AnnulusLoads
        Loads per radius [N/m] and [N], (S,).
    alpha : Array
        Angle of attack from the chord line [rad], (S, P).
    past_stall : Array
        How far alpha is past the stall angle, negative before it [rad], (S, P).
    u_t, u_p : Array
        Section velocities (1) and (2) [m/s], (S, P).
    """

    inflow: Array
    per_radius: AnnulusLoads
    alpha: Array
    past_stall: Array
    u_t: Array
    u_p: Array


def disk_field(case: Case, radius: Array, sines: Array, azimuth: AzimuthNodes) -> DiskField:
    """Fields at one operating point.

    Parameters
    ----------
    case : Case
        One operating point, as arrays (1,).
    radius : Array, shape (S,)
        y [m].
    sines : Array, shape (P,)
        sin(psi) at which alpha is wanted [-].
    azimuth : AzimuthNodes
        Azimuths to average the loads over.
    """
    problem = annulus_problem(case, radius[:, None])
    inflow = inflow_root(problem, xp.asarray(MAX_STEPS), azimuth)
    if case.v_hover is not None:
        inflow, _ = vortex_ring.blend_vortex_ring(
            case.v_axial, case.v_inplane, case.v_hover, inflow
        )
    at = problem.at
    loads = element.annulus_loads(at, inflow, azimuth)
    if not azimuth.axial:
        loads = with_added(loads, case.rotor.added, at, inflow, azimuth)
    u_t = tangential_velocity(at.omega, at.radius, at.v_inplane, sines[None, :])
    u_p = normal_velocity(at.v_axial, inflow) * xp.ones_like(u_t)
    blade = at.station
    across, along = blade.sine * u_t - blade.cosine * u_p, blade.cosine * u_t + blade.sine * u_p
    speed = floored_norm(u_t, u_p)
    angle = angle_of(along, across, speed)
    side = xp.where(angle < 0.0, -1.0, 1.0)
    past_stall = side * (angle - at.law.stall_angle(blade.reynolds_per_speed * speed, side))
    density = case.rotor.medium.density
    return DiskField(
        inflow=inflow[:, 0],
        per_radius=AnnulusLoads(*(density * part[:, 0] for part in loads)),
        alpha=angle + at.zero_lift,
        past_stall=past_stall,
        u_t=u_t,
        u_p=u_p,
    )
