"""Confidence intervals of parameters that are known to lie within bounds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def bounded_intervals(
    centre: Floats, root: Floats, lower: Floats, upper: Floats, quantile: float
) -> tuple[Floats, Floats]:
    """Ends of the profile intervals of a quadratic sum of squares within bounds; (P,), (P,).

    A value of one parameter belongs to its interval if some values of the others, within their
    bounds, make the sum of squares exceed its least value within the bounds by no more than
    ``quantile`` squared.  So the bounds of one parameter narrow the intervals of those that it is
    correlated with; far from all bounds the ends are centre +- quantile * deviation.

    centre : where the sum of squares is least when bounds are left aside (P,).
    root : W (R, P), R <= P, so that the sum of squares is |W (x - centre)|^2 in units of its
    variance; W^T W is the inverse of the covariance, where there is one.
    lower, upper : bounds (P,).  quantile : of Student's t.
    All in units in which the parameters are of like size.
    """
    from scipy.optimize import brentq, lsq_linear

    target = root @ centre

    def least(k: int, value: float) -> float:
        rest = np.arange(centre.size) != k
        wanted = target - root[:, k] * value
        if not rest.any():
            return float(wanted @ wanted)
        inside = lsq_linear(root[:, rest], wanted, (lower[rest], upper[rest]), "bvls")
        return 2.0 * float(inside.cost)

    best = lsq_linear(root, target, (lower, upper), "bvls")
    allowed = 2.0 * float(best.cost) + quantile**2
    ends = np.empty((2, centre.size))
    for k, middle in enumerate(best.x):
        for side, bound in enumerate((lower[k], upper[k])):
            past = bound == middle or least(k, bound) <= allowed
            ends[side, k] = (
                bound if past else brentq(lambda v, k=k: least(k, v) - allowed, middle, bound)
            )
    return ends[0], ends[1]
