"""Friction along the yawed blade, against integrals of vectors and in its limits."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import propmap as pm
from propmap.loads import LOADS
from tests.oracle.points import SECTIONS
from tests.oracle.sampled import sampled

BLADE, APC = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")
FRICTION = (pm.correction("radial-friction"),)
OMEGA = 600.0
OBLIQUE = (OMEGA, np.array([4.0, 9.0, 14.0, 9.0]), np.radians([80.0, 60.0, 90.0, 100.0]))


def rotors(law: Any, *others: str, accuracy: str = "standard") -> tuple[pm.Rotor, pm.Rotor]:
    """Without and with friction along the blade."""
    model = pm.Model(BLADE, law, corrections=tuple(pm.correction(text) for text in others))
    more = dataclasses.replace(model, corrections=(*model.corrections, *FRICTION))
    plain, rough = (pm.Rotor(one, accuracy=accuracy) for one in (model, more))
    return plain, rough


def literal(law: pm.Airfoil, speed: float, beta: float) -> tuple[float, float]:
    """What friction adds to drag [N] and torque [N m]: vectors in space, summed over a full turn.

    x along the hub's in-plane velocity, z along the axis; a blade at psi points to
    (-cos(psi), sin(psi), 0) and moves towards (sin(psi), cos(psi), 0), psi being 0 at the rear.
    """
    y, weight = np.polynomial.legendre.leggauss(80)
    low, high = BLADE.root, BLADE.radius
    y, weight = 0.5 * (low + high) + 0.5 * (high - low) * y, 0.5 * (high - low) * weight
    chord = PchipInterpolator(BLADE.station, BLADE.chord)(y)
    v_i = pm.Rotor(pm.Model(BLADE, law)).inflow(OMEGA, speed, beta, radius=y).inflow
    air, psi = pm.Air(), 2.0 * np.pi * (np.arange(720) + 0.5) / 720
    along = np.stack([-np.cos(psi), np.sin(psi), 0.0 * psi], axis=-1)[:, None]
    ahead = np.stack([np.sin(psi), np.cos(psi), 0.0 * psi], axis=-1)[:, None]
    hub = speed * np.array([np.sin(beta), 0.0, np.cos(beta)])
    wind = -hub - OMEGA * y[:, None] * ahead - v_i[:, None] * [0.0, 0.0, 1.0]
    across = wind - (wind * along).sum(axis=-1, keepdims=True) * along

    def friction(velocity: np.ndarray) -> np.ndarray:
        size = np.linalg.norm(velocity, axis=-1)
        c_v = law.c_d0 + 2.04 * law.c_p / np.sqrt(air.density * size * chord / air.viscosity)
        return (0.5 * air.density * size * c_v * chord)[..., None] * velocity

    force = BLADE.blades * weight[:, None] * (friction(wind) - friction(across)) / psi.size
    return -float(force[..., 0].sum()), -float((y[:, None] * force * ahead).sum())


@pytest.mark.parametrize(("speed", "beta"), [(12.0, 45.0), (6.0, 100.0)])
def test_it_adds_what_vectors_in_space_give(speed: float, beta: float) -> None:
    plain, rough = (
        rotor.loads(OMEGA, speed, np.radians(beta)) for rotor in rotors(APC, accuracy="fine")
    )
    drag, torque = literal(APC, speed, np.radians(beta))
    assert float(rough.drag - plain.drag) == pytest.approx(drag, rel=1e-3)
    assert float(rough.torque - plain.torque) == pytest.approx(torque, rel=1e-3)
    assert drag > 0.0
    assert torque > 0.0


def test_slow_edgewise_flight_has_half_as_much_profile_drag_again() -> None:
    """With a constant C_D alone, U_T U sin(psi) gives Omega y V and the radial part half of it."""
    law = pm.Airfoil(0.0, 0.0, 0.0, 0.3, c_d0=0.02, c_p=0.0)
    plain, rough = (rotor.loads(OMEGA, 0.5, np.pi / 2) for rotor in rotors(law, accuracy="fine"))
    assert float(rough.drag / plain.drag) == pytest.approx(1.5, rel=1e-3)


def test_axial_flow_is_that_of_the_paper() -> None:
    points = (OMEGA, np.array([8.0, 0.0, 4.0, 14.0]), np.array([0.0, 0.0, np.pi, np.pi]))
    plain, rough = (rotor.loads(*points) for rotor in rotors(APC))
    for load in LOADS:
        np.testing.assert_array_equal(getattr(rough, load), getattr(plain, load))


def test_only_drag_and_torque_change() -> None:
    """By the annuli's mean inflow, with and without harmonics."""
    added = []
    for others in ((), ("pitt-peters",)):
        plain, rough = (rotor.loads(*OBLIQUE) for rotor in rotors(APC, *others))
        for load in ("thrust", "roll_moment", "pitch_moment", "side_force", "status"):
            np.testing.assert_array_equal(getattr(rough, load), getattr(plain, load))
        assert (rough.drag > 1.01 * plain.drag).all()
        assert (rough.torque > plain.torque).all()
        added.append(rough.drag - plain.drag)
    np.testing.assert_allclose(*added, rtol=1e-9)


def test_a_table_has_its_drag_at_zero_lift() -> None:
    """A table sampled from the paper's law rubs as that law does."""
    table = sampled(SECTIONS["apc"], 1.0, 5.0, np.geomspace(5e3, 4e5, 8))
    added = []
    for law in (APC, table):
        plain, rough = (rotor.loads(*OBLIQUE) for rotor in rotors(law))
        added.append(rough.drag - plain.drag)
    np.testing.assert_allclose(added[1], added[0], rtol=0.05)
