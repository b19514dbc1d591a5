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
    """Straight from the law: rings of 720 pieces, stretched spacing along the wake."""
    psi = 2.0 * np.pi * (np.arange(720) + 0.5) / 720
    radial = np.stack([np.cos(psi), np.sin(psi), 0.0 * psi], axis=1)
    # Rings of a rotor that pushes the air down turn clockwise as seen from above.
    tangent = np.stack([np.sin(psi), -np.cos(psi), 0.0 * psi], axis=1)
    share = (np.arange(4000) + 0.5) / 4000
    along, step = 300.0 * share**3, 900.0 * share**2 / 4000
    total = 0.0
    for s, ds in zip(along, step, strict=True):
        off = place - radial - s * direction
        pull = np.cross(tangent, off) / np.linalg.norm(off, axis=1, keepdims=True) ** 3
        total -= ds * float(pull[:, 2].mean()) / 2.0
    return total


@pytest.mark.parametrize("z", [4.0, 1.0, 0.0, -0.5, -3.0, -40.0])
def test_on_the_axis_in_axial_flow(z: float) -> None:
    """A semi-infinite solenoid: half of 1 - z/sqrt(1 + z^2)."""
    found = axial_velocity(np.array([0.0, 0.0, z]), DOWN, core=0.0)
    assert found == pytest.approx(0.5 * (1.0 - z / np.hypot(1.0, z)), abs=1e-12)


@pytest.mark.parametrize("chi", [0.0, 0.6, 1.2, 1.5])
def test_half_the_far_velocity_at_the_center_for_every_skew(chi: float) -> None:
    found = axial_velocity(np.zeros(3), skewed(chi, 0.7), core=0.0, azimuths=512)
    assert found == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize(
    ("place", "chi"),
    [
        ((2.1, 0.4, 0.2), 1.0),
        ((-2.3, 0.0, 0.0), 1.3),
        ((0.2, -3.0, -0.4), 0.4),
        ((0.3, 0.2, 0.5), 0.8),
    ],
)
def test_against_a_sum_over_pieces_of_vortex(place: tuple[float, ...], chi: float) -> None:
    where, direction = np.array(place), skewed(chi)
    exact = biot_savart(where, direction)
    assert axial_velocity(where, direction, core=0.0, azimuths=256) == pytest.approx(
        exact, abs=2e-4
    )
    # As it is used: with a core, and fewer azimuths.
    assert axial_velocity(where, direction) == pytest.approx(exact, abs=0.02)


def test_mirror_symmetry_and_turning_about_the_axis() -> None:
    rng = np.random.default_rng(0)
    place, chi = rng.normal(0.0, 2.0, (50, 3)), rng.uniform(0.1, 1.4, 50)
    wake = np.stack([skewed(c) for c in chi])
    mirror = np.array([1.0, -1.0, 1.0])
    here = axial_velocity(place, wake, azimuths=64)
    np.testing.assert_allclose(here, axial_velocity(mirror * place, wake, azimuths=64), rtol=1e-12)
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    turned = axial_velocity(place @ quarter.T, wake @ quarter.T, azimuths=64)
    np.testing.assert_allclose(here, turned, rtol=1e-12)


def test_nothing_far_away_and_upwash_ahead_and_beside() -> None:
    wake = skewed(1.2)
    far = axial_velocity(np.array([[-60.0, 0.0, 0.0], [0.0, 60.0, 0.0], [0.0, 0.0, 60.0]]), wake)
    np.testing.assert_allclose(far, 0.0, atol=1e-3)
    ahead, beside, behind = axial_velocity(
        np.array([[-2.2, 0.0, 0.0], [0.0, 2.2, 0.0], [2.2, 0.0, 0.0]]), wake
    )
    assert ahead < -0.005 and beside < -0.005 and behind > 0.2


def test_smooth_where_the_wake_s_surface_sweeps_over_a_place() -> None:
    place = np.array([2.5, 0.0, 0.0])
    chi = np.linspace(1.2, 1.7, 401)
    found = axial_velocity(place[None], np.stack([skewed(c) for c in chi]))
    assert np.isfinite(found).all()
    assert np.max(np.abs(np.diff(found))) < 0.05
