"""Loads with an inflow that varies around the disk."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import propmap as pm
from propmap.loads import LOADS

BLADE = pm.propeller("apc-8x6e")
NAMES = ("pitt-peters", "pitt-peters-gradient", "coleman", "drees", "white-blake")
OMEGA = 600.0
OBLIQUE = (OMEGA, np.array([4.0, 9.0, 14.0]), np.radians([80.0, 60.0, 85.0]))


def rotor(name: str | None) -> pm.Rotor:
    corrections = (pm.correction(name),) if name else ()
    return pm.Rotor(pm.Model(BLADE, pm.airfoil("paper-apc"), corrections=corrections))


@pytest.mark.parametrize("name", NAMES)
def test_axial_flow_is_that_of_the_paper(name: str) -> None:
    """Climb, rest, vortex ring and windmill."""
    points = (
        600.0,
        np.array([8.0, 0.0, 4.0, 6.0, 14.0]),
        np.array([0.0, 0.0, np.pi, np.pi, np.pi]),
    )
    want, got = rotor(None).loads(*points), rotor(name).loads(*points)
    for load in LOADS:
        np.testing.assert_allclose(getattr(got, load), getattr(want, load), atol=1e-12)
    assert (want.status == got.status).all()
    stopped = rotor(name).loads(0.0, [0.0, 9.0, 9.0], [0.0, 0.0, 1.2])
    assert all(np.isfinite(getattr(stopped, load)).all() for load in LOADS)
    assert float(stopped.thrust[0]) == 0.0


GRADIENTS: dict[str, Callable[[float, float], float]] = {
    "pitt-peters-gradient": lambda chi, _: 15.0 * np.pi / 32.0 * np.tan(0.5 * chi),
    "coleman": lambda chi, _: np.tan(0.5 * chi),
    "white-blake": lambda chi, _: np.sqrt(2.0) * np.sin(chi),
    "drees": lambda chi, mu: 4.0 / 3.0 * (1.0 - np.cos(chi) - 1.8 * mu**2) / np.sin(chi),
}
"""Share of the mean inflow at the wake's skew chi [rad] and the advance ratio mu."""


@pytest.mark.parametrize("name", GRADIENTS)
@pytest.mark.parametrize("k", [0, 1])
def test_gradients_without_feedback_are_those_printed(name: str, k: int) -> None:
    """Towards the rear alone but for Drees, by the inflow around the disk."""
    one, y = rotor(name), np.linspace(BLADE.root, BLADE.radius, 41)
    speed, beta = float(OBLIQUE[1][k]), float(OBLIQUE[2][k])
    psi, share = np.arange(8) * np.pi / 4.0, y / BLADE.radius
    local = one.inflow(OMEGA, speed, beta, radius=y, azimuth=psi).local_inflow
    mean, across = float(one.loads(OMEGA, speed, beta).mean_inflow), speed * np.sin(beta)
    chi, mu = np.arctan2(across, speed * np.cos(beta) + mean), across / (OMEGA * BLADE.radius)
    longitudinal = 2.0 * (local * np.cos(psi)).mean(axis=1) / share
    lateral = 2.0 * (local * np.sin(psi)).mean(axis=1) / share
    np.testing.assert_allclose(longitudinal, GRADIENTS[name](chi, mu) * mean, rtol=1e-6)
    expected = -2.0 * mu * mean if name == "drees" else 0.0
    np.testing.assert_allclose(lateral, expected, rtol=1e-6, atol=1e-9)


def test_two_shapes_are_refused() -> None:
    two = (pm.correction("pitt-peters"), pm.correction("coleman"))
    with pytest.raises(pm.InputError, match="pitt-peters and coleman both define"):
        pm.Model(pm.propeller("apc-8x6e"), pm.airfoil("paper-apc"), corrections=two)


@pytest.mark.parametrize("beta", [np.pi / 2, 0.0, np.radians(110.0)])
def test_loads_are_continuous(beta: float) -> None:
    """Through edgewise and axial flow, and where the vortex ring fades in."""
    angle = beta + 1e-4 * np.arange(-3.0, 4.0)
    found = rotor("pitt-peters").loads(600.0, 6.0, angle)
    for load in LOADS:
        values = getattr(found, load)
        steps = np.abs(np.diff(values))
        assert steps.max() < 3e-4 * np.abs(found.thrust).max(), load


def test_the_wrench_has_all_six_loads() -> None:
    one, omega = rotor("pitt-peters"), 600.0
    loads, wrench = one.loads(omega, 10.0, np.pi / 2), one.wrench(omega, [10.0, 0.0, 0.0])
    np.testing.assert_allclose(wrench.force, [-loads.drag, loads.side_force, loads.thrust])
    # Nose up is about -y where x points forward and z up.
    turning = [-loads.roll_moment, -loads.pitch_moment, -loads.torque]
    np.testing.assert_allclose(wrench.moment, turning)
    assert all(getattr(loads, load) > 0.0 for load in LOADS if load != "side_force")
