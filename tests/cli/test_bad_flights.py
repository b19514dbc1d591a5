"""Bad recordings and vehicle files for `fit flight` and `check`: the cause and what to do."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from propmap.cli.fit_flight import read_flights
from propmap.errors import InputError
from propmap.model.airfoil import parameter_set
from propmap.typing import Floats
from propmap.vehicle.files import read_vehicle
from tests.flight import agile

from .conftest import Run, refused

RATE, DURATION = 50.0, 10.0
GOOD = agile.agile(RATE, DURATION)
V, W, F = (agile.VECTORS[name] for name in ("velocity", "rates", "specific_force"))
Q, ROTORS = agile.QUATERNION, agile.ROTORS
Columns = dict[str, Floats]
LONGEST = 500

pytestmark = pytest.mark.usefixtures("filters_once")


def vectors(columns: Columns, names: tuple[str, ...]) -> Floats:
    return np.stack([columns[name] for name in names], axis=1)


def put(columns: Columns, names: tuple[str, ...], values: Floats) -> Columns:
    return columns | dict(zip(names, values.T, strict=True))


def scaled(names: tuple[str, ...], *factors: float) -> Callable[[Columns], Columns]:
    return lambda c: put(c, names, vectors(c, names) * np.array(factors))


def body_to_world(columns: Columns) -> Rotation:
    return Rotation.from_quat(vectors(columns, Q), scalar_first=True)


def in_world(names: tuple[str, ...]) -> Callable[[Columns], Columns]:
    return lambda c: put(c, names, body_to_world(c).apply(vectors(c, names)))


def copied(names: tuple[str, ...], *others: str) -> Callable[[Columns], Columns]:
    return lambda c: put(c, names, vectors(c, others))


def in_frd_and_ned(columns: Columns) -> Columns:
    body = Rotation.from_matrix(np.diag([1.0, -1.0, -1.0]))
    world = Rotation.from_matrix([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    turned = world * body_to_world(columns) * body
    return put(columns, Q, turned.as_quat(scalar_first=True))


def gravity_off(columns: Columns) -> Columns:
    up = body_to_world(columns).apply([0.0, 0.0, 9.80665], inverse=True)
    return put(columns, F, vectors(columns, F) - up)


def late(names: tuple[str, ...], samples: int, since: int) -> Callable[[Columns], Columns]:
    def change(columns: Columns) -> Columns:
        values = vectors(columns, names)
        moved = np.concatenate([values[:since], values[since - samples : -samples]])
        return put(columns, names, moved)

    return change


def every(step: int) -> Callable[[Columns], Columns]:
    return lambda c: {name: column[::step] for name, column in c.items()}


STATED = ('velocity_in = "body"', 'velocity_in = "world"')
Case = tuple[Callable[[Columns], Columns], str, str]
IN_FRD = (1, -1, -1)
MISTAKES: dict[str, Case] = {
    "gyro in degrees": (scaled(W, 57.29578), "(p, q, r) are in degrees per second", "to rad/s"),
    "IMU in FRD": (
        lambda c: scaled(F, *IN_FRD)(scaled(W, *IN_FRD)(c)),
        "rates (p, q, r) and specific_force (ax, ay, az) are along the axes of FRD",
        "of both",
    ),
    "attitude world to body": (
        scaled(Q, 1, -1, -1, -1),
        "rotates world to body axes, expected",
        "signs of qx, qy and qz",
    ),
    "attitude x, y, z, w": (copied(Q, "qx", "qy", "qz", "qw"), "x, y, z, w", "qw is the last"),
    "attitude in FRD and NED": (in_frd_and_ned, "rotates FRD to NED, but the", "same frames"),
    "velocity in world axes": (in_world(V), "along world axes, not body", 'velocity_in = "world"'),
    "velocity in km/h": (scaled(V, 3.6), "is in km/h", "convert it to m/s"),
    "stated in world axes: an altitude for a climb rate": (
        lambda c: put(c, V, np.column_stack([vectors(in_world(V)(c), V)[:, :2], c["pz"]])),
        "the third component of velocity (vx, vy, vz) is an altitude",
        "column of the vertical velocity",
    ),
    "stated in world axes: velocity north, east, down": (
        lambda c: put(c, V, vectors(in_world(V)(c), V)[:, [1, 0, 2]] * [1, 1, -1]),
        "is along the axes of NED, not ENU",
        "world_frame",
    ),
    "gravity taken off": (gravity_off, "gravity is subtracted from specific", "in hover"),
    "accelerometer upside down": (scaled(F, -1), "points down in hover", "change its sign"),
    "accelerometer in world axes": (in_world(F), "along world axes, not body", "of the body"),
    "time twice as slow": (scaled(("t",), 2.0), "the times are 2 times", "in seconds"),
    "rotors in another order": (
        copied(ROTORS, "m2", "m4", "m1", "m3"),
        "fit rotors 2, 4, 1, 3",
        "correct rotor_order",
    ),
    "rotors in rpm": (scaled(ROTORS, 9.5493), "rpm read as rad/s", 'rotor_unit = "rpm"'),
    "far too slow": (every(20), "are 0.4 s apart", "higher rate"),
}
DOUBTS: dict[str, Case] = {
    "gyro dead": (scaled(W, 0.0), "rates (p, q, r) never change", "rates (p, q, r) and attitude"),
    "gyro late": (late(W, 7, since=7), "(p, q, r) come 0.14 s after attitude", "one clock"),
    "attitude's clock jumps": (
        late(Q, 30, since=250),
        "describe different motions in 2 of 5 segments, from 3.994 to 7.978 s",
        "a jump of a clock",
    ),
    "accelerometer with a dead axis": (
        lambda c: c | {"ay": np.full_like(c["ay"], 0.02)},
        "never changes along y",
        "a dead axis",
    ),
    "clock jumps ahead": (
        lambda c: c | {"t": c["t"] + 100.0 * (c["t"] > 5.0)},
        "no sample from 5 to",
        "clock jumped",
    ),
    "a rotor not measured": (
        lambda c: c | {"m3": np.full_like(c["m3"], 1100.0)},
        "never changes for rotor 3",
        "measured",
    ),
    "too slow to filter": (every(5), "too few for a low-pass at 6 Hz", "--low-pass to 3.3"),
}


def remarks_of(folder: Path, *logs: Columns, edit: tuple[str, str] = ("", "")) -> tuple[str, ...]:
    """Return the remarks on accepted logs; raise ``InputError`` for refused logs."""
    assert edit[0] in agile.vehicle()
    text = agile.vehicle().replace(*edit, 1)
    (folder / "vehicle.toml").write_text(text, encoding="utf-8")
    paths = [folder / f"log_{k}.csv" for k in range(len(logs))]
    for path, columns in zip(paths, logs, strict=True):
        agile.write(columns, path)
    file = read_vehicle(folder / "vehicle.toml")
    return read_flights(paths, file, "balance", seconds=2.0, samples=100, low_pass=6.0).remarks


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_refused_with_its_cause_and_remedy(name: str, tmp_path: Path) -> None:
    damage, cause, remedy = MISTAKES[name]
    with pytest.raises(InputError) as caught:
        remarks_of(tmp_path, damage(GOOD), edit=STATED if "stated" in name else ("", ""))
    line = str(caught.value)
    assert "log_0.csv" in line and cause in line and remedy in line
    assert line.isprintable() and len(line) < LONGEST


@pytest.mark.parametrize("name", DOUBTS)
def test_a_doubt_is_a_remark(name: str, tmp_path: Path) -> None:
    damage, doubt, remedy = DOUBTS[name]
    remarks = remarks_of(tmp_path, damage(GOOD))
    told = " ".join(remarks)
    assert "log_0.csv" in told and doubt in told and remedy in told
    assert all(line.isprintable() and len(line) < LONGEST for line in remarks)


def test_good_flights_and_the_order_that_was_named_give_no_remark(tmp_path: Path) -> None:
    assert remarks_of(tmp_path, GOOD, agile.agile(RATE, DURATION, seed=4)) == ()
    mixed = copied(ROTORS, "m2", "m4", "m1", "m3")(GOOD)
    edit = ("[log]\n", "[log]\nrotor_order = [2, 4, 1, 3]\n")
    assert remarks_of(tmp_path, mixed, edit=edit) == ()


def test_flights_of_two_vehicles(tmp_path: Path) -> None:
    """The second one takes 15 % more rotor speed in hover: another mass or propeller."""
    (told,) = remarks_of(tmp_path, GOOD, scaled(ROTORS, 1.15)(GOOD))
    assert "log_0.csv: force / (mass * rotor speed^2) in slow flight is 1.32 times that" in told
    assert "log_1.csv" in told and "fit the flights one by one" in told


def test_both_commands_say_it_in_one_line(run: Run) -> None:
    Path("vehicle.toml").write_text(agile.vehicle(), encoding="utf-8")
    Path("set.toml").write_text(parameter_set("paper-apc").to_toml(), encoding="utf-8")
    agile.write(scaled(W, 57.29578)(GOOD), Path("log.csv"))
    log = ["log.csv", "--vehicle", "vehicle.toml"]
    for command in (["fit", "flight", *log, "-o", "out.toml"], ["check", "set.toml", *log]):
        refused(run(*command), "are in degrees per second")
    assert not Path("out.toml").exists()
