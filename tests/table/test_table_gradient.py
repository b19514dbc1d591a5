"""A table's derivatives against finite differences of the table, and against the model's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from propmap.loads import LOADS
from propmap.table import LoadTable

from .conftest import random_points

FIELDS = (*LOADS, "power")


def _difference(table: LoadTable, point: np.ndarray, k: int, step: float, name: str) -> float:
    ends = []
    for side in (-1.0, 1.0):
        moved = point.copy()
        moved[k] += side * step
        if point.size == 3:
            ends.append(getattr(table.loads(*moved.tolist()), name))
        else:
            ends.append(getattr(table.loads_at_velocity(float(moved[0]), moved[1:]), name))
    return float(ends[1] - ends[0]) / (2.0 * step)


def _check(table: LoadTable, points: np.ndarray, gradient: Any, steps: tuple[float, ...]) -> None:
    for row, point in enumerate(points):
        for name in FIELDS:
            scale = np.abs(getattr(gradient, name)).max(axis=0)
            for k, step in enumerate(steps):
                # A knot within the step, where the second derivative jumps, shows first.
                expected = _difference(table, point, k, step, name)
                found = getattr(gradient, name)[row, k]
                assert found == pytest.approx(expected, rel=1e-5, abs=1e-5 * scale[k])


def test_polar_derivatives(invented: LoadTable) -> None:
    omega, speed, beta = random_points(invented, 40, seed=1)
    beta_sign = np.where(np.arange(40) % 2, 1.0, -1.0)
    speed, omega = 0.1 + 0.9 * speed, 210.0 + 0.95 * (omega - 200.0)
    points = np.stack([omega, speed, np.clip(beta, 0.01, 3.1) * beta_sign], -1)
    _check(invented, points, invented.gradient(*points.T), (1e-3, 1e-5, 1e-5))


def test_derivatives_with_the_velocity(invented: LoadTable) -> None:
    rng = np.random.default_rng(2)
    velocity, omega = rng.uniform(-1.0, 1.0, (40, 3)), rng.uniform(300.0, 900.0, 40)
    points = np.concatenate([omega[:, None], velocity], axis=1)
    gradient = invented.gradient_at_velocity(omega, velocity)
    _check(invented, points, gradient, (1e-3, 1e-5, 1e-5, 1e-5))


@pytest.mark.parametrize("axial", [-1.0, 0.0, 1e-9])
@pytest.mark.parametrize("inplane", [0.0, 1e-9])
def test_derivatives_are_finite_and_right_without_motion_across(
    invented: LoadTable, axial: float, inplane: float
) -> None:
    omega, radius = 500.0, invented.content.radius
    gradient = invented.gradient_at_velocity(omega, [inplane, 0.0, axial])
    assert all(np.isfinite(field).all() for field in gradient)
    # What the invented coefficients are made from, by hand; with Omega^(-1/2) between the ends.
    share = (omega**-0.5 - 200.0**-0.5) / (1000.0**-0.5 - 200.0**-0.5)
    force = 1.2 * np.pi * radius**4 * omega**2 / (omega * radius)
    j = axial / (omega * radius)
    growth = 1.0 + 0.01 * share
    expected = force * growth * (-0.08 + 0.04 * j)
    assert gradient.thrust[3] == pytest.approx(expected, rel=2e-3)
    assert gradient.thrust[1:3] == pytest.approx([0.0, 0.0], abs=1e-3 * force * 0.08)
    assert gradient.drag[1] == pytest.approx(force * 0.006 * (1.0 + j), rel=2e-3)
    assert gradient.drag[2] == pytest.approx(0.0, abs=1e-12)
