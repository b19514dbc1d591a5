"""Newton's method for many small systems of equations at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from propmap.typing import Floats

ITERATIONS = 40

SHORTEST = 1.0 / 32.0
"""Share of a step below which the search of a system ends."""

NEAR = 1e-2
"""Norm of a residual below which derivatives are kept up by what steps do, by Broyden's rule: they
cost as much as three residuals."""

RESTARTS = 10
"""Times, at most, that systems without a solution begin anew at their neighbours'."""

Linearised = Callable[[Floats, NDArray[np.intp]], tuple[Floats, Floats]]
"""Residuals (m, u) and their derivatives (m, u, u), of unknowns (m, u) of the systems of these
numbers (m,); NaN where there are none."""

Residuals = Callable[[Floats, NDArray[np.intp]], Floats]
"""The residuals alone."""

Bounded = Callable[[Floats, Floats], Floats]
"""A step (m, u), shortened to what may be trusted, from unknowns (m, u) and a step."""


def solve(
    linearised: Linearised,
    residuals: Residuals,
    bounded: Bounded,
    first: Floats,
    order: Floats,
    tolerance: float,
) -> Floats:
    """Unknowns (n, u) of n systems, the best that were found.

    A step that does not lower the residual is halved.  A system that ends without a solution begins
    anew at that of the nearest system that has one.

    Parameters
    ----------
    linearised, residuals, bounded : callable
        See ``Linearised``, ``Residuals`` and ``Bounded``.
    first : ndarray, shape (n, u)
        Where to begin.
    order : ndarray, shape (n,)
        By which systems are near each other.
    tolerance : float
        Largest norm of a solution's residual.
    """
    functions = linearised, residuals, bounded
    best, size = _newton(*functions, first, np.arange(len(first)), tolerance)
    for _ in range(RESTARTS):
        good, lost = np.flatnonzero(size <= tolerance), np.flatnonzero(size > tolerance)
        if not (lost.size and good.size):
            break
        nearest = good[np.abs(order[lost][:, None] - order[good]).argmin(axis=1)]
        found, left_over = _newton(*functions, best[nearest], lost, tolerance)
        better = left_over < size[lost]
        best[lost[better]], size[lost[better]] = found[better], left_over[better]
        if not (left_over <= tolerance).any():
            break
    return best


def _newton(
    linearised: Linearised,
    residuals: Residuals,
    bounded: Bounded,
    first: Floats,
    numbers: NDArray[np.intp],
    tolerance: float,
) -> tuple[Floats, Floats]:
    """The best unknowns (m, u) of some systems, and the norms of what they leave over (m,)."""
    best, step = first.copy(), np.zeros_like(first)
    size, share = np.full(len(first), np.inf), np.ones(len(first))
    at_work, near = np.arange(len(first)), False
    left, inverse = np.zeros(0), np.zeros(0)
    for _ in range(ITERATIONS):
        moved = share[at_work, None] * step[at_work]
        trial = best[at_work] + moved
        if near:
            residual = residuals(trial, numbers[at_work])
            inverse = _followed(inverse, moved, residual - left)
        else:
            residual, slopes = linearised(trial, numbers[at_work])
            inverse = _inverse(slopes)
        norm = np.nan_to_num(np.linalg.norm(residual, axis=1), nan=np.inf)
        better = norm < size[at_work]
        won = at_work[better]
        best[won], size[won], share[won] = trial[better], norm[better], 1.0
        share[at_work[~better]] *= 0.5
        onward = -np.einsum("mij,mj->mi", inverse[better], residual[better])
        step[won] = bounded(trial[better], onward)
        kept = (size[at_work] > tolerance) & (share[at_work] >= SHORTEST)
        at_work, left, inverse = at_work[kept], residual[kept], inverse[kept]
        if not at_work.size:
            break
        near = bool(better[kept].all() and (size[at_work] <= NEAR).all())
    return best, size


def _inverse(slopes: Floats) -> Floats:
    """Inverses (m, u, u) of derivatives, zero where there are none."""
    known = np.asarray(np.isfinite(slopes).all(axis=(1, 2)))
    return np.linalg.pinv(np.where(known[:, None, None], slopes, 0.0), rcond=1e-12)


def _followed(inverse: Floats, moved: Floats, change: Floats) -> Floats:
    """Inverses (m, u, u) that lead from the ``change`` of the residuals to what was ``moved``."""
    missed = moved - np.einsum("mij,mj->mi", inverse, change)
    along = np.einsum("mi,mij->mj", moved, inverse)
    size = np.einsum("mi,mi->m", along, change)[:, None, None]
    update = missed[:, :, None] * along[:, None, :]
    return inverse + np.divide(update, size, out=np.zeros_like(update), where=size != 0.0)
