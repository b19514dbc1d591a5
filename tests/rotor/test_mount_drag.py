"""A rotor on a mount: what it adds, that it adds nothing else, derivatives."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import propmap
from propmap.engine.rotor_arrays import rotor_arrays
from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.model.corrections import typical_area
from propmap.solve.resolution import Resolution
from propmap.solve.rotor_loads import rotor_loads

BLADE, LAW = propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")
AREA, WAKE = 0.0014, 1.3
MOUNT = f"mount-drag:area_m2={AREA},wake={WAKE}"

OMEGA = 600.0
SPEED = np.array([0.0, 3.0, 9.0, 14.0, 8.0, 4.0, 15.0, 6.0])
BETA = np.radians([0.0, 0.0, 40.0, 90.0, 100.0, 170.0, 175.0, 180.0])
"""Hover, climb, oblique, edgewise, descent, vortex ring, windmill, axial descent."""


def rotor(*corrections: str, compiled: bool = False) -> propmap.Rotor:
    made = tuple(propmap.correction(text) for text in corrections)
    return propmap.Rotor(propmap.Model(BLADE, LAW, corrections=made), compiled=compiled)


@pytest.mark.parametrize("others", [(), ("pitt-peters",)])
def test_it_adds_its_drag_at_the_mean_inflow_and_nothing_else(others: tuple[str, ...]) -> None:
    bare, mounted = (rotor(*others, *added).loads(OMEGA, SPEED, BETA) for added in ((), (MOUNT,)))
    across, along = SPEED * np.sin(BETA), SPEED * np.cos(BETA)
    air = np.sqrt(across**2 + (along + WAKE * bare.mean_inflow) ** 2)
    expected = 0.5 * 1.225 * AREA * across * air
    assert expected[3] > 0.3 * bare.drag[3]
    np.testing.assert_allclose(mounted.drag - bare.drag, expected, rtol=1e-9, atol=1e-14)
    for name in (*LOADS, "power", "status", "mean_inflow"):
        if name != "drag":
            np.testing.assert_array_equal(getattr(mounted, name), getattr(bare, name), name)


def test_an_area_of_zero_changes_no_bit() -> None:
    bare, mounted = (
        rotor(*added).loads(OMEGA, SPEED, BETA) for added in ((), ("mount-drag:area_m2=0",))
    )
    np.testing.assert_array_equal(mounted.drag, bare.drag)
    assert rotor().arrays.mount is None


@pytest.mark.parametrize("spin", ["ccw", "cw"])
def test_the_force_is_against_the_inplane_velocity_and_has_no_moment(spin: str) -> None:
    velocity = np.array([3.0, -4.0, 2.0])
    bare, mounted = (rotor(*added).wrench(OMEGA, velocity, spin) for added in ((), (MOUNT,)))
    np.testing.assert_array_equal(mounted.moment, bare.moment)
    added = mounted.force - bare.force
    assert added @ velocity < 0.0 and added[2] == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(np.cross(added, [3.0, -4.0, 0.0]), 0.0, atol=1e-12)


def test_without_an_area_it_is_that_of_a_typical_motor() -> None:
    assert rotor("mount-drag").arrays.mount.area == typical_area(BLADE.radius)
    found, stated = (
        rotor(text).loads(OMEGA, 9.0, 1.2)
        for text in ("mount-drag", f"mount-drag:area_m2={typical_area(BLADE.radius)}")
    )
    assert found.drag == stated.drag


def test_a_mount_may_be_another_than_where_the_constants_are_from() -> None:
    law = replace(LAW, corrections=("tip-loss", "mount-drag:area_m2=0.002"))
    own = propmap.Model(BLADE, law)
    assert rotor_arrays(own).mount.area == 0.002 and rotor_arrays(own).factors
    mine = propmap.Model(BLADE, law, corrections=(propmap.correction(MOUNT),))
    assert rotor_arrays(mine).mount.area == AREA and rotor_arrays(mine).factors
    assert mine == own.with_mount(propmap.correction(MOUNT))
    assert mine.fingerprint() != own.fingerprint()
    with pytest.raises(InputError, match="was found with tip-loss, not with pitt-peters"):
        propmap.Model(BLADE, law, corrections=(propmap.correction("pitt-peters"),))
    with pytest.raises(InputError, match="mount-drag is given twice"):
        propmap.Model(BLADE, LAW, corrections=(propmap.correction(MOUNT),) * 2)


POINTS = {
    "oblique": (600.0, 6.0, 9.0),
    "hover": (600.0, 0.0, 0.0),
    "axial climb": (600.0, 5.0, 0.0),
    "vortex ring": (600.0, -4.0, 1.0),
    "windmill": (500.0, -15.0, 2.0),
}


@pytest.fixture(scope="module")
def drag_and_slope() -> Any:
    """Rotor drag of a rotor on a mount, and its derivative along a way."""
    arrays = rotor(MOUNT).arrays

    def drag(point: dict[str, Any]) -> Any:
        mount = arrays.mount._replace(area=point["area"], wake=point["wake"])
        flow = (jnp.reshape(point[name], 1) for name in ("omega", "v_axial", "v_inplane"))
        found = rotor_loads(arrays._replace(mount=mount), *flow, Resolution(24, 48))
        return found.loads.drag[0]

    return jax.jit(lambda point, way: jax.jvp(drag, (point,), (way,)))


@pytest.mark.slow
@pytest.mark.parametrize("where", POINTS)
def test_derivatives_are_central_differences(where: str, drag_and_slope: Any) -> None:
    """By the area and the share of the inflow, and by the flow, on which the inflow depends."""
    names = ("omega", "v_axial", "v_inplane")
    flow = dict(zip(names, POINTS[where], strict=True))
    point = flow | {"area": AREA, "wake": WAKE}
    sizes = {"omega": 0.02, "v_axial": 1e-3, "v_inplane": 1e-3, "area": 1e-4, "wake": 1e-3}
    with jax.enable_x64(True):
        for name, step in sizes.items():
            if name == "v_axial" and where == "hover":
                continue  # there the inflow has a kink, see the gradients of the bare rotor
            way = dict.fromkeys(point, 0.0) | {name: 1.0}
            exact = float(drag_and_slope(point, way)[1])
            up, down = (
                float(drag_and_slope(point | {name: point[name] + h}, way)[0])
                for h in (step, -step)
            )
            assert exact == pytest.approx((up - down) / (2.0 * step), rel=2e-4, abs=1e-9), name
