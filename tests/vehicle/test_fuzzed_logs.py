"""Damaged logs of every kind: their readers say one line or read what is there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from propmap.errors import InputError
from propmap.vehicle.files import VehicleFile, read_vehicle
from propmap.vehicle.log_readers import read_flight_log
from tests.flight.synthetic import NEUROBEM, vehicle_with

from .refusals import LOG
from .write_dataflash import write_dataflash
from .write_logs import write_bag, write_csv
from .write_px4_log import write_ulog

BYTES = st.lists(
    st.tuples(st.floats(0.0, 1.0), st.integers(0, 64), st.binary(max_size=16)),
    min_size=1,
    max_size=3,
)


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[bytes, VehicleFile]]:
    """Whole logs by name, and what reads each."""
    folder = tmp_path_factory.mktemp("logs")
    plain = read_vehicle(NEUROBEM).vehicle
    bag = {"storage": "ros1", "odometry": True}
    written = {
        "log.csv": write_csv(LOG, folder / "log.csv"),
        "log.ulg": write_ulog(LOG, folder / "log.ulg", plain),
        "log.bin": write_dataflash(LOG, folder / "log.bin"),
        "log.bag": write_bag(LOG, folder / "log.bag", plain, **bag),  # type: ignore[arg-type]
    }
    found = {}
    for name, table in written.items():
        place = folder / name.replace(".", "-")
        place.mkdir()
        found[name] = ((folder / name).read_bytes(), vehicle_with(table, place))
    return found


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(name=st.sampled_from(["log.csv", "log.ulg", "log.bin", "log.bag"]), edits=BYTES)
def test_one_line_or_a_right_reading(
    logs: dict[str, tuple[bytes, VehicleFile]],
    tmp_path: Path,
    name: str,
    edits: list[tuple[float, int, bytes]],
) -> None:
    content, vehicle = logs[name]
    for where, cut, junk in edits:
        start = int(where * len(content))
        content = content[:start] + junk + content[start + cut :]
    path = tmp_path / name
    path.write_bytes(content)
    try:
        log = read_flight_log(path, vehicle)
    except InputError as error:
        assert str(error).isprintable()
    else:
        assert np.isfinite(log.rotor_speed).all() and (np.diff(log.time) > 0.0).all()
    path.unlink()
    assert list(tmp_path.iterdir()) == []
