"""Whatever is wrong with a log, the reader says so in one line with a remedy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import FlightLog
from propmap.vehicle.log_checks import check_recording
from propmap.vehicle.log_readers import read_flight_log, read_recording
from tests.flight.synthetic import NEUROBEM, vehicle_with

from .refusals import LOG, message_of
from .write_logs import write_bag, write_csv, write_ulog

VEHICLE = read_vehicle(NEUROBEM).vehicle


@pytest.mark.parametrize(
    ("file", "content", "parts"),
    [
        ("log.csv", b"", ["the file is empty", "give the log of a flight"]),
        ("log.csv", b"\n \n", ["log.csv"]),
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
    log = write_csv(LOG, tmp_path / "good.csv")
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
    ("topic", "remedy"),
    [
        ("vehicle_attitude", "SDLOG_PROFILE"),
        ("vehicle_local_position", "SDLOG_PROFILE"),
        (
            "esc_status or actuator_motors or actuator_outputs",
            "motor controllers with telemetry",
        ),
    ],
)
def test_a_ulog_without_a_topic(topic: str, remedy: str, tmp_path: Path) -> None:
    path = tmp_path / "a.ulg"
    vehicle_file = vehicle_with(
        write_ulog(LOG, path, VEHICLE, leave_out=(topic.split()[0],)), tmp_path
    )
    message = message_of(path, vehicle_file)
    assert f"a.ulg: no topic {topic}; found " in message and remedy in message
    assert "vehicle_acceleration" in message


def test_all_that_is_missing_is_named_at_once(tmp_path: Path) -> None:
    path = tmp_path / "a.ulg"
    missing = ("vehicle_attitude", "vehicle_angular_velocity", "vehicle_acceleration", "esc_status")
    log = write_ulog(LOG, path, VEHICLE, leave_out=(*missing, "sensor_combined"))
    message = message_of(path, vehicle_with(log, tmp_path))
    rates = "no vehicle_angular_velocity or sensor_combined"
    assert f"no topic vehicle_attitude, {rates}, no esc_status or actuator_motors" in message
    assert "vehicle_local_position" in message.partition("found")[2]
    log = write_bag(LOG, tmp_path / "bag", VEHICLE)
    log = log.replace('"/imu"', '"/imu_raw"').replace('"/odometry"', '"/odom"')
    message = message_of(tmp_path / "bag", vehicle_with(log, tmp_path))
    assert "no topic /odom, no /imu_raw; the bag has /imu (sensor_msgs/Imu), /odometry" in message
    assert "correct odometry, imu in [log.topics] of" in message


def test_a_ulog_cut_short_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    path = tmp_path / "a.ulg"
    vehicle_file = vehicle_with(write_ulog(LOG, path, VEHICLE), tmp_path)
    whole = path.read_bytes()
    # The topics are written one after the other: nothing of the last one is left.
    path.write_bytes(whole[: len(whole) // 3])
    assert "no topic" in message_of(path, vehicle_file)
    path.write_bytes(whole[:-40])
    assert len(read_flight_log(path, vehicle_file)) == len(LOG) - 1


def _with_rotors(count: int) -> FlightLog:
    speeds = np.tile(LOG.rotor_speed[:, :1], (1, count))
    return replace(LOG, rotor_speed=speeds)


def test_the_log_of_another_vehicle(tmp_path: Path) -> None:
    """The numbers of rotors differ: both are named."""
    six = replace(VEHICLE, mounts=VEHICLE.mounts + VEHICLE.mounts[:2])
    log = write_ulog(_with_rotors(6), tmp_path / "a.ulg", six)
    message = message_of(tmp_path / "a.ulg", vehicle_with(log, tmp_path))
    assert (
        "a.ulg: the log has 6 rotor speeds, of which 1, 2, 3, 4, 5, 6 are not always zer" in message
    )
    assert "the vehicle has 4 rotors; give one [[rotors]] table per rotor" in message
    log = write_bag(_with_rotors(6), tmp_path / "bag", six)
    message = message_of(tmp_path / "bag", vehicle_with(log, tmp_path))
    assert "the log has 6 rotor speeds" in message


@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [
        ('imu = "/imu"', 'imu = "/imu_raw"', ["no topic /imu_raw; the bag has /imu (sensor_msgs"]),
        ('imu = "/imu"', 'imu = "/imu_raw"', ["correct imu in [log.topics] of", "vehicle.toml"]),
        ('imu = "/imu"', 'imu = "/odometry"', ["of type nav_msgs/Odometry, expected sensor_msgs/"]),
        (
            'rotor_speed = "/rotor_speed"',
            "",
            ["a bag needs the topics", "rotor_speed", "add [log.topics]"],
        ),
        ('odometry = "/odometry"', "", ["odometry (or pose and velocity)"]),
        ('rotor_unit = "rad/s"', "", ["no rotor_unit", '"rad/s" or "rpm" or "erpm"']),
        (
            'rotor_speed = "/rotor_speed"',
            'rotor_speed = "/imu"',
            ["sensor_msgs/Imu with 3 arrays of numbers", "record the speeds as one of std_msgs/"],
        ),
        (
            'imu = "/imu"\n',
            "",
            ["the twist is in the world frame", 'add imu = "/..." to [log.topics]'],
        ),
    ],
)
def test_bad_bags(old: str, new: str, parts: list[str], tmp_path: Path) -> None:
    log = write_bag(LOG, tmp_path / "bag", VEHICLE)
    assert old in log
    log = log.replace(old, new)
    if parts[0].startswith("the twist"):
        log = log.replace("[log]\n", '[log]\nvelocity_in = "world"\n')
    message = message_of(tmp_path / "bag", vehicle_with(log, tmp_path))
    for part in parts:
        assert part in message


def test_a_twist_needs_its_frame(tmp_path: Path) -> None:
    log = write_bag(LOG, tmp_path / "bag", VEHICLE, odometry=False)
    log = log.replace('velocity_in = "world"\n', "")
    message = message_of(tmp_path / "bag", vehicle_with(log, tmp_path))
    assert "vehicle.toml: [log]: no velocity_in" in message


def test_a_gap_is_told_in_seconds_since_the_start(tmp_path: Path) -> None:
    """Bags have stamps since 1970, which say nothing when rounded."""
    part = LOG.picked((LOG.time < 0.9) | (LOG.time > 1.6))
    vehicle_file = vehicle_with(write_bag(part, tmp_path / "bag", VEHICLE), tmp_path)
    notes = check_recording(read_recording(tmp_path / "bag", vehicle_file))
    assert any("has no sample from 0.88 to 1.62 s, and this time is left" in note for note in notes)
    assert not any("e+09" in note for note in notes)


def test_signals_of_two_clocks(tmp_path: Path) -> None:
    """Rotor speeds recorded an hour after the rest, such as wall time against boot time."""
    from propmap.vehicle.log import Signal, common_clock

    time = np.arange(0.0, 5.0, 0.01)
    early, late = (Signal(n, t, t[:, None]) for n, t in (("attitude", time), ("rpm", time + 3600)))
    with pytest.raises(InputError, match=r"attitude ends at 4\.99 s, rpm begins at 3600 s"):
        common_clock([early, late], [], str(tmp_path))
    both = [replace(signal, time=signal.time + 1.7e9) for signal in (early, late)]
    with pytest.raises(InputError, match=r"attitude ends at 4\.99 s, rpm begins at 3600 s"):
        common_clock(both, [], str(tmp_path))
    with pytest.raises(InputError, match="the rate is 0"):
        common_clock([early], [], str(tmp_path), rate=0.0)
