"""The velocity of a skewed vortex cylinder against closed forms and direct Biot-Savart sums."""

from __future__ import annotations

import numpy as np
import pytest

from propmap.vehicle.wakes import axial_velocity

DOWN = np.array([0.0, 0.0, -1.0])


def skewed(chi: float, bearing: float = 0.0) -> np.ndarray:
    """Wake direction ``chi`` [rad] from straight down, towards ``bearing`` in the disk plane."""
    side = np.array([np.cos(bearing), np.sin(bearing), 0.0])
    return np.sin(chi) * side + np.cos(chi) * DOWN


def biot_savart(place: np.ndarray, direction: np.ndarray) -> float:
    """Straight from the law: rings of 360 pieces, stretched spacing along the wake."""
    psi = 2.0 * np.pi * (np.arange(360) + 0.5) / 360
    radial = np.stack([np.cos(psi), np.sin(psi), 0.0 * psi], axis=1)
    # Rings of a rotor that pushes the air down turn clockwise as seen from above.
    tangent = np.stack([np.sin(psi), -np.cos(psi), 0.0 * psi], axis=1)
    share = (np.arange(1000) + 0.5) / 1000
    along, step = 300.0 * share**3, 900.0 * share**2 / 1000
    total = 0.0
    for s, ds in zip(along, step, strict=True):
        off = place - radial - s * direction
        pull = np.cross(tangent, off) / np.linalg.norm(off, axis=1, keepdims=True) ** 3
        total -= ds * float(pull[:, 2].mean()) / 2.0
    return total


def test_on_the_axis_in_axial_flow() -> None:
    """A semi-infinite solenoid: half of 1 - z/sqrt(1 + z^2)."""
    z = np.array([4.0, 1.0, 0.0, -0.5, -40.0])
    found = axial_velocity(z[:, None] * [0.0, 0.0, 1.0], np.tile(DOWN, (5, 1)), core=0.0)
    np.testing.assert_allclose(found, 0.5 * (1.0 - z / np.hypot(1.0, z)), atol=1e-12)


def test_half_the_far_velocity_at_the_center_for_every_skew() -> None:
    wakes = np.stack([skewed(chi, 0.7) for chi in (0.0, 0.6, 1.2, 1.5)])
    found = axial_velocity(np.zeros((4, 3)), wakes, core=0.0, azimuths=512)
    np.testing.assert_allclose(found, 0.5, atol=1e-6)


@pytest.mark.parametrize(
    ("place", "chi", "bearing"),
    [((2.1, 0.4, 0.2), 1.0, 0.0), ((-2.3, 0.0, 0.0), 1.3, 0.0), ((0.3, 0.2, 0.5), 0.8, -1.9)],
)
def test_against_a_sum_over_pieces_of_vortex(
    place: tuple[float, ...], chi: float, bearing: float
) -> None:
    where, direction = np.array(place), skewed(chi, bearing)
    exact = biot_savart(where, direction)
    assert axial_velocity(where, direction, core=0.0, azimuths=256) == pytest.approx(
        exact, abs=2e-4
    )
    # As it is used: with a core, and fewer azimuths.
    assert axial_velocity(where, direction) == pytest.approx(exact, abs=0.02)
