"""Confidence intervals of parameters that are known to lie within bounds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from propmap.typing import Floats


class Quadratic(NamedTuple):
    """A sum of squares |slopes x - target|^2 within bounds; slopes (R, P), bounds (P,)."""

    slopes: Floats
    target: Floats
    lower: Floats
    upper: Floats

    def profile(self, k: int, value: float) -> tuple[float, Floats]:
        """The least sum of squares with parameter k at ``value``, and x (P,) there."""
        from scipy.optimize import lsq_linear

        rest = np.arange(self.lower.size) != k
        wanted = self.target - self.slopes[:, k] * value
        x = np.full(self.lower.size, value)
        if not rest.any():
            return float(wanted @ wanted), x
        bounds = (self.lower[rest], self.upper[rest])
        inside = lsq_linear(self.slopes[:, rest], wanted, bounds, "bvls")
        x[rest] = inside.x
        return 2.0 * float(inside.cost), x


def bounded_intervals(
    centre: Floats, root: Floats, lower: Floats, upper: Floats, quantile: Floats | float
) -> tuple[Floats, Floats]:
    """Ends of the profile intervals of the sum of squares |W (x - centre)|^2 within bounds.

    A value of one parameter belongs to its interval if some values of the others, within their
    bounds, make the sum of squares exceed its least value within the bounds by no more than
    ``quantile`` squared.  So the bounds of one parameter narrow the intervals of those that it is
    correlated with; far from all bounds the ends are centre +- quantile * deviation.

    Parameters
    ----------
    centre : ndarray, shape (P,)
        Where the sum is least, bounds left aside; in units in which parameters are of like size.
    root : ndarray, shape (R, P)
        W, R <= P; W^T W is the inverse of the covariance, where there is one.
    lower, upper : ndarray, shape (P,)
        Bounds.
    quantile : float, or ndarray of shape (P,)
        Of Student's t.

    Returns
    -------
    low, high : ndarray, shape (P,)
        Ends.
    """
    from scipy.optimize import brentq, lsq_linear

    squares = Quadratic(root, root @ centre, lower, upper)
    best = lsq_linear(root, squares.target, (lower, upper), "bvls")
    each = np.broadcast_to(quantile, centre.shape)
    ends = np.empty((2, centre.size))
    for k, middle in enumerate(best.x):
        allowed = 2.0 * float(best.cost) + float(each[k]) ** 2

        def beyond(v: float, k: int = k, allowed: float = allowed) -> float:
            return squares.profile(k, v)[0] - allowed

        for side, bound in enumerate((lower[k], upper[k])):
            ends[side, k] = bound
            if bound != middle and beyond(bound) > 0.0:
                ends[side, k] = brentq(beyond, middle, bound)
    return ends[0], ends[1]
