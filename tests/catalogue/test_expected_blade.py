"""Blades that were not measured: means of those that were, of any size."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import propmap
from propmap import catalogue
from propmap.catalogue.designation import designation
from propmap.catalogue.expected import (
    ERRORS,
    MEDIAN_ERRORS,
    SHARES,
    SIZE_TREND,
    ExpectedBlade,
    MeasuredShape,
    bundled_mean,
    mean_blade,
    measured_shapes,
)
from propmap.catalogue.lookup import designated
from propmap.model.plausibility import at_share, blade_warnings
from tools.catalogue.population import shapes_without

RESULTS = Path(__file__).resolve().parents[2] / "benchmarks" / "results" / "left_out.json"
FAMILIES = sorted({entry.family for entry in catalogue.entries()})
family = st.sampled_from([(), *((name,) for name in FAMILIES), ("gwsdd", "gwssf")])
length = st.floats(0.05, 1.0)


def invented(name: str, size: float, chord: float, offset: float, begin: int = 0) -> MeasuredShape:
    some = np.where(np.arange(SHARES.size) < begin, np.nan, 1.0)
    return MeasuredShape(name, (size, size), chord * some, offset * some)


def test_a_series_has_one_vote_however_many_its_propellers() -> None:
    many = [invented("a", size, 0.2, 0.0) for size in np.linspace(0.1, 0.3, 9)]
    found = mean_blade([*many, invented("b", 0.2, 0.1, 0.04)])
    np.testing.assert_allclose(found.chord, 0.15, rtol=1e-14)
    np.testing.assert_allclose(found.offset, 0.02, rtol=1e-14)
    assert found.propellers == 10


def test_the_blade_begins_where_most_members_do() -> None:
    late = [invented("a", 0.1, 0.2, 0.0, begin=3), invented("b", 0.1, 0.1, 0.0, begin=3)]
    early = invented("c", 0.1, 0.3, 0.0)
    assert mean_blade([*late, early]).share[0] == pytest.approx(SHARES[3])
    found = mean_blade([late[0], early])
    assert found.share[0] == pytest.approx(SHARES[0])
    # Only the early one is there at the root, both further out.
    assert found.chord[0] == pytest.approx(0.3)
    assert found.chord[5] == pytest.approx(0.25)
    assert bundled_mean(("nr640",)).share[0] == pytest.approx(0.3)


def pitch_of(entry: catalogue.Entry) -> float:
    label = designation(entry.title)
    assert label is not None
    return label.pitch


def test_blades_of_one_size_count_as_one_propeller() -> None:
    """Three specimens of the GWS 5x4.3, and the APC 9x6E of its maker and of the database."""
    sizes = [(one.family, one.size) for one in measured_shapes()]
    assert len(set(sizes)) == len(sizes)
    assert len([family for family, _ in sizes if family == "gwsdd"]) == 13
    assert len([family for family, _ in sizes if family == "apce"]) == 13


@given(family, length, st.floats(0.2, 1.5), st.floats(0.01, 0.5))
def test_more_pitch_is_more_twist_everywhere(
    of: tuple[str, ...], diameter: float, ratio: float, more: float
) -> None:
    mean = bundled_mean(of)
    low, high = (
        mean.propeller("p", diameter, diameter * pitch, 2) for pitch in (ratio, ratio + more)
    )
    assert (high.twist > low.twist).all()
    np.testing.assert_array_equal(high.chord, low.chord)


@pytest.mark.parametrize("name", ["uiuc-apce-11x7", "uiuc-ma-11x6"])
def test_a_blade_is_predicted_by_its_siblings(name: str) -> None:
    entry, own = catalogue.entry(name), catalogue.load(name)
    rest = shapes_without(entry)
    assert len(rest) == len(measured_shapes()) - 1
    found = mean_blade(rest, [entry.family]).propeller("p", own.diameter, pitch_of(entry), 2)
    for share in (0.5, 0.75, 0.9):
        (chord, twist), (own_chord, own_twist) = at_share(found, share), at_share(own, share)
        assert chord == pytest.approx(own_chord, rel=0.12)
        assert np.degrees(twist) == pytest.approx(np.degrees(own_twist), abs=2.0)


@pytest.mark.parametrize(
    "text", ["apc 10x4.2mr", "130x70", "graupner 12x6", "zinger 20x10", "nr640 9x5 4-blade", "10x7"]
)
def test_designations_give_loads_with_bands(text: str) -> None:
    assert isinstance(designated(text), ExpectedBlade)
    blade, rotor = propmap.propeller(text), propmap.Rotor(propmap.catalogue_model(text))
    assert blade_warnings(blade) == []
    omega = 80.0 / blade.radius
    loads = rotor.loads(omega, np.array([0.0, 6.0]), np.array([0.0, 1.2]))
    assert (loads.thrust > 0.0).all() and (loads.torque > 0.0).all()
    coefficient = loads.thrust / (1.225 * (omega / (2.0 * np.pi)) ** 2 * blade.diameter**4)
    assert ((coefficient > 0.02) & (coefficient < 0.4)).all()
    for std, load in ((loads.std.thrust, loads.thrust), (loads.std.torque, loads.torque)):
        assert ((std > 0.04 * load) & (std < 0.6 * load)).all()


def test_bands_widen_beyond_the_sizes_that_were_measured() -> None:
    """The note gives the range; the added variance is proportional to log(diameter) squared."""

    def spread(text: str) -> float:
        model = propmap.catalogue_model(text)
        loads = propmap.Rotor(model).loads(100.0 / model.propeller.radius, 0.0, 0.0)
        return float(loads.std.thrust / loads.thrust)

    for form, low, high in (("T-Motor {}x{}", 13.0, 35.5), ("HQ {}x{}x3", 1.9, 10.0)):
        last, further, furthest = (form.format(k * high, k * 0.35 * high) for k in (1, 1.4, 1.96))
        inside, more, most = (spread(text) ** 2 for text in (last, further, furthest))
        assert more - inside == pytest.approx((SIZE_TREND * np.log(1.4)) ** 2, rel=0.05)
        assert most - inside == pytest.approx(4.0 * (more - inside), rel=0.05)
        for text, noted in ((last, False), (further, True), (form.format(0.9 * low, low), True)):
            meant = designated(text)
            assert isinstance(meant, ExpectedBlade)
            assert (f"diameters of {low:g} to {high:g} in" in meant.summary) == noted
    # Without a manufacturer: the trend of the constants with the size may go on.
    assert spread("19x8") < spread("30x12.6") < spread("60x25.3")


def test_errors_that_are_told_are_those_of_propellers_left_out() -> None:
    found = json.loads(RESULTS.read_text(encoding="utf-8"))
    for name, (half, most) in ERRORS.items():
        np.testing.assert_allclose(half, found[name]["median"], atol=0.005)
        np.testing.assert_allclose(most, found[name]["nine_in_ten"], atol=0.005)
    for name, error in (MEDIAN_ERRORS | {"maker": MEDIAN_ERRORS["family"]}).items():
        assert error == pytest.approx(np.mean(found[name]["median"]), abs=0.007)


@pytest.mark.parametrize(
    ("text", "families", "unknown", "measured"),
    [
        ("130x70", 27, (), ("uiuc-ef-130x70",)),
        ("HQ 5x4.3x3", 27, ("hq",), ()),
        ("gws 8x4.5 hd", 2, ("hd",), ()),
        ("12x6.5E", 1, (), ()),
    ],
)
def test_what_is_told(
    text: str, families: int, unknown: tuple[str, ...], measured: tuple[str, ...]
) -> None:
    meant = designated(text)
    assert isinstance(meant, ExpectedBlade)
    assert len(meant.shape.families) == families
    assert (meant.unknown, meant.others) == (unknown, measured)
    assert (meant.family is not None) == (families == 1)
    for told in (*(() if meant.wanted.maker else unknown), *measured, meant.wanted.maker):
        assert told in meant.summary
    assert "not measured" in meant.propeller.source
