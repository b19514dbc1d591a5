"""A simulated log goes through the readers and gives its operating points again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.errors import InputError
from propmap.flight.simulate import (
    NOISELESS,
    SensorNoise,
    expectation,
    fly,
    log_csv,
    log_map,
    log_table,
)
from propmap.flight.steady import operating_points, steady_segments
from propmap.units import GRAVITY
from propmap.vehicle.log import FlightLog
from propmap.vehicle.log_readers import read_flight_log
from propmap.vehicle.vehicle import Vehicle

from .conftest import SPEEDS
from .synthetic import vehicle_with


def _read_back(log: FlightLog, folder: Path) -> FlightLog:
    path = folder / "flight.csv"
    path.write_text(log_csv(log))
    file = vehicle_with(log_table(4), folder)
    assert file.log.columns == log_map(4).columns
    return read_flight_log(path, file)


def test_the_points_come_back(points: FlightLog, tmp_path: Path) -> None:
    noise = SensorNoise()
    points = points.picked(slice(7, None))
    log = _read_back(fly(points, noise=noise, seed=3), tmp_path)
    segments = steady_segments(log)
    assert len(segments) == len(points)
    found = operating_points(log, segments)
    # There are 600 samples; a margin for the moments around each segment that are not steady.
    mean = 5.0 / np.sqrt(600.0)
    assert found.velocity == pytest.approx(points.velocity, abs=mean * noise.velocity + 0.01)
    assert found.up == pytest.approx(points.up, abs=mean * noise.attitude + 0.002)
    allowed = mean * noise.specific_force + 0.03
    assert found.specific_force == pytest.approx(points.specific_force, abs=allowed)
    assert found.rotor_speed == pytest.approx(points.rotor_speed, rel=mean * noise.rotor_speed)
    assert found.rates == pytest.approx(points.rates, abs=0.02)


def test_without_noise(points: FlightLog, tmp_path: Path) -> None:
    flown = fly(points.picked(slice(0, None, 11)), noise=NOISELESS, rate=50.0)
    log = _read_back(flown, tmp_path)
    for name in ("time", "velocity", "rates", "up", "specific_force", "rotor_speed"):
        # The file has nine digits.
        written, read = getattr(flown, name), getattr(log, name)
        np.testing.assert_allclose(read, written, rtol=1e-8, atol=1e-7, err_msg=name)
    held = log.picked(log.time < 6.0)
    np.testing.assert_allclose(held.velocity - points.velocity[0], 0.0, atol=1e-7)
    np.testing.assert_allclose(np.sum(held.specific_force * held.up, axis=1), GRAVITY, rtol=1e-6)
    # What the accelerometer reads between two speeds is their difference.
    forward = log.velocity / log.speed[:, None]
    push = np.sum(log.specific_force * forward, axis=1)
    assert np.sum(push[1:] * np.diff(log.time)) == pytest.approx(14.0, rel=1e-3)
    assert np.abs(push).max() <= 2.0 + 1e-6


def test_the_seed_decides(points: FlightLog) -> None:
    two = points.picked(slice(0, 2))
    one, same, other = (fly(two, noise=SensorNoise(), seed=s) for s in (1, 1, 2))
    assert np.array_equal(one.velocity, same.velocity)
    assert not np.array_equal(one.velocity, other.velocity)
    spread = np.std(one.rotor_speed[:600] / two.rotor_speed[0])
    assert spread == pytest.approx(SensorNoise().rotor_speed, rel=0.1)


@pytest.mark.parametrize(("dwell", "rate"), [(0.5, 100.0), (6.0, 1.0), (3600.0, 10_000.0)])
def test_bad_sampling(points: FlightLog, dwell: float, rate: float) -> None:
    with pytest.raises(InputError):
        fly(points, dwell=dwell, rate=rate)


def test_deviations_shrink_with_flights_and_precision(
    vehicle: Vehicle, airfoil: propmap.Airfoil, points: FlightLog
) -> None:
    def deviation(log: FlightLog, error: float) -> np.ndarray:
        found = expectation(vehicle, airfoil, log, error=error).uncertainty
        return np.sqrt(np.diag(found.covariance))

    once = deviation(points, 0.01)
    ratio = deviation(points.picked(np.tile(np.arange(SPEEDS.size), 4)), 0.01) / once
    # The square root of four times as many, and less as fewer degrees of freedom are lost.
    assert (ratio < 0.75).all()
    assert deviation(points, 0.02) == pytest.approx(2.0 * once)
    # Loads are not known better than to 0.1 %.
    assert deviation(points, 0.0) == pytest.approx(0.1 * once)


def test_verdicts(vehicle: Vehicle, airfoil: propmap.Airfoil, points: FlightLog) -> None:
    precise = expectation(vehicle, airfoil, points, error=0.001)
    verdicts = dict(zip(precise.choice.free, precise.uncertainty.verdicts, strict=True))
    assert verdicts["c_l1"] == "identified"
    assert "the data allow" in verdicts["c_d"]
    assert precise.truth[0] == airfoil.c_l1
    blind = expectation(vehicle, airfoil, points.picked(slice(0, 2)))
    assert not any(blind.uncertainty.identified)
    outside = airfoil.with_parameters(alpha_0=0.95)
    with pytest.raises(InputError, match="outside the bounds of a fit"):
        expectation(vehicle, outside, points)
