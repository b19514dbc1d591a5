"""The inflow over the whole disk: radial nodes that follow stall, and v_i at each."""

from __future__ import annotations

import functools
from typing import NamedTuple

import jax

from propmap.arrays.namespace import Array, DerivativeByRule, held, xp
from propmap.physics import element
from propmap.physics.geometry import blade_shape
from propmap.physics.parameters import Blade, Medium, Section
from propmap.physics.velocities import AzimuthNodes
from propmap.solve import folds, split
from propmap.solve.inflow import MAX_STEPS, InflowQuestion, find_root, moving_root
from propmap.solve.quadrature import RadialNodes, panel_nodes
from propmap.solve.root_count import several_roots


class Case(NamedTuple):
    """Everything that the inflow depends on; a pytree.

    blade, section, medium : see ``parameters``.  omega [rad/s], v_axial = V cos(beta),
    v_inplane = V sin(beta) [m/s], windmill : 1 on the windmill branch, else 0; all (B,).  windmill
    is None where nothing descends.
    """

    blade: Blade
    section: Section
    medium: Medium
    omega: Array
    v_axial: Array
    v_inplane: Array
    windmill: Array | None


class DiskSolution(NamedTuple):
    """What was searched for, as mere numbers that do not move with anything; a pytree.

    fold : where stall begins and ends along the blade, None if it is not followed.
    spare (E, B) : shares of the span [-] for the edges without a fold, None like ``fold``.
    inflow (S, B) : v_i at the radial nodes [m/s], NaN where it was not found.
    several (B,) : whether (11) was seen to have several roots.
    """

    fold: folds.Fold | None
    spare: Array | None
    inflow: Array
    several: Array


class DiskInflow(NamedTuple):
    """Radial nodes (S, B) or (S, 1), equation (11) there, v_i there (S, B) [m/s]."""

    nodes: RadialNodes
    ask: InflowQuestion
    inflow: Array


def question(case: Case, radius: Array) -> InflowQuestion:
    """Equation (11) at radius (S, B) or (S, 1) [m]."""
    shape = blade_shape(case.blade, radius)
    at = element.annulus(
        shape, case.blade, case.section, case.medium, case.omega, case.v_axial, case.v_inplane
    )
    return InflowQuestion(at, case.windmill)


def solve_disk(
    case: Case, panels: tuple[int, ...], azimuth: AzimuthNodes
) -> tuple[DiskSolution, DiskInflow]:
    """Solve (11) over the disk; differentiable nowhere, for that see ``disk_inflow``.

    panels : radial nodes on each panel, static.  One panel is the whole blade; with more,
    their edges follow stall (``split``).
    azimuth : azimuth nodes.
    """
    case = held(case)
    root, tip = case.blade.root, case.blade.tip
    fold = spare = None
    if len(panels) > 1:
        still = functools.partial(question, case)
        near, survey = split.hump_crossings(still, root, tip, len(panels) - 1, azimuth)
        fold = folds.find_folds(near, still, root, tip, azimuth)
        spare = (near.radius - root) / (tip - root)
    edges = _edges(case, fold, spare, azimuth)
    nodes = panel_nodes(edges, panels)
    ask = question(case, nodes.radius)
    if fold is None:
        start = xp.full(case.omega.shape, xp.inf)
        several = xp.zeros(case.omega.shape, bool)
    else:
        start = split.start_below_hump(survey, fold, edges, panels, ask)
        several = survey.several | xp.any(fold.folded, axis=0)
    inflow = find_root(ask, start, xp.asarray(MAX_STEPS), azimuth)
    if fold is None:
        several = several_roots((ask, inflow), azimuth)
    return DiskSolution(fold, spare, inflow, several), DiskInflow(nodes, ask, inflow)


def disk_inflow(
    case: Case, solution: DiskSolution, panels: tuple[int, ...], azimuth: AzimuthNodes
) -> DiskInflow:
    """Nodes and inflow of a solution, made to move with everything in ``case``: differentiable.

    case, panels, azimuth : those that were solved.
    """
    nodes = panel_nodes(_edges(case, solution.fold, solution.spare, azimuth), panels)
    ask = question(case, nodes.radius)
    return DiskInflow(nodes, ask, moving_root(ask, solution.inflow, azimuth))


def _edges(
    case: Case, fold: folds.Fold | None, spare: Array | None, azimuth: AzimuthNodes
) -> Array:
    """Radii [m] of the panels' edges, rising; (P + 1, B), or (2, 1) of a single panel."""
    root, tip = case.blade.root, case.blade.tip
    if fold is None or spare is None:
        return edges_about(case.blade, xp.zeros((0, 1)))
    return edges_about(case.blade, _moving_edges(case, fold, root + (tip - root) * spare, azimuth))


def edges_about(blade: Blade, inner: Array) -> Array:
    """The panels' edges (E + 2, B) [m], rising, from the inner ones (E, B) in any order."""
    ends = xp.ones((1, inner.shape[1]))
    if inner.shape[0] == 2:  # as most have, without a sort, see ``propmap.engine.lanes``
        inner = xp.stack([xp.min(inner, axis=0), xp.max(inner, axis=0)])
    else:
        inner = xp.sort(inner, axis=0)
    return xp.concatenate([blade.root * ends, inner, blade.tip * ends])


@DerivativeByRule
def _moving_edges(
    case: Case,  # noqa: ARG001 - what the folds move with, in the derivative below
    fold: folds.Fold,
    otherwise: Array,
    azimuth: AzimuthNodes,  # noqa: ARG001
) -> Array:
    return xp.where(fold.found, fold.radius, otherwise)


@_moving_edges.defjvp
def _moving_edges_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    (case, fold, otherwise, azimuth), (case_dot, _, otherwise_dot, _) = primals, tangents
    _, fold_dot = jax.jvp(
        lambda c: folds.follow(fold, functools.partial(question, c), azimuth),
        (case,),
        (case_dot,),
    )
    edges = _moving_edges(case, fold, otherwise, azimuth)
    return edges, xp.where(fold.found, fold_dot, otherwise_dot)
