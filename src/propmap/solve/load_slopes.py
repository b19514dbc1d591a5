"""Derivatives of the loads with respect to section parameters and flow, at a solution of (11).

The residual g of (11) is zero at the edges of the radial panels and at the nodes.  So the
derivatives of the edges' radii and of the nodes' inflow follow from the implicit function theorem.
One pass over the azimuth gives the partial derivatives of g that it needs, those by the parameters,
the radius and the inflow; a second pass gives the derivatives of the loads.  Differentiating
``rotor_loads.disk_loads`` by JAX takes five passes and twice as long to compile.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from propmap.arrays.namespace import Array
from propmap.physics.loads import RadialNodes
from propmap.physics.rotor import RotorArrays
from propmap.physics.velocities import AzimuthNodes
from propmap.solve.disk import DiskInflow, DiskSolution, edges_about
from propmap.solve.problem import Case, annulus_problem, residual
from propmap.solve.quadrature import panel_nodes
from propmap.solve.rotor_loads import loads_over_disk

FLOW = ("omega", "v_axial", "v_inplane")
"""Flow quantities with respect to which loads can be differentiated."""

Change = tuple[Array, ...]
"""Changes, or a direction: an entry for each name of ``moving``, or for these and more."""


MOUNT_AREA = "mount_area"
"""The area of what is mounted in the slipstream [m^2], where the rotor has one."""

GEOMETRY = ("chord_scale", "twist_offset")
"""The blade's common relative change of the chord [-] and common offset of the twist [rad]; see
``Blade``."""


def with_geometry(rotor: RotorArrays) -> RotorArrays:
    """The ``rotor`` with its ``GEOMETRY`` at 0, where it can be differentiated by that."""
    still: Any = dict.fromkeys(GEOMETRY, np.float64(0.0))
    return rotor._replace(blade=rotor.blade._replace(**still))


def moving(rotor: RotorArrays) -> tuple[str, ...]:
    """Names of what the loads of a rotor can be differentiated by: the law's parameters, the area
    of what is mounted, those of its ``GEOMETRY`` that are not None, the flow."""
    mounted = () if rotor.mount is None else (MOUNT_AREA,)
    shape = tuple(name for name in GEOMETRY if getattr(rotor.blade, name) is not None)
    return (*rotor.law.parameters, *mounted, *shape, *FLOW)


def with_terms(rotor: RotorArrays, names: Sequence[str]) -> RotorArrays:
    """The rotor with those terms of its law among ``names`` that were left out of it as zero."""
    left_out = [name for name in names if name not in (*moving(rotor), *GEOMETRY)]
    if not left_out:
        return rotor
    zero: Any = dict.fromkeys(left_out, np.float64(0.0))
    return rotor._replace(law=rotor.law.plus(**zero))


def moved_rotor(rotor: RotorArrays, change: Mapping[str, Array]) -> RotorArrays:
    """The rotor with ``change`` added to those of its quantities in ``moving`` that it names."""
    changes = dict(change)
    area = changes.pop(MOUNT_AREA, None)
    if area is not None and rotor.mount is not None:
        rotor = rotor._replace(mount=rotor.mount._replace(area=rotor.mount.area + area))
    shape = {n: getattr(rotor.blade, n) + changes.pop(n) for n in GEOMETRY if n in changes}
    return rotor._replace(blade=rotor.blade._replace(**shape), law=rotor.law.plus(**changes))


class Directions(NamedTuple):
    """Directions of the derivatives: by how much each of ``moving`` changes along each of them.

    One array for each name, since XLA takes a kernel to cut a column out of a matrix.

    Attributes
    ----------
    loads : tuple of Array
        For each of ``moving``, in its own unit, its change along D directions, (D,).
    residual : tuple of Array
        The same for each of ``moving``, then the radius and the inflow, (D + 2,); along the last
        two directions only the radius or only the inflow changes.
    """

    loads: tuple[Array, ...]
    residual: tuple[Array, ...]


def directions_of(movable: Sequence[str], names: Sequence[str], count: int) -> Directions:
    """``count`` directions: one for each of ``names``, all in ``movable``, the others zero."""
    ways = np.zeros((count, len(movable)))
    for row, name in enumerate(names):
        ways[row, movable.index(name)] = 1.0
    own = np.zeros((count + 2, len(movable) + 2))
    own[:count, : len(movable)] = ways
    own[count:, len(movable) :] = np.eye(2)
    return Directions(tuple(ways.T.copy()), tuple(own.T.copy()))


def load_slopes(
    case: Case,
    solution: DiskSolution,
    panels: tuple[int, ...],
    azimuth: AzimuthNodes,
    directions: Directions,
    v_hover_slopes: Array | None,
) -> Array:
    """Derivatives of the loads, eqs. (13)-(15), by the implicit function theorem on (11).

    Parameters
    ----------
    case : Case
        The case that was solved, at B points.
    solution : DiskSolution
        Its solution.
    panels, azimuth
        Radial nodes per panel and azimuth nodes, those that it was solved with.
    directions : Directions
        D of them.
    v_hover_slopes : Array or None
        Change of ``case.v_hover`` along each direction [m/s], (D, B).

    Returns
    -------
    Array
        Derivatives of ``propmap.loads.LOADS``, in their order and units, along each direction;
        (D, loads, B).
    """
    inner = _inner_edges(case, solution)
    own = inner.shape[0]
    nodes = panel_nodes(edges_about(case.rotor.blade, inner), panels)
    by_case, by_radius, by_inflow = _residual_slopes(
        case, solution, nodes, azimuth, directions.residual
    )

    def follow(inner_slope: Array) -> RadialNodes:
        def place(edges: Array) -> RadialNodes:
            return panel_nodes(edges_about(case.rotor.blade, edges), panels)

        change: RadialNodes = jax.jvp(place, (inner,), (inner_slope,))[1]
        return change

    def loads(change: Change, here: RadialNodes, inflow: Array, v_hover: Array | None) -> Array:
        now = _moved(case, change)._replace(v_hover=v_hover)
        disk = DiskInflow(here, annulus_problem(now, here.radius), inflow)
        found = loads_over_disk(now, disk, solution.harmonics, solution.several, panels, azimuth)
        return jnp.stack(found.loads)

    def along(direction: Change, v_hover_slope: Array | None, by_case: Array) -> Array:
        change = follow(_edge_slope(solution, by_case[:own], by_radius[:own]))
        drift = by_case[own:] + by_radius[own:] * change.radius
        fixed = by_inflow[own:] == 0.0
        inflow_slope = jnp.where(fixed, 0.0, -drift / jnp.where(fixed, 1.0, by_inflow[own:]))
        still = len(directions.loads) * (jnp.zeros(()),)
        here = (still, nodes, solution.inflow, case.v_hover)
        return jax.jvp(loads, here, (direction, change, inflow_slope, v_hover_slope))[1]

    return jax.vmap(along)(directions.loads, v_hover_slopes, by_case)


def _inner_edges(case: Case, solution: DiskSolution) -> Array:
    """The panels' inner edges (E, B) [m] in the order of the folds; none of a single panel."""
    root, tip = case.rotor.blade.root, case.rotor.blade.tip
    if solution.fold is None or solution.spare is None:
        return jnp.zeros((0, 1))
    spare = root + (tip - root) * solution.spare
    return jnp.where(solution.fold.found, solution.fold.radius, spare)


