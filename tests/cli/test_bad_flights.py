"""Bad recordings and vehicle files for `fit flight` and `check`: the cause and what to do.

Both read their flights by ``read_flights``; what is found needs no model of the rotors but one
point in hover.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from propmap.cli.fit_flight import read_flights
from propmap.errors import InputError
from propmap.model.airfoil import parameter_set
from propmap.typing import Floats
from propmap.vehicle.files import read_vehicle
from tests.flight import agile

from .conftest import Run

GOOD = agile.agile()
V, W, F, P = (agile.VECTORS[name] for name in ("velocity", "rates", "specific_force", "position"))
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


def renamed(*order: str) -> Callable[[Columns], Columns]:
    return lambda c: put(c, Q, vectors(c, order))


def in_frd_and_ned(columns: Columns) -> Columns:
    body = Rotation.from_matrix(np.diag([1.0, -1.0, -1.0]))
    world = Rotation.from_matrix([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    turned = world * body_to_world(columns) * body
    return put(columns, Q, turned.as_quat(scalar_first=True))


def gravity_off(columns: Columns) -> Columns:
    up = body_to_world(columns).apply([0.0, 0.0, 9.80665], inverse=True)
    return put(columns, F, vectors(columns, F) - up)


def at(name: str, value: float, where: Any = slice(None)) -> Callable[[Columns], Columns]:
    def change(columns: Columns) -> Columns:
        column = columns[name].copy()
        column[where] = value
        return columns | {name: column}

    return change


def rows(where: Any) -> Callable[[Columns], Columns]:
    return lambda c: {name: column[where] for name, column in c.items()}


def later(names: tuple[str, ...], samples: int, since: int = 0) -> Callable[[Columns], Columns]:
    def change(columns: Columns) -> Columns:
        values = vectors(columns, names)
        moved = np.roll(values, samples, axis=0)
        moved[: max(since, samples)] = values[: max(since, samples)]
        return put(columns, names, moved)

    return change


def jump(columns: Columns) -> Columns:
    return columns | {"t": columns["t"] + np.where(columns["t"] > 7.0, 100.0, 0.0)}


def repeated(share: int) -> Callable[[Columns], Columns]:
    def change(columns: Columns) -> Columns:
        time = columns["t"].copy()
        time[1::share] = time[:-1:share]
        return columns | {"t": time}

    return change


def clipped(columns: Columns) -> Columns:
    return columns | {"az": np.minimum(columns["az"], 11.0)}


WORLD = ('velocity_in = "body"', 'velocity_in = "world"')
SIX = ("[log]\n", '[[rotors]]\nposition = [0.2, 0.2, 0.0]\nspin = "cw"\n\n[log]\n')
CASES: dict[str, tuple[Callable[[Columns], Columns], list[str], bool]] = {
    "gyro in degrees": (
        scaled(W, 57.29578),
        ["rates (p, q, r) are in degrees per second", "convert them to rad/s"],
        True,
    ),
    "gyro converted twice": (
        scaled(W, 1 / 57.29578),
        ["in rad/s, converted from degrees twice"],
        True,
    ),
    "gyro in FRD": (
        scaled(W, 1, -1, -1),
        ["rates (p, q, r) are along the axes of FRD, not FLU", "change the signs of their y and z"],
        True,
    ),
    "IMU in FRD": (
        lambda c: scaled(F, 1, -1, -1)(scaled(W, 1, -1, -1)(c)),
        ["rates (p, q, r) and specific_force (ax, ay, az) are along the axes of FRD"],
        True,
    ),
    "gyro dead": (
        scaled(W, 0.0),
        ["rates (p, q, r) never change", "rates (p, q, r) and attitude"],
        False,
    ),
    "gyro late": (later(W, 14), ["rates (p, q, r) come 0.14 s after attitude", "one clock"], False),
    "attitude world to body": (
        scaled(Q, 1, -1, -1, -1),
        ["turns world to body axes, expected body to world", "signs of qx, qy and qz"],
        True,
    ),
    "attitude x, y, z, w": (
        renamed("qx", "qy", "qz", "qw"),
        ["in the order x, y, z, w", "correct the columns"],
        True,
    ),
    "attitude shifted": (
        renamed("qz", "qw", "qx", "qy"),
        ["in the order w, x, y, z", "qw is the column that is named qx"],
        True,
    ),
    "attitude not of length 1": (scaled(Q, 2, 2, 2, 2), ["are no unit quaternion", "qw, qx"], True),
    "attitude in FRD and NED": (
        in_frd_and_ned,
        ["attitude (qw, qx, qy, qz) turns FRD to NED, stated are FLU and ENU"],
        True,
    ),
    "attitude's clock jumps": (
        later(Q, 60, since=700),
        ["describe different motions in", "to 13.98 s", "a jump of a clock"],
        False,
    ),
    "velocity in world axes": (
        in_world(V),
        ["velocity (vx, vy, vz) is along world axes, not body axes", 'velocity_in = "world"'],
        True,
    ),
    "velocity in FRD": (
        scaled(V, 1, -1, -1),
        ["velocity (vx, vy, vz) is along the axes of FRD"],
        True,
    ),
    "velocity in km/h": (scaled(V, 3.6), ["is in km/h", "convert it to m/s"], True),
    "positions": (
        lambda c: put(c, V, vectors(c, P)),
        ["holds positions", "columns of the velocity"],
        True,
    ),
    "velocity dead": (scaled(V, 0.0), ["velocity (vx, vy, vz) never change"], False),
    "gravity taken off": (gravity_off, ["gravity is taken off specific_force", "in hover"], True),
    "accelerometer upside down": (scaled(F, -1), ["points the wrong way", "change its sign"], True),
    "accelerometer in FRD": (
        scaled(F, 1, -1, -1),
        ["specific_force (ax, ay, az) is along the axes of FRD, not FLU"],
        True,
    ),
    "accelerometer in world axes": (in_world(F), ["is along world axes, not body axes"], True),
    "accelerometer in g": (scaled(F, 1 / 9.80665), ["is in units of g", "m/s^2"], True),
    "accelerometer constant": (
        lambda c: at("ax", 0.0)(at("ay", 0.0)(at("az", 9.8)(c))),
        ["specific_force (ax, ay, az) never change", "log what was measured"],
        False,
    ),
    "accelerometer with a dead axis": (at("ay", 0.02), ["never changes along y"], False),
    "accelerometer saturated": (
        clipped,
        ["stands at 11 along z in", "end of the sensor's range", "widen the range"],
        False,
    ),
    "time in ms": (
        lambda c: c | {"t": 1000.0 * c["t"]},
        ["comes every 10 s", "give times in seconds"],
        True,
    ),
    "time twice as slow": (
        lambda c: c | {"t": 2.0 * c["t"]},
        ["the times are 2 times those by which attitude and gyro agree", "in seconds"],
        True,
    ),
    "clock jumps ahead": (jump, ["no sample from 7 to 107.01 s", "clock jumped"], False),
    "clock jumps back": (
        lambda c: c | {"t": c["t"] - np.where(c["t"] > 7.0, 5.0, 0.0)},
        ["with a time that does not rise", "sort by time or cut the log"],
        True,
    ),
    "many stamps twice": (repeated(5), ["280 of 1400 samples", "does not rise"], True),
    "some stamps twice": (repeated(100), ["dropped: 14 samples with a time that"], False),
    "a column without numbers": (at("q", np.nan), ["1400 of 1400", "not finite"], True),
    "a rotor missing": (at("m3", np.nan), ["rotor_speed (m1, m2, m3, m4) are not finite"], True),
    "a rotor at rest": (at("m3", 0.0), ["rotor 3 stands still in the whole log"], True),
    "a rotor not measured": (at("m3", 1100.0), ["never changes of rotor 3", "measured"], False),
    "rotors in another order": (
        lambda c: put(c, ROTORS, vectors(c, ("m2", "m4", "m1", "m3"))),
        ["do not turn the vehicle", "rather of rotors 2, 4, 1, 3", "correct rotor_order"],
        True,
    ),
    "rotors in rpm": (scaled(ROTORS, 9.5493), ["rpm read as rad/s", 'rotor_unit = "rpm"'], True),
    "rotors in rev/s": (scaled(ROTORS, 1 / 6.2832), ["0.02", "times the weight"], True),
    "too short": (rows(slice(0, 6)), ["has 6 samples, expected at least 10"], True),
    "too slow to filter": (
        rows(slice(None, None, 10)),
        ["10 samples per second are too few for a low-pass at 6 Hz", "--low-pass to 3.3"],
        False,
    ),
    "far too slow": (rows(slice(None, None, 40)), ["comes every 0.4 s", "higher rate"], True),
}
STATED: dict[str, tuple[tuple[str, str], Callable[[Columns], Columns], list[str], bool]] = {
    "velocity in body axes, stated world": (
        WORLD,
        lambda c: c,
        ["is along body axes, not world axes", 'velocity_in = "body"'],
        True,
    ),
    "altitude for a climb rate": (
        WORLD,
        lambda c: put(c, V, np.column_stack([vectors(in_world(V)(c), V)[:, :2], c["pz"]])),
        ["the third component of velocity (vx, vy, vz) is an altitude"],
        True,
    ),
    "velocity north, east, down": (
        WORLD,
        lambda c: put(c, V, vectors(in_world(V)(c), V)[:, [1, 0, 2]] * [1, 1, -1]),
        ["is along the axes of NED, not ENU", "world_frame"],
        True,
    ),
    "rotors in rad/s, stated rpm": (
        ('rotor_unit = "rad/s"', 'rotor_unit = "rpm"'),
        lambda c: c,
        ["rad/s read as rpm", 'write rotor_unit = "rad/s"'],
        True,
    ),
    "a rotor more than in the log": (
        SIX,
        lambda c: c,
        ["rotor_speed names 4 columns, the vehicle has 5 rotors"],
        True,
    ),
    "all in FRD and NED": (
        ('"flu"\nworld_frame = "enu"', '"frd"\nworld_frame = "ned"'),
        lambda c: c,
        ["specific force along the vertical averages -", "check body_frame, world_frame"],
        True,
    ),
    "mass in grams": (
        ("mass = 0.772", "mass = 772.0"),
        lambda c: c,
        ["times the weight", "772 kg looks like grams"],
        True,
    ),
    "wrong order stated": (
        ("[log]\n", "[log]\nrotor_order = [2, 4, 1, 3]\n"),
        lambda c: c,
        ["rather of rotors 3, 1, 4, 2", "correct rotor_order"],
        True,
    ),
}


def remarks_of(folder: Path, *logs: Columns, edit: tuple[str, str] = ("", "")) -> tuple[str, ...]:
    """What the commands say of logs that they take; ``InputError`` where they do not."""
    assert edit[0] in agile.vehicle()
    text = agile.vehicle().replace(*edit, 1)
    (folder / "vehicle.toml").write_text(text, encoding="utf-8")
    paths = [folder / f"log_{k}.csv" for k in range(len(logs))]
    for path, columns in zip(paths, logs, strict=True):
        agile.write(columns, path)
    file = read_vehicle(folder / "vehicle.toml")
    return read_flights(paths, file, "balance", seconds=2.0, samples=100, low_pass=6.0).remarks


def says(folder: Path, columns: Columns, edit: tuple[str, str], certain: bool) -> str:
    if not certain:
        return "\n".join(remarks_of(folder, columns, edit=edit))
    with pytest.raises(InputError) as caught:
        remarks_of(folder, columns, edit=edit)
    return str(caught.value)


def test_a_good_flight_gives_no_remark(tmp_path: Path) -> None:
    assert remarks_of(tmp_path, GOOD, agile.agile(seed=4)) == ()


@pytest.mark.parametrize("name", CASES)
def test_a_bad_recording(name: str, tmp_path: Path) -> None:
    damage, parts, certain = CASES[name]
    told = says(tmp_path, damage(GOOD), ("", ""), certain)
    assert "log_0.csv" in told
    for part in parts:
        assert part in told
    assert all(line.isprintable() and len(line) < LONGEST for line in told.split("\n"))


@pytest.mark.parametrize("name", STATED)
def test_a_vehicle_file_that_does_not_suit(name: str, tmp_path: Path) -> None:
    edit, damage, parts, certain = STATED[name]
    told = says(tmp_path, damage(GOOD), edit, certain)
    for part in parts:
        assert part in told
    assert all(line.isprintable() and len(line) < LONGEST for line in told.split("\n"))


def test_the_order_that_is_named_is_the_one_that_puts_it_right(tmp_path: Path) -> None:
    mixed = put(GOOD, ROTORS, vectors(GOOD, ("m2", "m4", "m1", "m3")))
    edit = ("[log]\n", "[log]\nrotor_order = [2, 4, 1, 3]\n")
    assert remarks_of(tmp_path, mixed, edit=edit) == ()


def test_flights_of_two_vehicles(tmp_path: Path) -> None:
    """The second one takes 15 % more rotor speed in hover: another mass or propeller."""
    (told,) = remarks_of(tmp_path, GOOD, scaled(ROTORS, 1.15)(GOOD))
    assert "log_0.csv has 1.32 times the force per mass and squared rotor speed of" in told
    assert "log_1.csv" in told and "fit the flights one by one" in told


@pytest.mark.parametrize("command", ["fit", "check"])
def test_both_commands_say_it_in_one_line(command: str, run: Run, tmp_path: Path) -> None:
    (tmp_path / "vehicle.toml").write_text(agile.vehicle(), encoding="utf-8")
    (tmp_path / "set.toml").write_text(parameter_set("paper-apc").to_toml(), encoding="utf-8")
    agile.write(scaled(W, 57.29578)(GOOD), tmp_path / "log.csv")
    vehicle = ["--vehicle", "vehicle.toml"]
    arguments = {
        "fit": ["fit", "flight", "log.csv", *vehicle, "--method", "balance", "-o", "out.toml"],
        "check": ["check", "set.toml", "log.csv", *vehicle],
    }
    done = run(*arguments[command])
    assert done.code == 2 and done.out == ""
    assert done.err.count("\n") == 1 and "are in degrees per second" in done.err
    assert not (tmp_path / "out.toml").exists()
