"""Loads with an inflow that varies around the disk."""

from __future__ import annotations

from typing import NamedTuple

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


class Harmonics(NamedTuple):
    """What a model adds to the annuli's inflow, and the flow that carries the wake away [m/s]."""

    mean: float
    lateral: float
    longitudinal: float
    annuli: float
    chi: float  # [rad]
    mass_flow: float


def harmonics(name: str, speed: float, beta: float) -> tuple[Harmonics, pm.Loads]:
    """Read off the inflow around the disk, which varies as y/R times sin(psi) and cos(psi)."""
    one, y = rotor(name), np.linspace(BLADE.root, BLADE.radius, 41)
    psi, share = np.arange(8) * np.pi / 4.0, y / BLADE.radius
    field = one.inflow(OMEGA, speed, beta, radius=y, azimuth=psi)
    loads = one.loads(OMEGA, speed, beta)
    lateral = 2.0 * (field.local_inflow * np.sin(psi)).mean(axis=1) / share
    longitudinal = 2.0 * (field.local_inflow * np.cos(psi)).mean(axis=1) / share
    np.testing.assert_allclose(lateral, lateral[0], atol=1e-9)
    np.testing.assert_allclose(longitudinal, longitudinal[0], atol=1e-9)
    added = field.inflow - rotor(None).inflow(OMEGA, speed, beta, radius=y).inflow
    annuli, across = float(loads.mean_inflow), speed * np.sin(beta)
    through = speed * np.cos(beta) + annuli
    at_disk = np.hypot(across, through)
    flow = (annuli, np.arctan2(across, abs(through)), at_disk + annuli * through / at_disk)
    means = (float(np.median(added)), float(lateral[0]), float(longitudinal[0]))
    return Harmonics(*means, *flow), loads


@pytest.mark.parametrize("k", range(3))
def test_the_harmonics_belong_to_the_loads(k: int) -> None:
    """The equations of Pitt and Peters hold at what was found, feedback included."""
    speed, beta = float(OBLIQUE[1][k]), float(OBLIQUE[2][k])
    found, loads = harmonics("pitt-peters", speed, beta)
    gain = 1.0 / (pm.Air().density * np.pi * BLADE.radius**2 * found.mass_flow)
    cosine, plain = np.cos(found.chi), rotor(None).loads(OMEGA, speed, beta)
    lateral = 4.0 / (1.0 + cosine) * gain * float(loads.roll_moment) / BLADE.radius
    rear = -gain * float(loads.pitch_moment) / BLADE.radius
    longitudinal = 15.0 * np.pi / 64.0 * np.tan(0.5 * found.chi) * gain * float(loads.thrust)
    longitudinal += 4.0 * cosine / (1.0 + cosine) * rear
    assert found.lateral == pytest.approx(lateral, rel=1e-6)
    assert found.longitudinal == pytest.approx(longitudinal, rel=1e-6)
    mean = 0.5 * gain * float(loads.thrust - plain.thrust)
    assert found.mean == pytest.approx(mean, rel=0.02, abs=1e-3 * found.annuli)


GRADIENTS = {
    "pitt-peters-gradient": lambda chi: 15.0 * np.pi / 32.0 * np.tan(0.5 * chi),
    "coleman": lambda chi: np.tan(0.5 * chi),
    "white-blake": lambda chi: np.sqrt(2.0) * np.sin(chi),
}


@pytest.mark.parametrize("name", GRADIENTS)
@pytest.mark.parametrize("k", [0, 1])
def test_gradients_without_feedback_are_those_printed(name: str, k: int) -> None:
    """A share of the mean inflow that the wake's skew chi sets, towards the rear alone."""
    found, _ = harmonics(name, float(OBLIQUE[1][k]), float(OBLIQUE[2][k]))
    expected = GRADIENTS[name](found.chi) * found.annuli
    assert found.longitudinal == pytest.approx(expected, rel=1e-6)
    assert found.lateral == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("k", range(3))
def test_drees_at_an_advance_ratio(k: int) -> None:
    """4/3 (1 - cos chi - 1.8 mu^2) / sin chi and -2 mu."""
    speed, beta = float(OBLIQUE[1][k]), float(OBLIQUE[2][k])
    found, _ = harmonics("drees", speed, beta)
    mu = speed * np.sin(beta) / (OMEGA * BLADE.radius)
    factor = 4.0 / 3.0 * (1.0 - np.cos(found.chi) - 1.8 * mu**2) / np.sin(found.chi)
    assert found.longitudinal == pytest.approx(factor * found.annuli, rel=1e-6)
    assert found.lateral == pytest.approx(-2.0 * mu * found.annuli, rel=1e-6)


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
    assert loads.pitch_moment > 0.0
