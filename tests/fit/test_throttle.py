"""Rotor speeds from throttle: the curve, and a flight fitted with it beside one with speeds."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from propmap.cli import main
from propmap.cli.fit_flight import FROM_THROTTLE, read_flights
from propmap.fit.comparison import flight_forces, force_deviations, values_for
from propmap.fit.files import FitFile, read_fit
from propmap.fit.flight import ForceModel
from propmap.fit.parameters import FIRST_GUESS, THROTTLE
from propmap.flight.simulate import SensorNoise, fly, log_csv, log_table, trim
from propmap.model.airfoil import parameter_set
from propmap.typing import Floats
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import FlightLog
from propmap.vehicle.throttle import CURVE, HOVER_DRIVE, LAG, USUAL, ThrottleCurve, lagged
from tests.flight.commands import Commands, commands
from tests.flight.synthetic import NEUROBEM, vehicle_text

VEHICLE = read_vehicle(NEUROBEM).vehicle
LAW = parameter_set("paper-apc").with_corrections(["pitt-peters", "installed:factor=1.9"])
SPEEDS = np.array([0.5, 3.0, 6.0, 9.0])
FREE = "c_l1,zero_lift_angle,c_d0,drag_factor,mount_area,drag_area_z"
RATE = 50.0


def test_the_lag_is_that_of_a_motor() -> None:
    time = np.arange(0.0, 1.0, 0.01)
    once, by_lag = lagged(np.where(time < 0.2, 1.0, 2.0)[:, None], 0.01)
    assert once[time < 0.19] == pytest.approx(1.0)
    later = time > 0.2
    # Between samples commands change linearly: the step is at 0.195 s on average.
    expected = 2.0 - np.exp(-(time - 0.195) / USUAL[LAG])
    assert once[later, 0] == pytest.approx(expected[later], abs=3e-3)
    # A longer lag has reached less.
    assert (by_lag[later] < 0.0).all()


def test_derivatives_of_rotor_speeds_and_forces() -> None:
    rng = np.random.default_rng(1)
    shape = (12, 4)
    log = FlightLog(
        source="hand-made",
        time=np.arange(12.0),
        velocity=rng.normal(size=(12, 3)) * [4.0, 1.0, 1.0],
        rates=np.zeros((12, 3)),
        up=np.tile([0.0, 0.0, 1.0], (12, 1)),
        specific_force=np.tile([0.0, 0.0, 9.81], (12, 1)),
        rotor_speed=np.ones(shape),
        throttle=0.45 * rng.uniform(0.7, 1.4, shape),
        throttle_by_lag=0.45 * rng.normal(size=shape),
    )
    at = {HOVER_DRIVE: 0.45, "throttle_speed": 1.1, "throttle_expo": 0.4, "motor_lag": 0.06}
    model = ForceModel(VEHICLE, log, LAW)
    section = {name: getattr(LAW, name) for name in ("c_l1", "c_l2", "c_d", "alpha_0")}
    values = {**FIRST_GUESS, **section, **at}
    found = model.at(values, CURVE).slopes
    for row, name in enumerate(CURVE):
        step = 1e-4 * THROTTLE[name].spread
        up, down = (model.at({**values, name: at[name] + h}, ()).loads for h in (step, -step))
        quotient = (up - down) / (2.0 * step)
        assert found[row] == pytest.approx(quotient, rel=1e-3, abs=1e-3 * np.abs(quotient).max())


def test_measured_speeds_stay() -> None:
    speeds = np.full((3, 4), 700.0)
    curve = ThrottleCurve.of(VEHICLE, {HOVER_DRIVE: 0.5})
    unknown = np.full_like(speeds, np.nan)
    found, slopes = curve.speeds(unknown, unknown, speeds)
    assert np.array_equal(found, speeds)
    assert all(not slope.any() for slope in slopes.values())


# -------------------------------------------------------------------------------------------------
# Twins: a flight with rotor speeds, and the same with commands to the motors in place of them.


def _write(log: FlightLog, driven: Commands | None, folder: Path, name: str) -> Path:
    path = folder / f"{name}.csv"
    lines = list(csv.reader(log_csv(log).splitlines()))
    if driven is not None:
        pulses = 1000.0 + 1000.0 * driven.share
        more = np.column_stack([pulses, driven.voltage])
        heads = [*(f"pwm_{k}" for k in range(1, 5)), "volts"]
        kept = len(lines[0]) - 4
        cells = [heads, *([f"{x:.6f}" for x in row] for row in more)]
        lines = [[*row[:kept], *new] for row, new in zip(lines, cells, strict=True)]
    path.write_text("\n".join(",".join(row) for row in lines) + "\n")
    return path


def _flown(seed: int) -> tuple[FlightLog, Commands]:
    """Circles with the noise of sensors, but for what commands are made from."""
    points = trim(VEHICLE, LAW, SPEEDS, radius=12.0, tether=False)
    noise = SensorNoise(rotor_speed=0.0)
    smooth = fly(points, dwell=5.0, rate=RATE, noise=noise, seed=seed)
    rng = np.random.default_rng(seed)
    noisy = 1.0 + SensorNoise().rotor_speed * rng.standard_normal(smooth.rotor_speed.shape)
    return replace(smooth, rotor_speed=smooth.rotor_speed * noisy), commands(smooth, 0.01)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Vehicle files, logs of two flights with each kind of columns, and a fit of the first."""
    here = tmp_path_factory.mktemp("twins")
    table = log_table(4)
    named, _, speeds = table.partition("rotor_speed")
    driven = "throttle" + speeds.replace("rotor_", "pwm_").replace("_radps", "")
    limits = named.replace("[log]", "[log]\nthrottle_range = [1000, 2000]")
    texts = {"speeds": table, "throttle": f'{limits}{driven}battery_voltage = "volts"\n'}
    for kind, text in texts.items():
        (here / f"{kind}.toml").write_text(vehicle_text(text))
    for seed, name in ((1, "seen"), (2, "unseen")):
        log, motors = _flown(seed)
        _write(log, None, here, f"{name}_speeds")
        _write(log, motors, here, f"{name}_throttle")
    for kind, more in (("speeds", ""), ("throttle", f",{','.join(CURVE)}")):
        log, vehicle, fit = (
            here / n for n in (f"seen_{kind}.csv", f"{kind}.toml", f"{kind}_fit.toml")
        )
        options = ["--vehicle", str(vehicle), "--method", "balance", "--prior-from", "population"]
        few = ["--free", FREE + more, "--starts", "1", "--folds", "3", "--samples", "150"]
        assert main(["fit", "flight", str(log), *options, *few, "-o", str(fit)]) == 0
    return here


