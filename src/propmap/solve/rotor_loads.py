"""Loads of a rotor at any operating point: solve (11) over the disk, then integrate."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

from propmap.arrays.materialize import materialize
from propmap.arrays.namespace import Array, stop_gradient, xp
from propmap.physics import element, momentum, vortex_ring
from propmap.physics.added_loads import with_added
from propmap.physics.element import AnnulusLoads
from propmap.physics.inflow_harmonics import DiskFlow, Harmonics
from propmap.physics.loads import integrate, mean_over_disk
from propmap.physics.rotor import RotorArrays
from propmap.physics.velocities import AzimuthNodes, azimuth_nodes
from propmap.solve.disk import DiskInflow, DiskSolution, disk_inflow, solve_disk
from propmap.solve.harmonics import HarmonicProblem, find_harmonics, moving_harmonics
from propmap.solve.problem import Case
from propmap.solve.quadrature import tail
from propmap.solve.resolution import Resolution


class RotorLoads(NamedTuple):
    """Loads of one rotor, and what statuses are made of; every field of shape (B,).

    Attributes
    ----------
    loads : AnnulusLoads
        Thrust, drag [N], torque and moments [N m] of the rotor, as in ``propmap.Loads``.
    roots : Array
        Largest number of roots of (11) along the blade: 1 or 3.
    ring : Array
        Share of the vortex ring's inflow in the inflow [-].
    mean_inflow : Array
        v_i averaged over the disk's area [m/s].
    attached : Array
        Smallest share of attached flow along the blade, at the mean angle of attack [-].
    mirrored : Array
        Whether on the windmill branch the mean inflow is past the range of momentum theory.
    thrust_tail, torque_tail : Array
        Estimated quadrature error of a load [N], [N m], see ``quadrature.tail``.
    """

    loads: element.AnnulusLoads
    roots: Array
    ring: Array
    mean_inflow: Array
    attached: Array
    mirrored: Array
    thrust_tail: Array
    torque_tail: Array

    @property
    def rows(self) -> tuple[Array, ...]:
        """All arrays, the loads first."""
        return *self.loads, *self[1:]

    @classmethod
    def of_rows(cls, rows: Iterable[Array]) -> RotorLoads:
        """The inverse of ``rows``."""
        every = tuple(rows)
        count = len(element.AnnulusLoads._fields)
        return cls(element.AnnulusLoads(*every[:count]), *every[count:])


def disk_loads(case: Case, panels: tuple[int, ...], azimuth: AzimuthNodes) -> RotorLoads:
    """Loads, eqs. (13)-(15), with a known static inflow; differentiable with respect to ``case``.

    ``panels`` and ``azimuth`` are those of ``solve_disk``.
    """
    solution, found = solve_disk(case, panels, azimuth)
    harmonics = None
    if case.rotor.shape is not None and not azimuth.axial:
        harmonics = find_harmonics(harmonic_problem(case, found), azimuth).harmonics
    disk = disk_inflow(case, solution, panels, azimuth)
    return loads_over_disk(case, disk, harmonics, solution.several, panels, azimuth)


def search_loads(
    case: Case, panels: tuple[int, ...], azimuth: AzimuthNodes
) -> tuple[RotorLoads, DiskSolution]:
    """``disk_loads`` without derivatives, and the solution; the arguments are the same."""
    case = stop_gradient(case)
    solution, disk = solve_disk(case, panels, azimuth)
    if case.rotor.shape is None or azimuth.axial:
        return loads_over_disk(case, disk, None, solution.several, panels, azimuth), solution
    found = find_harmonics(harmonic_problem(case, disk), azimuth)
    density = case.rotor.medium.density
    total = AnnulusLoads(*(density * load for load in found.loads))
    if case.rotor.added:
        nothing = AnnulusLoads(*(xp.zeros_like(disk.inflow) for _ in total))
        added = integrate(_with_added(case, disk, nothing, azimuth), disk.nodes, density)
        total = AnnulusLoads(*(a + b for a, b in zip(total, added, strict=True)))
    loads = _rotor_loads(case, disk, total, found.integrand, solution.several, panels)
    return loads, solution._replace(harmonics=found.harmonics)


def loads_over_disk(
    case: Case,
    disk: DiskInflow,
    harmonics: Harmonics | None,
    several: Array,
    panels: tuple[int, ...],
    azimuth: AzimuthNodes,
) -> RotorLoads:
    """Loads, eqs. (13)-(15), with a known inflow; differentiable by ``case`` and ``disk``.

    Parameters
    ----------
    case : Case
        The case that was solved.
    disk : DiskInflow
        Its inflow.
    harmonics : Harmonics or None
        How the inflow varies around the disk, found before; None where it does not.
    several : Array, shape (B,)
        Whether several roots of (11) were found.
    panels, azimuth
        Radial nodes and azimuths, as in ``solve_disk``.
    """
    rotor = case.rotor
    inflow, _ = with_vortex_ring(case, disk)
    at = disk.problem.at
    if harmonics is not None:
        harmonics = moving_harmonics(harmonic_problem(case, disk), harmonics, azimuth)
    per_radius = materialize(
        lambda: element.annulus_loads(at, inflow, azimuth, harmonics), rotor.blade.root
    )
    per_radius = _with_added(case, disk, per_radius, azimuth)
    total = integrate(per_radius, disk.nodes, rotor.medium.density)
    integrand = disk.nodes.weight * xp.stack([per_radius.thrust, per_radius.torque])
    return _rotor_loads(case, disk, total, integrand, several, panels)


def _rotor_loads(
    case: Case,
    disk: DiskInflow,
    total: AnnulusLoads,
    integrand: Array,
    several: Array,
    panels: tuple[int, ...],
) -> RotorLoads:
    """Loads with what statuses are made of.

    ``integrand`` (2, S, B) is thrust and torque of the annuli, times weights, per density.
    """
    rotor, v_axial, v_inplane = case.rotor, case.v_axial, case.v_inplane
    inflow, ring = with_vortex_ring(case, disk)
    mean_inflow = mean_over_disk(inflow, disk.nodes)
    if rotor.mount is not None:
        flow = (v_axial, v_inplane, mean_inflow)
        mounted = rotor.mount.drag(rotor.medium.density, *flow)
        total = total._replace(drag=total.drag + mounted)
    mirrored = xp.zeros_like(v_axial) > 0.0
    windmill = disk.problem.wake.windmill
    if windmill is not None:
        past_limit = momentum.past_momentum_theory(v_axial, v_inplane, mean_inflow)
        mirrored = (windmill > 0.0) & past_limit
    attached = rotor.law.attached_share(element.mean_angle_of_attack(disk.problem.at, inflow))
    tails = rotor.medium.density * tail(stop_gradient(integrand), panels)
    return RotorLoads(
        total,
        roots=xp.where(several, 3, 1),
        ring=ring,
        mean_inflow=mean_inflow,
        attached=xp.min(attached, axis=0),
        mirrored=mirrored,
        thrust_tail=tails[0],
        torque_tail=tails[1],
    )


def _with_added(
    case: Case, disk: DiskInflow, loads: AnnulusLoads, azimuth: AzimuthNodes
) -> AnnulusLoads:
    """Loads of the annuli with those that corrections add; none do so in axial flow."""
    if azimuth.axial:
        return loads
    inflow, _ = with_vortex_ring(case, disk)
    return with_added(loads, case.rotor.added, disk.problem.at, inflow, azimuth)


def with_vortex_ring(case: Case, disk: DiskInflow) -> tuple[Array, Array]:
    """The annuli's inflow [m/s], (S, B), and the share of the vortex ring's in it [-], (B,)."""
    if case.v_hover is None:
        return disk.inflow, xp.zeros_like(case.v_axial)
    flow = (case.v_axial, case.v_inplane, case.v_hover)
    return vortex_ring.blend_vortex_ring(*flow, disk.inflow)


def harmonic_problem(case: Case, disk: DiskInflow) -> HarmonicProblem:
    """What the harmonics depend on at a ``case`` whose annulus inflow is ``disk``."""
    inflow, ring = with_vortex_ring(case, disk)
    mean_inflow = mean_over_disk(inflow, disk.nodes)
    flow = DiskFlow(case.omega, case.v_axial, case.v_inplane, mean_inflow)
    shape: Any = case.rotor.shape
    return HarmonicProblem(disk.problem.at, disk.nodes, inflow, flow, 1.0 - ring, shape)


def hover_inflow(rotor: RotorArrays, omega: Array, stations: int) -> Array:
    """The static inflow v_h [m/s], eq. (12), from the rotor's own static thrust.

    Parameters
    ----------
    rotor : RotorArrays
        The rotor.
    omega : Array, shape (B,)
        Rotational speed [rad/s].
    stations : int
        Radial nodes on the whole blade.
    """
    still = xp.zeros_like(omega)
    panels = Resolution(stations=stations).panels
    static = disk_loads(Case(rotor, omega, still, still, still), panels, azimuth_nodes(1))
    return momentum.static_inflow(static.loads.thrust, rotor.medium.density, rotor.blade.tip)


def rotor_loads(
    rotor: RotorArrays,
    omega: Array,
    v_axial: Array,
    v_inplane: Array,
    resolution: Resolution | None = None,
) -> RotorLoads:
    """Loads of a rotor anywhere from climb to windmill descent, eqs. (1)-(15), in JAX.

    Safe under jit, vmap, jvp and vjp.

    Parameters
    ----------
    rotor : RotorArrays
        Blade, section law and air, differentiable.
    omega : Array, shape (B,)
        Rotational speed [rad/s], >= 0.
    v_axial : Array, shape (B,)
        V cos(beta) [m/s], positive in climb.
    v_inplane : Array, shape (B,)
        V sin(beta) [m/s], >= 0.
    resolution : Resolution, optional
        Static; the default is good to 0.1 % of static thrust up to an advance ratio
        V sin(beta)/(Omega R) of about 0.5.

    Returns
    -------
    RotorLoads
        Arrays of shape (B,); loads are NaN where an inflow was not found.
    """
    resolution = resolution or Resolution()
    v_hover = hover_inflow(rotor, omega, resolution.stations)
    case = Case(rotor, omega, v_axial, v_inplane, v_hover)
    return disk_loads(case, resolution.panels, azimuth_nodes(resolution.azimuths))
