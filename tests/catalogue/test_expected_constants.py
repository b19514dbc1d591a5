"""Constants of propellers that were not identified, and of those without a measured blade."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap import catalogue
from propmap.catalogue.expected import (
    ExpectedBlade,
    constants_of,
    coordinates,
    equivalent,
    expected_constants,
    size_of,
    slopes_of,
)
from propmap.catalogue.identified import PARAMETERS, identified_without_blade
from propmap.catalogue.lookup import designated, meant_by, search
from propmap.errors import InputError
from propmap.typing import Floats
from tests.catalogue.test_expected_blade import RESULTS

SIZE = (0.254, 0.15)


def coefficients(blade: propmap.Propeller, airfoil: propmap.Airfoil) -> Floats:
    """Thrust and torque at rest and at two speeds."""
    rotor = propmap.Rotor(propmap.Model(blade, airfoil))
    loads = rotor.loads(600.0, np.array([0.0, 5.0, 9.0]), np.array([0.0, 0.0, 0.4]))
    return np.stack([loads.thrust, loads.torque])


def test_a_wider_blade_turned_further_has_the_loads_of_equivalent_constants() -> None:
    blade = propmap.propeller("uiuc-apce-10x7")
    other = replace(blade, chord=1.1 * blade.chord, twist=blade.twist + 0.02)
    # The chord is in the Reynolds number; without the terms of it skin friction is left.
    without = {name: 0.0 for name in PARAMETERS if name.startswith("reynolds")}
    law = replace(expected_constants("apce", SIZE).airfoil, **without)
    place = coordinates(np.array([getattr(law, name) for name in PARAMETERS]))
    moved = constants_of(place + equivalent(other, blade))
    held = replace(law, **dict(zip(PARAMETERS, moved.tolist(), strict=True)))
    wanted, found, before = (
        coefficients(*pair) for pair in ((other, law), (blade, held), (blade, law))
    )
    np.testing.assert_allclose(found, wanted, rtol=5e-3)
    assert (np.abs(before / wanted - 1.0) > 0.05).all()


def test_the_blade_s_part_is_told_apart() -> None:
    known = expected_constants("apce", SIZE).airfoil.uncertainty
    unknown = expected_constants("apce", SIZE, "family").airfoil.uncertainty
    assert known is not None and unknown is not None and unknown.with_blade is not None
    assert known.with_blade is None
    np.testing.assert_array_equal(unknown.with_blade.matrix, known.covariance.matrix)
    lift = PARAMETERS.index("c_l1")
    assert unknown.covariance.matrix[lift, lift] > known.covariance.matrix[lift, lift]
    for one in (known, unknown):
        assert one.covariance.names == PARAMETERS
        assert one.thrust_coefficient > one.power_coefficient > 0.0


def test_larger_propellers_have_more_lift_and_those_of_more_pitch_stall_later() -> None:
    small, large, steep = (
        expected_constants("apce", size).airfoil
        for size in ((0.15, 0.1), (0.4, 0.27), (0.15, 0.14))
    )
    assert large.c_l1 > 1.05 * small.c_l1
    assert steep.alpha_0 > 1.05 * small.alpha_0


def test_the_goals_of_propellers_left_out_are_met() -> None:
    """Median errors and what bands of 95 % hold, of what the committed command wrote."""
    found = json.loads(RESULTS.read_text(encoding="utf-8"))
    for group, most in (("family", 0.10), ("population", 0.15), ("family_static", 0.065)):
        assert max(found[group]["median"]) <= most
    for group in ("family", "population", "family_blade", "population_blade", "own_run"):
        for where in ("at_rest", "moving"):
            held = [share for share in found[group][where] if share is not None]
            assert all(0.91 <= share <= 0.98 for share in held), (group, where)
            assert not held or 0.92 <= np.mean(held) <= 0.975
    assert min(found["family_static"]["moving"]) >= 0.91


def test_size_is_the_label_s_and_that_of_the_blade_without_one() -> None:
    blade = propmap.propeller("uiuc-apce-10x7")
    labeled = size_of(meant_by("uiuc-apce-10x7"), blade)
    assert labeled == pytest.approx((0.254, 0.1778))
    by_twist = size_of(None, blade)
    assert by_twist[0] == pytest.approx(0.254, rel=2e-3)
    assert by_twist[1] == pytest.approx(0.1778, rel=0.15)
    assert size_of(meant_by("5x4.3x3"), blade) == pytest.approx((0.127, 0.10922))


@pytest.mark.parametrize(
    ("text", "own", "geometry"),
    [
        ("aeronaut 9x5", "uiuc-ancf-9x5", "population"),
        ("uiuc-ANCF-12x6.5", "uiuc-ancf-12x6.5", "population"),
        ("APC sport 8x8", "uiuc-apcsp-8x8", "family"),
    ],
)
def test_propellers_with_loads_and_no_blade_have_their_own_constants(
    text: str, own: str, geometry: str
) -> None:
    meant = meant_by(text)
    assert isinstance(meant, ExpectedBlade) and meant.own is not None
    assert (meant.own.propeller, meant.own.geometry, meant.geometry) == (own, geometry, geometry)
    assert "was not measured" in meant.summary and "err" not in meant.summary
    assert meant.propeller.blades == 2


def test_another_number_of_blades_has_constants_to_be_expected() -> None:
    meant = designated("ancf 12x8x3")
    assert isinstance(meant, ExpectedBlade) and meant.own is None
    assert meant.family == "ancf" and "uiuc-ancf-12x8" in meant.summary
    found = expected_constants("ancf", size_of(meant, meant.propeller), meant.geometry)
    assert "of its family, ancf" in found.summary


def test_of_several_without_blade_the_candidates_are_named() -> None:
    meant = designated("apc 8x8")
    assert isinstance(meant, ExpectedBlade) and meant.own is None
    assert meant.others == ("apc-8x8e", "uiuc-apcsp-8x8")
    with pytest.raises(InputError):
        designated("uiuc-ancf-9x44")


def test_they_are_listed_and_every_name_is_found_again() -> None:
    every = identified_without_blade()
    assert len(every) > 90 and not {one.propeller for one in every} & set(catalogue.names())
    listed = {entry.name: entry for entry in search("not measured")}
    assert set(listed) == {one.propeller for one in every}
    for one in every:
        meant = meant_by(listed[one.propeller].name)
        assert isinstance(meant, ExpectedBlade) and meant.own is one
        if one.family == "apc29ff":
            continue  # its title has the words of apcff, of which that size was measured
        by_title = designated(listed[one.propeller].title.partition(",")[0])
        assert isinstance(by_title, ExpectedBlade) and by_title.own is one, one.propeller
    assert len(search("")) == len(catalogue.entries()) + len(every)


CONSTANTS = np.array([5.3, 2.4, 2.6, 0.23, -0.045, 0.024, -0.019, 0.12, -0.35, 0.07])


def test_coordinates_and_constants_are_each_other_s_inverse() -> None:
    many = CONSTANTS * np.random.default_rng(1).uniform(0.5, 1.5, (20, CONSTANTS.size))
    np.testing.assert_allclose(constants_of(coordinates(many)), many, rtol=1e-14)
    # The angle of least drag counts from the chord line.
    place = coordinates(CONSTANTS)
    assert np.isclose(place[PARAMETERS.index("drag_angle")], -0.045 + 0.07)
    np.testing.assert_allclose(place[0], np.log(5.3))


def test_slopes_are_central_differences() -> None:
    place, step = coordinates(CONSTANTS), 1e-6
    for k, row in enumerate(np.eye(CONSTANTS.size)):
        change = constants_of(place + step * row) - constants_of(place - step * row)
        np.testing.assert_allclose(slopes_of(place)[:, k], change / (2.0 * step), atol=1e-8)
