"""Estimates of loads, unit errors, and where warnings begin."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.errors import InputError
from propmap.model.plausibility import (
    CHORD,
    LIFT_SLOPE,
    LOAD_RATIO,
    SMALL_BLADES,
    SPEED_OF_SOUND,
    ZERO_LIFT,
    air_warnings,
    blade_warnings,
    estimated_loads,
    load_warnings,
    pitch_ratio,
    point_warnings,
)
from propmap.model.propeller import LIKELY_RADIUS
from propmap.model.unit_errors import UNIT_ERRORS, Range, common_errors, looks_like, unit_errors

BLADE = propmap.propeller("apc-8x6e")
AIR = propmap.Air()
OMEGA = np.array([300.0, 500.0, 700.0])
STILL = np.zeros(3)


@pytest.mark.parametrize("climb", [0.0, 0.1])
def test_estimate_balances_momentum_and_blade_element(climb: float) -> None:
    """The inflow by bisection, from lift and momentum of the annulus at 0.75 R."""
    tip = OMEGA[1] * BLADE.radius
    chord = np.interp(0.75 * BLADE.radius, BLADE.station, BLADE.chord)
    twist = np.interp(0.75 * BLADE.radius, BLADE.station, BLADE.twist) - ZERO_LIFT

    def excess(inflow: float) -> float:
        speed, width = 0.75 * tip, 2.0 * np.pi * 0.75 * BLADE.radius
        angle = twist - inflow * tip / speed
        lift = 0.5 * AIR.density * speed**2 * LIFT_SLOPE * angle * BLADE.blades * chord
        through = AIR.density * inflow * tip * width
        return float(lift - through * 2.0 * (inflow - climb) * tip)

    low, high = climb, 1.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) > 0.0 else (low, middle)
    thrust = 2.0 * AIR.density * np.pi * BLADE.radius**2 * low * (low - climb) * tip**2
    found = estimated_loads(BLADE, AIR, OMEGA[1:2], np.array([climb * tip]))["thrust"][0]
    assert found == pytest.approx(SMALL_BLADES * thrust, rel=1e-9)


def test_estimated_torque_responds_to_the_blade() -> None:
    base = estimated_loads(BLADE, AIR, OMEGA, STILL)["torque"]
    wide = estimated_loads(replace(BLADE, chord=1.2 * BLADE.chord), AIR, OMEGA, STILL)["torque"]
    flat = estimated_loads(replace(BLADE, twist=0.8 * BLADE.twist), AIR, OMEGA, STILL)["torque"]
    assert (flat < base).all() and (base < wide).all()
    np.testing.assert_allclose(base / OMEGA**2, base[0] / OMEGA[0] ** 2)


@pytest.mark.parametrize(
    ("usual", "quantity"),
    [
        (LIKELY_RADIUS, "length"),
        (CHORD, "chord over radius"),
        (Range(0.9, 1.45), "density"),
        (LOAD_RATIO, "thrust"),
        (LOAD_RATIO, "torque"),
    ],
)
def test_each_unit_error_is_named_first_for_a_typical_figure(usual: Range, quantity: str) -> None:
    typical, errors = float(np.sqrt(usual.low * usual.high)), UNIT_ERRORS[quantity]
    for name, factor in errors.items():
        found = unit_errors(typical * factor, usual, errors)
        assert found[0] == name
        assert name in looks_like(found)
    for value in (0.0, -1.0, np.inf, 1e30):
        assert unit_errors(value, usual, errors) == []


def test_a_unit_error_must_explain_all_figures() -> None:
    errors = [("both", (10.0, 100.0)), ("the first", (10.0, 1.0))]
    assert common_errors((11.0, 90.0), Range(0.5, 2.0), errors) == ["both"]


def test_mach_numbers() -> None:
    def told(mach: float) -> list[str]:
        return point_warnings(
            BLADE, np.array([mach * SPEED_OF_SOUND / BLADE.radius]), np.zeros(1), np.zeros(1)
        )

    assert told(0.74) == []
    (note,) = told(0.99)
    assert "Mach 0.99" in note
    with pytest.raises(InputError, match=r"Mach 1\.01"):
        told(1.01)
    with pytest.raises(InputError, match="speed looks like km/h"):
        point_warnings(BLADE, np.array([100.0]), np.array([400.0]) * 0.9, np.zeros(1))


def test_what_is_unusual_but_sound_is_passed() -> None:
    flat = replace(BLADE, twist=np.full_like(BLADE.twist, 0.2))
    assert blade_warnings(flat) == []
    assert air_warnings(propmap.Air.standard(10000.0)) == []
    # Rest, standing rotors, descent, and one fast row among slow ones.
    omega = np.array([0.0, 0.0, 500.0, 500.0, 500.0, 100.0])
    speed = np.array([0.0, 10.0, 0.0, 9.0, 12.0, 30.0])
    beta = np.array([0.0, 1.0, 0.0, np.pi, 1.2, 1.5])
    assert point_warnings(BLADE, omega, speed, beta) == []
    assert point_warnings(BLADE, np.zeros(2), np.ones(2), np.zeros(2)) == []


def test_scatter_and_missing_loads_are_no_unit_error() -> None:
    """Loads that err by a third, in both directions, and gaps among them."""
    rng = np.random.default_rng(5)
    omega, speed = rng.uniform(300.0, 800.0, 60), np.tile([0.0, 4.0, 8.0], 20)
    loads = {
        name: values * np.exp(0.3 * rng.standard_normal(60))
        for name, values in estimated_loads(BLADE, AIR, omega, speed).items()
    }
    loads["thrust"][::7] = np.nan
    loads["torque"] = np.full(60, np.nan)
    assert load_warnings(BLADE, AIR, omega, speed, 0.0 * speed, loads) == []
    nothing = {"thrust": np.full(3, np.nan), "drag": np.ones(3)}
    assert load_warnings(BLADE, AIR, OMEGA, STILL, STILL, nothing) == []
    assert load_warnings(BLADE, AIR, STILL, STILL, STILL, {"thrust": np.ones(3)}) == []


@pytest.mark.parametrize("name", ["thrust", "torque"])
def test_a_load_that_is_mostly_zero_is_named(name: str) -> None:
    loads = estimated_loads(BLADE, AIR, OMEGA, STILL)
    loads[name][:2] = 0.0
    (told,) = load_warnings(BLADE, AIR, OMEGA, STILL, STILL, loads)
    assert f"{name} is 0 times the estimate" in told


def test_a_single_row_of_another_sign_is_told() -> None:
    loads = estimated_loads(BLADE, AIR, OMEGA, STILL)
    assert load_warnings(BLADE, AIR, OMEGA, STILL, STILL, loads) == []
    loads["torque"][1] *= -1.0
    told = f"torque is negative in 1 of {OMEGA.size} rows at rest; check the sign"
    assert load_warnings(BLADE, AIR, OMEGA, STILL, STILL, loads) == [told]
    # Beyond the blade's pitch speed a windmill's loads are negative, and rightly so.
    loads["thrust"][1] *= -1.0
    speed = np.where(loads["torque"] < 0.0, 1.2 * pitch_ratio(BLADE) * OMEGA * BLADE.radius, 0.0)
    assert load_warnings(BLADE, AIR, OMEGA, speed, STILL, loads) == []


def test_loads_of_one_fast_speed_are_not_taken_for_edgewise_flow() -> None:
    """At three quarters of the pitch speed: 6 in of pitch and 8 in of diameter."""
    assert pitch_ratio(BLADE) == pytest.approx(6.0 / 8.0 / np.pi, rel=0.1)
    speed = np.full(3, 0.75 * pitch_ratio(BLADE) * 500.0 * BLADE.radius)
    omega = np.full(3, 500.0)
    loads = estimated_loads(BLADE, AIR, omega, speed)
    assert load_warnings(BLADE, AIR, omega, speed, 0.0 * speed, loads) == []


def test_more_power_in_the_air_than_on_the_shaft() -> None:
    loads = estimated_loads(BLADE, AIR, OMEGA, STILL)
    loads["thrust"], loads["torque"] = 1.8 * loads["thrust"], 0.5 * loads["torque"]
    with pytest.raises(InputError, match="times the shaft power"):
        load_warnings(BLADE, AIR, OMEGA, STILL, STILL, loads)
