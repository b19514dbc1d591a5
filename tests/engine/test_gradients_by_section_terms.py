"""Derivatives by the two terms of the section law that the paper does not have."""

from __future__ import annotations

import numpy as np
import pytest

import propmap as pm
from propmap.engine.accuracy import accuracy
from propmap.engine.evaluation import prepare
from propmap.engine.gradients import LoadGradients, load_gradients
from propmap.engine.rotor_arrays import rotor_arrays

BLADE = pm.propeller("apc-8x6e")
NAMES = ("reynolds_camber", "drag_angle", "zero_lift_angle", "omega")
STEPS = (1e-5, 1e-5, 1e-5, 1e-2)
LAW = pm.Airfoil(
    *(5.0, 1.6, 1.7, 0.38),
    zero_lift_angle=-0.05,
    c_d0=0.02,
    reynolds_camber=-0.02,
    drag_angle=0.07,
)
OMEGA = np.array([300.0, 600.0, 500.0, 600.0])
AXIAL, INPLANE = np.array([0.0, 9.0, 5.0, -2.0]), np.array([0.0, 0.0, 8.0, 4.0])
"""At rest, axial, oblique, descent."""


def at(law: pm.Airfoil, omega: np.ndarray = OMEGA) -> LoadGradients:
    arrays = rotor_arrays(pm.Model(BLADE, law))
    return load_gradients(prepare(arrays), accuracy("standard"), NAMES, omega, AXIAL, INPLANE)


@pytest.mark.slow
@pytest.mark.parametrize("law", [LAW, LAW.with_parameters(reynolds_camber=0.0, drag_angle=0.0)])
def test_derivatives_are_central_differences(law: pm.Airfoil) -> None:
    """Also where the terms are zero, and so left out of the law's own programs."""
    found = at(law)
    for row, (name, step) in enumerate(zip(NAMES, STEPS, strict=True)):
        ends = []
        for h in (step, -step):
            moved = (
                law if name == "omega" else law.with_parameters(**{name: getattr(law, name) + h})
            )
            ends.append(at(moved, OMEGA + h if name == "omega" else OMEGA).loads)
        difference = (ends[0] - ends[1]) / (2.0 * step)
        size = np.abs(difference).max(axis=1, keepdims=True) + 1e-12
        np.testing.assert_allclose(
            found.slopes[:, row] / size, difference / size, atol=5e-4, err_msg=name
        )
