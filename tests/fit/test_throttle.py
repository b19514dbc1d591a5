"""Rotor speeds from throttle: the curve, and a flight fitted with it beside one with speeds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from propmap.cli import main
from propmap.cli.fit_flight import FROM_THROTTLE
from propmap.errors import InputError
from propmap.fit.files import read_fit
from propmap.fit.flight import ForceModel
from propmap.fit.least_squares import Rows
from propmap.fit.parameters import FIRST_GUESS, THROTTLE, Choice, general
from propmap.report.fit_page import notes
from propmap.vehicle.throttle import CURVE, HOVER_DRIVE, LAG, USUAL, ThrottleCurve, lagged
from tests.flight.commands import LAG as MOTORS_LAG

from .flight_twin import manoeuvre
from .throttle_twin import LAW, VEHICLE, differences, fit_both


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
    log = replace(
        manoeuvre(0, 12),
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


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Short twins, and a fit of each."""
    here = tmp_path_factory.mktemp("twins")
    fit_both(here, dwell=2.0, samples=40, folds=2)
    return here


def test_forces_from_throttle_are_those_from_rotor_speeds(folder: Path) -> None:
    found = differences(folder)
    assert found["force"] < 0.05
    assert 0.9 < found["band"] < 1.1
    assert found["inside"] > 0.9
    # The fit has another curve than the motors, but finds their lag.
    record = read_fit(folder / "throttle_fit.toml").record
    (lag,) = (p for p in record.parameters if p.name == LAG)
    assert lag.value == pytest.approx(MOTORS_LAG, abs=0.02) and lag.low < MOTORS_LAG < lag.high
    assert FROM_THROTTLE in notes(record)


def test_only_a_fit_with_a_curve_checks_a_log_without_rotor_speeds(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def check(fit: str, log: str) -> int:
        files = [str(folder / f"{fit}_fit.toml"), str(folder / f"unseen_{log}.csv")]
        return main(["check", *files, "--vehicle", str(folder / f"{log}.toml")])

    assert check("throttle", "throttle") == 0
    told = capsys.readouterr()
    assert "in 95 % band" in " ".join(told.out.split()) and "converts throttle" in told.err
    assert check("speeds", "throttle") == 2
    assert "the fit used measured rotor speeds" in capsys.readouterr().err
    # Measured rotor speeds need no curve.
    assert check("throttle", "speeds") == 0


def test_steady_segments_and_terms_need_rotor_speeds(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = [str(folder / f"{name}_throttle.csv") for name in ("seen", "unseen")]
    way = ["--vehicle", str(folder / "throttle.toml"), "-o", str(folder / "none.toml")]
    assert main(["fit", "flight", logs[0], *way, "--method", "level"]) == 2
    assert "do not determine the blade" in capsys.readouterr().err
    assert main(["fit", "terms", *logs, *way]) == 2
    assert "motor commands instead of rotor speeds" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["speeds", "throttle"])
def test_what_is_free_by_default_and_by_a_prior(
    kind: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[tuple[str, ...]] = []

    def fit(_rows: Rows, choice: Choice, *_: object, **__: object) -> None:
        seen.append(choice.free)
        raise InputError("no more is needed", "stop")

    monkeypatch.setattr("propmap.cli.fit_flight.fit", fit)
    log, vehicle = str(folder / f"seen_{kind}.csv"), str(folder / f"{kind}.toml")
    more = ["--prior", "sensor_bias_z=0:0.1", "--prior", "sensor_tilt_y[seen]=0:0.01"]
    more += ["--fix", "motor_lag=0.03", "--fix", "sensor_tilt_x=0"]
    way = ["--method", "balance", "-o", str(folder / "none.toml")]
    assert main(["fit", "flight", log, "--vehicle", vehicle, *more, *way]) == 2
    driven, free = {"throttle_speed", "throttle_expo"}, {general(name) for name in seen[0]}
    assert {"sensor_bias_z", "sensor_tilt_y"} <= free
    assert not {"motor_lag", "sensor_tilt_x", "thrust_scale"} & free
    assert driven & free == (driven if kind == "throttle" else set())
