"""Motor, controller and battery: energy is kept, and what no data sheet says is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.powertrain import (
    RPM,
    Battery,
    Motor,
    Powertrain,
    SpeedController,
    cell_voltage,
)

MOTOR = Motor(920.0 * RPM, 0.12, (0.6,), (10.0,))
BATTERY = Battery(4, 5.0 * 3600.0, 0.02)

BASE = """schema = 1
name = "quad"
frame = "flu"
mass = 1.2
propeller = "apc-8x6e"
[[rotors]]
position = [0.16, -0.16, 0.0]
spin = "ccw"
"""
MOTOR_TABLE = """[motor]
kv_rpm_per_volt = 920
resistance = 0.12
no_load_current = 0.6
"""
BATTERY_TABLE = """[battery]
cells = 4
capacity_mAh = 5000
"""


def test_a_motor_keeps_energy() -> None:
    torque, omega = np.array([0.0, 0.1, 0.3]), np.array([300.0, 600.0, 900.0])
    state = MOTOR.driven(torque, omega)
    # Into the shaft, the winding, and the no-load loss i_0 omega/Kv.
    lost = MOTOR.resistance * state.current**2 + 0.6 * omega / MOTOR.speed_constant
    assert state.power == pytest.approx(torque * omega + lost, rel=1e-12)
    # At 10 V without load, the speed is that of Kv less the drop of 0.6 A on the winding.
    free = MOTOR.speed_constant * (10.0 - 0.6 * 0.12)
    state = MOTOR.driven(np.zeros(1), np.array([free]))
    assert state.voltage == pytest.approx(10.0) and state.current == pytest.approx(0.6)
    hot = replace(MOTOR, temperature=100.0)
    assert hot.hot_resistance == pytest.approx(0.12 * (1.0 + 0.00393 * 80.0))


def test_no_load_currents_are_met() -> None:
    volts, amps = np.array([10.0, 14.0, 18.0]), np.array([0.5, 0.62, 0.8])
    for count in (2, 3):
        motor = Motor(90.0, 0.1, tuple(amps[:count]), tuple(volts[:count]))
        omega = 90.0 * (volts[:count] - amps[:count] * 0.1)
        assert motor.idle_current(omega) == pytest.approx(amps[:count])


def test_a_controller_loses() -> None:
    state = MOTOR.driven(np.array([0.2]), np.array([600.0]))
    assert SpeedController().power(state) == pytest.approx(state.power)
    lossy = SpeedController(resistance=0.02).power(state)
    assert lossy - state.power == pytest.approx(0.02 * state.current**2)
    assert SpeedController(efficiency=0.9).power(state) == pytest.approx(state.power / 0.9)


def test_a_battery_delivers_its_power() -> None:
    power, charge = np.array([0.0, 50.0, 400.0]), np.array([1.0, 0.6, 0.3])
    current, voltage = BATTERY.current(power, charge), BATTERY.voltage(power, charge)
    assert current * voltage == pytest.approx(power)
    assert voltage == pytest.approx(4.0 * cell_voltage(charge) - 0.02 * current)
    # The most that it can: half of the open-circuit voltage on the resistance.
    full = 4.0 * cell_voltage(np.ones(1))
    most = full**2 / (4.0 * 0.02)
    assert np.isfinite(BATTERY.current(0.999 * most, np.ones(1)))
    assert np.isnan(BATTERY.current(1.001 * most, np.ones(1)))
    assert BATTERY.share_used(most, np.ones(1)) == pytest.approx(1.0)


def test_cells_fall_with_their_charge() -> None:
    charge = np.linspace(0.0, 1.0, 101)
    voltage = cell_voltage(charge)
    assert (np.diff(voltage) > 0.0).all()
    assert 4.05 < voltage[-1] < 4.2 and 3.6 < voltage[50] < 3.9


def test_endurance_is_charge_over_current() -> None:
    """A reference by small steps, which shares the current alone."""
    power, charge, time = np.array(160.0), 1.0, 0.0
    while charge > 0.2:
        charge -= float(BATTERY.current(power, np.array(charge))) / BATTERY.capacity
        time += 1.0
    found = BATTERY.endurance(np.array([160.0]), np.array([0.0]))
    assert found == pytest.approx(time, rel=2e-3)
    after = BATTERY.charge_after(power, float(found[0]), np.array(1.0))
    assert after == pytest.approx(0.2, abs=1e-6)
    assert np.isnan(BATTERY.charge_after(np.array(200.0), 7200.0, np.array(1.0)))
    # Energy drawn at the terminals and lost inside is what the open-circuit voltage gave.
    assert 0.75 < 160.0 * found[0] / (5.0 * 3600.0 * 14.8) < 0.85


def test_endurance_ends_where_the_voltage_is_too_low() -> None:
    power = np.full(3, 160.0)
    times = BATTERY.endurance(power, np.array([0.0, 15.0, 16.5]))
    assert times[0] > times[1] > 0.0 and np.isnan(times[2])
    end = BATTERY.charge_after(power[1], float(times[1]), np.array(1.0))
    assert BATTERY.voltage(power[1], end) == pytest.approx(15.0, abs=1e-4)


def test_the_file(tmp_path: Path) -> None:
    path = tmp_path / "quad.toml"
    esc = "[esc]\nefficiency = 0.95\n"
    path.write_text(BASE + MOTOR_TABLE + esc + BATTERY_TABLE, encoding="utf-8")
    found = read_vehicle(path).vehicle.powertrain
    assert found.motor == Motor(920.0 * RPM, 0.12, (0.6,))
    assert found.controller == SpeedController(efficiency=0.95)
    assert found.battery == Battery(4, 18000.0)
    path.write_text(BASE, encoding="utf-8")
    assert read_vehicle(path).vehicle.powertrain == Powertrain()


def changed(table: str, key: str, value: str) -> str:
    lines = [line for line in table.splitlines() if not line.startswith(f"{key} ")]
    return "\n".join([*lines, f"{key} = {value}", ""])


BAD = {
    "kv in rad/s/V": (changed(MOTOR_TABLE, "kv_rpm_per_volt", "96.3") + BATTERY_TABLE, "9.549"),
    "resistance in milliohms": (changed(MOTOR_TABLE, "resistance", "120"), "milliohms"),
    "no-load currents without voltages": (
        changed(MOTOR_TABLE, "no_load_current", "[0.5, 0.7]"),
        "voltage for each",
    ),
    "no-load voltage in millivolts": (MOTOR_TABLE + "no_load_voltage = 0.01\n", "milliohms"),
    "winding in kelvin": (MOTOR_TABLE + "winding_temperature = 353\n", "-60 to 250"),
    "esc with both": (
        MOTOR_TABLE + "[esc]\nresistance = 0.01\nefficiency = 0.95\n",
        "resistance or efficiency",
    ),
    "esc in percent": (MOTOR_TABLE + "[esc]\nefficiency = 95\n", "fraction from 0.5 to 1"),
    "esc without motor": ("[esc]\nresistance = 0.01\n", r"no \[motor\]"),
    "half a cell": (MOTOR_TABLE + changed(BATTERY_TABLE, "cells", "3.7"), "in series"),
    "capacity in A h": (MOTOR_TABLE + changed(BATTERY_TABLE, "capacity_mAh", "5"), "5000"),
    "kv far too large": (
        changed(MOTOR_TABLE, "kv_rpm_per_volt", "92000") + BATTERY_TABLE,
        "another motor",
    ),
    "battery without cells": (MOTOR_TABLE + "[battery]\ncapacity_mAh = 5000\n", "no cells"),
    "maximum current of 0": (MOTOR_TABLE + "maximum_current = 0\n", "above 0"),
    "usable share in percent": (MOTOR_TABLE + BATTERY_TABLE + "usable_share = 80\n", "not percent"),
    "battery in milliohms": (MOTOR_TABLE + BATTERY_TABLE + "resistance = 20\n", "milliohms"),
    "power drawn negative": (MOTOR_TABLE + BATTERY_TABLE + "auxiliary_power = -5\n", "0 or more"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_wrong_is_said(case: str, tmp_path: Path) -> None:
    text, told = BAD[case]
    path = tmp_path / "quad.toml"
    path.write_text(BASE + text, encoding="utf-8")
    with pytest.raises(InputError, match=told) as error:
        read_vehicle(path)
    assert "\n" not in str(error.value) and "quad.toml" in str(error.value)
