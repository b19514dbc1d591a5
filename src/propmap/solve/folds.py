"""Folds: the radii at which the hump's top passes zero, solved for and followed.

From a crossing that ``split`` has seen, Newton's steps lead to the fold, or where there is no
hump but a shoulder, to the steepest rise of the inflow; and both move with the operating point.
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
"""Newton steps on a fold, at most."""

SHOULDER_STEPS = 6
"""The same on a shoulder: where a smooth integrand is split hardly matters."""

ProblemAt = Callable[[Array], AnnulusProblem]
"""Equation (11) at radii of shape (S, B) [m]."""


class Crossing(NamedTuple):
    """Where the hump passes zero, to within the grid; all (E, B) for E edges.

    radius [m] and inflow [m/s] by interpolation; spacing [m]: about how well the radius is
    known, zero where there is no crossing and radius is where a panel is split nevertheless.
    """

    radius: Array
    inflow: Array
    spacing: Array


class Fold(NamedTuple):
    """Folds and shoulders, all (E, B): radius [m], inflow [m/s] there, whether it is a
    fold, and whether it is either and moves with the operating point."""

    radius: Array
    inflow: Array
    folded: Array
    found: Array


class _FoldSearch(NamedTuple):
    radius: Array
    steepest: Array  # v_i at the top of the residual's slope [m/s]
    top: Array  # v_i at the top of the hump, or else at the shoulder [m/s]
    folded: Array
    small: Array  # whether the last step was


def _repeated(problem: AnnulusProblem, edges: int, times: int) -> AnnulusProblem:
    """Equation (11) with its first ``edges`` stations ``times`` over, then the rest: the blade's
    shape, which takes as long as the forces, is looked up once."""

    def rows(a: Array) -> Array:
        return xp.concatenate([a[:edges]] * times + [a[edges:]])

    station = jax.tree.map(rows, problem.at.station)
    return problem._replace(at=problem.at._replace(station=station))


def find_folds(
    near: Crossing, problem_at: ProblemAt, root: Array, tip: Array, azimuth: AzimuthNodes
) -> Fold:
    """Solve for the fold, or else for the steepest rise of the inflow, from each crossing.

    At a radius, the slope of the residual has a top over v_i, found from a parabola.  Where
    it is positive there is a hump above it, whose own top is where the slope falls to zero;
    the radius at which the residual vanishes there is the fold.  Where it is negative there
    is only a shoulder, and the radius is that at which the residual vanishes on it.  At the
    cusp between the two they coincide, so the edge moves without a jump.

    Parameters
    ----------
    near : Crossing
        Where to begin, (E, B), and the radius where nothing is found.
    problem_at : callable
        Equation (11) at radii (S, B) [m].
    root, tip : Array
        Ends of the blade [m].
    azimuth : AzimuthNodes
        Nodes to average over.
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
        # The top of the hump: Newton on the slope, above the steepest point.
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
        # Lanes that have ended stay, so that no result depends on what else is in the batch.
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
    """The folds' radii [m], made to move with what ``problem_at`` depends on; (E, B).

    At a fold the slope with respect to v_i vanishes, so the residual stays zero if
    d(radius) = -(d residual) / (d residual/d radius).  At a shoulder the same is near enough,
    since the loads do not depend on where a smooth integrand is split.
    """
    anchor, v = stop_gradient((fold.radius, fold.inflow))

    def at_fold(radius: Array) -> Array:
        return residual(problem_at(radius), v, azimuth)

    value, along = jax.jvp(at_fold, (anchor,), (xp.ones_like(anchor),))
    along = stop_gradient(xp.where(fold.found & (along != 0.0), along, xp.inf))
    return anchor - (value - stop_gradient(value)) / along
