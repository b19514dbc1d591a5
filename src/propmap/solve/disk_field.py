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
from propmap.solve.disk import solve_disk
from propmap.solve.harmonics import find_harmonics
from propmap.solve.problem import Case, annulus_problem
from propmap.solve.resolution import Resolution
from propmap.solve.root import MAX_STEPS, inflow_root
from propmap.solve.rotor_loads import harmonic_problem


class DiskField(NamedTuple):
    """Fields over stations (S,) and azimuths (P,).

    Attributes
    ----------
    inflow : Array
        v_i [m/s], its mean over azimuth, (S,).
    local_inflow : Array
        v_i [m/s] with its harmonics, (S, P).
    per_radius : AnnulusLoads
        Loads per radius [N/m] and [N], (S,).
    alpha : Array
        Angle of attack from the chord line [rad], (S, P).
    past_stall : Array
        How far alpha is past the stall angle, negative before it [rad], (S, P).
    u_t, u_p : Array
        Section velocities (1) and (2) [m/s], (S, P).
    normal_force : Array
        Force along the axis on one blade per radius [N/m], (S, P).
    """

    inflow: Array
    local_inflow: Array
    per_radius: AnnulusLoads
    alpha: Array
    past_stall: Array
    u_t: Array
    u_p: Array
    normal_force: Array


def disk_field(case: Case, radius: Array, psi: Array, azimuth: AzimuthNodes) -> DiskField:
    """Fields at one operating point.

    Parameters
    ----------
    case : Case
        One operating point, as arrays (1,).
    radius : Array, shape (S,)
        y [m].
    psi : Array, shape (P,)
        Azimuths at which the fields are wanted [rad].
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
    harmonics = None
    if case.rotor.shape is not None and not azimuth.axial:
        _, disk = solve_disk(case, Resolution().panels, azimuth)
        harmonics = find_harmonics(harmonic_problem(case, disk), azimuth).harmonics
    loads = element.annulus_loads(at, inflow, azimuth, harmonics)
    if not azimuth.axial:
        loads = with_added(loads, case.rotor.added, at, inflow, azimuth)
    sines, mean = xp.sin(psi)[None, :], inflow
    local = inflow * xp.ones_like(sines)
    if harmonics is not None:
        behind, before = element.local_inflow(at, inflow, harmonics, sines)
        local = xp.where(xp.cos(psi)[None, :] >= 0.0, behind, before)
        mean = inflow + harmonics.mean
    u_t = tangential_velocity(at.omega, at.radius, at.v_inplane, sines)
    u_p = normal_velocity(at.v_axial, local)
    blade = at.station
    across, along = blade.sine * u_t - blade.cosine * u_p, blade.cosine * u_t + blade.sine * u_p
    speed = floored_norm(u_t, u_p)
    angle = angle_of(along, across, speed)
    side = xp.where(angle < 0.0, -1.0, 1.0)
    past_stall = side * (angle - at.law.stall_angle(blade.reynolds_per_speed * speed, side))
    density = case.rotor.medium.density
    return DiskField(
        inflow=mean[:, 0],
        local_inflow=local,
        per_radius=AnnulusLoads(*(density * part[:, 0] for part in loads)),
        alpha=angle + at.zero_lift,
        past_stall=past_stall,
        u_t=u_t,
        u_p=u_p,
        normal_force=density * element.element_forces(at, local, sines).normal,
    )
