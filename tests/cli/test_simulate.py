"""`propmap simulate flight`: the log, what is printed before, and one-line errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.flight.simulate import trim
from propmap.flight.steady import operating_points, steady_stretches
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log_readers import read_flight_log
from propmap.vehicle.vehicle import Vehicle, Wakes

from .conftest import Run

pytestmark = pytest.mark.usefixtures("brief")

VEHICLE = """schema = 1
name = "quadrotor"
frame = "flu"
mass = 1.0
propeller = "apc-8x6e"
""" + "".join(
    f'[[rotors]]\nposition = [{x}, {y}, 0.0]\nspin = "{spin}"\n'
    for x, y, spin in ((0.1, 0.1, "cw"), (-0.1, 0.1, "ccw"), (-0.1, -0.1, "cw"), (0.1, -0.1, "ccw"))
)
FLIGHT = ["simulate", "flight", "--vehicle", "vehicle.toml", "--airfoil", "paper-apc"]
SMALL = [*FLIGHT, "--speeds", "9,11,13", "-o", "flight.csv"]


@pytest.fixture(autouse=True)
def _vehicle(_workplace: None) -> None:
    Path("vehicle.toml").write_text(VEHICLE)


def test_wakes_are_flown_unless_they_are_left_out(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    flown = []

    def note(vehicle: Vehicle, *_: object, **__: object) -> None:
        flown.append(vehicle.wakes)
        raise InputError("this is enough", "look at what was flown")

    monkeypatch.setattr("propmap.flight.simulate.trim", note)
    Path("vehicle.toml").write_text(VEHICLE + "[wakes]\ndownwash = 3.0\n")
    for more in ((), ("--no-wakes",)):
        assert "this is enough" in run(*SMALL, *more).err
    assert flown == [Wakes(downwash=3.0), None]


def test_a_flight_is_written_and_read_back(run: Run) -> None:
    done = run(*SMALL, "--noise", "0.02", "--seed", "4")
    assert (done.code, done.err) == (0, "")
    assert sorted(path.name for path in Path().iterdir()) == ["flight.csv", "vehicle.toml"]
    for text in ("force error of 2.00%", "c_l1", "alpha_0", "weak", "1/rad", "95 %"):
        assert text in done.out
    assert "wrote flight.csv: 3 speeds" in done.out
    # The table that is printed makes the vehicle file read the log.
    table = done.out[done.out.index("[log]") :]
    Path("vehicle.toml").write_text(VEHICLE + table)
    log = read_flight_log("flight.csv", read_vehicle("vehicle.toml"))
    found = operating_points(log, steady_stretches(log))
    assert found.speed == pytest.approx([9.0, 11.0, 13.0], abs=0.03)
    again = run(*SMALL, "--noise", "0.02", "--seed", "4", "--force", "--no-expectation")
    assert again.code == 0
    assert "vehicle.toml already describes this log" in again.out
    assert "95 %" not in again.out and "[log]" not in again.out
    same = read_flight_log("flight.csv", read_vehicle("vehicle.toml"))
    assert np.array_equal(same.rotor_speed, log.rotor_speed)


def test_without_noise_the_log_is_the_trim(run: Run) -> None:
    import propmap

    sensors = [f"--{name}-noise=0" for name in ("rotor", "velocity", "attitude", "accelerometer")]
    quiet = ["--noise", "0", *sensors, "--no-expectation"]
    done = run(*SMALL, *quiet)
    assert (done.code, done.err) == (0, "")
    Path("vehicle.toml").write_text(VEHICLE + done.out[done.out.index("[log]") :])
    read = read_vehicle("vehicle.toml")
    log = read_flight_log("flight.csv", read)
    law = propmap.airfoil("paper-apc").with_corrections(["pitt-peters", "radial-friction"])
    points = trim(read.vehicle, law, np.array([9.0, 11.0, 13.0]))
    for sample, point in ((0, 0), (-1, 2)):
        # The file has nine digits.
        assert log.rotor_speed[sample] == pytest.approx(points.rotor_speed[point], rel=1e-8)
        assert log.velocity[sample] == pytest.approx(points.velocity[point], abs=1e-7)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--vehicle", "absent.toml"], "absent.toml: no such file"),
        (["--vehicle", "wrong.toml"], "wrong.toml"),
        (["--airfoil", "paper-apx"], "paper-apc"),
        (["--speeds", "fast"], "--speeds 'fast' cannot be read"),
        (["--speeds", "0.5:14.5"], "A:B:N"),
        (["--speeds", "-1,5"], "speed is negative"),
        (["--speeds", "5,5"], "do not increase"),
        (["--noise", "-0.01"], "--noise is -0.01"),
        (["--noise", "nan"], "--noise is nan"),
        (["--noise", "1"], "times the weight"),
        (["--velocity-noise", "-1"], "--velocity-noise"),
        (["--radius", "0"], "radius is 0 m"),
        (["--dwell", "0.1"], "held for 0.1 s"),
        (["--rate", "1"], "rate is 1"),
        (["--seed", "-1"], "'--seed'"),
        (["--free", "c_l1,c_l3"], "'c_l3' is not a parameter"),
        (["--free", "wing_c_l1"], "no wing"),
        (["--speeds", "10,70"], "70 m/s cannot be flown"),
        (["-o", "flight.txt"], "extension"),
        (["-o", "absent/flight.csv"], "no folder"),
    ],
)
def test_what_cannot_be_is_told_in_one_line(run: Run, arguments: list[str], message: str) -> None:
    Path("wrong.toml").write_text("schema = 1\n")
    done = run(*SMALL, *arguments)
    assert done.code == 2
    assert message in done.err
    assert done.err.count("\n") == 1
    assert not Path("flight.csv").exists()


def test_existing_files_are_kept(run: Run) -> None:
    Path("flight.csv").write_text("mine")
    assert "--force" in run(*SMALL).err
    assert Path("flight.csv").read_text() == "mine"
