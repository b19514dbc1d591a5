"""Newton's method for many small systems of equations at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from propmap.typing import Floats

ITERATIONS = 40

SHORTEST = 1.0 / 32.0
"""Share of a step below which the search of a system ends."""

RESTARTS = 10
"""Times, at most, that systems without a solution begin anew at their neighbours'."""

Linearised = Callable[[Floats, NDArray[np.intp]], tuple[Floats, Floats]]
"""Residuals (m, u) and their derivatives (m, u, u), of unknowns (m, u) of the systems of these
numbers (m,); NaN where there are none."""

Bounded = Callable[[Floats, Floats], Floats]
"""A step (m, u), shortened to what may be trusted, from unknowns (m, u) and a step."""


def solve(
    linearised: Linearised, bounded: Bounded, first: Floats, order: Floats, tolerance: float
) -> Floats:
    """Unknowns (n, u) of n systems, the best that were found.

    A step that does not lower the residual is halved.  A system that ends without a solution begins
    anew at that of the nearest system that has one.

    Parameters
    ----------
    linearised, bounded : callable
        See ``Linearised`` and ``Bounded``.
    first : ndarray, shape (n, u)
        Where to begin.
    order : ndarray, shape (n,)
        By which systems are near each other.
    tolerance : float
        Largest norm of a solution's residual.
    """
    best, size = _newton(linearised, bounded, first, np.arange(len(first)), tolerance)
    for _ in range(RESTARTS):
        good, lost = np.flatnonzero(size <= tolerance), np.flatnonzero(size > tolerance)
        if not (lost.size and good.size):
            break
        nearest = good[np.abs(order[lost][:, None] - order[good]).argmin(axis=1)]
        found, left_over = _newton(linearised, bounded, best[nearest], lost, tolerance)
        better = left_over < size[lost]
        best[lost[better]], size[lost[better]] = found[better], left_over[better]
        if not (left_over <= tolerance).any():
            break
    return best


def _newton(
    linearised: Linearised,
    bounded: Bounded,
    first: Floats,
    numbers: NDArray[np.intp],
    tolerance: float,
) -> tuple[Floats, Floats]:
    """The best unknowns (m, u) of some systems, and the norms of what they leave over (m,)."""
    best, step = first.copy(), np.zeros_like(first)
    size, share = np.full(len(first), np.inf), np.ones(len(first))
    at_work = np.arange(len(first))
    for _ in range(ITERATIONS):
        trial = best[at_work] + share[at_work, None] * step[at_work]
        residual, slopes = linearised(trial, numbers[at_work])
        norm = np.nan_to_num(np.linalg.norm(residual, axis=1), nan=np.inf)
        better = norm < size[at_work]
        won = at_work[better]
        best[won], size[won], share[won] = trial[better], norm[better], 1.0
        share[at_work[~better]] *= 0.5
        step[won] = bounded(trial[better], _newton_step(residual[better], slopes[better]))
        at_work = at_work[(size[at_work] > tolerance) & (share[at_work] >= SHORTEST)]
        if not at_work.size:
            break
    return best, size


def _newton_step(residual: Floats, slopes: Floats) -> Floats:
    """The step (m, u) to where the linear systems vanish; no step without derivatives."""
    known = np.asarray(np.isfinite(slopes).all(axis=(1, 2)))
    inverse = np.linalg.pinv(np.where(known[:, None, None], slopes, 0.0), rcond=1e-12)
    return -np.einsum("mij,mj->mi", inverse, residual)
