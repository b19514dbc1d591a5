"""What is printed on a blade is understood, or refused in one line."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import propmap
from propmap import catalogue
from propmap.catalogue.designation import PRIOR, UNITS, candidates, designation
from propmap.catalogue.expected import ExpectedBlade
from propmap.catalogue.lookup import designated, meant_by
from propmap.units import INCH

MM = 1e-3


NO_SIZE = [
    *("abc", "5x", "x5", "1.5", "8 6", "1x2x3x4", "31mm x 4", "da4002", "a1234", "HQ 5"),
    *("Ethix S9", "S3", "T504", "514666", "5045.5", "5040x3.5", "0545", "gemfan x3", "5040x3x2"),
]


def test_no_size() -> None:
    for text in NO_SIZE:
        assert designation(text) is None, text
        with pytest.raises(propmap.InputError, match="neither a propeller of the catalogue nor a"):
            propmap.propeller(text)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("0x5", "diameter of 0 m"),
        ("5x50", "pitch of 1.27 m"),
        ("5x4x1", "1 blades"),
        ("12345", "pitch of 0.0876 m"),
        ("apc 10x7", "may be uiuc-apce-10x7, uiuc-apcsf-10x7"),
        ("apc-8x6q", "did you mean apc-8x6e"),
        ("5x", "did you mean apc-5x"),
    ],
)
def test_refusals_are_one_line(text: str, says: str) -> None:
    with pytest.raises(propmap.InputError, match=says) as caught:
        propmap.propeller(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("APC 10x4.7SF", "uiuc-apcsf-10x4.7"),
        ("apc slow flyer 10x4.7", "uiuc-apcsf-10x4.7"),
        ("master airscrew electric 9x6", "uiuc-mae-9x6"),
        ("kyosho 11x9 2-blade", "uiuc-kyosho-11x9"),
        ("gwssf 10.0x4.7 - 2", "uiuc-gwssf-10x4.7"),
        ("APC 5.1x5E", "apc-5.1x5.0e"),
        ("APC 11x7E 3-blade", "apc-11x7e-3"),
    ],
)
def test_one_propeller(text: str, name: str) -> None:
    found = designated(text)
    assert isinstance(found, catalogue.Entry) and found.name == name
    assert propmap.propeller(text) == propmap.propeller(name)


def test_every_title_means_its_own_propeller() -> None:
    for entry in catalogue.entries():
        wanted = designation(entry.title)
        assert wanted is not None
        assert wanted.diameter == pytest.approx(entry.diameter_m, rel=0.011), entry.name
        own = [found for found in candidates(wanted) if found.family == entry.family]
        assert own, entry.name


@pytest.mark.parametrize("text", ["apc 8x6", "APC 12x7E"])
def test_a_makers_file_is_not_meant_unless_series_and_blades_are(text: str) -> None:
    """APC's sport propellers have no letter, and of his 12x7E three blades are known alone."""
    found = designated(text)
    assert isinstance(found, ExpectedBlade)
    assert any(name.startswith("apc-") for name in found.others)
    assert found.others[0] in found.summary


with Path(__file__).with_name("designations.csv").open(encoding="utf-8") as file:
    REAL = [
        (
            row["designation"],
            *(float(row[n]) * UNITS[row["unit"]] for n in ("diameter", "pitch")),
            row,
        )
        for row in csv.DictReader(file)
    ]  # designations of manufacturers and shops, with diameter and pitch [m]


def test_designations_of_manufacturers_are_read_correctly() -> None:
    """Of 756 designations from 31 mm to 2 m, the HQ1312 alone is read as another size, 1.3x1.2 in;
    the note lists its size."""
    other = []
    for text, diameter, pitch, row in REAL:
        found = designation(text)
        assert found is not None, text
        if (found.diameter, found.pitch) != pytest.approx((diameter, pitch), rel=1e-9):
            other.append(text)
            assert f"{row['diameter']} x {row['pitch']} {row['unit']}" in found.reading, text
        assert row["blades"] in ("", str(found.blades)), text
    assert len(REAL) >= 500 and other == ["HQ1312"]


def test_the_prior_describes_the_sizes_of_manufacturers() -> None:
    sizes = {
        (round(diameter / INCH, 3), round(pitch / diameter, 4)) for _, diameter, pitch, _ in REAL
    }
    diameters, ratios = np.log(np.array(sorted(sizes))).T
    known = np.log(PRIOR["diameters"])
    usual, spread = (np.interp(diameters, known, PRIOR[row]) for row in ("ratios", "spread"))
    standardized = (ratios - np.log(usual)) / spread
    # Standard errors of the mean and the standard deviation of 388 sizes are 0.05 and 0.04.
    assert abs(standardized.mean()) < 0.1 and abs(standardized.std() - 1.0) < 0.08
    assert math.exp(np.median(diameters)) == pytest.approx(PRIOR["diameters"][3], rel=0.1)
    assert diameters.std() == pytest.approx(PRIOR["size_spread"], rel=0.15)
    assert min(ratios) > math.log(PRIOR["flattest"])


@given(
    st.integers(31, 2000),
    st.floats(0.25, 1.2),
    st.sampled_from(["mm", "cm", "m", "in", "inch", "inches", '"', "\u2033", "''"]),
    st.sampled_from(["{d}x{p}{u}", "{d} x {p} {u}", "{d}{u}x{p}{u}", "{d} {u} \u00d7 {p} {u}"]),
    st.sampled_from(["", "x3", "x4", " 3-blade", " 4 blades"]),
    st.sampled_from(["", "T-Motor NS", "Gemfan ", "Xoar "]),
)
def test_a_written_unit_counts(
    diameter: int, ratio: float, unit: str, form: str, blades: str, maker: str
) -> None:
    scale = UNITS.get(unit, INCH)
    d, p = (f"{length * MM / scale:.5g}" for length in (diameter, ratio * diameter))
    found = designation(maker + form.format(d=d, p=p, u=unit) + blades)
    assert found is not None
    assert (found.diameter, found.pitch) == pytest.approx((float(d) * scale, float(p) * scale))
    assert not blades or str(found.blades) in blades


