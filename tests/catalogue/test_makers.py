"""Names as people type them are read as makers of multirotors' propellers mean them."""

from __future__ import annotations

import pytest

import propmap
from propmap.catalogue.designation import designation
from propmap.catalogue.lookup import meant_by
from propmap.units import INCH

ASSUMED = "two blades assumed"

THIRTY = [
    ("51466", 5.1, 4.66, 3, "3 blades if it is from Gemfan: five-digit sizes have three blades"),
    ("Gemfan 51466", 5.1, 4.66, 3, "3 blades: five-digit sizes have three blades"),
    ("51433", 5.1, 4.33, 3, "if it is from Gemfan"),
    ("GF51466-3", 5.1, 4.66, 3, "in, 3 blades"),
    ("Gemfan Hurricane 51477", 5.1, 4.77, 3, "3 blades: five-digit sizes"),
    ("Gemfan 2036-4", 2.0, 3.6, 4, "2 x 3.6 in, 4 blades"),
    ("Gemfan LR 7042-2", 7.0, 4.2, 2, "in, 2 blades"),
    ("Gemfan 5152", 5.1, 5.2, None, ASSUMED),
    ("5040x3", 5.0, 4.0, 3, "5 x 4 in, 3 blades"),
    ("T5045C", 5.0, 4.5, 3, "3 blades if it is from DALPROP: T marks three blades"),
    ("Cyclone T5040C", 5.0, 4.0, 3, "3 blades: T marks three blades"),
    ("DALPROP T7056", 7.0, 5.6, 3, "3 blades: T marks three blades"),
    ("DAL Q2035C", 2.0, 3.5, 4, "4 blades: Q marks four blades"),
    ("DAL 5045BN", 5.0, 4.5, None, ASSUMED),
    ("T5146", 5.1, 4.6, 3, "if it is from DALPROP"),
    ("T-Motor T5147", 5.1, 4.7, 3, "3 blades: T sizes below eight inches"),
    ("T-Motor T5143S-3", 5.1, 4.3, 3, "in, 3 blades"),
    ("T-Motor T1045", 10.0, 4.5, None, ASSUMED),
    ("T-Motor P15x5", 15.0, 5.0, None, ASSUMED),
    ("P15x5", 15.0, 5.0, None, ASSUMED),
    ("T-Motor 28x9.2", 28.0, 9.2, None, ASSUMED),
    ("DJI 9450", 9.4, 5.0, None, ASSUMED),
    ("DJI 1345", 13.0, 4.5, None, ASSUMED),
    ("HQProp 7x3.5x3", 7.0, 3.5, 3, "7 x 3.5 in, 3 blades"),
    ("HQ T5x4.5x3 V1S", 5.0, 4.5, 3, "in, 3 blades"),
    ("HQ5045", 5.0, 4.5, None, ASSUMED),
    ("HQ Ethix S3", 5.0, 3.1, 3, "3 blades: S3 is the 5x3.1x3"),
    ("Ethix S4", 5.0, 3.7, 3, "S4 is the 5x3.7x3"),
    ("Ethix S5", 5.0, 4.0, 3, "S5 is the 5x4x3"),
    ("Lumenier 5x4.5", 5.0, 4.5, None, ASSUMED),
    ("EMAX Avan 5x2.8x3", 5.0, 2.8, 3, "in, 3 blades"),
    ("Avan Flow 5043", 5.0, 4.3, None, ASSUMED),
    ("Azure Power 5148", 5.1, 4.8, None, ASSUMED),
    ("1636", 1.6, 3.6, None, "1.6 x 3.6 in (not 16 x 3.6 in), two blades assumed"),
]


@pytest.mark.parametrize(("text", "diameter", "pitch", "blades", "told"), THIRTY)
def test_names_people_type(
    text: str, diameter: float, pitch: float, blades: int | None, told: str
) -> None:
    found = designation(text)
    assert found is not None
    assert (found.diameter / INCH, found.pitch / INCH) == pytest.approx((diameter, pitch))
    assert found.blades == blades
    assert told in found.reading and f"{diameter:g} x {pitch:g} in" in found.reading
    own = propmap.propeller(text)
    assert (own.diameter / INCH, own.blades) == (pytest.approx(diameter), blades or 2)


def test_no_two_are_one() -> None:
    assert len({text for text, *_ in THIRTY}) >= 30


NO_SIZE = [
    *("Ethix S9", "S3", "DJI", "Gemfan Hurricane", "T504", "514666", "5045.5", "5040x3.5", "0545"),
    *("a1234", "da4002", "T-Motor", "HQ 5", "gemfan x3", "5040x3x2"),
]


@pytest.mark.parametrize("text", NO_SIZE)
def test_nonsense_is_no_size(text: str) -> None:
    assert designation(text) is None
    with pytest.raises(propmap.InputError, match="neither a propeller of the catalogue nor a file"):
        propmap.propeller(text)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("T5000", "pitch of 0 m"),
        ("12345", "pitch of 0.0876 m"),
        ("5040x1", "1 blades"),
        ("Gemfan 51466-9", "9 blades"),
        ("5045 12-blade", "12 blades"),
    ],
)
def test_what_no_propeller_has_is_refused(text: str, says: str) -> None:
    with pytest.raises(propmap.InputError, match=says) as caught:
        propmap.propeller(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "asked", "blades", "told"),
    [
        ("T5045C", 2, 2, "2 blades as requested, not 3"),
        ("T5045C", 3, 3, "if it is from DALPROP"),
        ("DJI 9450", 3, 3, "3 blades as requested;"),
        ("HQ 5x4.3x3", None, 3, "3 blades;"),
    ],
)
def test_a_number_that_is_asked_for_wins(
    text: str, asked: int | None, blades: int, told: str
) -> None:
    meant = meant_by(text, asked)
    assert meant is not None and propmap.propeller(text, asked).blades == blades
    assert told in meant.summary  # type: ignore[union-attr]


def test_a_word_that_only_holds_a_makers_is_not_its() -> None:
    """The database's "magf" is Master Airscrew's, "gf" in it is not Gemfan."""
    found = designation("magf 10x6")
    assert found is not None and found.maker == ""
