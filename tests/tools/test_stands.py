"""Static loads of multirotor propellers on stands, and the prior that they give."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import propmap as pm
from propmap.catalogue import expected
from propmap.catalogue.lookup import meant_by
from tools.stands import main, read_stands, shift_of

STANDS = Path(__file__).resolve().parents[3] / "shared" / "data" / "static" / "stands.csv"
needs_data = pytest.mark.skipif(not STANDS.exists(), reason="needs the reference data")


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("HQ 5x4.3x3", "three blades and more"),
        ("DJI 9.4x5x2", "two blades"),
        ("T-Motor 18x6.1", "carbon"),
    ],
)
def test_static_loads_by_name_have_the_distribution_of_the_stands(name: str, kind: str) -> None:
    model = pm.catalogue_model(name)
    size = expected.size_of(meant_by(name), model.propeller)
    mean = expected.expected_prior(None, size, "population").mean
    before, _ = expected.static_loads(mean, size, model.propeller.blades)
    rotor = pm.Rotor(model)
    loads = rotor.loads(expected.STAND_TIP_SPEED / model.propeller.radius, 0.0, 0.0)
    for k, load in enumerate(("thrust", "torque")):
        value = getattr(loads, load)
        assert np.log(value) - before[k] == pytest.approx(expected.STAND_SHIFT[k], abs=2e-3)
        spread = getattr(loads.std, load) / value
        assert spread == pytest.approx(expected.STAND_DEVIATIONS[kind][k], rel=0.03)


@needs_data
def test_the_numbers_are_those_that_the_tool_prints(capsys: pytest.CaptureFixture[str]) -> None:
    main(STANDS)
    lines = capsys.readouterr().out.splitlines()
    for kind, errors in expected.STAND_ERRORS.items():
        (line,) = [one for one in lines if one.startswith(kind)]
        shown = [float(one) for one in re.findall(r"([\d.]+)%", line)[:2]]
        assert shown == pytest.approx([100.0 * error for error in errors], abs=0.06)
    printed = {
        name: json.loads(value)
        for name, _, value in (line.partition(" = ") for line in lines if " = " in line)
    }
    assert printed["STANDS"] == expected.STANDS
    assert printed["STAND_SHIFT"] == pytest.approx(expected.STAND_SHIFT.tolist(), abs=1e-3)
    assert printed["STAND_CORRELATION"] == pytest.approx(expected.STAND_CORRELATION, abs=0.01)
    for kind, deviations in expected.STAND_DEVIATIONS.items():
        assert printed["STAND_DEVIATIONS"][kind] == pytest.approx(deviations, abs=1e-3)
        assert tuple(printed["STAND_SIZES"][kind]) == expected.STAND_SIZES[kind]
    assert printed["SIZE_TREND"] == expected.SIZE_TREND
    assert printed["TINY_TREND"] == expected.TINY_TREND


def test_the_band_of_a_tiny_propeller_contains_the_measured_thrust() -> None:
    """A Crazyflie rotor has 0.070 N at 17,174 rpm (Bitcraze, four rotors on a scale)."""
    for text, blades in (("47x17mm", None), ("47x17mm", 2)):
        loads = pm.Rotor(pm.catalogue_model(text, blades)).loads(17_174.0 * pm.units.RPM, 0.0, 0.0)
        low, high = loads.interval(0.95)
        assert low.thrust < 0.070 < high.thrust
        assert "4 to 40 in were measured" in meant_by(text, blades).summary


@needs_data
def test_held_out_propellers_are_inside_their_bands() -> None:
    every = read_stands(STANDS)
    scores: dict[str, list[float]] = {}
    for k, one in enumerate(every):
        without = shift_of([*every[:k], *every[k + 1 :]])
        score = (one.errors[0] - without.mean[0]) / without.deviations[one.kind][0]
        scores.setdefault(one.kind, []).append(abs(float(score)))
    for kind, some in scores.items():
        assert len(some) > 15 and np.mean(np.array(some) < 1.96) >= 0.9, kind
