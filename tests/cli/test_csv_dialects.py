"""Every reader of a CSV file gives the same values for each dialect of spreadsheets."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from propmap.cli.fit_flight import all_level_tables
from propmap.errors import InputError
from propmap.flight.steady import read_level_table
from propmap.io.csv import LOAD_COLUMNS, read_points
from propmap.io.geometry import read_geometry_file
from propmap.io.sections import looks_like_section_table, read_section_table
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log_readers import read_flight_log
from tests.flight.synthetic import NEUROBEM, vehicle_with
from tests.io import samples
from tests.io.samples_csv import rewritten
from tests.vehicle.refusals import LOG
from tests.vehicle.write_logs import write_csv

DIALECTS = ("tabs", "decimal commas of a spreadsheet")  # all of them: tests/io
POINTS = "beta_deg,note,rpm,speed_mps,thrust_N\n80,first,4000,14.5,1.25\n85.5,b,4100.25,0,\n"
LEVEL = "speed_mps,note,pitch_deg,rpm_1,rpm_2,rpm_3,rpm_4\n0.5,a,0,9000.5,9100,9200,9300\n"
SECTION = "alpha_deg,Re,CL,CD,CM\n" + "".join(
    f"{angle},{re},{np.sin(np.radians(2 * angle)):.6f},{0.02 + abs(angle) / 90:.6f},0.1\n"
    for re in (50000, 100000)
    for angle in range(-180, 181, 5)
)

Values = list[np.ndarray]


def geometry(path: Path) -> Values:
    blade = read_geometry_file(path)
    assert (blade.name, blade.blades) == ("hand-made, short", 3)
    return [blade.station, blade.chord, blade.twist]


def points(path: Path) -> Values:
    found, columns, _ = read_points(path, LOAD_COLUMNS)
    return [*found.si, columns["thrust_N"]]


def level_table(path: Path) -> Values:
    assert all_level_tables([path])
    log = read_level_table(path, read_vehicle(NEUROBEM).vehicle)
    return [log.velocity, log.rotor_speed, log.up]


def section_table(path: Path) -> Values:
    assert looks_like_section_table(path)
    table = read_section_table(path)
    return [table.angle, table.reynolds, table.lift, table.drag]


READERS: dict[str, tuple[str, Callable[[Path], Values]]] = {
    "geometry": ("# name: hand-made, short\n" + samples.CSV.split("\n", 1)[1], geometry),
    "points": (POINTS, points),
    "level table": (LEVEL, level_table),
    "section table": (SECTION, section_table),
}


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("reader", READERS)
def test_every_reader(reader: str, dialect: str, tmp_path: Path) -> None:
    text, read = READERS[reader]
    (tmp_path / "plain.csv").write_text(text)
    (tmp_path / "other.csv").write_bytes(rewritten(text, dialect).encode())
    pairs = zip(read(tmp_path / "plain.csv"), read(tmp_path / "other.csv"), strict=True)
    for plain, other in pairs:
        np.testing.assert_array_equal(plain, other)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_flight_log(dialect: str, tmp_path: Path) -> None:
    plain, other = tmp_path / "plain.csv", tmp_path / "other.csv"
    vehicle = vehicle_with(write_csv(LOG, plain), tmp_path)
    other.write_bytes(rewritten(plain.read_text(), dialect).encode())
    expected, found = read_flight_log(plain, vehicle), read_flight_log(other, vehicle)
    for field in ("time", "velocity", "rates", "up", "specific_force", "rotor_speed"):
        np.testing.assert_array_equal(getattr(expected, field), getattr(found, field))


def test_flight_log_with_more_fields_than_names(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    vehicle = vehicle_with(write_csv(LOG, path), tmp_path)
    first, second, *rest = path.read_text().splitlines()
    path.write_text("\n".join([first, f"{second},5", *rest]))
    with pytest.raises(InputError, match=r"line 2: found \d+ fields"):
        read_flight_log(path, vehicle)
