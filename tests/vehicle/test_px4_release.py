"""A flight in the layout of PX4 1.15 and 1.16, as CSV and as bag: the same log, all six axes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from propmap.typing import Floats
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import FlightLog, low_passed
from propmap.vehicle.log_checks import check_recording
from propmap.vehicle.log_readers import read_flight_log, read_recording
from propmap.vehicle.throttle import lagged
from tests.flight.commands import commands
from tests.flight.synthetic import NEUROBEM, flight, vehicle_with

from .refusals import message_of
from .write_logs import write_bag, write_csv
from .write_px4_log import topics_of, write_px4_log

VEHICLE = read_vehicle(NEUROBEM).vehicle
LOG = flight(rate=200.0).picked(slice(700, 1900))
"""Six seconds: at 3 m/s, and on to 6 m/s."""

RATES = {
    "vehicle_attitude": 2,
    "vehicle_local_position": 4,
    "esc_status": 2,
    "actuator_motors": 20,
    "actuator_outputs": 20,
}
"""One of so many samples: attitude and rotor speeds at 100 Hz, velocity at 50, the IMU at 200."""

OFF = {
    "velocity": 0.002,
    "rates": 0.003,
    "up": 0.0005,
    "specific_force": 0.03,
    "rotor_speed": 0.2,
    "angular_acceleration": 0.01,
    "specific_force_rate": 0.2,
}
"""By how much low-passed logs may differ: of a vibration of 3 m/s^2 (0.3 rad/s) a hundredth is
left, and where it is differentiated, by the low-pass at 6 Hz alone, somewhat more."""


def shaken(log: FlightLog, frequency: float, size: float) -> FlightLog:
    """The log with a vibration [Hz] in what IMU and motor controllers measure."""
    wave = np.sin(2.0 * np.pi * frequency * log.time)[:, None]
    return replace(
        log, specific_force=log.specific_force + size * wave, rates=log.rates + 0.1 * size * wave
    )


def read_px4(tables: dict[str, Any], folder: Path) -> FlightLog:
    write_px4_log(tables, folder / "a.ulg")
    return read_flight_log(folder / "a.ulg", vehicle_with("", folder))


def at(log: FlightLog, name: str, when: Floats) -> Floats:
    columns = getattr(log, name).T
    return np.stack([np.interp(when, log.time - log.time[0], column) for column in columns], axis=1)


def test_the_three_formats_give_the_same_low_passed_log(tmp_path: Path) -> None:
    """Each topic on a clock of its own, shaken at 61 Hz: as if all had been sampled alike."""
    log = shaken(LOG, 61.0, 3.0)
    found = {"ulg": read_px4(topics_of(log, RATES), tmp_path)}
    table = write_csv(log, tmp_path / "a.csv")
    found["csv"] = read_flight_log(tmp_path / "a.csv", vehicle_with(table, tmp_path))
    table = write_bag(log, tmp_path / "bag", VEHICLE, every={"/odometry": 4, "/rotor_speed": 2})
    found["bag"] = read_flight_log(tmp_path / "bag", vehicle_with(table, tmp_path))
    assert {name: round(1.0 / np.diff(each.time).mean()) for name, each in found.items()} == {
        "ulg": 50,
        "csv": 200,
        "bag": 50,
    }
    truth = low_passed(LOG)
    when = np.linspace(0.5, 5.4, 200)
    for form, each in found.items():
        passed = low_passed(each)
        for name, off in OFF.items():
            seen, wanted = at(passed, name, when), at(truth, name, when)
            np.testing.assert_allclose(seen, wanted, rtol=0, atol=off, err_msg=f"{form} {name}")


def test_the_accelerometer_of_sensor_combined_has_a_time_of_its_own(tmp_path: Path) -> None:
    tables = topics_of(LOG, {})
    del tables["vehicle_acceleration"], tables["vehicle_angular_velocity"]
    read = read_px4(tables, tmp_path)
    inner = slice(2, -2)
    wanted = at(LOG, "specific_force", read.time - LOG.time[0] - 1.0)
    np.testing.assert_allclose(read.specific_force[inner], wanted[inner], atol=2e-4)
    tables["sensor_combined"]["accelerometer_timestamp_relative"][300:320] = 2**31 - 1
    again = read_px4(tables, tmp_path)
    np.testing.assert_allclose(again.specific_force, read.specific_force, atol=0.01)


def test_motors_are_numbered_as_their_controllers_without_functions(tmp_path: Path) -> None:
    tables = topics_of(LOG, {}, order=(3, 1, 4, 2))
    tables["esc_status"]["esc"]["actuator_function"] = 0
    read = read_px4(tables, tmp_path)
    np.testing.assert_allclose(read.rotor_speed, LOG.rotor_speed[:, [2, 0, 3, 1]], atol=0.06)


def test_slots_of_other_outputs_are_left_out(tmp_path: Path) -> None:
    """Eight slots, four of motors, wired across each other; one note says what is not read."""
    tables = topics_of(LOG, {}, order=(None, 3, 1, None, 4, 2, None, None))
    read = read_px4(tables, tmp_path)
    np.testing.assert_allclose(read.rotor_speed, LOG.rotor_speed, atol=0.06)
    recording = read_recording(tmp_path / "a.ulg", vehicle_with("", tmp_path))
    (note,) = [text for text in check_recording(recording) if "esc_status has" in text]
    assert "esc_status has 8 slots; those of motors 1 to 4 are read" in note
    assert note.endswith("slots of no motor are left out: 1, 4, 7, 8")


@pytest.mark.parametrize("output", ["UAVCAN_EC_FUNC", "PWM_AUX_FUNC"])
def test_parameters_say_what_outputs_turn(output: str, tmp_path: Path) -> None:
    """Where esc_status does not; servos, whose functions are from 201, are no motors."""
    order = (3, None, 1, 4, 2, None)
    tables = topics_of(LOG, {}, order=order)
    tables["esc_status"]["esc"]["actuator_function"] = 0
    turned = {f"{output}{k}": 100 + n if n else 201 for k, n in enumerate(order, start=1)}
    write_px4_log(tables, tmp_path / "a.ulg", turned)
    read = read_flight_log(tmp_path / "a.ulg", vehicle_with("", tmp_path))
    np.testing.assert_allclose(read.rotor_speed, LOG.rotor_speed, atol=0.06)


def test_slots_that_nothing_tells_apart_are_an_error(tmp_path: Path) -> None:
    tables = topics_of(LOG, {}, order=(None, 3, 1, None, 4, 2))
    tables["esc_status"]["esc"]["actuator_function"] = 0
    write_px4_log(tables, tmp_path / "a.ulg")
    message = message_of(tmp_path / "a.ulg", vehicle_with("", tmp_path))
    assert "the log has 6 rotor speeds, of which 2, 3, 5, 6 are not always zero; the" in message
    assert "the vehicle has 4 rotors; give one [[rotors]] table per rotor" in message
    assert "configure the autopilot's motor outputs, or save as CSV" in message


def test_velocities_that_are_not_valid_are_left_out(tmp_path: Path) -> None:
    tables = topics_of(LOG, {})
    place = tables["vehicle_local_position"]
    place["v_xy_valid"][:400], place["vx"][:400] = False, 1e3
    read = read_px4(tables, tmp_path)
    assert len(read) == len(LOG) - 400
    np.testing.assert_allclose(read.velocity, LOG.velocity[400:], atol=1e-5)
    place["v_z_valid"] = False
    write_px4_log(tables, tmp_path / "a.ulg")
    message = message_of(tmp_path / "a.ulg", vehicle_with("", tmp_path))
    assert "marks all 1200 samples of its velocity as not valid; fly with" in message


@pytest.mark.parametrize("topic", ["actuator_motors", "actuator_outputs"])
def test_commands_are_read_in_place_of_rotor_speeds(topic: str, tmp_path: Path) -> None:
    driven = commands(LOG)
    tables = topics_of(LOG, RATES, order=(None, 3, 1, None, 4, 2), driven=driven)
    del tables["esc_status"]
    if topic == "actuator_outputs":
        del tables["actuator_motors"]
    functions = {f"PWM_MAIN_FUNC{k}": 100 + m for k, m in ((2, 3), (3, 1), (5, 4), (6, 2))}
    write_px4_log(tables, tmp_path / "a.ulg", functions)
    read = read_flight_log(tmp_path / "a.ulg", vehicle_with("", tmp_path))
    assert read.commanded and np.array_equal(read.rotor_speed, read.throttle)
    worth = driven.share * driven.voltage[:, None]
    expected, _ = lagged(worth, float(LOG.time[1]))
    later = read.time > read.time[0] + 1.0  # armed for longer than the lag
    stamps = LOG.time + 1.0
    for k in range(4):
        held = np.interp(read.time[later], stamps, expected[:, k])
        assert read.throttle[later, k] == pytest.approx(held, rel=5e-3)
