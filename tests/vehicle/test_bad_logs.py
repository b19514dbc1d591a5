"""Every reader of logs names what is wrong with a file, and the remedy, in one line."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import Signal, common_clock
from propmap.vehicle.log_checks import check_recording
from propmap.vehicle.log_readers import read_flight_log, read_recording
from tests.flight.synthetic import NEUROBEM, vehicle_with

from .refusals import LOG, message_of
from .write_logs import csv_columns, write_bag
from .write_px4_log import write_ulog

VEHICLE = read_vehicle(NEUROBEM).vehicle


@pytest.mark.parametrize(
    ("file", "content", "parts"),
    [
        ("log.csv", b"", ["the file is empty", "give the log of a flight"]),
        ("log.csv", bytes(range(256)) * 9, ["log.csv"]),
        ("log.ulg", b"\x93\x11junk" * 99, ["log.ulg: not a ULog file", "original .ulg file"]),
        ("log.ulg", b"ULog\x01\x12\x35\x01" + b"\xff" * 99, ["log.ulg"]),
        ("log.mcap", b"\x93\x11junk" * 99, ["log.mcap: not a readable bag", "ROS 2 folder"]),
        ("log.db3", b"\x93\x11junk" * 99, ["log.db3: not a readable bag", "ROS 2 folder"]),
        ("log.bag", b"\x93\x11junk" * 99, ["log.bag: not a readable bag", "ROS 1 .bag"]),
        ("log.txt", b"t,x\n1,2\n", ["extension is '.txt'", ".csv, .parquet", "ROS 2 bag"]),
    ],
)
def test_junk(file: str, content: bytes, parts: list[str], tmp_path: Path) -> None:
    _, log = csv_columns(LOG)
    log += '[log.topics]\nodometry = "/odometry"\nrotor_speed = "/rotor_speed"\n'
    (tmp_path / file).write_bytes(content)
    message = message_of(tmp_path / file, vehicle_with(log, tmp_path))
    for part in parts:
        assert part in message


def test_no_file_and_no_bag(tmp_path: Path) -> None:
    vehicle_file = vehicle_with("", tmp_path)
    assert "no such file; check the path" in message_of(tmp_path / "a.ulg", vehicle_file)
    assert "has no metadata.yaml" in message_of(tmp_path, vehicle_file)


@pytest.mark.parametrize(
    ("leave_out", "missing", "remedy"),
    [
        (
            ("esc_status",),
            "esc_status or actuator_motors or actuator_outputs",
            "motor controllers with telemetry",
        ),
        (
            ("vehicle_attitude", "vehicle_angular_velocity", "sensor_combined", "esc_status"),
            "vehicle_attitude, no vehicle_angular_velocity or sensor_combined, no esc_status or ",
            "SDLOG_PROFILE",
        ),
    ],
)
def test_all_topics_that_a_ulog_lacks_are_named(
    leave_out: tuple[str, ...], missing: str, remedy: str, tmp_path: Path
) -> None:
    path = tmp_path / "a.ulg"
    log = write_ulog(LOG, path, VEHICLE, leave_out=leave_out)
    message = message_of(path, vehicle_with(log, tmp_path))
    assert f"a.ulg: no topic {missing}" in message and remedy in message
    assert "vehicle_acceleration" in message.partition("found")[2]


def test_damaged_definitions_of_a_ulog_are_located(tmp_path: Path) -> None:
    """pyulog 1.3 does not return from a definition of unknown kind beyond the end of the file."""
    path = tmp_path / "a.ulg"
    vehicle_file = vehicle_with(write_ulog(LOG, path, VEHICLE), tmp_path)
    whole, second = path.read_bytes(), 16 + 3 + 40
    assert whole[18:19] == b"B" and whole[second + 2 : second + 3] in b"FIP"
    for damaged in (whole[: second + 1] + b"\xff\x00" + whole[second + 3 :], whole[: second + 9]):
        path.write_bytes(damaged)
        message = message_of(path, vehicle_file)
        assert f"no complete definition begins at byte {second} of {len(damaged)}" in message
        assert "check the path" not in message and "original .ulg file" in message


def test_a_ulog_cut_short_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    path = tmp_path / "a.ulg"
    vehicle_file = vehicle_with(write_ulog(LOG, path, VEHICLE), tmp_path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 20])
    message_of(path, vehicle_file)
    path.write_bytes(whole[:-40])
    assert len(read_flight_log(path, vehicle_file)) == len(LOG) - 1


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A bag with a gap, and the ``[log]`` table for it."""
    folder = tmp_path_factory.mktemp("bags") / "bag"
    part = LOG.picked((LOG.time < 0.9) | (LOG.time > 1.6))
    return folder, write_bag(part, folder, VEHICLE)


@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [
        (
            'imu = "/imu"',
            'imu = "/imu_raw"',
            [
                "no topic /imu_raw; the bag has /imu (sensor_msgs/Imu), /odometry",
                "correct imu in [log.topics] of",
                "vehicle.toml",
            ],
        ),
        (
            'rotor_speed = "/rotor_speed"',
            "",
            ["a bag needs the topics", "rotor_speed", "add [log.topics]"],
        ),
        (
            'rotor_speed = "/rotor_speed"',
            'rotor_speed = "/imu"',
            ["sensor_msgs/Imu with 3 arrays of numbers", "record the speeds as one of std_msgs/"],
        ),
        (
            '[log.topics]\nimu = "/imu"\n',
            'velocity_in = "world"\n[log.topics]\n',
            ["the twist is in the world frame", 'add imu = "/..." to [log.topics]'],
        ),
    ],
)
def test_bad_topics_of_bags(
    old: str, new: str, parts: list[str], bag: tuple[Path, str], tmp_path: Path
) -> None:
    path, log = bag
    assert old in log
    message = message_of(path, vehicle_with(log.replace(old, new), tmp_path))
    for part in parts:
        assert part in message


def test_a_twist_needs_its_frame(tmp_path: Path) -> None:
    log = write_bag(LOG, tmp_path / "bag", VEHICLE, odometry=False)
    log = log.replace('velocity_in = "world"\n', "")
    message = message_of(tmp_path / "bag", vehicle_with(log, tmp_path))
    assert "vehicle.toml: [log]: no velocity_in" in message


def test_a_gap_is_told_in_seconds_since_the_start(bag: tuple[Path, str], tmp_path: Path) -> None:
    """Bags have stamps since 1970, which are useless when rounded."""
    path, log = bag
    notes = check_recording(read_recording(path, vehicle_with(log, tmp_path)))
    assert any("has no sample from 0.88 to 1.62 s, and this time is left" in note for note in notes)
    assert not any("e+09" in note for note in notes)


def test_signals_of_two_clocks() -> None:
    """Rotor speeds recorded an hour after the rest, such as wall time against boot time."""
    time = np.arange(0.0, 5.0, 0.01)
    early, late = (Signal(n, t, t[:, None]) for n, t in (("attitude", time), ("rpm", time + 3600)))
    for offset in (0.0, 1.7e9):
        both = [replace(signal, time=signal.time + offset) for signal in (early, late)]
        with pytest.raises(InputError, match=r"attitude ends at 4\.99 s, rpm begins at 3600 s"):
            common_clock(both, [], "log")
    with pytest.raises(InputError, match="the rate is 0"):
        common_clock([early], [], "log", rate=0.0)
