"""Tolerances and finite-difference steps for float64 and for float32."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from propmap.arrays.namespace import Array


class Precision(NamedTuple):
    """Tolerances, each relative to the size of what it applies to [-]; see ``solve.root``.

    Attributes
    ----------
    safe_step : float
        Step towards a root below which Newton steps take over from safe steps.
    newton_step : float
        Newton step below which the root counts as found.
    left_over : float
        Error left by a Newton step, estimated from the curvature, below which it is the last one.
    residual : float
        Largest accepted residual of (11), relative to its terms.
    difference : float
        Finite-difference step of the search for folds.
    fold, shoulder : float
        Change of the radius of a fold, or of a shoulder, below which it counts as found.
    """

    safe_step: float
    newton_step: float
    left_over: float
    residual: float
    difference: float
    fold: float
    shoulder: float


FLOAT64 = Precision(1e-7, 1e-9, 1e-12, 1e-9, 1e-6, 1e-8, 1e-5)
FLOAT32 = Precision(1e-5, 1e-5, 1e-6, 3e-5, 3e-3, 3e-5, 1e-4)


def precision_of(values: Array) -> Precision:
    """The tolerances for an array of float64 or float32."""
    return FLOAT32 if values.dtype == np.float32 else FLOAT64
