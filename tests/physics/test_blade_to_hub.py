"""The blade continued to the hub: its shape, and when there is nothing to continue."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import propmap as pm
from propmap.arrays.namespace import by_numpy
from propmap.engine.rotor_arrays import rotor_arrays
from propmap.physics.geometry import Blade, blade_shape
from propmap.physics.rotor import RotorArrays

BLADE, LAW = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")


def arrays(*texts: str, blade: pm.Propeller = BLADE) -> RotorArrays:
    return rotor_arrays(
        pm.Model(blade, LAW, corrections=tuple(pm.correction(text) for text in texts))
    )


def shape(blade: Blade, radius: Any) -> tuple[np.ndarray, np.ndarray]:
    with by_numpy():
        chord, twist = blade_shape(blade, np.asarray(radius))
    return np.asarray(chord), np.asarray(twist)


def test_the_measured_part_stays_as_it_is() -> None:
    y = np.linspace(BLADE.station[0], BLADE.radius, 500)
    for found, measured in zip(
        shape(arrays("blade-to-hub:radius_m=0.006").blade, y), shape(arrays().blade, y), strict=True
    ):
        np.testing.assert_array_equal(found, measured)


def test_inside_the_pitch_is_constant_and_the_chord_tapers() -> None:
    first, chord_there, twist_there = BLADE.station[0], BLADE.chord[0], BLADE.twist[0]
    y = np.linspace(0.008, first, 97)
    blade = arrays("blade-to-hub:radius_m=0.008").blade
    chord, twist = shape(blade, y)
    assert float(blade.root) == 0.008
    np.testing.assert_allclose(y * np.tan(twist), first * np.tan(twist_there), rtol=1e-4)
    outside = first + 0.1 * BLADE.radius
    taper = (shape(arrays().blade, [outside])[0][0] - chord_there) / (outside - first)
    assert taper > 0.0
    want = np.maximum(chord_there + taper * (y - first), 0.5 * chord_there)
    np.testing.assert_allclose(chord, want, atol=1e-4 * chord_there)


def test_the_chord_has_a_floor_and_grows_no_wider_inwards() -> None:
    y = BLADE.station - BLADE.station[0]
    for slope, least in ((1.6, 0.5), (-0.1, 1.0)):
        chord = 0.012 + slope * np.minimum(y, 0.02)
        blade = pm.Propeller("tapered", 2, BLADE.station, chord, BLADE.twist)
        inside = shape(arrays("blade-to-hub:radius_m=0.002", blade=blade).blade, [0.002, 0.004])
        np.testing.assert_allclose(inside[0], least * 0.012, rtol=1e-12)


def test_the_hub_is_by_default_a_share_of_the_radius() -> None:
    assert float(arrays("blade-to-hub").blade.root) == pytest.approx(0.08 * BLADE.radius)


def test_a_blade_that_reaches_the_hub_stays_as_it_is() -> None:
    y = np.concatenate([[0.07 * BLADE.radius], BLADE.station])
    chord, twist = (np.concatenate([[v[0]], v]) for v in (BLADE.chord, BLADE.twist))
    whole = pm.Propeller("whole", 2, y, chord, twist)
    at_first = f"blade-to-hub:radius_m={float(BLADE.station[0])!r}"
    for found, plain in (
        (arrays("blade-to-hub", blade=whole), arrays(blade=whole)),
        (arrays(at_first), arrays()),
    ):
        for one, other in zip(found.blade, plain.blade, strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("radius", ["0", "-0.01", "inf", "nan"])
def test_a_radius_that_cannot_be_is_refused(radius: str) -> None:
    with pytest.raises(pm.InputError, match="give the hub's radius in metres"):
        pm.correction(f"blade-to-hub:radius_m={radius}")


def test_a_hub_outside_the_first_station_is_refused() -> None:
    with pytest.raises(pm.InputError, match=r"is 8 m, but the blade begins at 0\.024"):
        arrays("blade-to-hub:radius_m=8")


def test_a_root_cut_out_and_a_longer_blade_contradict_each_other() -> None:
    with pytest.raises(pm.InputError, match=r"root is cut out at 0\.03 m"):
        arrays("blade-to-hub", blade=BLADE.with_root_cutout(0.03))


def test_corrections_act_alike_in_any_order() -> None:
    """The loss at the hub begins where the blade does: at the hub in either order."""
    one, other = (
        arrays(*pair) for pair in (("blade-to-hub", "hub-loss"), ("hub-loss", "blade-to-hub"))
    )
    assert one.factors == other.factors
    assert float(one.factors[0].hub_radius) == pytest.approx(0.08 * BLADE.radius)  # type: ignore[attr-defined]
