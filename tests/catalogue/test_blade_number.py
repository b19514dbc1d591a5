"""Blades on propellers of more than two are narrower, and what is known of static thrust counts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.catalogue.expected import (
    AT_REST,
    CHORD_OF_MORE,
    STAND_DEVIATION,
    bundled_population,
    expected_prior,
    known_at_rest,
    left_at_rest,
)
from propmap.catalogue.lookup import geometry_of, meant_by

WHOLE = bundled_population("population").between + bundled_population("population").within


@pytest.mark.parametrize(("text", "blades"), [("HQ 5x4.3x3", 3), ("5x4.3 6-blade", 6)])
def test_a_number_of_blades_changes_the_chord_and_nothing_else(text: str, blades: int) -> None:
    two, more = propmap.propeller("HQ 5x4.3"), propmap.propeller(text)
    assert (two.blades, more.blades) == (2, blades)
    np.testing.assert_allclose(more.chord, CHORD_OF_MORE * two.chord, rtol=1e-12)
    assert replace(two, blades=blades, chord=more.chord).fingerprint() == more.fingerprint()
    assert "more than two blades" in more.source and "MIT" in more.citation
    assert propmap.propeller("HQ 5x4.3", blades=blades).fingerprint() == more.fingerprint()


@pytest.mark.parametrize(
    ("text", "other"),
    [
        ("APC 12x6.5E 3-blade", "APC 12x6.5E"),
        ("nr640 9x5 4-blade", "nr640 9x5"),
        ("5x4.3x2", "5x4.3"),
    ],
)
def test_blades_of_a_series_and_of_two_stay_as_they_were(text: str, other: str) -> None:
    np.testing.assert_array_equal(propmap.propeller(text).chord, propmap.propeller(other).chord)


def test_a_measured_blade_on_another_hub() -> None:
    own = propmap.propeller("uiuc-nr640-9x5.68")
    assert own.blades == 2 and propmap.propeller("nr640 9x5.68 - 3") == replace(own, blades=3)


def relative_band(text: str, blades: int | None = None) -> float:
    """Half the width of the 95 % band of static thrust, over thrust."""
    model = propmap.catalogue_model(text, blades)
    loads = propmap.Rotor(model).loads(80.0 / model.propeller.radius, 0.0, 0.0)
    return float(1.96 * loads.std.thrust / loads.thrust)


@pytest.mark.parametrize("text", ["5x4x4", "T5045C", "Lumenier 5x4.5"])
def test_bands_of_multirotors_propellers_are_narrower(text: str) -> None:
    assert 0.16 < relative_band(text) < 0.30
    assert relative_band("5x4.5") > 0.33, "of no maker, and two blades are assumed"
    assert relative_band("5x4.5", 2) < 0.30


def test_an_option_counts_as_the_name_does() -> None:
    blade = propmap.propeller("5x4.5", blades=3)
    assert geometry_of(meant_by("5x4.5"), blade) == geometry_of(meant_by("5x4.5", 3), blade)
    assert geometry_of(meant_by("5x4.5x3"), blade) == "multirotor"
    assert geometry_of(meant_by("5x4.5"), propmap.propeller("5x4.5")) == "population"
    assert geometry_of(meant_by("apc 12x6.5e", 3), blade) == "family"


def test_static_thrust_is_as_well_known_as_is_said() -> None:
    narrowed = known_at_rest(WHOLE, left_at_rest(WHOLE))
    assert AT_REST @ narrowed @ AT_REST == pytest.approx(STAND_DEVIATION**2, rel=1e-9)
    assert (np.linalg.eigvalsh(narrowed) > 0.0).all()
    taken = np.linalg.eigvalsh(WHOLE - narrowed)
    assert (taken[:-1] < 1e-12).all() and taken[-1] > 0.0, "in one direction"
    # What goes with static thrust not at all stays: the covariance with it is nil.
    apart = np.eye(AT_REST.size)[4] - AT_REST * (AT_REST @ WHOLE[4]) / (AT_REST @ WHOLE @ AT_REST)
    assert apart @ narrowed @ apart == pytest.approx(apart @ WHOLE @ apart, rel=1e-9)
    prior = expected_prior(None, (0.127, 0.11), "multirotor")
    np.testing.assert_allclose(prior.covariance, narrowed, rtol=1e-9)
    np.testing.assert_array_equal(
        prior.mean, expected_prior(None, (0.127, 0.11), "population").mean
    )
