"""A fit's record, made up."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from propmap.fit.fit_record import (
    Covered,
    FitErrors,
    FitRecord,
    FittedLoad,
    FreeParameter,
)


def load(name: str, rms: float, hover: float, crossed: float = math.nan) -> FittedLoad:
    """A load whose measured values have the root mean square 1."""
    bands = {"0-3 m/s": FitErrors(4, 0.5 * rms, 0.0, rms, hover)}
    bands["6-9 m/s"] = FitErrors(6, 4.0 * rms, 0.0, rms, hover)
    return FittedLoad(name, "N", FitErrors(10, rms, 0.0, rms, hover), 1.0, crossed, bands)


def covered(beta: float, advance: float, points: int = 10) -> Covered:
    return Covered(
        points, (4000.0, 6000.0), 5000.0, (1.0, 9.0), (0.01, advance), (beta, beta), beta
    )


def parameter(name: str, value: float, lower: float, upper: float) -> FreeParameter:
    return FreeParameter(name, "-", value, lower, upper, lower, upper, "identified", True)


def record(**changed: Any) -> FitRecord:
    whole = FitRecord(
        kind="tunnel",
        version="0",
        data=[("mine.csv", "abc")],
        remarks=[],
        rows=20,
        unsolved=0,
        parameters=[parameter("c_l1", 5.0, 0.5, 12.0), parameter("c_d", 1.0, 0.0, 10.0)],
        loads=[load("thrust", 0.02, 0.3, 0.022)],
        points=10,
        rpm=(4000.0, 6000.0),
        typical_rpm=5000.0,
        speed=(0.0, 9.0),
        at_rest=None,
        angles=[covered(0.0, 0.2), covered(90.0, 0.25)],
        covariance=np.diag([0.04, 0.01]),
        correlation=np.eye(2),
        singular_values=np.array([1.0, 0.5]),
        minima=1,
        starts=1,
    )
    return replace(whole, **changed)
