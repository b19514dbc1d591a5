"""The inflow over the whole disk: radial nodes that follow stall, and v_i at each."""

from __future__ import annotations

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import lax

from propmap.theory import blade_element, stall_folds, stall_split
from propmap.theory.blade_shape import blade_shape
from propmap.theory.inflow import MAX_STEPS, InflowQuestion, inflow_root
from propmap.theory.parameters import Array, Blade, Medium, Section
from propmap.theory.quadrature import RadialNodes, panel_nodes
from propmap.theory.velocities import AzimuthNodes


class Case(NamedTuple):
    """Everything that the inflow depends on; a pytree.

    blade, section, medium : see ``parameters``.  omega [rad/s], v_axial = V cos(beta),
    v_inplane = V sin(beta) [m/s], windmill : 1 on the windmill branch, else 0; all (B,).
    """

    blade: Blade
    section: Section
    medium: Medium
    omega: Array
    v_axial: Array
    v_inplane: Array
    windmill: Array


class DiskInflow(NamedTuple):
    """Radial nodes (S, B) or (S, 1), v_i there (S, B) [m/s], whether (11) was seen to have
    several roots (B,)."""

    nodes: RadialNodes
    inflow: Array
    several: Array


def question(case: Case, radius: Array) -> InflowQuestion:
    """Equation (11) at radius (S, B) or (S, 1) [m]."""
    shape = blade_shape(case.blade, radius)
    at = blade_element.annulus(
        shape, case.blade, case.section, case.medium, case.omega, case.v_axial, case.v_inplane
    )
    return InflowQuestion(at, case.windmill)


def disk_inflow(case: Case, panels: tuple[int, ...], azimuth: AzimuthNodes) -> DiskInflow:
    """Solve (11) over the disk; differentiable with respect to everything in ``case``.

    panels : radial nodes on each panel, static.  One panel is the whole blade; with more,
    their edges follow stall (``stall_split``).
    azimuth : azimuth nodes.
    """
    root, tip = case.blade.root, case.blade.tip
    max_steps = jnp.asarray(MAX_STEPS)
    if len(panels) == 1:
        nodes = panel_nodes(jnp.stack([root, tip])[:, None], panels)
        ask = question(case, nodes.radius)
        anywhere = jnp.full(case.omega.shape, jnp.inf)
        inflow = inflow_root(ask, anywhere, max_steps, azimuth)
        return DiskInflow(nodes, inflow, jnp.zeros(case.omega.shape, bool))
    inner, several, survey = _inner_edges(case, len(panels) - 1, azimuth)
    ends = jnp.ones((1, inner.shape[1]))
    edges = jnp.concatenate([root * ends, jnp.sort(inner, axis=0), tip * ends])
    nodes = panel_nodes(edges, panels)
    ask = question(case, nodes.radius)
    start = stall_split.start_below_hump(*lax.stop_gradient((survey, edges)), panels, ask)
    inflow = inflow_root(ask, lax.stop_gradient(start), max_steps, azimuth)
    return DiskInflow(nodes, inflow, several)


def _inner_edges(
    case: Case, count: int, azimuth: AzimuthNodes
) -> tuple[Array, Array, stall_split.Survey]:
    """Radii (count, B) [m] at which to split, whether several roots were seen (B,), survey."""
    root, tip = case.blade.root, case.blade.tip
    still = functools.partial(question, lax.stop_gradient(case))
    span = lax.stop_gradient((root, tip))
    near, survey = stall_split.hump_crossings(still, *span, count, azimuth)
    fold = stall_folds.find_folds(near, still, *span, azimuth)
    elsewhere = root + (tip - root) * lax.stop_gradient((near.radius - root) / (tip - root))
    edges = _moving_edges(case, fold, elsewhere, azimuth)
    return edges, survey.several | jnp.any(fold.folded, axis=0), survey


@jax.custom_jvp
def _moving_edges(
    case: Case,  # noqa: ARG001 - what the folds move with, in the derivative below
    fold: stall_folds.Fold,
    otherwise: Array,
    azimuth: AzimuthNodes,  # noqa: ARG001
) -> Array:
    return jnp.where(fold.found, fold.radius, otherwise)


@_moving_edges.defjvp
def _moving_edges_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    (case, fold, otherwise, azimuth), (case_dot, _, otherwise_dot, _) = primals, tangents
    _, fold_dot = jax.jvp(
        lambda c: stall_folds.follow(fold, functools.partial(question, c), azimuth),
        (case,),
        (case_dot,),
    )
    edges = _moving_edges(case, fold, otherwise, azimuth)
    return edges, jnp.where(fold.found, fold_dot, otherwise_dot)
