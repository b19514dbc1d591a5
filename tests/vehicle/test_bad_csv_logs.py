"""Whatever is wrong with a CSV log or its column map, the reader says so in one line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.flight.synthetic import vehicle_with

from .refusals import LOG, message_of
from .write_logs import write_csv


@dataclass
class Table:
    """A CSV log as cells, and its ``[log]`` table, to be damaged."""

    header: list[str]
    rows: list[list[str]]
    log: str

    def put(self, row: int, column: str, value: str) -> None:
        self.rows[row][self.header.index(column)] = value

    def column(self, name: str, change: Callable[[float], float]) -> None:
        place = self.header.index(name)
        for row in self.rows:
            row[place] = repr(change(float(row[place])))


def _edit(old: str, new: str) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        assert old in table.log
        table.log = table.log.replace(old, new)

    return change


def _degrees(table: Table) -> None:
    for name, cell in (("roll", "10.0"), ("pitch", "20.0"), ("yaw", "30.0")):
        table.header.append(name)
        for row in table.rows:
            row.append(cell)
    lines = [line for line in table.log.splitlines() if not line.startswith("q")]
    table.log = "\n".join([*lines, 'roll = "roll"', 'pitch = "pitch"', 'yaw = "yaw"', ""])


CSV_CASES: dict[str, tuple[Callable[[Table], object], list[str]]] = {
    "a column is missing": (
        lambda t: t.header.__setitem__(t.header.index("vy"), "v_y"),
        ["missing columns: 'vy'; the", "time_s, vx, v_y", "did you mean 'v_y'", "velocity"],
    ),
    "no column map": (
        lambda t: setattr(t, "log", t.log.partition("[log.columns]")[0]),
        [
            "keys without a column: 'time', 'velocity', 'rates', 'rotor_speed', 'qw'",
            "correct time,",
        ],
    ),
    "attitude twice": (
        lambda t: setattr(t, "log", t.log + 'roll = "roll"\n'),
        ["the attitude is given twice", "keep only one"],
    ),
    "text in a number": (
        lambda t: t.put(4, "vx", "fast"),
        ["log.csv, line 6, column vx", "'fast' is not a number", "decimal point"],
    ),
    "many samples are NaN": (
        lambda t: [t.put(row, "q", "nan") for row in range(20, 40)],
        ["20 of 120 samples of rates (p, q, r) are not finite", "export the log again"],
    ),
    "a wrong quaternion": (
        _edit('qw = "qw"', 'qw = "vx"'),
        ["samples of attitude (qw, qx, qy, qz) are without a unit quaternion", "qw, qx, qy, qz"],
    ),
    "time runs back": (
        lambda t: setattr(t, "rows", t.rows[60:] + t.rows[:60]),
        ["60 of 120 samples", "out of time order", "sort by time"],
    ),
    "time in ms": (
        lambda t: t.column("time_s", lambda time: 1000.0 * time),
        ["are 20 s apart", "give times in seconds"],
    ),
    "another body frame": (
        _edit('body_frame = "flu"', 'body_frame = "frd"'),
        ["the rotors point down on average", "check body_frame, world_frame", "vehicle.toml"],
    ),
    "in units of g": (
        lambda t: [t.column(name, lambda a: a / 9.80665) for name in ("ax", "ay", "az")],
        ["vertical is 1 m/s^2", "in m/s^2, not in units of g"],
    ),
    "angles in degrees": (_degrees, ["reach 30", "probably in degrees", "to radians"]),
    "no frame stated": (
        _edit('body_frame = "flu"\n', ""),
        ["vehicle.toml: [log]: no body_frame", 'add body_frame = "flu" or "frd"'],
    ),
    "erpm without pole pairs": (
        _edit('"rad/s"', '"erpm"'),
        ["pole_pairs is missing", "half the number of the motor's magnets"],
    ),
}


@pytest.mark.parametrize("name", CSV_CASES)
def test_bad_csv(name: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    log = write_csv(LOG, path)
    lines = path.read_text(encoding="utf-8").splitlines()
    table = Table(lines[0].split(","), [line.split(",") for line in lines[1:]], log)
    damage, parts = CSV_CASES[name]
    damage(table)
    text = "\n".join(",".join(cells) for cells in [table.header, *table.rows])
    path.write_text(text, encoding="utf-8")
    message = message_of(path, vehicle_with(table.log, tmp_path))
    for part in parts:
        assert part in message
