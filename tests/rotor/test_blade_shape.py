"""A blade continued to the hub, and one that flattens as it turns, against blades by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import propmap as pm
from propmap.loads import LOADS
from propmap.model.corrections import BladeUntwist

BLADE, LAW = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")
FLOWS = (600.0, np.array([0.0, 6.0, 10.0, 8.0]), np.array([0.0, 0.3, 1.5, 2.4]))


def rotor(*texts: str, blade: pm.Propeller = BLADE) -> pm.Rotor:
    return pm.Rotor(pm.Model(blade, LAW, corrections=tuple(pm.correction(t) for t in texts)))


@pytest.mark.parametrize("hub", [0.008, 0.016])
def test_loads_are_those_of_a_blade_continued_by_hand(hub: float) -> None:
    """The chord tapers as it does outside, to half at least, and grows no wider inwards."""
    first, chord_there, radius = BLADE.station[0], BLADE.chord[0], BLADE.radius
    y = np.linspace(hub, first, 60)[:-1]
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


def test_reverse_flow_and_inflow_reach_to_the_hub() -> None:
    """By default at a share of the radius."""
    one, plain = rotor("blade-to-hub"), rotor()
    assert one.inflow(600.0, 10.0, 1.5).radius[0] == pytest.approx(0.08 * BLADE.radius)
    longer, shorter = (float(r.loads(600.0, 20.0, 1.5).reverse_flow) for r in (one, plain))
    assert longer > shorter
    assert one.model.reynolds(600.0, 10.0, 1.5)[0] < plain.model.reynolds(600.0, 10.0, 1.5)[0]


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


AT_100 = 100.0 / BLADE.radius
"""Rotational speed at which the tip moves at 100 m/s [rad/s]."""


def untwisted(angle: float | None, blade: pm.Propeller = BLADE) -> pm.Rotor:
    corrections = () if angle is None else (BladeUntwist(angle),)
    model = pm.Model(blade, LAW, corrections=corrections)
    return pm.Rotor(model, accuracy="fine")


@pytest.mark.parametrize("share", [0.5, 1.5])
def test_loads_are_those_of_a_blade_with_that_twist(share: float) -> None:
    s = BLADE.station / BLADE.radius
    lost = 0.03 * share**2 * s * (2.0 - s)
    flat = untwisted(None, replace(BLADE, twist=BLADE.twist - lost))
    flow = (share * AT_100, [0.0, 6.0, 12.0], [0.0, 0.7, 1.5])
    bent, rigid = untwisted(0.03).loads(*flow), untwisted(None).loads(*flow)
    for name in LOADS:
        wanted = getattr(flat.loads(*flow), name)
        np.testing.assert_allclose(getattr(bent, name), wanted, rtol=2e-4, atol=1e-6)
    assert (bent.thrust < rigid.thrust).all()


def test_slow_blades_and_none_are_rigid() -> None:
    slow, rigid = (untwisted(angle).loads(0.02 * AT_100, 0.1, 1.0) for angle in (0.05, None))
    assert slow.thrust == pytest.approx(rigid.thrust, 1e-3)
    assert untwisted(0.0).loads(AT_100, 5.0, 1.0) == untwisted(None).loads(AT_100, 5.0, 1.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: pm.correction("blade-to-hub:radius_m=-0.01"), "give the radius of the hub in"),
        (lambda: rotor("blade-to-hub:radius_m=8"), r"is 8 m, but the blade begins at 0\.024"),
        (
            lambda: rotor("blade-to-hub", blade=BLADE.with_root_cutout(0.03)),
            r"root is cut out at 0\.03 m",
        ),
        (lambda: BladeUntwist(0.3), "100 m/s"),
    ],
)
def test_what_does_not_suit_the_blade_is_refused(call: Any, message: str) -> None:
    with pytest.raises(pm.InputError, match=message):
        call().loads(*FLOWS)
