"""Derivatives of the loads by section parameters, blade and flow, at a solution of (11).

The residual g of (11) is zero at the edges of the radial panels and at the nodes.  So the
derivatives of the edges' radii and of the nodes' inflow follow from the implicit function theorem,
and those of the harmonics from theirs.  All need the same partial derivatives of the forces of
blade elements, which ``physics.element_slopes`` gives in one pass over the azimuth: that of (11),
or a second one where the loads have another inflow than (11).

Differentiating ``rotor_loads.disk_loads`` by JAX takes five passes, each with every direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp

from propmap.arrays.namespace import Array
from propmap.loads import FLOW, GEOMETRY
from propmap.physics.element_slopes import THROUGH, mean_slopes, moved_forces
from propmap.physics.loads import RadialNodes
from propmap.physics.velocities import AzimuthNodes
from propmap.solve.disk import DiskSolution, edges_about
from propmap.solve.followed_loads import EdgeMove, FollowedLoads
from propmap.solve.moved_case import (
    RADIUS,
    change_of,
    motion_of,
    moved_rotor,
    moving,
    sources_of,
    with_terms,
)
from propmap.solve.problem import Case, annulus_problem
from propmap.solve.quadrature import panel_nodes

__all__ = [
    "FLOW",
    "GEOMETRY",
    "Directions",
    "directions_of",
    "load_slopes",
    "moved_rotor",
    "moving",
    "with_terms",
]


@jax.tree_util.register_static
@dataclass(frozen=True)
class Directions:
    """What to differentiate by; a pytree without arrays, as programs are made for its names.

    Attributes
    ----------
    names : tuple of str
        Each of ``moving`` or of ``GEOMETRY``.
    """

    names: tuple[str, ...]


def directions_of(movable: Sequence[str], names: Sequence[str], count: int) -> Directions:
    """The ``count`` directions along ``names``, each one of ``movable`` or of ``GEOMETRY``."""
    unknown = [name for name in names if name not in (*movable, *GEOMETRY)]
    if unknown or len(names) != count:
        raise ValueError(f"{count} directions along {names}, of {movable}")
    return Directions(tuple(names))


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
    names = directions.names
    inner = _inner_edges(case, solution)
    edges = inner.shape[0]

    def place(inner: Array) -> RadialNodes:
        return panel_nodes(edges_about(case.rotor.blade, inner), panels)

    nodes = place(inner)
    radius, inflow = nodes.radius, solution.inflow
    if solution.fold is not None:
        radius = jnp.concatenate([solution.fold.radius, radius])
        inflow = jnp.concatenate([solution.fold.inflow, inflow])
    problem = annulus_problem(case, radius)
    at = problem.at
    changes = {name: change_of(case, radius, inflow, name) for name in names}
    if edges:
        changes[RADIUS] = change_of(case, radius, inflow, RADIUS)
    motions = {name: motion_of(at, name, by) for name, by in changes.items()}
    sources = sources_of(at, changes)

    # Where the loads have the inflow of (11), one pass over the azimuth is enough.
    once = solution.harmonics is None and case.v_hover is None
    means = mean_slopes(at, inflow, azimuth, sources, None, thrust_alone=not once)

    def residual_slope(name: str) -> Array:
        blade = at.blades * moved_forces(means, motions[name])[0][0]
        wake = changes[name].wake
        return blade if wake is None else blade - wake

    _, wake_slope = problem.wake.thrust_slope(at, inflow)
    by_inflow = (at.blades * means[THROUGH].turn[0][0] - wake_slope)[edges:]
    per_inflow = jnp.where(by_inflow == 0.0, 0.0, 1.0 / jnp.where(by_inflow == 0.0, 1.0, by_inflow))
    drifts = {name: residual_slope(name) for name in names}
    followed = {name: -per_inflow * drift[edges:] for name, drift in drifts.items()}
    moves = []
    if edges:
        by_radius = residual_slope(RADIUS)
        slopes = jnp.stack(
            [_edge_slope(solution, drift[:edges], by_radius[:edges]) for drift in drifts.values()]
        )
        for k in range(edges):
            unit = jnp.broadcast_to((jnp.arange(edges) == k)[:, None] * 1.0, inner.shape)
            change: RadialNodes = jax.jvp(place, (inner,), (unit,))[1]
            inflow_slope = -per_inflow * by_radius[edges:] * change.radius
            moves.append(EdgeMove(change, inflow_slope, slopes[:, k]))
    station, changes, means = _of_nodes(edges, (at.station, changes, means))
    here = problem._replace(at=at._replace(station=station))
    loads = FollowedLoads.at(case, solution, nodes, azimuth, here, changes, means)
    return loads.slopes(followed, moves, v_hover_slopes)


def _of_nodes(edges: int, values: Any) -> Any:
    """Arrays at edges and nodes (E + S, B) without the edges; those without rows stay."""
    return jax.tree.map(lambda a: a[edges:] if jnp.ndim(a) == 2 else a, values)


def _inner_edges(case: Case, solution: DiskSolution) -> Array:
    """The panels' inner edges (E, B) [m] in the order of the folds; none of a single panel."""
    root, tip = case.rotor.blade.root, case.rotor.blade.tip
    if solution.fold is None or solution.spare is None:
        return jnp.zeros((0, 1))
    spare = root + (tip - root) * solution.spare
    return jnp.where(solution.fold.found, solution.fold.radius, spare)


def _edge_slope(solution: DiskSolution, by_case: Array, by_radius: Array) -> Array:
    """Derivative of the edges' radii along one direction, (E, B); see ``folds.follow``.

    At a fold dg/dv_i = 0, so that g stays zero if the radius changes by -(change of g)/(dg/dy).
    """
    assert solution.fold is not None
    moves = solution.fold.found & (by_radius != 0.0)
    return jnp.where(moves, -by_case / jnp.where(moves, by_radius, 1.0), 0.0)
