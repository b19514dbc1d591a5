"""One flight through every file format: all formats give the same log."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import FlightLog
from propmap.vehicle.log_readers import read_flight_log
from tests.flight.synthetic import NEUROBEM, flight, vehicle_with

from .write_dataflash import write_dataflash
from .write_logs import START, csv_columns, write_bag, write_csv
from .write_px4_log import write_ulog

LOG = flight(rate=50.0).picked(slice(150, 650))
"""Ten seconds, from hover to 6 m/s."""

VEHICLE = read_vehicle(NEUROBEM).vehicle


def write_merged(log: FlightLog, path: Path) -> str:
    """Write settings as Blackbox Explorer, and a row per quantity as PlotJuggler merges topics."""
    columns, table = csv_columns(log, velocity_in="world")
    names = list(columns)
    lines = ['"Product","Blackbox"', '"rollPID","45,80,30"', ",".join(f'"{n}"' for n in names)]
    quantities = names[1:4], names[4:7], names[7:10], names[10:14], names[14:]
    for k in range(log.time.size):
        for own in quantities:
            cells = (str(columns[n][k]) if n in ("time_s", *own) else "" for n in names)
            lines.append(",".join(cells))
    path.write_text("\n".join(lines), encoding="utf-8")
    return table


write_ros = functools.partial(write_bag, vehicle=VEHICLE)
FORMATS: dict[str, tuple[str, float, Callable[[FlightLog, Path], str]]] = {
    "csv, frd and ned": (
        "a.csv",
        0.0,
        functools.partial(write_csv, body_frame="frd", world_frame="ned", velocity_in="world"),
    ),
    "csv, frd and enu, angles, rpm": (
        "a.csv",
        0.0,
        functools.partial(write_csv, body_frame="frd", angles=True, rotor_unit="rpm"),
    ),
    "csv, settings above and a row per quantity": ("a.csv", 0.0, write_merged),
    "ulog": ("a.ulg", 1.0, functools.partial(write_ulog, vehicle=VEHICLE)),
    "dataflash": ("a.bin", 1.0, write_dataflash),
    "ros 2, sqlite, pose and twist": ("bag", START, functools.partial(write_ros, odometry=False)),
    "ros 2, mcap, joint states": (
        "bag",
        START,
        functools.partial(write_ros, storage="mcap", rotor_type="sensor_msgs/msg/JointState"),
    ),
    "ros 1": ("a.bag", START, functools.partial(write_ros, storage="ros1")),
}


@pytest.mark.parametrize("name", FORMATS)
def test_a_log_is_read_as_it_was_written(name: str, tmp_path: Path) -> None:
    file, start, write = FORMATS[name]
    vehicle_file = vehicle_with(write(LOG, tmp_path / file), tmp_path)
    read = read_flight_log(tmp_path / file, vehicle_file)
    assert "dropped" not in read.source
    assert_same(read, LOG, start)
    # The file of a ROS 2 bag without its folder.
    for alone in (tmp_path / file).glob("*.mcap"):
        assert_same(read_flight_log(alone, vehicle_file), LOG, start)


def assert_same(read: FlightLog, wanted: FlightLog, start: float) -> None:
    # ULog holds microseconds, float32 and whole rpm; bags nanoseconds since 1970 in a float64.
    assert read.time.size == wanted.time.size
    np.testing.assert_allclose(read.time - start, wanted.time, rtol=0, atol=2e-6)
    for name, tolerance in (
        ("velocity", 1e-5),
        ("rates", 1e-6),
        ("up", 1e-6),
        ("specific_force", 1e-5),
        ("rotor_speed", 0.06),
    ):
        np.testing.assert_allclose(
            getattr(read, name), getattr(wanted, name), rtol=0, atol=tolerance, err_msg=name
        )


def test_another_message_with_one_array_and_no_imu(tmp_path: Path) -> None:
    """Whole rad/s in a type without a name of its own; rates then come from the odometry."""
    part = LOG.picked(slice(300, 350))
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


def test_rotor_order_says_which_rotor_a_column_is(tmp_path: Path) -> None:
    table = write_csv(LOG, tmp_path / "a.csv")
    table = table.replace("[log]\n", "[log]\nrotor_order = [3, 1, 2, 4]\n")
    read = read_flight_log(tmp_path / "a.csv", vehicle_with(table, tmp_path))
    np.testing.assert_allclose(read.rotor_speed[:, [2, 0, 1, 3]], LOG.rotor_speed)


def test_wind_is_taken_off_the_velocity(tmp_path: Path) -> None:
    """The same wind, from the north-west and downwards, in both frames."""
    ned = write_csv(LOG, tmp_path / "a.csv", body_frame="frd", world_frame="ned")
    enu = write_csv(LOG, tmp_path / "b.csv")
    ned = ned.replace("[log]\n", "[log]\nwind = [-3.0, 2.0, 0.5]\n")
    enu = enu.replace("[log]\n", "[log]\nwind = [2.0, -3.0, -0.5]\n")
    first = read_flight_log(tmp_path / "a.csv", vehicle_with(ned, tmp_path))
    second = read_flight_log(tmp_path / "b.csv", vehicle_with(enu, tmp_path))
    np.testing.assert_allclose(first.velocity, second.velocity, atol=1e-9)
    off = np.linalg.norm(first.velocity - LOG.velocity, axis=1)
    np.testing.assert_allclose(off, np.sqrt(13.25), rtol=1e-9)
    np.testing.assert_allclose(first.climb_rate - LOG.climb_rate, 0.5, atol=1e-9)


def test_a_gap_is_cut_out_and_bad_samples_are_dropped(tmp_path: Path) -> None:
    table = write_csv(LOG, tmp_path / "a.csv")
    header, *rows = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    for k in (100, 104):
        cells = rows[k].split(",")
        cells[header.split(",").index("rotor_1")] = ""
        rows[k] = ",".join(cells)
    del rows[200:230]
    rows[20] = rows[19]
    (tmp_path / "a.csv").write_text("\n".join([header, *rows]), encoding="utf-8")
    read = read_flight_log(tmp_path / "a.csv", vehicle_with(table, tmp_path))
    assert "2 samples not finite" in read.source and "1 samples out of time order" in read.source
    assert not np.any((read.time > LOG.time[200]) & (read.time < LOG.time[229]))
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
