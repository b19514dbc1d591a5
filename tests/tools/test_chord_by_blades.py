"""The chord of blades on propellers of more than two, from static thrust."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.catalogue.expected import AT_REST, CHORD_OF_MORE, LEFT_OUT_ERROR, STAND_DEVIATION
from propmap.model.air import Air
from propmap.units import INCH, RPM
from tools.chord_by_blades import (
    DENSITY,
    LeftOut,
    StaticTest,
    hub_ratios,
    left_out,
    main,
    means_by_series,
    read_stand,
    rule,
    widened,
)

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
STAND, LOADS = DATA / "static" / "five_inch_stand.csv", DATA / "uiuc" / "loads.csv"
needs_data = pytest.mark.skipif(not STAND.exists(), reason="needs the reference data")
OMEGA = np.linspace(4000.0, 16000.0, 7) * RPM


def invented(name: str, blades: int, factor: float) -> StaticTest:
    """A propeller whose thrust is what the model gives with this ``factor``."""
    size = 5.0 * INCH, 4.3 * INCH
    test = StaticTest(name, name, blades, size, OMEGA, np.ones_like(OMEGA), DENSITY)
    return test._replace(thrust=np.array(test.loads(factor).thrust))


@pytest.mark.parametrize(("blades", "factor"), [(2, 1.1), (3, 0.72)])
def test_a_factor_is_found_again(blades: int, factor: float) -> None:
    assert invented("a", blades, factor).factor() == pytest.approx(factor, rel=1e-3)


def test_the_more_they_scatter_the_less_they_are_believed() -> None:
    alike = np.full(3, -0.3)
    assert rule(alike, np.full(3, -0.1)) == pytest.approx((-0.3, 0.0))
    hubs, scatter = np.array([-0.12, -0.1, -0.08]), np.array([-0.1, 0.0, 0.1])
    found = [rule(-0.3 + share * scatter, hubs) for share in (0.1, 1.0, 2.0)]
    means, deviations = np.transpose(found)
    assert -0.3 < means[0] < -0.295 < means[1] < means[2] < -0.1
    assert (np.diff(deviations) > 0.0).all()
    mean, deviation = rule(np.array([-0.4, 0.2]), hubs)
    assert (mean, deviation) == pytest.approx((-0.1, 0.0)), "scatter explains the difference"


def test_few_errors_are_widened_by_student() -> None:
    # The 97.5 % points of Student's t with four and three degrees of freedom.
    assert widened([0.1] * 4) == pytest.approx(0.1 * 2.7764 / 1.96, rel=1e-3)
    assert widened([0.1, -0.1, 0.1]) == pytest.approx(0.1 * 3.1824 / 1.96, rel=1e-3)


def test_its_own_thrust_plays_no_part_in_its_factor() -> None:
    stand = [
        invented("a", 3, 0.7), invented("b", 3, 0.74), invented("c", 4, 0.76), invented("d", 2, 1)
    ]  # fmt: skip
    hubs = np.array([-0.12, -0.1, -0.08])
    other = [*stand[:2], invented("c", 4, 0.9), stand[3]]
    one, changed = left_out(stand, hubs)[2], left_out(other, hubs)[2]
    assert changed.factor == one.factor == pytest.approx(0.72, abs=0.01)
    assert left_out(stand, hubs)[3].factor == 1.0


def test_a_hub_with_two_blades_is_what_others_are_counted_from() -> None:
    factors = {2: 1.2, 3: 1.08, 4: 0.96}
    found = hub_ratios([invented("a", *one)._replace(name="blade") for one in factors.items()])
    assert [ratio for _, ratio in found] == pytest.approx([0.9, 0.8], rel=1e-3)
    assert means_by_series(found) == pytest.approx([np.log(0.72) / 2.0], rel=1e-2)


@needs_data
def test_propellers_of_the_stand_are_predicted_by_the_others(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """And the program prints the numbers that the catalogue has."""
    found: list[LeftOut] = []

    def kept(*given: Any) -> list[LeftOut]:
        found.extend(left_out(*given))
        return found

    monkeypatch.setattr("tools.chord_by_blades.left_out", kept)
    main(STAND, LOADS)
    assert [one.test.blades for one in found] == [3, 3, 4, 2]
    for one in found:
        assert abs(np.expm1(one.error)) <= min(0.10, LEFT_OUT_ERROR), one.test.name
        assert one.half_width <= 0.30 and one.inside >= 0.95, one.test.name
    told = dict(re.findall(r"^([A-Z_]+) = ([\d., -]+\d)", capsys.readouterr().out, re.MULTILINE))
    assert float(told["CHORD_OF_MORE"]) == pytest.approx(CHORD_OF_MORE, abs=0.002)
    assert float(told["STAND_DEVIATION"]) == pytest.approx(STAND_DEVIATION, abs=0.001)
    slopes = [float(word) for word in told["AT_REST"].split(",")]
    np.testing.assert_allclose(slopes, AT_REST, atol=0.02)


@needs_data
def test_propellers_of_the_stand_by_name() -> None:
    for test in read_stand(STAND):
        model = propmap.catalogue_model(test.name)
        assert model.propeller.blades == test.blades
        assert model.propeller.diameter == pytest.approx(test.size[0])
        model = replace(model, air=Air(DENSITY))
        loads = propmap.Rotor(model).loads(test.omega, 0.0, 0.0)
        assert abs(np.median(loads.thrust / test.thrust) - 1.0) <= 0.10, test.name
        assert 1.96 * np.median(loads.std.thrust / loads.thrust) <= 0.30, test.name
