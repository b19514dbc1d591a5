"""`propmap simulate flight`: the log, what is printed before, and one-line errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.flight.steady import operating_points, steady_segments
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log_readers import read_flight_log
from propmap.vehicle.vehicle import Vehicle, Wakes

from .conftest import Run
from .fit_inputs import VEHICLE

pytestmark = pytest.mark.usefixtures("brief")

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
    found = operating_points(log, steady_segments(log))
    assert found.speed == pytest.approx([9.0, 11.0, 13.0], abs=0.03)
    again = run(*SMALL, "--noise", "0.02", "--seed", "4", "--force", "--no-expectation")
    assert again.code == 0
    assert "vehicle.toml already describes this log" in again.out
    assert "95 %" not in again.out and "[log]" not in again.out
    same = read_flight_log("flight.csv", read_vehicle("vehicle.toml"))
    assert np.array_equal(same.rotor_speed, log.rotor_speed)
    assert "--force" in run(*SMALL).err
