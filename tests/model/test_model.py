"""What a model tells of itself, and the rule about corrections and the law they were found with."""

from __future__ import annotations

import numpy as np
import pytest

import propmap
from propmap.errors import InputError

# A blade of constant chord and four stations, so that Re is known by hand.
BLADE = propmap.Propeller(
    "plank", 2, np.array([0.02, 0.05, 0.08, 0.1]), np.full(4, 0.01), np.full(4, 0.2)
)
LAW = propmap.airfoil("paper-apc")
TIP_LOSS = propmap.correction("tip-loss")


def test_reynolds_along_the_blade() -> None:
    air = propmap.Air(1.2, 1.8e-5)
    model = propmap.Model(BLADE, LAW, air)
    low, high = model.reynolds(500.0, 0.0, 0.0)
    at_tip = 1.2 * 500.0 * 0.1 * 0.01 / 1.8e-5
    # One per cent of the integral of y^2 lies within 0.0263 m, and outside 0.0997 m.
    assert high == pytest.approx(0.997 * at_tip, rel=0.01)
    assert low == pytest.approx(0.263 * at_tip, rel=0.04)
    # Axial flow adds in quadrature, an advancing blade by as much as the speed.
    assert model.reynolds(500.0, 30.0, 0.0)[1] == pytest.approx(
        at_tip * np.hypot(0.997, 30.0 / 50.0), rel=0.01
    )
    assert model.reynolds(500.0, 30.0, np.pi / 2)[1] == pytest.approx(at_tip * 1.6, rel=0.02)
    several = model.reynolds([300.0, 900.0], [0.0, 0.0], 0.0)
    assert several == pytest.approx((0.6 * low, 1.8 * high))
    assert model.reynolds(0.0, 0.0, 0.0) == (0.0, 0.0)


def test_a_law_brings_its_corrections() -> None:
    law = LAW.with_corrections(["tip-loss"])
    model = propmap.Model(BLADE, law)
    assert model.corrections == (TIP_LOSS,) and model.law_title == "paper-apc + tip-loss"
    assert model.fingerprint() == propmap.Model(BLADE, LAW, corrections=(TIP_LOSS,)).fingerprint()
    assert model.fingerprint() != propmap.Model(BLADE, LAW).fingerprint()
    assert propmap.Model(BLADE, law, corrections=(TIP_LOSS,)) == model
    hub_loss = propmap.correction("hub-loss")
    with pytest.raises(InputError, match="paper-apc was fitted with tip-loss, not with hub-loss"):
        propmap.Model(BLADE, law, corrections=(hub_loss,))
    with pytest.raises(InputError, match="not with hub-loss"):
        law.with_corrections(["hub-loss"])
    assert "\ncorrections" not in LAW.to_toml()
    assert '\ncorrections = ["tip-loss"]\n' in law.to_toml()


def test_a_section_table_may_have_corrections_too() -> None:
    angle = np.radians(np.linspace(-180.0, 180.0, 73))
    lift, drag = np.sin(2.0 * angle)[None], 0.02 + np.sin(angle)[None] ** 2
    table = propmap.SectionTable(angle, np.array([1e5]), lift, drag, name="plate")
    model = propmap.Model(BLADE, table.with_corrections(["tip-loss"]))
    assert model.corrections == (TIP_LOSS,)
    assert model.fingerprint() != propmap.Model(BLADE, table).fingerprint()
    close = np.sort(np.append(angle, 1e-6))
    with pytest.raises(InputError, match=r"0\.01 deg apart"):
        propmap.SectionTable(close, np.array([1e5]), np.sin(2.0 * close)[None], 0.0 * close[None])
    with pytest.raises(InputError, match="does not rise through zero between -30 and 30 deg"):
        propmap.SectionTable(angle, np.array([1e5]), -lift, drag)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("hub-loss:radius_m=0.012,radius_m=0.02", "radius_m is given twice; give it once"),
        ("hub-loss:", "'' is not field=number"),
        ("hub-loss:radius_m=0.012,", "'' is not field=number"),
    ],
)
def test_no_part_of_a_correction_is_ignored(text: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        propmap.correction(text)


def test_a_correction_without_the_number_that_it_needs_is_refused_in_a_line() -> None:
    with pytest.raises(InputError, match=r"blade-untwist: no tip_angle.*tip_angle=number"):
        propmap.correction("blade-untwist")
