"""Tolerances and steps of differences that suit the precision of the numbers at hand."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from propmap.arrays.namespace import Array


class Precision(NamedTuple):
    """All relative to the sizes at hand [-].

    Attributes
    ----------
    safe_step : float
        Of the walk to a root, after which Newton's steps follow.
    newton_step : float
        After which a root is taken as found.
    left_over : float
        What a Newton step leaves, by the curvature: for float64 most steps of 1e-7 are the last.
    residual : float
        Largest accepted residual, of the terms of (11).
    difference : float
        Step of the differences by which folds are followed.
    fold, shoulder : float
        Change of the radius of a fold, or shoulder, after which it is taken as found.
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
    """What suits an array of float64 or float32."""
    return FLOAT32 if values.dtype == np.float32 else FLOAT64
