"""Readers of flight logs, one file per format."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from propmap.errors import InputError
from propmap.vehicle.flight_log import FlightLog
from propmap.vehicle.log_map import LogMap
from propmap.vehicle.logs.assembly import flight_log
from propmap.vehicle.logs.csv_log import read_csv_log
from propmap.vehicle.logs.recording import Recording
from propmap.vehicle.logs.rosbag import read_rosbag
from propmap.vehicle.logs.ulog import read_ulog
from propmap.vehicle.vehicle_toml import VehicleFile

READERS: dict[str, Callable[[Path, LogMap], Recording]] = {
    ".csv": read_csv_log,
    ".parquet": read_csv_log,
    ".pq": read_csv_log,
    ".ulg": read_ulog,
    ".bag": read_rosbag,
    ".db3": read_rosbag,
    ".mcap": read_rosbag,
}
"""By the file's ending; a folder is a bag of ROS 2."""


def read_flight_log(
    path: str | os.PathLike[str], vehicle_file: VehicleFile, *, rate: float | None = None
) -> FlightLog:
    """Read a flight log of any kind: CSV, Parquet, PX4's ULog, bags of ROS 1 and ROS 2.

    Signals are interpolated linearly to one clock, those that are faster after a low-pass; gaps
    above 0.25 s are cut out.  Samples that cannot be used are dropped, which ``source`` then tells,
    or refused where they are many.

    Parameters
    ----------
    path : path
        Of the file, or the folder of a ROS 2 bag.
    vehicle_file : VehicleFile
        The vehicle and the map of the log.
    rate : float, optional
        Samples per second [1/s]; by default the sample times of the slowest of attitude, velocity
        and rotor speed.

    Raises
    ------
    InputError
        Where the log cannot be read, or is not one of this vehicle.
    """
    return flight_log(read_recording(path, vehicle_file), vehicle_file, rate)


def read_recording(path: str | os.PathLike[str], vehicle_file: VehicleFile) -> Recording:
    """What a flight log of any kind holds, as it was recorded.

    Parameters
    ----------
    path, vehicle_file : path, VehicleFile
        As for ``read_flight_log``.

    Raises
    ------
    InputError
        Where the log cannot be read.
    """
    file = Path(path)
    where = str(file)
    try:
        folder, there = file.is_dir(), file.exists()
        empty = file.is_file() and file.stat().st_size == 0
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read: {error}", "check the path", where) from None
    if not there:
        raise InputError("no such file", "check the path", where)
    if empty:
        raise InputError("the file is empty", "give the log of a flight", where)
    kind = file.suffix.lower()
    if not folder and kind not in READERS:
        raise InputError(
            f"the file's ending is {kind!r}, expected one of {', '.join(READERS)}",
            "give a log of one of these kinds, or the folder of a ROS 2 bag",
            where,
        )
    if folder and not (file / "metadata.yaml").exists():
        raise InputError(
            "this folder has no metadata.yaml, expected a ROS 2 bag", "name a file inside it", where
        )
    reader = read_rosbag if folder else READERS[kind]
    return reader(file, vehicle_file.log)
