"""Loads go over into those of axial flow without a gap as the in-plane velocity vanishes."""

from __future__ import annotations

import numpy as np
import pytest

import propmap as pm

INPLANE = np.concatenate([[0.0], np.logspace(-300.0, 0.0, 61), np.logspace(-12.0, -2.0, 31)])
CLIMB = (-8.0, -3.0, -0.3, 0.0, 0.3, 2.0)
MODELS = {
    "paper": lambda: pm.Model(pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")),
    "recommended": lambda: pm.catalogue_model("APC 8x6E"),
    "another": lambda: pm.catalogue_model("uiuc-gwsdd-5x4.3-c"),
    "finite blades": lambda: pm.Model(
        pm.propeller("apc-8x6e"),
        pm.airfoil("paper-apc"),
        corrections=(pm.correction("tip-loss"), pm.correction("hub-loss")),
    ),
}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.slow] * (n == "finite blades")) for n in MODELS]
)
def test_no_in_plane_velocity_is_too_small(name: str) -> None:
    rotor = pm.Rotor(MODELS[name]())
    still = rotor.loads(600.0, 0.0, 0.0)
    for climb in CLIMB:
        loads = rotor.loads(600.0, np.hypot(climb, INPLANE), np.arctan2(INPLANE, climb))
        assert (loads.status != "not_converged").all()
        close = INPLANE < 1e-9
        for load, scale in ((loads.thrust, still.thrust), (loads.torque, still.torque)):
            assert np.isfinite(load).all()
            np.testing.assert_allclose(load[close], load[0], atol=1e-9 * float(scale))
        np.testing.assert_allclose(loads.drag[close], 0.0, atol=1e-9 * float(still.thrust))


def test_the_wrench_in_a_nearly_axial_wind_is_that_of_axial_flow() -> None:
    rotor = pm.Rotor(MODELS["recommended"]())
    for climb in (0.3, 0.0, -3.0):
        wrench = rotor.wrench(600.0, [1e-9, 0.0, climb])
        axial = rotor.wrench(600.0, [0.0, 0.0, climb])
        np.testing.assert_allclose(wrench.force, axial.force, atol=1e-8)
        np.testing.assert_allclose(wrench.moment, axial.moment, atol=1e-8)
