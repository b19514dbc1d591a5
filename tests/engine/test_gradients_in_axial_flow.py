"""In axial flow there is no rotor drag, but it grows with the in-plane velocity from there."""

from __future__ import annotations

import numpy as np
import pytest

import propmap
from propmap.engine.accuracy import accuracy
from propmap.engine.evaluation import FEW, prepare
from propmap.engine.gradients import LoadGradients, load_gradients
from propmap.engine.rotor_arrays import rotor_arrays
from propmap.loads import LOADS

NAMES = ("v_inplane", "mount_area", "v_axial")
SETTING = accuracy("standard")
STEP = 1e-3
AREA = 0.0014


def found(v_inplane: float, count: int, *more: str) -> LoadGradients:
    """At ``count`` points, hovering and climbing in turn."""
    corrections = tuple(map(propmap.correction, (f"mount-drag:area_m2={AREA}", *more)))
    model = propmap.Model(
        propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"), corrections=corrections
    )
    v_axial = np.resize([5.0, 0.0], count)
    flow = (np.full(count, 600.0), v_axial, np.full(count, v_inplane))
    return load_gradients(prepare(rotor_arrays(model)), SETTING, NAMES, *flow)


@pytest.mark.parametrize(
    ("count", "more"),
    [
        (8, ()),
        pytest.param(8, ("pitt-peters",), marks=pytest.mark.slow),
        pytest.param(FEW, (), marks=pytest.mark.slow),
        pytest.param(FEW, ("pitt-peters",), marks=pytest.mark.slow),
    ],
)
def test_loads_leave_axial_flow_as_their_derivatives_say(count: int, more: tuple[str, ...]) -> None:
    """For few points and for many, for which programs with a single azimuth find the loads."""
    axial, beside = found(0.0, count, *more), found(STEP, count, *more)
    inplane = [k for k, load in enumerate(LOADS.values()) if load.inplane]
    np.testing.assert_allclose(axial.loads[inplane], 0.0, atol=1e-12)
    slope = axial.slopes[:, NAMES.index("v_inplane")]
    difference = (beside.loads - axial.loads)[inplane] / STEP
    assert (np.abs(difference[0]) > 1e-2).all()
    np.testing.assert_allclose(slope[inplane], difference, rtol=1e-3, atol=1e-7)
    # Thrust and torque do not tell one side from the other.
    np.testing.assert_allclose(np.delete(slope, inplane, axis=0), 0.0, atol=1e-9)


def test_the_mount_s_area_acts_on_the_drag_alone() -> None:
    beside = found(STEP, 8)
    drag = list(LOADS).index("drag")
    slope = beside.slopes[:, NAMES.index("mount_area")]
    np.testing.assert_array_equal(np.delete(slope, drag, axis=0), 0.0)
    axial = found(0.0, 8)
    # The drag is the blades' and the area's, which acts in proportion to itself.
    np.testing.assert_array_equal(axial.slopes[drag, NAMES.index("mount_area")], 0.0)
    assert (slope[drag] > 0.0).all()
    assert (beside.loads[drag] > AREA * slope[drag]).all()