def test_digits_are_read_or_listed_for_every_common_size() -> None:
    """Four digits are tenths of an inch, or both lengths are whole inches: 34x12 is 3412."""
    small = [(d / 10, p / 10) for d in range(20, 100) for p in range(10, 100) if 0.4 < p / d < 1.3]
    large = [(float(d), float(p)) for d in range(30, 41) for p in range(10, 19)]
    for k, (diameter, pitch) in enumerate([*small, *large]):
        scale = 10 if k < len(small) else 1
        found = designation(f"{round(diameter * scale)}{round(pitch * scale)}")
        assert found is not None
        assert f"{diameter:g} x {pitch:g} in" in found.reading, (diameter, pitch)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("T-Motor 3412", "34 x 12 in (not 3.4 x 1.2 in)"),
        ("75x40", "75 x 40 in (not 7.5 x 4 in or 75 x 40 mm)"),
        ("1575x610", "1575 x 610 mm"),
        ("52x26x3", "52 x 26 in (not 5.2 x 2.6 in), 3 blades"),
        ("KDE 5x3", "5 x 3 in, an unusual size for KDE Direct"),
        ("Hobbywing 36190", "36 x 19 in, two blades assumed"),
    ],
)
def test_another_probable_size_and_an_unusual_size_are_noted(text: str, told: str) -> None:
    found = designation(text)
    assert found is not None and f"read as {told}" in found.reading


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("31mm 4 blade", "the pitch, or the unit after the pitch, is missing"),
        ("1.2 m", "as in 31x20mm"),
        ('12" x 6', "or 12x6in"),
        ("EDF 70x50mm", "is a ducted fan"),
        ("Emax 2306 2400kv", "is a motor; give the propeller, as in 10x4.5"),
    ],
)
def test_a_size_without_pitch_is_refused_without_suggestions(text: str, says: str) -> None:
    with pytest.raises(propmap.InputError, match=says) as caught:
        propmap.propeller(text)
    assert "did you mean" not in str(caught.value)


ASSUMED = "two blades assumed"

BY_MAKERS = [
    ("51466", 5.1, 4.66, 3, "3 blades if it is from Gemfan: five-digit sizes have three blades"),
    ("Gemfan 2036-4", 2.0, 3.6, 4, "2 x 3.6 in, 4 blades"),
    ("5040x3", 5.0, 4.0, 3, "5 x 4 in, 3 blades"),
    ("T5045C", 5.0, 4.5, 3, "3 blades if it is from DALPROP: T marks three blades"),
    ("DAL Q2035C", 2.0, 3.5, 4, "4 blades: Q marks four blades"),
    (
        "DAL 5045BN",
        5.0,
        4.5,
        3,
        "three blades assumed, as for most DALPROP propellers of this size",
    ),
    ("T-Motor T5147", 5.1, 4.7, 3, "3 blades: T sizes below eight inches"),
    ("DJI 9450", 9.4, 5.0, None, ASSUMED),
    ("HQ Ethix S3", 5.0, 3.1, 3, "3 blades: S3 is the 5x3.1x3"),
    ("KDE-CF185-TP 18.5x6.3", 18.5, 6.3, 3, "3 blades: TP and TRIPLE mark three blades"),
    ('24.5" x 8.1 DUAL-EDN (KDE)', 24.5, 8.1, 2, "2 blades: DP and DUAL mark two blades"),
    ("2x 10.5x4.5", 10.5, 4.5, None, ASSUMED),
    ("5x 4x3", 5.0, 4.0, 3, "in, 3 blades"),
    ("2212 920KV 1045", 10.0, 4.5, None, ASSUMED),
    ('32" x 12', 32.0, 12.0, None, ASSUMED),
    ("1636", 1.6, 3.6, None, "1.6 x 3.6 in (not 16 x 3.6 in), two blades assumed"),
]


@pytest.mark.parametrize(("text", "diameter", "pitch", "blades", "told"), BY_MAKERS)
def test_names_are_read_as_their_makers_mean_them(
    text: str, diameter: float, pitch: float, blades: int | None, told: str
) -> None:
    found = designation(text)
    assert found is not None
    assert (found.diameter / INCH, found.pitch / INCH) == pytest.approx((diameter, pitch))
    assert found.blades == blades
    assert told in found.reading and f"{diameter:g} x {pitch:g} in" in found.reading
    own = propmap.propeller(text)
    assert (own.diameter / INCH, own.blades) == (pytest.approx(diameter), blades or 2)


@pytest.mark.parametrize(
    ("text", "asked", "blades", "told"),
    [
        ("T5045C", 2, 2, "2 blades as requested, not 3"),
        ("T5045C", 3, 3, "if it is from DALPROP"),
        ("DJI 9450", 3, 3, "3 blades as requested;"),
        ("HQ 5x4.3x3", None, 3, "3 blades;"),
    ],
)
def test_a_number_of_blades_that_is_asked_for_wins(
    text: str, asked: int | None, blades: int, told: str
) -> None:
    meant = meant_by(text, asked)
    assert isinstance(meant, ExpectedBlade)
    assert propmap.propeller(text, asked).blades == blades
    assert told in meant.summary
