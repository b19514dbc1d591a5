"""Drag of what is mounted in the slipstream: its equation, its limits, what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from propmap.arrays.namespace import by_numpy
from propmap.errors import InputError
from propmap.model.corrections import MountDrag, typical_area
from propmap.physics.mount_drag import Mounted

DENSITY = np.float64(1.2)


def drag(area: float, wake: float, *flow: Any) -> np.ndarray:
    """At v_axial, v_inplane and inflow [m/s]."""
    mounted = Mounted(np.float64(area), np.float64(wake))
    with by_numpy():
        return np.asarray(mounted.drag(DENSITY, *(np.atleast_1d(np.float64(v)) for v in flow)))


def test_the_drag_is_the_equation() -> None:
    # 1/2 1.2 0.002 4 sqrt(4^2 + (1 + 1.5 * 2/1.5)^2) with 4, 3 and 5.
    assert drag(0.002, 1.5, 1.0, 4.0, 4.0 / 3.0) == pytest.approx(0.5 * 1.2 * 0.002 * 4.0 * 5.0)


def test_the_correction_says_the_same_of_itself() -> None:
    flow = np.array([-3.0, 0.0, 2.0]), np.array([0.0, 5.0, 12.0]), np.array([4.0, 3.0, 1.0])
    for area in (0.002, None):
        mount = MountDrag(area, wake=1.5)
        told = mount.drag(0.1, float(DENSITY), *flow)
        np.testing.assert_allclose(told, drag(mount.area(0.1), 1.5, *flow), rtol=1e-12)


def test_edgewise_outside_the_slipstream_it_is_the_drag_of_a_plate() -> None:
    assert drag(0.002, 0.0, 0.0, 9.0, 5.0) == pytest.approx(0.5 * 1.2 * 0.002 * 81.0)


def test_it_is_the_inplane_part_of_a_drag_along_the_air_s_velocity() -> None:
    v_axial, v_inplane, inflow = 3.0, 7.0, 4.0
    air = np.array([v_inplane, v_axial + inflow])
    whole = 0.5 * DENSITY * 0.002 * np.linalg.norm(air) * air
    assert drag(0.002, 1.0, v_axial, v_inplane, inflow) == pytest.approx(whole[0])


def test_the_slipstream_makes_it_linear_in_slow_flight() -> None:
    slow, slower = drag(0.002, 1.0, 0.0, [0.02, 0.01], 6.0)
    assert slow / slower == pytest.approx(2.0, rel=1e-5)
    assert slower / 0.01 == pytest.approx(0.5 * 1.2 * 0.002 * 6.0, rel=1e-5)


def test_there_is_none_in_axial_flow_nor_without_a_mount() -> None:
    assert (drag(0.002, 1.0, [-9.0, -5.0, 0.0, 12.0], 0.0, 5.0) == 0.0).all()
    assert drag(0.0, 1.0, 3.0, 7.0, 4.0) == 0.0


def test_a_typical_motor_has_28_by_30_mm_below_8_inches() -> None:
    assert typical_area(0.1016) == pytest.approx(0.028 * 0.030)
    assert typical_area(0.2032) == pytest.approx(4.0 * typical_area(0.1016))


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"area_m2": -1e-4}, "area_m2 is -0.0001: give an area of 0 m"),
        ({"area_m2": math.nan}, "area_m2 is nan"),
        ({"area_m2": math.inf}, "area_m2 is inf"),
        ({"wake": 2.1}, "wake is 2.1: give a share of the inflow"),
        ({"wake": math.nan}, "wake is nan"),
    ],
)
def test_what_cannot_be_mounted(fields: dict[str, float], says: str) -> None:
    with pytest.raises(InputError, match=says):
        MountDrag(**fields)
