"""Propellers of a named number of blades, and the static loads of multirotor propellers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.catalogue.designation import FIVE_INCH_DOUBT, OTHER_DOUBT
from propmap.catalogue.expected import STAND_SHIFT
from propmap.catalogue.lookup import geometry_of, meant_by


@pytest.mark.parametrize(
    ("text", "other"),
    [
        ("APC 12x6.5E 3-blade", "APC 12x6.5E"),
        ("nr640 9x5 4-blade", "nr640 9x5"),
        ("5x4.3x2", "5x4.3"),
        ("HQ 5x4.3x3", "5x4.3"),
    ],
)
def test_a_number_of_blades_does_not_change_the_blade(text: str, other: str) -> None:
    np.testing.assert_array_equal(propmap.propeller(text).chord, propmap.propeller(other).chord)


def test_a_measured_blade_on_another_hub() -> None:
    own = propmap.propeller("uiuc-nr640-9x5.68")
    assert own.blades == 2 and propmap.propeller("nr640 9x5.68 - 3") == replace(own, blades=3)


def static_thrust(text: str, blades: int | None = None) -> tuple[float, float]:
    """Static thrust [N], and half the width of its 95 % band over thrust."""
    model = propmap.catalogue_model(text, blades)
    loads = propmap.Rotor(model).loads(80.0 / model.propeller.radius, 0.0, 0.0)
    return float(loads.thrust), float(1.96 * loads.std.thrust / loads.thrust)


def test_multirotor_propellers_have_less_thrust_than_the_mean_blade() -> None:
    (size_only, _), (named, _) = static_thrust("5x4.5"), static_thrust("5x4.5", 2)
    assert np.log(named / size_only) == pytest.approx(STAND_SHIFT[0], abs=0.01)
    halves = [static_thrust(text)[1] for text in ("T-Motor 18x6.1", "HQ 5x4.3x3", "DJI 5x4.5x2")]
    assert halves == sorted(halves) and halves[0] < 0.15 and halves[1] < 0.35


def test_an_unnamed_number_of_blades_is_in_the_band() -> None:
    """Racing propellers of five inches have three blades as a rule, others either number."""
    for text, count, counted in (("HQ 5x4.5", 3, "HQ 5x4.5x3"), ("HQ 7x4.5", 2, "HQ 7x4.5x2")):
        assert propmap.propeller(text).blades == count
        (thrust, half), (same, known) = static_thrust(text), static_thrust(counted)
        (_, asked), (other, _) = static_thrust(text, count), static_thrust(text, 5 - count)
        assert thrust == pytest.approx(same) and asked == pytest.approx(known)
        doubt = {3: FIVE_INCH_DOUBT, 2: OTHER_DOUBT}[count]
        more = doubt * (1.96 * np.log(other / thrust)) ** 2
        assert half**2 - known**2 == pytest.approx(more, rel=0.12)


def test_an_option_counts_as_the_name_does() -> None:
    blade = propmap.propeller("5x4.5", blades=3)
    assert geometry_of(meant_by("5x4.5"), blade) == geometry_of(meant_by("5x4.5", 3), blade)
    assert geometry_of(meant_by("5x4.5x3"), blade) == "multirotor"
    assert geometry_of(meant_by("5x4.5"), propmap.propeller("5x4.5")) == "population"
    assert geometry_of(meant_by("apc 12x6.5e", 3), blade) == "family"
