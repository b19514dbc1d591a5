"""Derivatives in the vortex ring and on the windmill branch, against central differences."""

from __future__ import annotations

import numpy as np
import pytest

import propmap
from propmap.engine.accuracy import accuracy
from propmap.engine.evaluation import prepare
from propmap.engine.gradients import LoadGradients, load_gradients

STEPS = {"omega": 3e-2, "v_axial": 1e-3, "v_inplane": 1e-3, "c_l1": 1e-4, "alpha_0": 1e-6}
NAMES = tuple(STEPS)
BLADE, LAW = propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")

# Speed [m/s] and beta [rad] at 600 rad/s: four points in the vortex ring, three on the windmill
# branch.
SPEED = np.array([3.0, 3.0, 3.0, 4.5, 14.0, 16.0, 20.0])
BETA = np.array([2.5, 2.9, 3.0, 2.8, 2.9, 3.0, 3.05])
FLOW = {
    "omega": np.full(SPEED.size, 600.0),
    "v_axial": SPEED * np.cos(BETA),
    "v_inplane": SPEED * np.sin(BETA),
}


def at(names: tuple[str, ...], **change: float) -> LoadGradients:
    """At all points, where what is named has changed."""
    constants = {name: getattr(LAW, name) + by for name, by in change.items() if name not in FLOW}
    law = LAW.with_parameters(**constants) if constants else LAW
    flow = (values + change.get(name, 0.0) for name, values in FLOW.items())
    rotor = prepare(propmap.Model(BLADE, law).arrays())
    return load_gradients(rotor, accuracy("standard"), names, *flow)


@pytest.fixture(scope="module")
def found() -> LoadGradients:
    return at(NAMES)


def test_the_points_are_in_the_states_that_they_stand_for() -> None:
    loads = propmap.Rotor(propmap.Model(BLADE, LAW), compiled=False).loads(600.0, SPEED, BETA)
    assert (loads.vortex_ring[:4] > 0.1).all()
    assert (loads.status[4:] == "windmill").all()


@pytest.mark.parametrize("name", NAMES)
def test_derivatives_are_central_differences_of_the_loads(found: LoadGradients, name: str) -> None:
    """0.6 % of the largest derivative of each load at any of the points: loads have small kinks."""
    step = STEPS[name]
    up, down = (at((), **{name: by}).loads for by in (step, -step))
    difference = (up - down) / (2.0 * step)
    size = np.max(np.abs(difference), axis=1, keepdims=True) + 1e-12
    slopes = found.slopes[:, NAMES.index(name)]
    np.testing.assert_allclose(slopes / size, difference / size, atol=6e-3)


def test_the_inflow_in_hover_does_not_depend_on_the_flow_it_is_used_in(
    found: LoadGradients,
) -> None:
    """The case in which it was once taken to: 30 % of the derivative by V cos(beta)."""
    thrust = found.slopes[0, NAMES.index("v_axial"), :3]
    np.testing.assert_allclose(thrust, [-0.0453, -0.0364, -0.0355], atol=1e-4)
