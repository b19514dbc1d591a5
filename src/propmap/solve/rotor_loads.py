"""Loads of the whole rotor, eqs. (13)-(15), at any operating point."""

from __future__ import annotations

from typing import NamedTuple

from propmap.arrays.namespace import Array, settled, xp
from propmap.physics import element, momentum, vortex_ring
from propmap.physics.parameters import Blade, Medium, Resolution, Section
from propmap.physics.velocities import AzimuthNodes, azimuth_nodes
from propmap.solve.disk import Case, DiskInflow, disk_inflow, solve_disk
from propmap.solve.hump import mean_attached_share


class RotorLoads(NamedTuple):
    """Loads of one rotor and how they came about; every field of shape (B,).

    thrust [N] along the axis; drag [N] in the disk plane against the in-plane velocity;
    torque [N m] needed to turn the shaft; roll_moment [N m] about the in-plane velocity,
    positive where the advancing side is lifted, before the sign of the spin is applied.
    roots : number of roots of (11), the largest over the blade, 1 or 3; ring : share of the
    vortex ring's inflow [-]; mean_inflow [m/s], by area; attached : smallest attached share over
    the nodes at the mean angle of attack [-]; mirrored : whether on the windmill branch the mean
    inflow is past the limit of momentum theory.
    """

    thrust: Array
    drag: Array
    torque: Array
    roll_moment: Array
    roots: Array
    ring: Array
    mean_inflow: Array
    attached: Array
    mirrored: Array


def disk_loads(
    blade: Blade,
    section: Section,
    medium: Medium,
    omega: Array,
    v_axial: Array,
    v_inplane: Array,
    v_hover: Array | None,
    panels: tuple[int, ...],
    azimuth: AzimuthNodes,
) -> RotorLoads:
    """Loads, eqs. (13)-(15), given the static inflow; all operating-point arrays (B,).

    blade, section, medium : see ``parameters``.
    omega [rad/s] >= 0; v_axial = V cos(beta), v_inplane = V sin(beta) >= 0 [m/s];
    v_hover : static inflow (12) at the same omega [m/s], read only where v_axial < 0; None where
    nothing descends.
    panels, azimuth : see ``solve_disk``.
    """
    case = case_of(blade, section, medium, omega, v_axial, v_inplane, v_hover)
    solution, _ = solve_disk(case, panels, azimuth)
    disk = disk_inflow(case, solution, panels, azimuth)
    return loads_over_disk(case, disk, solution.several, v_hover, azimuth)


def case_of(
    blade: Blade,
    section: Section,
    medium: Medium,
    omega: Array,
    v_axial: Array,
    v_inplane: Array,
    v_hover: Array | None,
) -> Case:
    """The case to be solved; arguments as in ``disk_loads``."""
    windmill = None if v_hover is None else vortex_ring.on_windmill_branch(v_axial, v_hover)
    return Case(blade, section, medium, omega, v_axial, v_inplane, windmill)


def loads_over_disk(
    case: Case, disk: DiskInflow, several: Array, v_hover: Array | None, azimuth: AzimuthNodes
) -> RotorLoads:
    """Loads, eqs. (13)-(15), where (11) is solved; differentiable by all but ``several``.

    case : the question.  disk : its answer.  several (B,) : whether (11) has several roots.
    v_hover, azimuth : as in ``disk_loads``.
    """
    medium, v_axial, v_inplane = case.medium, case.v_axial, case.v_inplane
    ring, inflow = xp.zeros_like(v_axial), disk.inflow
    if v_hover is not None:
        ring = vortex_ring.vortex_ring_weight(v_axial, v_inplane, v_hover)
        inflow = (1.0 - ring) * inflow + ring * vortex_ring.vortex_ring_inflow(v_axial, v_hover)
    per_radius = settled(
        lambda: element.annulus_loads(disk.ask.at, inflow, azimuth), case.blade.root
    )
    weight = disk.nodes.weight
    thrust, drag, torque, roll_moment = medium.density * xp.sum(
        weight * xp.stack(per_radius), axis=1
    )
    area = weight * disk.nodes.radius
    mean_inflow = xp.sum(area * inflow, axis=0) / xp.sum(area, axis=0)
    mirrored = xp.zeros_like(v_axial) > 0.0
    if case.windmill is not None:
        past_limit = momentum.is_mirrored(v_axial, v_inplane, mean_inflow)
        mirrored = (case.windmill > 0.0) & past_limit
    return RotorLoads(
        thrust=thrust,  # Eq. (13)
        drag=drag,  # Eq. (14)
        torque=torque,  # Eq. (15)
        roll_moment=roll_moment,
        roots=xp.where(several, 3, 1),
        ring=ring,
        mean_inflow=mean_inflow,
        attached=xp.min(mean_attached_share(disk.ask, inflow), axis=0),
        mirrored=mirrored,
    )


def hover_inflow(
    blade: Blade, section: Section, medium: Medium, omega: Array, stations: int
) -> Array:
    """The static inflow v_h [m/s], eq. (12), from the rotor's own static thrust; (B,).

    blade, section, medium : see ``parameters``.  omega : (B,) [rad/s].
    stations : radial nodes on the whole blade.
    """
    still = xp.zeros_like(omega)
    panels = Resolution(stations=stations).panels
    nodes = azimuth_nodes(1)
    static = disk_loads(blade, section, medium, omega, still, still, still, panels, nodes)
    return momentum.static_inflow(static.thrust, medium.density, blade.tip)


def rotor_loads(
    blade: Blade,
    section: Section,
    medium: Medium,
    omega: Array,
    v_axial: Array,
    v_inplane: Array,
    resolution: Resolution | None = None,
) -> RotorLoads:
    """Loads of a rotor anywhere from climb to windmill descent, eqs. (1)-(15).

    blade, section, medium : see ``parameters``; pytrees, differentiable.
    omega (B,) [rad/s] >= 0; v_axial = V cos(beta) (B,) [m/s], positive in climb;
    v_inplane = V sin(beta) (B,) [m/s].
    resolution : static; the default is good to 0.1 % of static thrust up to an advance
    ratio V sin(beta)/(Omega R) of about 0.5.
    Safe under jit, vmap, jvp and vjp.  Loads that were not found are NaN.
    """
    resolution = resolution or Resolution()
    v_hover = hover_inflow(blade, section, medium, omega, resolution.stations)
    panels, nodes = resolution.panels, azimuth_nodes(resolution.azimuths)
    return disk_loads(blade, section, medium, omega, v_axial, v_inplane, v_hover, panels, nodes)
