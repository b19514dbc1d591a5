"""One flight through every file format: read back, all give the same log and points."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from propmap.flight.steady import operating_points, steady_segments
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import FlightLog
from propmap.vehicle.log_readers import read_flight_log
from tests.flight.synthetic import NEUROBEM, SPEEDS, flight, vehicle_with

from .write_dataflash import write_dataflash
from .write_logs import START, csv_columns, write_bag, write_csv, write_ulog

LOG = flight()
VEHICLE = read_vehicle(NEUROBEM).vehicle
Write = Callable[[Path], str]

FORMATS: dict[str, tuple[str, float, Write]] = {
    "csv": ("a.csv", 0.0, lambda path: write_csv(LOG, path)),
    "csv, frd and ned": (
        "a.csv",
        0.0,
        lambda path: write_csv(LOG, path, body_frame="frd", world_frame="ned", velocity_in="world"),
    ),
    "csv, frd and enu, angles, rpm": (
        "a.csv",
        0.0,
        lambda path: write_csv(LOG, path, body_frame="frd", angles=True, rotor_unit="rpm"),
    ),
    "csv, world velocity, angles, erpm": (
        "a.csv",
        0.0,
        lambda path: write_csv(
            LOG, path, velocity_in="world", angles=True, rotor_unit="erpm", pole_pairs=7
        ),
    ),
    "ulog": ("a.ulg", 1.0, lambda path: write_ulog(LOG, path, VEHICLE)),
    "ulog, sensor_combined, erpm": (
        "a.ulg",
        1.0,
        lambda path: write_ulog(
            LOG,
            path,
            VEHICLE,
            pole_pairs=7,
            leave_out=("vehicle_angular_velocity", "vehicle_acceleration"),
        ),
    ),
    "dataflash": ("a.bin", 1.0, lambda path: write_dataflash(LOG, path)),
    "ros 2, sqlite": ("bag", START, lambda path: write_bag(LOG, path, VEHICLE)),
    "ros 2, mcap, joint states": (
        "bag",
        START,
        lambda path: write_bag(
            LOG, path, VEHICLE, storage="mcap", rotor_type="sensor_msgs/msg/JointState"
        ),
    ),
    "ros 2, pose and twist": (
        "bag",
        START,
        lambda path: write_bag(LOG, path, VEHICLE, odometry=False),
    ),
    "ros 1": ("a.bag", START, lambda path: write_bag(LOG, path, VEHICLE, storage="ros1")),
}


@pytest.mark.parametrize("name", FORMATS)
def test_a_log_is_read_as_it_was_written(name: str, tmp_path: Path) -> None:
    file, start, write = FORMATS[name]
    vehicle_file = vehicle_with(write(tmp_path / file), tmp_path)
    read = read_flight_log(tmp_path / file, vehicle_file)
    assert "dropped" not in read.source
    assert_same(read, LOG, start)
    points = operating_points(read, steady_segments(read))
    own = operating_points(LOG, steady_segments(LOG))
    assert_same(points, own, start)


def assert_same(read: FlightLog, wanted: FlightLog, start: float) -> None:
    # ULog holds microseconds, float32 and whole rpm; bags nanoseconds since 1970 in a float64.
    assert read.time.size == wanted.time.size
    np.testing.assert_allclose(read.time - start, wanted.time, rtol=0, atol=2e-6)
    for name, tolerance in (("velocity", 1e-5), ("rates", 1e-6), ("up", 1e-6)):
        np.testing.assert_allclose(
            getattr(read, name), getattr(wanted, name), rtol=0, atol=tolerance, err_msg=name
        )
    np.testing.assert_allclose(read.specific_force, wanted.specific_force, rtol=0, atol=1e-5)
    np.testing.assert_allclose(read.rotor_speed, wanted.rotor_speed, rtol=0, atol=0.06)


def test_an_mcap_file_is_read_without_its_folder(tmp_path: Path) -> None:
    vehicle_file = vehicle_with(write_bag(LOG, tmp_path / "bag", VEHICLE, storage="mcap"), tmp_path)
    (file,) = (tmp_path / "bag").glob("*.mcap")
    assert_same(read_flight_log(file, vehicle_file), LOG, START)


def test_another_message_with_one_array_and_no_imu(tmp_path: Path) -> None:
    """Whole rad/s in a type without a name of its own; rates then come from the odometry."""
    part = LOG.picked(slice(600, 700))
    log = write_bag(part, tmp_path / "bag", VEHICLE, rotor_type="std_msgs/msg/Int32MultiArray")
    vehicle_file = vehicle_with(log.replace('imu = "/imu"\n', ""), tmp_path)
    read = read_flight_log(tmp_path / "bag", vehicle_file)
    np.testing.assert_allclose(read.rotor_speed, part.rotor_speed, atol=0.5)
    np.testing.assert_allclose(read.rates, part.rates, atol=1e-9)
    assert np.isnan(read.specific_force).all()


def test_parquet(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    import pandas as pd

    columns, table = csv_columns(LOG)
    pd.DataFrame(columns).to_parquet(tmp_path / "a.parquet")
    assert_same(read_flight_log(tmp_path / "a.parquet", vehicle_with(table, tmp_path)), LOG, 0.0)


def test_each_speed_is_one_operating_point() -> None:
    points = operating_points(LOG, steady_segments(LOG))
    # A segment may reach into the change of speed by as much as the band allows.
    np.testing.assert_allclose(points.speed, SPEEDS, rtol=0, atol=0.15)
    np.testing.assert_allclose(np.linalg.norm(points.up, axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(points.climb_rate, 0.0, atol=0.02)


def test_rotor_order_says_which_rotor_a_column_is(tmp_path: Path) -> None:
    table = write_csv(LOG, tmp_path / "a.csv")
    table = table.replace("[log]\n", "[log]\nrotor_order = [3, 1, 2, 4]\n")
    read = read_flight_log(tmp_path / "a.csv", vehicle_with(table, tmp_path))
    np.testing.assert_allclose(read.rotor_speed[:, [2, 0, 1, 3]], LOG.rotor_speed)


def test_wind_is_taken_off_the_velocity(tmp_path: Path) -> None:
    ned = write_csv(LOG, tmp_path / "a.csv", body_frame="frd", world_frame="ned")
    enu = write_csv(LOG, tmp_path / "b.csv")
    # The same wind, from the north-west and downwards, in both frames.
    ned = ned.replace("[log]\n", "[log]\nwind = [-3.0, 2.0, 0.5]\n")
    enu = enu.replace("[log]\n", "[log]\nwind = [2.0, -3.0, -0.5]\n")
    first = read_flight_log(tmp_path / "a.csv", vehicle_with(ned, tmp_path))
    second = read_flight_log(tmp_path / "b.csv", vehicle_with(enu, tmp_path))
    np.testing.assert_allclose(first.velocity, second.velocity, atol=1e-9)
    off = np.linalg.norm(first.velocity - LOG.velocity, axis=1)
    np.testing.assert_allclose(off, np.sqrt(13.25), rtol=1e-9)
    np.testing.assert_allclose(first.climb_rate - LOG.climb_rate, 0.5, atol=1e-9)


def test_signals_of_different_rates_meet_on_the_slowest(tmp_path: Path) -> None:
    """Attitude at 50 Hz with a gap, the rest at 100 Hz: the gap is cut out."""
    table = write_csv(LOG, tmp_path / "a.csv")
    lines = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    header = lines[0].split(",")
    place = header.index("rotor_1")
    kept = []
    for k, line in enumerate(lines[1:]):
        cells = line.split(",")
        if k in (500, 507):
            cells[place] = ""
        if not 800 <= k < 850:
            kept.append(",".join(cells))
    (tmp_path / "a.csv").write_text("\n".join([lines[0], *kept]), encoding="utf-8")
    read = read_flight_log(tmp_path / "a.csv", vehicle_with(table, tmp_path))
    assert read.source.endswith("(dropped: 2 samples not finite)")
    assert not np.any((read.time > 8.0) & (read.time < 8.49))
    whole = LOG.picked(np.isin(np.round(LOG.time, 6), np.round(read.time, 6)))
    assert_same(read, whole, 0.0)


def test_a_rate_can_be_given(tmp_path: Path) -> None:
    vehicle_file = vehicle_with(write_csv(LOG, tmp_path / "a.csv"), tmp_path)
    read = read_flight_log(tmp_path / "a.csv", vehicle_file, rate=40.0)
    np.testing.assert_allclose(np.diff(read.time), 0.025, rtol=1e-9)
    expected = np.interp(read.time, LOG.time, LOG.velocity[:, 0])
    # Fewer samples than were logged: the corners of the changes of speed are rounded a little.
    np.testing.assert_allclose(read.velocity[:, 0], expected, atol=3e-3)
    np.testing.assert_allclose(np.linalg.norm(read.up, axis=1), 1.0, rtol=1e-12)
