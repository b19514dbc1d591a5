"""`propmap fit flight`: operating points and logs in, a fit file out."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from propmap.cli import main
from propmap.units import GRAVITY

from .conftest import Run, brief_commands
from .fit_inputs import CHECKED, FREE, LEVEL, QUICK, VEHICLE, fit_record, fitted


@pytest.fixture(scope="module")
def level_fit(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("fit")
    (place / "vehicle.toml").write_text(VEHICLE)
    (place / "level.csv").write_text(LEVEL)
    fit = place / "level_fit.toml"
    vehicle = ["--vehicle", str(place / "vehicle.toml")]
    level = [str(place / "level.csv"), "--method", "level", "--body-study"]
    with brief_commands():
        assert main(["fit", "flight", *level, *vehicle, *QUICK, "-o", str(fit)]) == 0
    return fit


def test_a_level_table(level_fit: Path) -> None:
    found = fit_record(level_fit)
    assert found["kind"] == "level flight" and found["rows"] == 7
    names = [d["file"] for d in found["data"]]
    assert names == ["level.csv", "vehicle.toml"]
    assert set(found["residuals"]) == {"vertical_force"}
    assert found["settings"]["vehicle"] == "test quadrotor"
    # Numbers made up near the hover of paper-apc.
    assert found["residuals"]["vertical_force"]["relative_rms"] < 0.1


def test_the_body_study_says_whether_its_terms_pay(level_fit: Path) -> None:
    told = [text for text in fit_record(level_fit)["remarks"] if "m^2 (" in text]
    assert len(told) == 2
    assert told[0].startswith("lift_area ") and told[1].startswith("drag_area_x ")
    assert all(" pays: " in t or " does not pay: " in t for t in told)
    assert all("m^2" in t and "residuals" in t for t in told)


def turning_log(folder: Path, count: int = 200) -> Path:
    """Two seconds of changing speed at 100 Hz, and the vehicle file with its columns."""
    time = np.arange(count) / 100.0
    speed = 2.0 + 4.0 * time
    half = 0.05 + 0.02 * time
    lines = ["t,vx,vy,vz,p,q,r,ax,ay,az,qw,qx,qy,qz,m1,m2,m3,m4"]
    for k in range(count):
        cosine, sine = np.cos(2 * half[k]), np.sin(2 * half[k])
        v = (speed[k] * cosine, 0.0, speed[k] * sine)
        # An acceleration of 4 m/s^2 forwards, and gravity, along the axes of a nose that sinks.
        felt = (4.0 * cosine - GRAVITY * sine, 0.0, 4.0 * sine + GRAVITY * cosine)
        numbers = [time[k], *v, 0.0, 0.04, 0.0, *felt]
        numbers += [np.cos(half[k]), 0.0, np.sin(half[k]), 0.0, *(4 * [585.0 + speed[k]])]
        lines.append(",".join(f"{number:.9g}" for number in numbers))
    (folder / "log.csv").write_text("\n".join(lines) + "\n")
    (folder / "logged.toml").write_text(
        VEHICLE
        + '[log]\nbody_frame = "flu"\nworld_frame = "enu"\nvelocity_in = "body"\n'
        + 'rotor_unit = "rad/s"\n[log.columns]\ntime = "t"\nvelocity = ["vx", "vy", "vz"]\n'
        + 'rates = ["p", "q", "r"]\nspecific_force = ["ax", "ay", "az"]\n'
        + "".join(f'{name} = "{name}"\n' for name in ("qw", "qx", "qy", "qz"))
        + 'rotor_speed = ["m1", "m2", "m3", "m4"]\n'
    )
    return folder / "log.csv"


@pytest.mark.slow
def test_without_steady_stretches_all_forces_are_fitted(run: Run, tmp_path: Path) -> None:
    log = turning_log(tmp_path)
    vehicle = ["--vehicle", tmp_path / "logged.toml"]
    free = ["--free", ",".join((*FREE, "drag_area_x")), "--starts", "1", "--samples", "40"]
    found, out = fitted(run, "flight", log, *vehicle, *free)
    assert found["kind"] == "flight" and found["rows"] == 120
    # A made-up log, whose rates and sideways force never change: that is said as well.
    told = " ".join(found["remarks"])
    assert "rates (p, q, r) never change" in told and "look for a dead axis" in told
    assert "fewer than 4 steady stretches of 2 s" in told
    assert "note: fewer than 4 steady stretches" in out
    checked = json.loads(run("check", "out.toml", log, *vehicle, "--format", "json").out)
    assert set(checked) == {"corrections", "rows", "loads"} and checked["rows"] == 200
    assert set(checked["loads"]) == {"force_x_N", "force_y_N", "force_z_N"}
    assert set(checked["loads"]["force_z_N"]) == CHECKED | {"by_speed", "by_envelope", "in_band"}
    # In fits of whole flights the main part is the envelope.
    assert found["envelope"]["percentiles"] == [1.0, 99.0]
    apart = checked["loads"]["force_z_N"]["by_envelope"]
    assert sum(one["rows"] for one in apart.values()) == 200
    refused = run("fit", "flight", log, *vehicle, *free, "--method", "level", "-o", "no.toml")
    assert refused.code == 2 and "no steady segment of 2 s" in refused.err
    assert not (tmp_path / "no.toml").exists()
