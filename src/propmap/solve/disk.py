"""The inflow over the whole disk: radial nodes that follow stall, and v_i at each of them."""

from __future__ import annotations

import functools
from typing import NamedTuple

import jax

from propmap.arrays.namespace import Array, custom_jvp, stop_gradient, xp
from propmap.physics.geometry import Blade
from propmap.physics.inflow_harmonics import Harmonics
from propmap.physics.loads import RadialNodes
from propmap.physics.velocities import AzimuthNodes
from propmap.solve import folds, split
from propmap.solve.problem import AnnulusProblem, Case, annulus_problem
from propmap.solve.quadrature import panel_nodes
from propmap.solve.root import MAX_STEPS, find_root, moving_root
from propmap.solve.root_count import several_roots


class DiskSolution(NamedTuple):
    """The result of the search, as constants without derivatives; a pytree.

    Attributes
    ----------
    fold : Fold or None
        Where attached flow begins and ends along the blade; None if stall is not followed.
    spare : Array, shape (E, B), or None
        Shares of the span [-] at which edges without a fold are; None where ``fold`` is.
    inflow : Array, shape (S, B)
        v_i at the radial nodes [m/s], NaN where it was not found.
    several : Array, shape (B,)
        Whether several roots of (11) were found.
    harmonics : Harmonics or None
        How the inflow varies around the disk; None before it is known and where it does not.
    """

    fold: folds.Fold | None
    spare: Array | None
    inflow: Array
    several: Array
    harmonics: Harmonics | None = None


class DiskInflow(NamedTuple):
    """Radial nodes (S, B) or (S, 1), equation (11) at these, and its root v_i (S, B) [m/s]."""

    nodes: RadialNodes
    problem: AnnulusProblem
    inflow: Array


def solve_disk(
    case: Case, panels: tuple[int, ...], azimuth: AzimuthNodes
) -> tuple[DiskSolution, DiskInflow]:
    """Solve (11) over the disk, without derivatives; these come from ``disk_inflow``.

    Parameters
    ----------
    case : Case
        Rotor and flow.
    panels : tuple of int
        Radial nodes on each panel, static.  With more than one panel, their edges follow stall, see
        ``solve.split``.
    azimuth : AzimuthNodes
        Azimuths to average over.
    """
    case = stop_gradient(case)
    root, tip = case.rotor.blade.root, case.rotor.blade.tip
    fold = spare = None
    if len(panels) > 1:
        still = functools.partial(annulus_problem, case)
        near, several = split.hump_crossings(still, root, tip, len(panels) - 1, azimuth)
        fold = folds.find_folds(near, still, root, tip, azimuth)
        spare = (near.radius - root) / (tip - root)
    edges = _edges(case, fold, spare, azimuth)
    nodes = panel_nodes(edges, panels)
    problem = annulus_problem(case, nodes.radius)
    inflow = find_root(problem, xp.asarray(MAX_STEPS), azimuth)
    if fold is None:
        several = several_roots((problem, inflow), azimuth)
    else:
        several = several | xp.any(fold.folded, axis=0)
    return DiskSolution(fold, spare, inflow, several), DiskInflow(nodes, problem, inflow)


def disk_inflow(
    case: Case, solution: DiskSolution, panels: tuple[int, ...], azimuth: AzimuthNodes
) -> DiskInflow:
    """Nodes and inflow of a ``solution``, differentiable with respect to everything in ``case``.

    The other arguments are those of ``solve_disk``.
    """
    nodes = panel_nodes(_edges(case, solution.fold, solution.spare, azimuth), panels)
    problem = annulus_problem(case, nodes.radius)
    return DiskInflow(nodes, problem, moving_root(problem, solution.inflow, azimuth))


def _edges(
    case: Case, fold: folds.Fold | None, spare: Array | None, azimuth: AzimuthNodes
) -> Array:
    """Radii [m] of the panels' edges, rising; (P + 1, B), or (2, 1) of a single panel."""
    root, tip = case.rotor.blade.root, case.rotor.blade.tip
    if fold is None or spare is None:
        return edges_about(case.rotor.blade, xp.zeros((0, 1)))
    return edges_about(
        case.rotor.blade, _moving_edges(case, fold, root + (tip - root) * spare, azimuth)
    )


def edges_about(blade: Blade, inner: Array) -> Array:
    """The panels' edges (E + 2, B) [m], rising, from the inner ones (E, B) in any order."""
    ends = xp.ones((1, inner.shape[1]))
    if inner.shape[0] == 2:  # the usual case without a sort, which ``engine.lanes`` forbids
        inner = xp.stack([xp.min(inner, axis=0), xp.max(inner, axis=0)])
    else:
        inner = xp.sort(inner, axis=0)
    return xp.concatenate([blade.root * ends, inner, blade.tip * ends])


@custom_jvp
def _moving_edges(
    case: Case,  # noqa: ARG001 - the derivative below needs it
    fold: folds.Fold,
    otherwise: Array,
    azimuth: AzimuthNodes,  # noqa: ARG001
) -> Array:
    return xp.where(fold.found, fold.radius, otherwise)


@_moving_edges.defjvp
def _moving_edges_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    (case, fold, otherwise, azimuth), (case_dot, _, otherwise_dot, _) = primals, tangents
    _, fold_dot = jax.jvp(
        lambda c: folds.follow(fold, functools.partial(annulus_problem, c), azimuth),
        (case,),
        (case_dot,),
    )
    edges = _moving_edges(case, fold, otherwise, azimuth)
    return edges, xp.where(fold.found, fold_dot, otherwise_dot)
