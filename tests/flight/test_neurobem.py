"""Two real flights, where they are at hand: frames, gravity and hover thrust hold together."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.flight.checks import check_rotor_speed
from propmap.flight.steady import steady_segments
from propmap.model.airfoil import parameter_set
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log_readers import read_flight_log

from .synthetic import FLIGHTS, NEUROBEM, vehicle_with

NAMES = ("neurobem_20210218171908", "neurobem_20210218172600")
pytestmark = pytest.mark.skipif(not FLIGHTS.is_dir(), reason="the flights are not here")
FILE = read_vehicle(NEUROBEM)


def columns(lines: list[str]) -> dict[str, Floats]:
    """Return the columns of a CSV file by name."""
    table = np.loadtxt(lines, delimiter=",", skiprows=1)
    return dict(zip(lines[0].split(","), table.T, strict=True))


@pytest.mark.parametrize("name", NAMES)
def test_a_flight_is_read_and_holds_together(name: str) -> None:
    path = FLIGHTS / f"{name}.csv"
    log, table = read_flight_log(path, FILE), columns(path.read_text("utf-8").splitlines())
    np.testing.assert_array_equal(log.time, table["t"])
    np.testing.assert_array_equal(log.rotor_speed[:, 2], table["mot3"])
    assert 11.0 < log.speed.max() < 15.0
    # The vertical velocity by ``up``, and all of it by the position.
    position = np.stack([table[f"pos_{axis}"] for axis in "xyz"], axis=1)
    moved = np.gradient(position, log.time, axis=0)
    np.testing.assert_allclose(np.linalg.norm(moved, axis=1), log.speed, atol=0.6)
    assert np.sqrt(np.mean((moved[:, 2] - log.climb_rate) ** 2)) < 0.05
    quiet = (log.speed < 0.3) & (np.linalg.norm(log.rates, axis=1) < 0.1)
    assert quiet.sum() > 20
    off = np.mean(log.specific_force[quiet] - GRAVITY * log.up[quiet], axis=0)
    # The vehicle is still accelerating gently: a part of the weight, in no set direction.
    assert np.linalg.norm(off) < 0.1 * GRAVITY
    # The rotors carry the weight.
    vehicle = FILE.vehicle
    rotor = Rotor(Model(vehicle.propeller, parameter_set("paper-apc"), vehicle.air))
    assert check_rotor_speed(log, rotor, vehicle, FILE.log.rotor_unit) == []
    with pytest.raises(InputError, match="no steady segment of 10 s: the longest lasts"):
        steady_segments(log, seconds=10.0)


def test_the_body_velocity_comes_back_from_the_world(tmp_path: Path) -> None:
    """Differentiated positions as world velocity give the body velocity of the file."""
    lines = (FLIGHTS / f"{NAMES[0]}.csv").read_text(encoding="utf-8").splitlines()[:2001]
    (tmp_path / "body.csv").write_text("\n".join(lines), encoding="utf-8")
    table = columns(lines)
    for axis in "xyz":
        table[f"vel_{axis}"] = np.gradient(table[f"pos_{axis}"], table["t"])
    values = np.stack(list(table.values()), axis=1)
    np.savetxt(tmp_path / "world.csv", values, delimiter=",", header=lines[0], comments="")
    log_table = "[log]" + NEUROBEM.read_text(encoding="utf-8").partition("[log]")[2]
    in_world = log_table.replace('velocity_in = "body"', 'velocity_in = "world"')
    assert in_world != log_table
    other = read_flight_log(tmp_path / "world.csv", vehicle_with(in_world, tmp_path))
    difference = other.velocity - read_flight_log(tmp_path / "body.csv", FILE).velocity
    assert np.all(np.sqrt(np.mean(difference**2, axis=0)) < 0.06)
