"""One simulated flight as CSV, ULog, DataFlash and bag: one set of points, one fit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.fit.fit import Settings, fit
from propmap.fit.flight import ForceModel, level_rows
from propmap.fit.parameters import Choice
from propmap.fit.tunnel import first_guess
from propmap.flight.simulate import SensorNoise, fly, trim
from propmap.flight.steady import operating_points, steady_segments
from propmap.vehicle.log import FlightLog
from propmap.vehicle.log_readers import read_flight_log
from tests.flight.synthetic import vehicle_with
from tests.vehicle.write_dataflash import write_dataflash
from tests.vehicle.write_logs import write_bag, write_csv, write_ulog

FREE = Choice(("c_l1", "alpha_0"), {"c_l2": 1.7, "c_d": 1.8})
SPEEDS = np.linspace(1.0, 12.0, 8)


@pytest.mark.slow
def test_formats_agree(tmp_path: Path) -> None:
    here = vehicle_with("", tmp_path)
    vehicle = here.vehicle
    points = trim(vehicle, propmap.airfoil("paper-apc"), SPEEDS)
    log = fly(points, noise=SensorNoise(), seed=5, rate=50.0)
    found: dict[str, FlightLog] = {}
    writers = {
        "csv": lambda path: write_csv(log, path),
        "ulg": lambda path: write_ulog(log, path, vehicle),
        "bin": lambda path: write_dataflash(log, path),
        "bag": lambda path: write_bag(log, path, vehicle),
    }
    for name, write in writers.items():
        folder = tmp_path / name
        folder.mkdir()
        path = folder / f"flight.{name}" if name != "bag" else folder / "flight"
        read = read_flight_log(path, vehicle_with(write(path), folder))
        found[name] = operating_points(read, steady_segments(read))
    first = found["csv"]
    assert len(first) == SPEEDS.size
    fits = {}
    for name, seen in found.items():
        assert seen.velocity == pytest.approx(first.velocity, abs=0.02), name
        assert seen.rotor_speed == pytest.approx(first.rotor_speed, rel=2e-3), name
        assert seen.up == pytest.approx(first.up, abs=2e-3), name
        rows = level_rows(ForceModel(vehicle, seen, first_guess()), FREE)
        fits[name] = fit(rows, FREE, Settings(starts=1, folds=0))
    for name, other in fits.items():
        sure = fits["csv"].uncertainty
        assert np.all((sure.low <= other.x) & (other.x <= sure.high)), name