def _edge_slope(solution: DiskSolution, by_case: Array, by_radius: Array) -> Array:
    """Derivative of the edges' radii along one direction, (E, B) or (0, 1); see ``folds.follow``.

    At a fold dg/dv_i = 0, so that g stays zero if the radius changes by -(change of g)/(dg/dy).
    """
    if solution.fold is None:
        return jnp.zeros((0, 1))
    moves = solution.fold.found & (by_radius != 0.0)
    return jnp.where(moves, -by_case / jnp.where(moves, by_radius, 1.0), 0.0)


def _moved(case: Case, change: Change) -> Case:
    """The case with ``change`` added to the quantities of ``moving``."""
    by_name = dict(zip(moving(case.rotor), change, strict=True))
    omega, v_axial, v_inplane = (by_name.pop(name) for name in FLOW)
    return case._replace(
        rotor=moved_rotor(case.rotor, by_name),
        omega=case.omega + omega,
        v_axial=case.v_axial + v_axial,
        v_inplane=case.v_inplane + v_inplane,
    )


def _residual_slopes(
    case: Case,
    solution: DiskSolution,
    nodes: RadialNodes,
    azimuth: AzimuthNodes,
    directions: Change,
) -> tuple[Array, Array, Array]:
    """Partial derivatives of the residual of (11) at the E folds, then at the S nodes: along the
    directions (D, E + S, B), by the radius and by the inflow (E + S, B)."""
    radius, inflow = nodes.radius, solution.inflow
    if solution.fold is not None:
        radius = jnp.concatenate([solution.fold.radius, radius])
        inflow = jnp.concatenate([solution.fold.inflow, inflow])

    def at(change: Change) -> Array:
        *moved, outwards, more_inflow = change
        here = annulus_problem(_moved(case, tuple(moved)), radius + outwards)
        return residual(here, inflow + more_inflow, azimuth)

    still = len(directions) * (jnp.zeros(()),)
    slopes = jax.vmap(lambda way: jax.jvp(at, (still,), (way,))[1])(directions)
    return slopes[:-2], slopes[-2], slopes[-1]
