"""What a rotor takes as names of derivatives, and the shapes of its answer.

That the derivatives are right is held by ``test_gradients_by_differences.py``.
"""

from __future__ import annotations

import numpy as np
import pytest

import propmap as pm
from propmap.loads import LOADS
from propmap.rotor import Rotor

BLADE, LAW = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")


def rotor(*texts: str) -> Rotor:
    corrections = tuple(pm.correction(text) for text in texts)
    return Rotor(pm.Model(BLADE, LAW, corrections=corrections))


def test_names_are_those_of_section_blade_mount_and_flow() -> None:
    names = rotor().parameters
    assert {"c_l1", "reynolds_camber", "drag_angle", "chord_scale", "untwist", "v_axial"} <= {
        *names
    }
    assert "mount_area" not in names
    assert {*rotor("installed").parameters} - {*names} == {"drag_factor", "mount_area"}


def test_other_names_and_flows_are_refused() -> None:
    with pytest.raises(pm.InputError, match=r"with respect to 'beta'.*names from c_l1"):
        rotor().gradients(["beta"], 600.0, 3.0, 4.0)
    with pytest.raises(pm.InputError, match="with respect to 'mount_area'"):
        rotor().gradients(["mount_area"], 600.0, 3.0, 4.0)
    with pytest.raises(pm.InputError, match="v_inplane is negative"):
        rotor().gradients(["c_l1"], 600.0, 3.0, -4.0)
    with pytest.raises(pm.InputError, match="omega contains a value that is not finite"):
        rotor().gradients(["c_l1"], np.nan, 3.0, 4.0)


def test_loads_and_derivatives_have_the_shape_of_the_flow() -> None:
    names, along, across = ("c_l1", "untwist"), np.array([[0.0], [3.0]]), np.array([0.0, 4.0, 8.0])
    found = rotor().gradients(names, 600.0, along, across)
    assert found.loads.shape == (len(LOADS), 2, 3)
    assert found.slopes.shape == (len(LOADS), 2, 2, 3)
    loads = rotor().loads_at_velocity(600.0, [8.0, 0.0, 3.0])
    assert found.loads[0, 1, 2] == pytest.approx(float(loads.thrust), rel=1e-12)
    assert found.slopes[0, 0, 1, 2] > 0.0 > found.slopes[0, 1, 1, 2]
