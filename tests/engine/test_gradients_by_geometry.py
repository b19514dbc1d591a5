"""Derivatives by a common change of the chord and a common offset of the twist."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap as pm
from propmap.engine.accuracy import accuracy
from propmap.engine.evaluation import prepare
from propmap.engine.gradients import LoadGradients, load_gradients
from propmap.engine.rotor_arrays import rotor_arrays
from propmap.solve.load_slopes import GEOMETRY

BLADE = pm.propeller("apc-8x6e")
LAW = pm.Airfoil(
    *(5.0, 1.6, 1.7, 0.38),
    zero_lift_angle=-0.05,
    c_d0=0.02,
    reynolds_camber=-0.02,
    drag_angle=0.03,
)
OMEGA = np.array([300.0, 600.0, 500.0, 600.0, 500.0])
AXIAL, INPLANE = np.array([0.0, 9.0, 5.0, -2.0, 3.0]), np.array([0.0, 0.0, 8.0, 4.0, 1.0])
"""At rest, axial, oblique, descent, and slow oblique climb, where stall is followed."""

MODELS = {
    "paper": (),
    "around the disk": ("pitt-peters", "radial-friction", "prandtl-glauert"),
    "stall delay": ("pitt-peters", "stall-delay"),
}


def at(
    corrections: tuple[str, ...],
    names: tuple[str, ...] = GEOMETRY,
    scale: float = 0.0,
    offset: float = 0.0,
) -> LoadGradients:
    """For the blade with its measured stations changed by ``scale`` and ``offset``."""
    blade = replace(BLADE, chord=BLADE.chord * (1.0 + scale), twist=BLADE.twist + offset)
    given = tuple(pm.correction(text) for text in corrections)
    arrays = rotor_arrays(pm.Model(blade, LAW, corrections=given))
    return load_gradients(prepare(arrays), accuracy("standard"), names, OMEGA, AXIAL, INPLANE)


@pytest.mark.parametrize("model", [pytest.param(m, marks=pytest.mark.slow) for m in MODELS])
def test_derivatives_are_central_differences(model: str) -> None:
    """Of blades whose measured stations are changed, made anew."""
    corrections = MODELS[model]
    found = at(corrections)
    # In descent the loads with stall delay have a kink nearby, by any parameter.
    smooth = AXIAL >= 0.0 if model == "stall delay" else np.full(AXIAL.size, True)
    steps = {"scale": 1e-5, "offset": 1e-5}
    for row, (changed, step) in enumerate(steps.items()):
        up, down = (at(corrections, (), **{changed: h}).loads for h in (step, -step))
        difference = (up - down) / (2.0 * step)
        size = np.abs(difference).max(axis=1, keepdims=True) + 1e-12
        error = (found.slopes[:, row] - difference) / size
        assert np.abs(error[:, smooth]).max() < 5e-4, changed


@pytest.mark.slow
def test_loads_and_other_derivatives_are_the_same_beside_them() -> None:
    names = ("c_l1", "omega")
    alone, beside = at((), names), at((), (*names, *GEOMETRY))
    np.testing.assert_array_equal(alone.loads, beside.loads)
    size = np.abs(alone.slopes).max(axis=2, keepdims=True) + 1e-12
    np.testing.assert_allclose(beside.slopes[:, :2] / size, alone.slopes / size, atol=1e-12)


@pytest.mark.slow
def test_more_chord_and_more_pitch_give_more_thrust_and_torque() -> None:
    """At rest; thrust grows less than the chord, as there is more inflow with it."""
    found = at(())
    thrust, torque = found.loads[0, 0], found.loads[2, 0]
    by_chord, by_twist = found.slopes[:, 0, 0], found.slopes[:, 1, 0]
    assert 0.0 < by_chord[0] < thrust
    assert 0.0 < by_chord[2] < 1.5 * torque
    assert by_twist[0] > 0.0 and by_twist[2] > 0.0
