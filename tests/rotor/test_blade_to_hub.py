"""The blade continued to the hub: its shape, and when there is nothing to continue."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap as pm
from propmap.loads import LOADS

BLADE, LAW = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")
FLOWS = (600.0, np.array([0.0, 6.0, 10.0, 8.0]), np.array([0.0, 0.3, 1.5, 2.4]))


def rotor(*texts: str, blade: pm.Propeller = BLADE) -> pm.Rotor:
    return pm.Rotor(pm.Model(blade, LAW, corrections=tuple(pm.correction(t) for t in texts)))


def twist_at(one: pm.Rotor, radius: np.ndarray) -> np.ndarray:
    """alpha is theta - phi."""
    field = one.inflow(600.0, 5.0, 0.0, radius=radius, azimuth=[0.0, 1.0])
    return field.alpha[:, 0] + np.arctan2(field.u_normal, field.u_tangential)[:, 0]


def test_the_measured_part_stays_as_it_is() -> None:
    y = np.linspace(BLADE.station[0], BLADE.radius, 500)
    longer, plain = (
        one.inflow(600.0, 5.0, 0.8, radius=y)
        for one in (rotor("blade-to-hub:radius_m=0.006"), rotor())
    )
    np.testing.assert_allclose(longer.normal_force, plain.normal_force, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(longer.alpha, plain.alpha, rtol=1e-12, atol=1e-12)


def test_inside_the_pitch_is_constant() -> None:
    first, twist_there = BLADE.station[0], BLADE.twist[0]
    y = np.linspace(0.008, first, 97)
    one = rotor("blade-to-hub:radius_m=0.008")
    assert one._core.span[0] == 0.008
    np.testing.assert_allclose(y * np.tan(twist_at(one, y)), first * np.tan(twist_there), rtol=1e-4)


@pytest.mark.parametrize("hub", [0.008, 0.016])
def test_loads_are_those_of_a_blade_continued_by_hand(hub: float) -> None:
    """The chord tapers as it does outside, to half at least, and grows no wider inwards."""
    first, chord_there, radius = BLADE.station[0], BLADE.chord[0], BLADE.radius
    y = np.linspace(hub, first, 60)[:-1]
    from scipy.interpolate import PchipInterpolator

    outside = float(PchipInterpolator(BLADE.station, BLADE.chord)(first + 0.1 * radius))
    taper = max((outside - chord_there) / (0.1 * radius), 0.0)
    chord = np.maximum(chord_there + taper * (y - first), 0.5 * chord_there)
    twist = np.arctan(first * np.tan(BLADE.twist[0]) / y)
    by_hand = replace(
        BLADE,
        station=np.concatenate([y, BLADE.station]),
        chord=np.concatenate([chord, BLADE.chord]),
        twist=np.concatenate([twist, BLADE.twist]),
        root_cutout=None,
    )
    want = pm.Rotor(pm.Model(by_hand, LAW), accuracy="fine").loads(*FLOWS)
    model = pm.Model(BLADE, LAW, corrections=(pm.correction(f"blade-to-hub:radius_m={hub}"),))
    got = pm.Rotor(model, accuracy="fine").loads(*FLOWS)
    for name in LOADS:
        size = np.abs(want.thrust).max() * (1.0 if LOADS[name].unit == "N" else radius)
        np.testing.assert_allclose(getattr(got, name), getattr(want, name), atol=2e-4 * size)


def test_the_hub_is_by_default_a_share_of_the_radius() -> None:
    assert rotor("blade-to-hub")._core.span[0] == pytest.approx(0.08 * BLADE.radius)


def test_a_blade_that_reaches_the_hub_stays_as_it_is() -> None:
    y = np.concatenate([[0.07 * BLADE.radius], BLADE.station])
    chord, twist = (np.concatenate([[v[0]], v]) for v in (BLADE.chord, BLADE.twist))
    whole = pm.Propeller("whole", 2, y, chord, twist)
    at_first = f"blade-to-hub:radius_m={float(BLADE.station[0])!r}"
    for found, plain in (
        (rotor("blade-to-hub", blade=whole), rotor(blade=whole)),
        (rotor(at_first), rotor()),
    ):
        for name in LOADS:
            one, other = (getattr(r.loads(*FLOWS), name) for r in (found, plain))
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("radius", ["0", "-0.01", "inf", "nan"])
def test_a_radius_that_cannot_be_is_refused(radius: str) -> None:
    with pytest.raises(pm.InputError, match="give the radius of the hub in meters"):
        pm.correction(f"blade-to-hub:radius_m={radius}")


def test_a_hub_outside_the_first_station_is_refused() -> None:
    with pytest.raises(pm.InputError, match=r"is 8 m, but the blade begins at 0\.024"):
        rotor("blade-to-hub:radius_m=8").loads(*FLOWS)


def test_a_root_cut_out_and_a_longer_blade_contradict_each_other() -> None:
    with pytest.raises(pm.InputError, match=r"root is cut out at 0\.03 m"):
        rotor("blade-to-hub", blade=BLADE.with_root_cutout(0.03)).loads(*FLOWS)


def test_corrections_act_alike_in_any_order() -> None:
    """The loss at the hub begins where the blade does: at the hub in either order."""
    one, other = (
        rotor(*pair).loads(*FLOWS)
        for pair in (("blade-to-hub", "hub-loss"), ("hub-loss", "blade-to-hub"))
    )
    for name in LOADS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    stated = rotor("blade-to-hub", f"hub-loss:radius_m={0.08 * BLADE.radius!r}").loads(*FLOWS)
    np.testing.assert_allclose(one.thrust, stated.thrust, rtol=1e-12)
