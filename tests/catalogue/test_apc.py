"""Blades by their maker's files: the published figures, and how measured blades differ."""

from __future__ import annotations

import re

import numpy as np
import pytest

import propmap
from propmap import catalogue
from propmap.catalogue import apc
from propmap.catalogue.designation import designation
from propmap.catalogue.expected import expected_constants
from propmap.catalogue.identified import identified
from propmap.catalogue.lookup import catalogue_model
from propmap.io.geometry import read_apc_pe0
from propmap.model.airfoil import Airfoil
from propmap.typing import Floats
from tests.catalogue.test_catalogue import DATA, with_data

PAIRS = [
    (name, made)
    for name in catalogue.names()
    for mark in ("e", "sf")
    for made in [f"apc-{name.rpartition('-')[2]}{mark}"]
    if name.startswith(f"uiuc-apc{mark}-") and made in catalogue.names()
]
"""Measured blades, and those of their maker's files."""


def at_three_quarters(name: str) -> Floats:
    """Logarithm of chord over radius, and twist [deg]."""
    blade = catalogue.load(name)
    shape = blade.chord / blade.radius, np.degrees(blade.twist)
    chord, twist = (np.interp(0.75 * blade.radius, blade.station, values) for values in shape)
    return np.array([np.log(chord), twist])


@with_data
def test_they_are_those_of_the_files() -> None:
    """All of the series that are told, but those with a file of their own in the catalogue."""
    series, seen = {"apce", "apcsf", "apcmr"}, 0
    for path in sorted((DATA / "apc" / "pe0").glob("*.PE0")):
        title = path.read_text().split(maxsplit=1)[0]
        if not re.fullmatch(r"[\d.]+x[\d.]+(E|EP|SF|MR)(-\d)?", title):
            assert (apc.series_of(title) or ("", ""))[0] not in series
            continue
        own, blade = read_apc_pe0(path), catalogue.load(f"apc-{title.lower()}")
        seen += 1
        assert (own.blades, own.name) == (blade.blades, blade.name)
        assert own.radius == pytest.approx(blade.radius, rel=1e-5)
        np.testing.assert_allclose(blade.station, own.station, atol=1e-4 * own.radius)
        np.testing.assert_allclose(blade.chord, own.chord, atol=1e-4 * own.radius)
        np.testing.assert_allclose(np.degrees(blade.twist), np.degrees(own.twist), atol=0.006)
    assert seen == len(apc.apc_blades()) + 5


@pytest.mark.parametrize(
    ("family", "pairs", "degrees"), [("apce", 12, (0.2, 0.6)), ("apcsf", 7, (-1.3, -0.7))]
)
def test_the_difference_is_that_of_the_pairs(
    family: str, pairs: int, degrees: tuple[float, float]
) -> None:
    some = [pair for pair in PAIRS if pair[0].startswith(f"uiuc-{family}-")]
    each = np.stack([at_three_quarters(one) - at_three_quarters(made) for one, made in some])
    found = apc.difference(family)
    assert len(each) == pairs
    np.testing.assert_allclose(found.mean[0], each[:, 0].mean(), atol=2e-3)
    np.testing.assert_allclose(np.degrees(found.mean[1]), each[:, 1].mean(), atol=0.03)
    deviation = np.sqrt(np.diag(found.covariance))
    wanted = each.std(axis=0, ddof=1) * np.sqrt(1.0 + 1.0 / pairs)
    np.testing.assert_allclose([deviation[0], np.degrees(deviation[1])], wanted, rtol=0.1)
    assert 0.96 <= np.exp(found.mean[0]) <= 0.985
    assert degrees[0] < np.degrees(found.mean[1]) < degrees[1]


def test_one_that_is_left_out_plays_no_part() -> None:
    (name,) = [made for one, made in PAIRS if one == "uiuc-apcsf-10x7"]
    # Its blade is turned back by more than two degrees, twice as far as the mean.
    whole, rest = apc.difference("apcsf"), apc.difference("apcsf", without=name)
    assert np.degrees(rest.mean[1] - whole.mean[1]) == pytest.approx(1.16 / 6.0, abs=0.02)
    assert rest.covariance[1, 1] < whole.covariance[1, 1]
    # A series that was not measured is known less.
    other, own = apc.difference("apcmr"), [apc.difference(f) for f in ("apce", "apcsf")]
    assert own[1].mean[1] < other.mean[1] < own[0].mean[1]
    assert all(other.covariance[1, 1] > one.covariance[1, 1] for one in own)


def thrust(name: str, law: Airfoil) -> float:
    rotor = propmap.Rotor(propmap.Model(catalogue.load(name), law))
    return float(rotor.loads(450.0, 4.0, 0.0).thrust)


def test_constants_make_up_for_what_the_file_differs() -> None:
    """Over a series, the maker's blade has the thrust of the measured one; without, it has not."""
    ratios = []
    for one, made in PAIRS:
        if one.startswith("uiuc-apcsf-"):
            label = designation(catalogue.entry(one).title)
            assert label is not None
            size = label.diameter, label.pitch
            measured, moved = (
                expected_constants("apcsf", size, how).airfoil for how in ("measured", "maker")
            )
            wanted = thrust(one, measured)
            ratios.append((thrust(made, moved) / wanted, thrust(made, measured) / wanted))
    with_it, without = np.log(ratios).mean(axis=0)
    assert abs(with_it) < 0.02 and abs(without) > 0.06


def test_the_bands_hold_what_is_not_known_of_the_blade() -> None:
    own = catalogue_model("uiuc-apce-10x7")
    moved = [catalogue_model(name) for name in ("apc-7x5e", "apc-12x4.5mr")]
    parts = []
    for one in (own, *moved):
        found = propmap.Rotor(one).loads(500.0, 3.0, 0.0)
        by = found.std_by_source
        parts.append(float(by["geometry"].thrust / found.thrust) if "geometry" in by else 0.0)
    assert parts[0] == 0.0 < 0.02 < parts[1] < parts[2]


def test_measured_loads_without_a_measured_blade_rest_on_it() -> None:
    for name in ("apc-8x4e", "apc-8x8e", "apc-9x7.5sf", "apc-8x6e"):
        found = identified(name, 2)
        assert found is not None and found.geometry == "maker"
        assert "the manufacturer's file" in found.verdict
