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
from propmap.vehicle.log_readers import read_flight_log

from .synthetic import FLIGHTS, NEUROBEM

pytestmark = pytest.mark.skipif(not FLIGHTS.is_dir(), reason="the flights are not here")
FILE = read_vehicle(NEUROBEM)


@pytest.mark.parametrize("name", ["neurobem_20210218171908", "neurobem_20210218172600"])
def test_a_flight_is_read_and_holds_together(name: str) -> None:
    path = FLIGHTS / f"{name}.csv"
    log, table = read_flight_log(path, FILE), np.genfromtxt(path, delimiter=",", names=True)
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
