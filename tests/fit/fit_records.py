"""A fit's record, made up."""

from __future__ import annotations

import math
from typing import Any

import msgspec
import numpy as np
import tomli_w

import propmap
from propmap.fit.files import DataSource, FitRecord, FittedLoad, FittedPropeller, FreeParameter
from propmap.fit.fit import Coverage, CoveredAngle
from propmap.fit.least_squares import End, ResidualErrors
from propmap.model.airfoil import parameter_set
from propmap.model.envelope import Envelope

ENVELOPE = Envelope((0.0, 100.0), (0.0, 0.25), (0.0, 0.25), (-0.05, 0.2), (4000.0, 6000.0))


def load(name: str, rms: float, hover: float, crossed: float = math.nan) -> FittedLoad:
    """A load whose measured values have the root mean square 1."""
    bands = {"0-3 m/s": ResidualErrors(4, 0.5 * rms, 0.5 * rms, 0.0, rms, hover)}
    bands["6-9 m/s"] = ResidualErrors(6, 4.0 * rms, 4.0 * rms, 0.0, rms, hover)
    return FittedLoad(10, rms, rms, 0.0, rms, hover, name, "N", crossed, bands)


def covered(beta: float, advance: float, points: int = 10) -> CoveredAngle:
    return CoveredAngle(
        points, (4000.0, 6000.0), 5000.0, (1.0, 9.0), (0.01, advance), (beta, beta), beta
    )


def parameter(name: str, value: float, lower: float, upper: float) -> FreeParameter:
    return FreeParameter(
        name, value, "-", lower, upper, "identified", True, value, lower=lower, upper=upper
    )


def record(**changed: Any) -> FitRecord:
    """A record; entries of the coverage may be changed like any other."""
    whole = Coverage(
        points=10,
        rpm=(4000.0, 6000.0),
        typical_rpm=5000.0,
        speed=(0.0, 9.0),
        angles=[covered(0.0, 0.2), covered(90.0, 0.25)],
    )
    of_coverage = {name: changed.pop(name) for name in whole.__struct_fields__ if name in changed}
    entries: dict[str, Any] = {
        "kind": "tunnel",
        "version": "0",
        "remarks": [],
        "rows": 20,
        "unsolved": 0,
        "seconds": 1.0,
        "settings": {},
        "fixed": {},
        "air": propmap.Air(),
        "propeller": FittedPropeller.of(propmap.propeller("apc-8x6e")),
        "data": [DataSource("mine.csv", "abc")],
        "covered": msgspec.structs.replace(whole, **of_coverage),
        "parameters": [parameter("c_l1", 5.0, 0.5, 12.0), parameter("c_d", 1.0, 0.0, 10.0)],
        "body": {},
        "wing": {},
        "covariance": np.diag([0.04, 0.01]),
        "correlation": np.eye(2),
        "singular_values": np.array([1.0, 0.5]),
        "loads": [load("thrust", 0.02, 0.3, 0.022)],
        "starts": [End(np.array([5.0, 1.0]), np.array([5.0, 1.0]), 0.1)],
    } | changed
    free = [p.name for p in entries["parameters"]]
    if len(free) != len(entries["singular_values"]):
        entries |= {"correlation": np.eye(len(free)), "singular_values": np.ones(len(free))}
    return FitRecord(free=free, **entries)


def fit_text(**changed: Any) -> str:
    """A fit file with this record."""
    law = parameter_set("paper-apc").to_toml()
    return law + "\n" + tomli_w.dumps({"fit": record(**changed).table()})
