"""Two real flights, where they are at hand: frames, gravity and hover thrust hold together."""

from __future__ import annotations

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.flight.checks import check_rotor_speed
from propmap.flight.steady import steady_segments
from propmap.model.airfoil import parameter_set
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.units import GRAVITY
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import FlightLog
from propmap.vehicle.log_readers import read_flight_log

from .synthetic import FLIGHTS, NEUROBEM

NAMES = ("neurobem_20210218171908", "neurobem_20210218172600")
pytestmark = pytest.mark.skipif(not FLIGHTS.is_dir(), reason="the flights are not here")
FILE = read_vehicle(NEUROBEM)


@pytest.fixture(params=NAMES)
def flight(request: pytest.FixtureRequest) -> tuple[FlightLog, np.ndarray]:
    """The log as read, and the file's own columns."""
    path = FLIGHTS / f"{request.param}.csv"
    return read_flight_log(path, FILE), np.genfromtxt(path, delimiter=",", names=True)


def test_every_sample_is_read(flight: tuple[FlightLog, np.ndarray]) -> None:
    log, table = flight
    np.testing.assert_array_equal(log.time, table["t"])
    np.testing.assert_array_equal(log.rotor_speed[:, 2], table["mot3"])
    assert 11.0 < log.speed.max() < 15.0


def test_gravity_is_along_up_in_quiet_flight(flight: tuple[FlightLog, np.ndarray]) -> None:
    log, _ = flight
    quiet = (log.speed < 0.3) & (np.linalg.norm(log.rates, axis=1) < 0.1)
    assert quiet.sum() > 20
    off = np.mean(log.specific_force[quiet] - GRAVITY * log.up[quiet], axis=0)
    # The vehicle is still accelerating gently: a part of the weight, in no set direction.
    assert np.linalg.norm(off) < 0.1 * GRAVITY


def test_positions_move_with_the_velocity(flight: tuple[FlightLog, np.ndarray]) -> None:
    """The vertical velocity by ``up``, and all of it by the file's own quaternion."""
    log, table = flight
    position = np.stack([table[f"pos_{axis}"] for axis in "xyz"], axis=1)
    moved = np.gradient(position, log.time, axis=0)
    np.testing.assert_allclose(np.linalg.norm(moved, axis=1), log.speed, atol=0.6)
    assert np.sqrt(np.mean((moved[:, 2] - log.climb_rate) ** 2)) < 0.05


def test_the_body_velocity_comes_back_from_the_world(
    flight: tuple[FlightLog, np.ndarray], tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Differentiated positions as world velocity give the body velocity of the file."""
    log, table = flight
    names = list(table.dtype.names)
    columns = {name: table[name].copy() for name in names}
    for axis in "xyz":
        columns[f"vel_{axis}"] = np.gradient(table[f"pos_{axis}"], table["t"])
    folder = tmp_path_factory.mktemp("world")
    np.savetxt(
        folder / "a.csv",
        np.stack(list(columns.values()), axis=1),
        delimiter=",",
        header=",".join(names),
        comments="",
    )
    text = NEUROBEM.read_text(encoding="utf-8").replace(
        'velocity_in = "body"', 'velocity_in = "world"'
    )
    text = text.replace('"propeller.csv"', f"'{NEUROBEM.parent / 'propeller.csv'}'")
    (folder / "vehicle.toml").write_text(text, encoding="utf-8")
    other = read_flight_log(folder / "a.csv", read_vehicle(folder / "vehicle.toml"))
    difference = other.velocity - log.velocity
    assert np.all(np.sqrt(np.mean(difference**2, axis=0)) < 0.06)


def test_the_rotors_carry_the_weight(flight: tuple[FlightLog, np.ndarray]) -> None:
    log, _ = flight
    vehicle = FILE.vehicle
    rotor = Rotor(Model(vehicle.propeller, parameter_set("paper-apc"), vehicle.air))
    assert check_rotor_speed(log, rotor, vehicle, FILE.log.rotor_unit) == []
    as_rpm = FlightLog(**{**log.__dict__, "rotor_speed": log.rotor_speed * np.pi / 30.0})
    with pytest.raises(InputError, match="rad/s read as rpm"):
        check_rotor_speed(as_rpm, rotor, vehicle, "rpm")


def test_aggressive_flights_have_no_long_steady_segment(
    flight: tuple[FlightLog, np.ndarray],
) -> None:
    log, _ = flight
    with pytest.raises(InputError, match="no steady segment of 10 s: the longest lasts"):
        steady_segments(log, seconds=10.0)