def _predicted(folder: Path, kind: str) -> tuple[FitFile, Floats, Floats]:
    """Forces (n, 3) [N] on the flight that was not fitted, and their deviations."""
    file, path = read_fit(folder / f"{kind}_fit.toml"), folder / f"unseen_{kind}.csv"
    vehicle = read_vehicle(folder / f"{kind}.toml")
    log = read_flights([path], vehicle, "balance", low_pass=6.0, curve=file.curve).log
    values, _ = values_for(file, vehicle.vehicle, log, [path])
    deviations = force_deviations(file, vehicle.vehicle, log, values)
    assert deviations is not None
    forces = flight_forces(vehicle.vehicle, log, file.airfoil, values).model
    return file, forces[:, :3], deviations[:, :3]


def test_forces_from_throttle_are_those_from_rotor_speeds(folder: Path) -> None:
    _, by_speed, band = _predicted(folder, "speeds")
    file, by_throttle, wider = _predicted(folder, "throttle")
    # The curve is another one than that of the motors, and its lag is found.
    lag = next(p for p in file.record.parameters if p.name == LAG)
    assert lag.low < 0.04 < lag.high
    size = np.sqrt(np.mean(np.sum(by_speed**2, axis=1)))
    off = by_throttle - by_speed
    assert np.sqrt(np.mean(np.sum(off**2, axis=1))) < 0.1 * size
    assert np.mean(np.abs(off) < 1.96 * wider, axis=0) == pytest.approx(1.0, abs=0.12)
    assert np.sqrt(np.mean(wider**2)) < 1.1 * np.sqrt(np.mean(band**2))


def test_the_fit_file_and_check_say_so(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fit, log = str(folder / "throttle_fit.toml"), str(folder / "unseen_throttle.csv")
    assert FROM_THROTTLE in read_fit(Path(fit)).record.remarks
    assert main(["check", fit, log, "--vehicle", str(folder / "throttle.toml")]) == 0
    told = capsys.readouterr()
    assert "in the 95 % bands" in told.out and "from throttle" in told.err


def test_steady_stretches_need_rotor_speeds(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, vehicle = str(folder / "seen_throttle.csv"), str(folder / "throttle.toml")
    way = ["--method", "level", "-o", str(folder / "none.toml")]
    assert main(["fit", "flight", log, "--vehicle", vehicle, *way]) == 2
    assert "say nothing of the blade" in capsys.readouterr().err
