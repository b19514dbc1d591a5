"""The core in descent beside a brute-force solution of (11), without its panels and searches."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

from papers.gill_dandrea_2017 import reference
from tools.dense_descents import (
    COMPILER,
    LIMIT,
    LOOKS,
    Point,
    chunk,
    dense_loads,
    differences,
    motions,
    rotor,
)

pytestmark = pytest.mark.skipif(
    shutil.which(COMPILER[0]) is None, reason=f"there is no {COMPILER[0]} to compile it with"
)

ONCE_WRONG = (
    Point("uiuc-mit-5x4", True, 1224.6024, 12.144173, 122.36),
    Point("uiuc-apcsp-11x4", False, 429.491768, 2.0795635, 87.13003),
    Point("uiuc-apcsp-11x4", True, 429.491768, 2.0795635, 87.13003),
    # A kink between two nodes, on the windmill branch.
    Point("uiuc-apcsp-11x4", False, 384.455245, 9.8259212, 180.0),
    # The root of the blade stalls at negative angles; beyond its middle, the angles are positive.
    Point("law-27", False, 2953.265781, 53.354085, 2.129995),
    # Attached and stalled azimuths alternate, and a scan did not find the attached root.
    Point("law-50", False, 1922.756872, 145.235775, 81.730947),
    # Forecasts on the windmill branch led to smaller roots.
    Point("law-69", False, 333.4359387140124, 16.880146182538812, 135.0640257559352),
    Point("law-10", True, 1251.354011094602, 80.6223955393153, 155.435689283979),
    # Newton's method started at a root between samples, too inexact for a sharp stall.
    Point("law-13", True, 360.8088634071986, 5.893180270784834, 43.41189472695556),
)
"""Points whose loads once had errors of up to 2.9 % of the static loads, without a status."""


def test_brute_force_is_the_reference() -> None:
    """It solves the equations as the plain Python of the reference does, in descent."""
    point = Point("apc-8x6e", True, 700.0, 20.0, 150.0)
    model, (motion,) = rotor(*point[:2]).model, motions([point])
    dense = dense_loads(model, LOOKS[0], motion[None])[0]
    omega, along, across = map(float, motion)
    plain = list(reference.loads(model, omega, along, across, radii=60))
    np.testing.assert_allclose(dense, plain, rtol=2e-3, atol=1e-12)


@pytest.mark.parametrize("point", ONCE_WRONG)
def test_points_that_were_wrong(point: Point) -> None:
    (row,) = differences([point], LOOKS[1:2])
    assert row["off"] < LIMIT


@pytest.mark.parametrize(
    ("count", "advance"),
    [
        (60, 0.0),
        pytest.param(1000, 0.0, marks=pytest.mark.slow),
        pytest.param(300, 4.0, marks=pytest.mark.slow),
    ],
)
def test_no_silent_error_in_descent(count: int, advance: float) -> None:
    """In fast flow past a slow rotor, too, each point above the limit has a status."""
    above = chunk(0, count, LOOKS, advance)["above"]
    assert isinstance(above, list)
    assert [row for row in above if row["status"] not in ("coarse", "not_converged")] == []
