"""Logs of ArduPilot: which messages are read, which outputs are motors, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from propmap.vehicle.log_checks import check_recording
from propmap.vehicle.log_readers import read_flight_log, read_recording
from propmap.vehicle.throttle import lagged
from tests.flight.commands import commands
from tests.flight.synthetic import vehicle_with

from .refusals import LOG, message_of
from .write_dataflash import write_dataflash


@pytest.mark.parametrize(
    "outputs",
    [
        {1: 3, 2: 1, 3: 4, 4: 2},
        {9: 3, 10: 1, 11: 4, 12: 2},  # behind the coprocessor's eight
        {1: None, 2: 3, 3: 1, 4: None, 5: 4, 6: 2},
    ],
)
def test_motors_are_told_by_their_function(outputs: dict[int, int | None], tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    here = vehicle_with(write_dataflash(LOG, path, outputs=outputs), tmp_path)
    read = read_flight_log(path, here)
    np.testing.assert_allclose(read.rotor_speed, LOG.rotor_speed, rtol=1e-6)
    notes = [note for note in check_recording(read_recording(path, here)) if "left out" in note]
    servos = [k for k, motor in outputs.items() if motor is None]
    assert len(notes) == bool(servos)
    assert all("ESC has 6 instances" in note and "left out: 0, 3" in note for note in notes)


def test_commands_are_read_where_there_are_no_speeds(tmp_path: Path) -> None:
    """The second battery is off, and pulses are whole microseconds."""
    path, driven = tmp_path / "a.bin", commands(LOG)
    outputs = {1: None, 2: 3, 3: 1, 4: None, 5: 4, 6: 2}
    table = write_dataflash(LOG, path, leave_out=("ESC",), outputs=outputs, driven=driven)
    read = read_flight_log(path, vehicle_with(table, tmp_path))
    expected, _ = lagged(driven.share * driven.voltage[:, None], 0.02)
    assert read.commanded
    np.testing.assert_allclose(read.throttle, expected, rtol=2e-3)


@pytest.mark.parametrize("speeds", ["ESC", "RPM"])
def test_electrical_rpm_are_divided_by_the_pole_pairs(speeds: str, tmp_path: Path) -> None:
    path = tmp_path / "a.BIN"
    write_dataflash(replace(LOG, rotor_speed=7.0 * LOG.rotor_speed), path, speeds=speeds)
    here = vehicle_with('[log]\nrotor_unit = "erpm"\npole_pairs = 7\n', tmp_path)
    read = read_flight_log(path, here)
    np.testing.assert_allclose(read.rotor_speed, LOG.rotor_speed, rtol=1e-6)


def test_a_controller_that_falls_silent_leaves_a_gap(tmp_path: Path) -> None:
    """What the others report meanwhile is no speed of its own, and nothing is put in its place."""
    path = tmp_path / "a.bin"
    here = vehicle_with(write_dataflash(LOG, path, silent=(3, 0.99, 1.61)), tmp_path)
    read = read_flight_log(path, here)
    assert not np.any((read.time - 1.0 > 0.99) & (read.time - 1.0 < 1.61))
    (note,) = [n for n in check_recording(read_recording(path, here)) if "no sample" in n]
    assert "rotor speed (ESC) has no sample from 0.98 to 1.62 s" in note


def test_all_that_is_missing_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    table = write_dataflash(LOG, path, leave_out=("ATT", "XKF1", "ESC", "RCOU"))
    message = message_of(path, vehicle_with(table, tmp_path))
    missing = "no message ATT or AHR2, no XKF1 or NKF1, no ESC or RPM or RCOU; found IMU"
    assert f"a.bin: {missing}" in message and "set LOG_BITMASK to log the missing" in message


@pytest.mark.parametrize("content", [b"\x93\x11junk" * 99, b"\xa3\x95\x80" * 99])
def test_junk_is_refused(content: bytes, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.bin").write_bytes(content)
    message = message_of(tmp_path / "a.bin", vehicle_with("", tmp_path))
    assert "a.bin: not a DataFlash log: " in message and "original .bin file of" in message
    assert capfd.readouterr() == ("", "")


def test_a_log_cut_short_or_damaged_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    here = vehicle_with(write_dataflash(LOG, path), tmp_path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] + bytes(300))
    assert 50 < len(read_flight_log(path, here)) < 62
    middle = 2 * len(whole) // 3
    path.write_bytes(whole[:middle] + bytes(300) + whole[middle + 300 :])
    assert len(read_flight_log(path, here)) > 110
