"""Folds: radii at which the inflow jumps to another branch of (11), solved for and differentiated.

``split`` explains the hump of the residual and finds roughly where its top passes zero.  From there
Newton's steps lead to that radius, the fold.  Where the residual has no hump but only a shoulder,
they lead to the radius at which the inflow rises most steeply.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import NamedTuple

import jax

from propmap.arrays.loops import while_loop
from propmap.arrays.namespace import Array, stop_gradient, xp
from propmap.arrays.precision import precision_of
from propmap.physics.velocities import AzimuthNodes
from propmap.solve.problem import AnnulusProblem, residual, residual_slope

FOLD_STEPS = 14
"""Newton steps to a fold, at most."""

SHOULDER_STEPS = 6
"""The same to a shoulder, where the exact radius hardly matters: the integrand is smooth."""

ProblemAt = Callable[[Array], AnnulusProblem]
"""Equation (11) at radii of shape (S, B) [m]."""


class Crossing(NamedTuple):
    """Where the height of the hump changes sign, interpolated; all (E, B) for E edges.

    radius [m] and inflow [m/s]; spacing [m], the uncertainty of the radius: zero where there is no
    change of sign, and radius is then where panels meet nevertheless.
    """

    radius: Array
    inflow: Array
    spacing: Array


class Fold(NamedTuple):
    """Folds and shoulders, all (E, B): radius [m], inflow there [m/s]; folded, whether it is a
    fold; found, whether it is either, so that it moves with the operating point."""

    radius: Array
    inflow: Array
    folded: Array
    found: Array


class _FoldSearch(NamedTuple):
    radius: Array
    steepest: Array  # v_i at which the residual's slope is largest [m/s]
    top: Array  # v_i at the top of the hump, or else at the shoulder [m/s]
    folded: Array
    small: Array  # whether the last step was small


def _repeated(problem: AnnulusProblem, edges: int, times: int) -> AnnulusProblem:
    """Equation (11) with its first ``edges`` stations ``times`` times over, then the rest: so the
    blade's shape, which takes as long as the forces, is looked up once."""

    def rows(a: Array) -> Array:
        return xp.concatenate([a[:edges]] * times + [a[edges:]])

    station = jax.tree.map(rows, problem.at.station)
    return problem._replace(at=problem.at._replace(station=station))


def find_folds(
    near: Crossing, problem_at: ProblemAt, root: Array, tip: Array, azimuth: AzimuthNodes
) -> Fold:
    """Solve for the fold, or else for the steepest rise of the inflow, from each crossing.

    At each radius the slope of the residual has a maximum over v_i, found from a parabola.  If this
    maximum is positive, the residual has a hump at larger v_i, with its top where the slope is
    zero; the fold is the radius at which the residual vanishes at the top.  If it is negative, the
    residual has only a shoulder, at the maximum; the radius is that at which the residual vanishes
    there.  Where a hump becomes a shoulder the two coincide, so that the edge does not jump.

    Parameters
    ----------
    near : Crossing
        Where to begin, (E, B); its radius is kept where nothing is found.
    problem_at : callable
        Equation (11) at radii (S, B) [m].
    root, tip : Array
        Ends of the blade [m].
    azimuth : AzimuthNodes
        Azimuths to average over.
    """
    at = problem_at(near.radius).at
    scale = xp.abs(at.omega * near.radius) + xp.abs(at.v_axial) + 1e-30
    within = precision_of(near.radius)
    dv, dy, wide = within.difference * scale, -within.difference * near.radius, 0.008 * scale

    def sought(steps: Array, state: _FoldSearch) -> Array:
        steps_left = xp.where(state.folded, FOLD_STEPS, SHOULDER_STEPS) - steps
        return ~state.small & (near.spacing > 0.0) & (steps_left > 0)

    def improve(counted: tuple[Array, _FoldSearch]) -> tuple[Array, _FoldSearch]:
        steps, before = counted
        y, v_s, v_t = before[:3]
        inflows = xp.concatenate([v_s - wide, v_s, v_s + wide, v_t, v_t + dv, v_t])
        here = problem_at(xp.concatenate([y, y + dy]))
        pair = residual_slope(_repeated(here, y.shape[0], 5), inflows, azimuth)
        g, slope = (a.reshape(6, *y.shape) for a in pair)
        bend = slope[0] - 2.0 * slope[1] + slope[2]
        curved = xp.where(bend < 0.0, bend, -xp.inf)
        shift = xp.clip(0.5 * (slope[0] - slope[2]) / curved, -1.0, 1.0)
        steepest = slope[1] + 0.5 * shift * (slope[2] - slope[0]) + 0.5 * shift**2 * bend
        v_s = v_s + wide * shift
        folded = steepest > 0.0
        # The top of the hump: a Newton step to zero slope, which is above the largest slope's v_i.
        width = wide * xp.sqrt(xp.where(folded, -2.0 * steepest / curved, 0.0))
        g_vv = (slope[4] - slope[3]) / dv
        top = v_t - slope[3] / xp.where(g_vv < 0.0, g_vv, -xp.inf)
        good = (g_vv < 0.0) & (top > v_s) & (top < v_s + 3.0 * width)
        goal = xp.where(folded, xp.where(good, top, v_s + width), v_s)
        g_y = (g[5] - g[3]) / dy
        down = g[3] / xp.where(g_y == 0.0, xp.inf, g_y)
        down = xp.clip(down, -0.5 * near.spacing, 0.5 * near.spacing)
        close = xp.where(folded, within.fold, within.shoulder)
        small = (xp.abs(down) < close * y) & (xp.abs(goal - v_t) < 1e3 * close * scale)
        after = _FoldSearch(y - down, v_s, goal, folded, small)
        # What has ended stays, so that no result depends on the other points of the batch.
        going = sought(steps, before)
        return steps + 1, jax.tree.map(functools.partial(xp.where, going), after, before)

    no = xp.zeros(near.radius.shape, bool)
    begin = _FoldSearch(near.radius, near.inflow, near.inflow, no, no)
    _, (y, _, v, folded, small) = while_loop(
        lambda counted: xp.any(sought(*counted)), improve, (xp.array(0), begin)
    )
    close = xp.abs(y - near.radius) < 2.0 * near.spacing
    found = small & close & (y > root) & (y < tip)
    return Fold(xp.where(found, y, near.radius), v, found & folded, found)


def follow(fold: Fold, problem_at: ProblemAt, azimuth: AzimuthNodes) -> Array:
    """The folds' radii [m], differentiable with respect to what ``problem_at`` depends on; (E, B).

    At a fold the residual's slope by v_i vanishes, so that the residual stays zero if
    d(radius) = -(d residual) / (d residual/d radius).  At a shoulder this is not exact, but the
    integral of a smooth function does not depend on where it is split.
    """
    anchor, v = stop_gradient((fold.radius, fold.inflow))

    def at_fold(radius: Array) -> Array:
        return residual(problem_at(radius), v, azimuth)

    value, along = jax.jvp(at_fold, (anchor,), (xp.ones_like(anchor),))
    along = stop_gradient(xp.where(fold.found & (along != 0.0), along, xp.inf))
    return anchor - (value - stop_gradient(value)) / along
