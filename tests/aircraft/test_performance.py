"""What is named on a power curve, missions, and tables in place of the rotor."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from propmap.aircraft.mission import EMPTY, Mission, fly, read_mission
from propmap.aircraft.performance import Performance, endurance, performance, rows, top_speed
from propmap.aircraft.trim import Aircraft
from propmap.errors import InputError
from propmap.units import RPM
from propmap.vehicle.powertrain import Motor, Powertrain
from propmap.vehicle.vehicle import Vehicle

from .conftest import aircraft_of


@pytest.fixture(scope="module")
def weak(vehicle: Vehicle) -> Aircraft:
    """One that is limited at a moderate speed, so that few states are needed."""
    return aircraft_of(vehicle, maximum_rotor_speed=720.0)


@pytest.fixture(scope="module")
def found(weak: Aircraft) -> Performance:
    return performance(weak, weak.steady([0.0, 12.0], margin=False))


def test_named_states(weak: Aircraft, found: Performance) -> None:
    assert found.hover is not None and found.least_power is not None
    assert found.best_range is not None and found.fastest is not None
    assert 0.0 < found.least_power.speed < found.best_range.speed <= found.fastest.speed
    beside = weak.steady(found.least_power.speed + np.array([-1.5, 0.0, 1.5]), margin=False).power
    assert beside[1] < beside[0] and beside[1] < beside[2]
    assert found.least_power.endurance > found.hover.endurance
    assert found.best_range.distance == pytest.approx(
        found.best_range.endurance * found.best_range.speed
    )
    ahead = performance(weak, found.states, wind=4.0)
    assert ahead.endurance == pytest.approx(found.endurance)
    assert ahead.distance == pytest.approx(found.endurance * (found.states.speed - 4.0))
    assert ahead.best_range is not None and ahead.best_range.speed > found.best_range.speed


def test_the_best_range_is_the_largest_distance_or_the_least_energy(vehicle: Vehicle) -> None:
    """In a headwind near the top speed, the battery voltage ends the fastest flights at once."""
    craft = aircraft_of(vehicle)
    without = replace(vehicle.powertrain, battery=None)
    electrical = aircraft_of(replace(vehicle, powertrain=without), maximum_rotor_speed=720.0)
    end = performance(craft, craft.steady([0.0, 12.0], margin=False)).fastest
    assert end is not None
    for one, wind in ((craft, 0.75 * end.speed), (electrical, 0.0)):
        states = one.steady([0.0, 12.0], margin=False)
        best = performance(one, states, wind=wind).best_range
        assert best is not None
        speed = best.speed + np.array([-0.4, 0.0, 0.4])
        beside = one.steady(speed, margin=False)
        if one is craft:
            merit = endurance(one, beside) * (speed - wind)
            assert best.distance == pytest.approx(merit[1]) and best.speed < 0.99 * end.speed
        else:
            merit = speed / beside.power
        assert merit[1] > merit[0] and merit[1] > merit[2]


def test_the_top_speed_is_the_same_for_requested_speeds_above_it(
    weak: Aircraft, found: Performance
) -> None:
    above = performance(weak, weak.steady([60.0, 70.0], margin=False))
    assert above.fastest is not None and found.fastest is not None
    assert above.fastest.speed == pytest.approx(found.fastest.speed, rel=2e-3)
    assert above.hover is not None and found.hover is not None
    assert above.hover.power == pytest.approx(found.hover.power) and above.limit == found.limit


def test_top_speed_is_at_its_limit(weak: Aircraft, found: Performance) -> None:
    assert found.fastest is not None and found.limit == "rpm_limit"
    edge = weak.steady(found.fastest.speed * np.array([1.0, 1.002]), margin=False)
    assert edge.status.tolist() == ["ok", "rpm_limit"]
    assert edge.used["rpm_limit"][0] == pytest.approx(1.0, abs=1e-3)
    limited = rows(edge)[1]
    assert limited["rpm_1"] is None and limited["thrust_4_N"] is None
    assert not any(isinstance(v, float) and math.isnan(v) for v in limited.values())
    with pytest.raises(InputError, match="must increase"):
        performance(weak, weak.steady([5.0, 5.0], margin=False))


def test_electrical_power_is_shaft_power_and_losses(aircraft: Aircraft, vehicle: Vehicle) -> None:
    states = aircraft.steady([0.0, 10.0], margin=False)
    assert states.shaft_power == pytest.approx(
        np.sum(states.torque * states.rotor_speed, axis=1), rel=1e-12
    )
    current = states.motor_current
    kv = vehicle.powertrain.motor.speed_constant
    lost = (0.12 + 0.01) * current**2 + 0.6 * states.rotor_speed / kv
    assert states.electrical_power == pytest.approx(
        states.shaft_power + lost.sum(axis=1) + 5.0, rel=1e-12
    )
    assert states.battery_current * states.battery_voltage == pytest.approx(
        states.electrical_power, rel=1e-12
    )
    unpowered = aircraft_of(replace(vehicle, powertrain=Powertrain()))
    states = unpowered.steady([0.0], margin=False)
    assert np.isnan(states.electrical_power).all() and np.isnan(states.throttle).all()
    assert states.power == pytest.approx(states.shaft_power)
    assert np.isnan(endurance(unpowered, states)).all()


def test_limits_of_the_model_are_no_margin_and_no_top_speed(vehicle: Vehicle) -> None:
    """Without a limit of the motors, the fastest blade tip ends the power curve."""
    motor = Motor(920.0 * RPM, 0.12, (0.6,), (10.0,))
    for drive in (Powertrain(), Powertrain(motor)):
        craft = aircraft_of(replace(vehicle, powertrain=drive))
        states = craft.steady([0.0, 12.0, 100.0])
        assert states.status.tolist() == ["ok", "ok", "tip_speed_limit"]
        assert np.isnan(states.thrust_margin).all() and craft.notes
        found = performance(craft, states)
        assert found.fastest is None and found.limit == "unknown"
        speed, limit = top_speed(craft, states, 0.0)
        assert math.isnan(speed) and limit == "unknown"
        assert found.hover is not None and found.best_range is not None
        assert 5.0 < found.best_range.speed < 40.0
    limits: dict[str, Motor] = {
        "rpm": replace(motor, maximum_speed=900.0),
        "current": replace(motor, maximum_current=20.0),
    }
    for name, limited in limits.items():
        craft = aircraft_of(replace(vehicle, powertrain=Powertrain(limited)))
        states = craft.steady([0.0, 12.0])
        assert (states.thrust_margin > 1.0).all() and craft.notes == [], name
        assert top_speed(craft, states, 0.0)[0] > 12.0
    heavy = aircraft_of(replace(vehicle, powertrain=Powertrain(), mass=60.0))
    none = performance(heavy, heavy.steady([0.0, 12.0]))
    assert none.fastest is None and none.limit in ("tip_speed_limit", "no_trim")


def test_charge_over_time_is_the_current_s_integral(aircraft: Aircraft) -> None:
    """Small steps of the current at the power of each leg, which share only that current."""
    legs = Mission(np.array([0.0, 10.0]), np.array([1.0, 0.0]), np.array([60.0, 240.0]))
    flown = fly(aircraft, legs)
    assert flown.status.tolist() == ["ok", "ok"]
    assert flown.energy == pytest.approx(flown.states.electrical_power * legs.duration)
    battery = aircraft.vehicle.powertrain.battery
    assert battery is not None
    charge, wanted = 1.0, []
    for power, duration in zip(flown.states.electrical_power, legs.duration, strict=True):
        for _ in range(int(duration)):
            charge -= float(battery.current(power, np.array(charge))) / battery.capacity
        wanted.append(charge)
    assert flown.charge == pytest.approx(wanted, abs=1e-4)
    course = flown.course
    assert course.time[1, 0] == course.time[0, -1] == 60.0 and course.time[-1, -1] == 300.0
    assert course.charge[1, 0] == course.charge[0, -1]
    assert (np.diff(course.charge, axis=1) < 0.0).all()
    emptied = fly(aircraft, Mission(np.zeros(2), np.zeros(2), np.array([3600.0, 60.0])))
    assert emptied.status.tolist() == [EMPTY, "not_reached"] and np.isnan(emptied.charge).all()
    assert np.nanmin(emptied.course.charge) >= 0.2 and not emptied.lasted.any()


def test_a_mission_ends_where_the_voltage_is_too_low(vehicle: Vehicle) -> None:
    """Four cells are 16.4 V when full and below 15 soon: a motor that needs 14.8 stops."""
    motor = vehicle.powertrain.motor
    assert motor is not None
    slow = replace(vehicle.powertrain, motor=replace(motor, speed_constant=45.0))
    craft = aircraft_of(replace(vehicle, powertrain=slow))
    flown = fly(craft, Mission(np.zeros(2), np.zeros(2), np.array([60.0, 1080.0])))
    assert flown.states.found.all()
    assert flown.status.tolist() == ["ok", "voltage_limit"]
    assert flown.lasted.tolist() == [True, False]
    needed = flown.states.throttle[1].max() * flown.states.battery_voltage[1]
    there = flown.course.voltage[1]
    assert np.nanmin(there) >= needed and np.isnan(there[-1])


BAD_MISSIONS = {
    "text": ("speed_mps,climb_mps,duration_s\nfast,0,10\n", "line 2"),
    "no duration": ("speed_mps,climb_mps,duration_s\n5,0,0\n", "duration_s is 0"),
    "a negative speed": ("speed_mps,climb_mps,duration_s\n-5,0,10\n", "positive"),
}


@pytest.mark.parametrize("case", BAD_MISSIONS)
def test_bad_missions(case: str, tmp_path: Path) -> None:
    text, told = BAD_MISSIONS[case]
    path = tmp_path / "legs.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=told) as error:
        read_mission(path)
    assert "legs.csv" in str(error.value)
