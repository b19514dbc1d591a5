"""Thrust of attached blades, against the loads of the full theory and against differences."""

from __future__ import annotations

import numpy as np
import pytest

import propmap

MODEL = propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"))


def flows(points: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(7)
    omega = rng.uniform(400.0, 900.0, points)
    return omega, rng.uniform(2.0, 8.0, points), rng.uniform(0.0, 10.0, points)


def test_near_the_loads_of_the_full_theory_in_climb() -> None:
    omega, axial, inplane = flows(40)
    # Nothing stalls from a climb of 2 m/s on: what differs are drag, small angles and azimuth.
    velocity = np.stack([inplane, 0.0 * omega, axial], axis=-1)
    exact = propmap.Rotor(MODEL).loads_at_velocity(omega, velocity).thrust
    found, none = propmap.Rotor(MODEL).attached_thrust(omega, axial, inplane)
    assert none.shape == (0, 40)
    assert np.sqrt(np.mean((found - exact) ** 2)) < 0.05 * np.sqrt(np.mean(exact**2))


@pytest.mark.parametrize("name", ["c_l1", "zero_lift_angle", "reynolds_camber", "reynolds_lift"])
def test_differences_of_other_constants(name: str) -> None:
    law = MODEL.airfoil
    assert isinstance(law, propmap.Airfoil)
    step = 1e-5

    def moved(by: float) -> propmap.Model:
        return MODEL.with_airfoil(law.with_parameters(**{name: getattr(law, name) + by}))

    points = flows(30)
    _, more = propmap.Rotor(MODEL).attached_thrust(*points, [moved(step)])
    up, down = (propmap.Rotor(moved(by)).attached_thrust(*points)[0] for by in (step, -step))
    np.testing.assert_allclose(more[0], 0.5 * (up - down), rtol=1e-3, atol=1e-9)
    assert np.any(np.abs(more) > 0.0)


def test_it_is_continuous_into_descent_and_positive() -> None:
    axial = np.linspace(5.0, -15.0, 400)
    still = np.zeros(400)
    for inplane in (0.0, 6.0):
        found, _ = propmap.Rotor(MODEL).attached_thrust(still + 600.0, axial, still + inplane)
        assert np.isfinite(found).all() and np.all(found > 0.0)
        assert np.max(np.abs(np.diff(found))) < 0.1 * np.max(found)
