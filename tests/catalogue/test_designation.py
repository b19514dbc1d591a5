"""What is printed on a blade is understood, or refused in one line."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

import propmap
from propmap import catalogue
from propmap.catalogue.designation import candidates, designation
from propmap.catalogue.expected import ExpectedBlade
from propmap.catalogue.lookup import designated
from propmap.units import INCH

MM = 1e-3


@pytest.mark.parametrize(
    ("text", "words", "diameter", "pitch", "blades"),
    [
        ("8x6", (), 8 * INCH, 6 * INCH, None),
        ("8x6E", ("e",), 8 * INCH, 6 * INCH, None),
        ("5x4.3x3", (), 5 * INCH, 4.3 * INCH, 3),
        ("apc 10x4.7sf", ("apc", "sf"), 10 * INCH, 4.7 * INCH, None),
        ("gws 8x4.5 hd", ("gws", "hd"), 8 * INCH, 4.5 * INCH, None),
        ("HQ 5x4.3x3", ("hq",), 5 * INCH, 4.3 * INCH, 3),
        ("HQ 5 x 4,3 3-blade", ("hq",), 5 * INCH, 4.3 * INCH, 3),
        ("130x70", (), 130 * MM, 70 * MM, None),
        ("E-flite 130x70 mm", ("e", "flite"), 130 * MM, 70 * MM, None),
        ("28x9.2 in", (), 28 * INCH, 9.2 * INCH, None),
        ("31mm x 20", (), None, None, None),
        ("1045", (), 10 * INCH, 4.5 * INCH, None),
        ("DJI 9450", ("dji",), 9.4 * INCH, 5 * INCH, None),
        ("6040x3", (), 6 * INCH, 4 * INCH, 3),
        ("da4002 5x1.58", ("da4002",), 5 * INCH, 1.58 * INCH, None),
        ("gwsdd 5.0x4.3 - 2", ("gwsdd",), 5 * INCH, 4.3 * INCH, 2),
        ("Dantsker 5\u00d73.75", ("dantsker",), 5 * INCH, 3.75 * INCH, None),
    ],
)
def test_designations(
    text: str,
    words: tuple[str, ...],
    diameter: float | None,
    pitch: float | None,
    blades: int | None,
) -> None:
    found = designation(text)
    if diameter is None:
        assert found is None
        return
    assert found is not None
    assert (found.words, found.blades) == (words, blades)
    assert (found.diameter, found.pitch) == pytest.approx((diameter, pitch), rel=1e-12)


@pytest.mark.parametrize("text", ["abc", "5x", "x5", "da4002", "1.5", "", "8 6", "1x2x3x4"])
def test_no_size(text: str) -> None:
    assert designation(text) is None
    with pytest.raises(propmap.InputError, match="neither a propeller of the catalogue nor a file"):
        propmap.propeller(text or "?")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("0x5", "diameter of 0 m"),
        ("5x0", "pitch of 0 m"),
        ("5x50", "pitch of 1.27 m"),
        ("5x4x1", "1 blades"),
        ("5x4x12", "12 blades"),
        ("apc 10x7", "may be uiuc-apce-10x7, uiuc-apcsf-10x7"),
        ("0x5", "did you mean .*x5"),
        ("apc-8x6q", "did you mean apc-8x6e"),
        ("apc-8x6", "did you mean apc-8x6e"),
        ("abc", "did you mean apc-"),
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
        ("apcsf 10x4.7", "uiuc-apcsf-10x4.7"),
        ("APC 11x7E", "uiuc-apce-11x7"),
        ("apc 8x6e", "apc-8x6e"),
        ("APC 8x4.5 MR", "apc-8x4.5mr"),
        ("master airscrew 9x6", "uiuc-ma-9x6"),
        ("master airscrew electric 9x6", "uiuc-mae-9x6"),
        ("gws 5x4.3", "uiuc-gwsdd-5x4.3"),
        ("ef 130x70", "uiuc-ef-130x70"),
        ("E-flite 130x70", "uiuc-ef-130x70"),
        ("graupner cam slim 10x6", "uiuc-grcsp-10x6"),
        ("kyosho 11x9 2-blade", "uiuc-kyosho-11x9"),
        ("ma 9x6", "uiuc-ma-9x6"),
        ("10x4.7SF", "uiuc-apcsf-10x4.7"),
        ("gwssf 10.0x4.7 - 2", "uiuc-gwssf-10x4.7"),
        ("APC 7x5E", "apc-7x5e"),
        ("apc-7x5E", "apc-7x5e"),
        ("12x6e", "apc-12x6e"),
        ("APC 12x4.5MR", "apc-12x4.5mr"),
        ("apc slow flyer 12x3.8", "apc-12x3.8sf"),
        ("APC 5.1x5E", "apc-5.1x5.0e"),
        ("APC 5x4E-4", "apc-5x4e-4"),
        ("APC 11x7E 3-blade", "apc-11x7e-3"),
        ("APC 11x4.5EP", "apc-11x4.5ep"),
    ],
)
def test_one_propeller(text: str, name: str) -> None:
    found = designated(text)
    assert isinstance(found, catalogue.Entry) and found.name == name
    assert propmap.propeller(text) == propmap.propeller(name)


@pytest.mark.parametrize("text", ["nr640 9x5.68 3-blade", "nr640 9x5.68 - 3", "NR640 9x5.68x3"])
def test_a_measured_blade_on_another_hub(text: str) -> None:
    own = propmap.propeller("uiuc-nr640-9x5.68")
    assert own.blades == 2
    assert propmap.propeller(text) == replace(own, blades=3)


def test_every_title_means_its_own_propeller() -> None:
    for entry in catalogue.entries():
        wanted = designation(entry.title)
        assert wanted is not None
        assert wanted.diameter == pytest.approx(entry.diameter_m, rel=0.011), entry.name
        own = [found for found in candidates(wanted) if found.family == entry.family]
        assert own, entry.name


@pytest.mark.parametrize("text", ["apc 12x6", "apc 8x6", "apc 7x5", "APC 12x7E"])
def test_a_makers_file_is_not_meant_unless_series_and_blades_are(text: str) -> None:
    """APC's sport propellers have no letter, and of his 12x7E three blades are known alone."""
    found = designated(text)
    assert isinstance(found, ExpectedBlade)
    assert any(name.startswith("apc-") for name in found.others)
    assert found.others[0] in found.summary


@given(
    st.floats(1.0, 40.0).map(lambda v: round(v, 2)),
    st.floats(0.2, 2.0),
    st.none() | st.integers(2, 8),
    st.sampled_from(["", "apc ", "HQ "]),
)
def test_what_is_written_is_read(
    diameter: float, ratio: float, blades: int | None, maker: str
) -> None:
    pitch = round(diameter * ratio, 2)
    found = designation(f"{maker}{diameter:g}x{pitch:g}" + (f"x{blades}" if blades else ""))
    assert found is not None and found.blades == blades
    assert (found.diameter, found.pitch) == pytest.approx((diameter * INCH, pitch * INCH))
