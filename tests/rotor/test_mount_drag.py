"""A rotor on a mount: what it adds, that it adds nothing else, derivatives."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.model.corrections import TYPICAL_AREA, TYPICAL_FACTOR, Installed
from propmap.rotor import core_corrections

BLADE, LAW = propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")
AREA, WAKE = 0.0014, 1.3
MOUNT = f"installed:factor=1,area_m2={AREA},wake={WAKE}"

OMEGA = 600.0
SPEED = np.array([0.0, 3.0, 9.0, 14.0, 8.0, 4.0, 15.0, 6.0])
BETA = np.radians([0.0, 0.0, 40.0, 90.0, 100.0, 170.0, 175.0, 180.0])
"""Hover, climb, oblique, edgewise, descent, vortex ring, windmill, axial descent."""


def rotor(*corrections: str) -> propmap.Rotor:
    made = tuple(propmap.correction(text) for text in corrections)
    return propmap.Rotor(propmap.Model(BLADE, LAW, corrections=made))


def test_it_adds_its_drag_at_the_mean_inflow_and_nothing_else() -> None:
    bare, mounted = (
        rotor("pitt-peters", *added).loads(OMEGA, SPEED, BETA) for added in ((), (MOUNT,))
    )
    across, along = SPEED * np.sin(BETA), SPEED * np.cos(BETA)
    air = np.sqrt(across**2 + (along + WAKE * bare.mean_inflow) ** 2)
    expected = 0.5 * 1.225 * AREA * across * air
    assert expected[3] > 0.3 * bare.drag[3]
    np.testing.assert_allclose(mounted.drag - bare.drag, expected, rtol=1e-9, atol=1e-14)
    for name in (*LOADS, "power", "status", "mean_inflow"):
        if name != "drag":
            np.testing.assert_array_equal(getattr(mounted, name), getattr(bare, name), name)
    # The force is against the in-plane velocity.
    velocity = np.array([3.0, -4.0, 2.0])
    one, other = (rotor(*added).wrench(OMEGA, velocity) for added in ((), (MOUNT,)))
    np.testing.assert_array_equal(other.moment, one.moment)
    added = other.force - one.force
    assert added @ velocity < 0.0 and added[2] == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(np.cross(added, [3.0, -4.0, 0.0]), 0.0, atol=1e-12)


def test_what_is_not_stated_is_typical_and_uncertain() -> None:
    radius = BLADE.radius
    given = core_corrections(rotor("installed").model)
    assert given["installed"] == TYPICAL_FACTOR[0]
    assert given["mount-area"] == TYPICAL_AREA[0] * radius**2
    assert Installed(2.0).deviations(radius) == {"mount_area": TYPICAL_AREA[1] * radius**2}
    assert Installed(2.0, 0.001).deviations(radius) == {}


def test_the_factor_multiplies_the_blades_own_drag_and_nothing_else() -> None:
    bare, doubled = (
        rotor("pitt-peters", "radial-friction", *added).loads(OMEGA, SPEED, BETA)
        for added in ((), ("installed:factor=2,area_m2=0",))
    )
    np.testing.assert_allclose(doubled.drag, 2.0 * bare.drag, rtol=1e-14)
    for name in ("thrust", "torque", "roll_moment", "side_force", "pitch_moment"):
        np.testing.assert_array_equal(getattr(doubled, name), getattr(bare, name), name)


def test_a_mount_may_be_another_than_where_the_constants_are_from() -> None:
    law = replace(LAW, corrections=("tip-loss", "installed:factor=1,area_m2=0.002"))
    own = propmap.Model(BLADE, law)
    told = core_corrections(own)
    assert told["mount-area"] == 0.002 and told["tip-loss"]
    mine = propmap.Model(BLADE, law, corrections=(propmap.correction(MOUNT),))
    told = core_corrections(mine)
    assert told["mount-area"] == AREA and told["tip-loss"]
    assert mine == own.with_mount(propmap.correction(MOUNT))
    assert mine.fingerprint() != own.fingerprint()
    with pytest.raises(InputError, match="was fitted with tip-loss, not with pitt-peters"):
        propmap.Model(BLADE, law, corrections=(propmap.correction("pitt-peters"),))
    with pytest.raises(InputError, match="installed is given twice"):
        propmap.Model(BLADE, LAW, corrections=(propmap.correction(MOUNT),) * 2)


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"factor": -1.0}, "factor is -1.0: give 1 for the drag of the blades"),
        ({"area_m2": -1e-4}, "area_m2 is -0.0001: give an area of 0 m"),
        ({"area_m2": math.nan}, "area_m2 is nan"),
        ({"wake": 2.1}, "wake is 2.1: give inflow at the mount"),
    ],
)
def test_what_cannot_be_mounted(fields: dict[str, float], says: str) -> None:
    with pytest.raises(InputError, match=says):
        Installed(**fields)
