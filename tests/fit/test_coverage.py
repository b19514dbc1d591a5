"""What a fit file says of its data's operating points."""

from __future__ import annotations

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.fit.fit import coverage

RPM = 30.0 / np.pi
RADIUS = 0.1


def test_points_are_grouped_by_angle_and_rest_apart() -> None:
    omega = np.array([500.0, 400.0, 600.0, 500.0, 0.0])
    speed = np.array([0.0, 5.0, 10.0, 2.0, 3.0])
    beta = np.radians([70.0, 84.0, 95.0, 10.0, 90.0])
    found = coverage(omega, speed, beta, RADIUS)
    # A rotor that stands still has no advance ratio.
    assert found.points == 4
    assert found.rpm == pytest.approx((400.0 * RPM, 600.0 * RPM))
    assert found.speed == (0.0, 10.0)
    assert found.at_rest is not None and found.at_rest.points == 1
    steep, edgewise = found.angles
    assert (steep.points, edgewise.points) == (1, 2)
    assert edgewise.beta == pytest.approx((84.0, 95.0))
    assert edgewise.typical_beta == pytest.approx(89.5)
    assert edgewise.speed == (5.0, 10.0)
    assert edgewise.advance == pytest.approx((5.0 / 40.0, 10.0 / 60.0))


def test_all_at_rest() -> None:
    found = coverage(np.array([300.0, 500.0]), np.zeros(2), np.zeros(2), RADIUS)
    assert found.angles == [] and found.at_rest is not None and found.at_rest.points == 2


def test_a_propeller_that_never_turns_is_refused() -> None:
    with pytest.raises(InputError, match="stands still at all points"):
        coverage(np.zeros(2), np.ones(2), np.zeros(2), RADIUS)
