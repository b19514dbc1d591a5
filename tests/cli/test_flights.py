"""`propmap fit flight`, `fit terms` and `simulate flight`: fits, pages and logs of flights."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.fit.comparison import AxisErrors, FittedStep, RecordedFlight, Step
from propmap.flight.simulate import trim
from propmap.flight.steady import operating_points, steady_segments
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log_readers import read_flight_log
from tests.flight import agile

from .conftest import Run, refused
from .fit_inputs import FREE, LEVEL, QUICK, VEHICLE, fitted

pytestmark = pytest.mark.usefixtures("brief", "filters_once", "pictures_as_they_fall")

LOG = agile.agile(rate=50.0, duration=8.0)
"""Two seconds of hover, then curves."""


def test_a_level_table_and_the_study_of_the_body(run: Run) -> None:
    Path("vehicle.toml").write_text(VEHICLE)
    Path("level.csv").write_text(LEVEL)
    asked = ["level.csv", "--vehicle", "vehicle.toml", "--method", "level", "--body-study"]
    found, _ = fitted(run, "flight", *asked, *QUICK)
    assert found["kind"] == "level flight" and found["rows"] == 7
    assert [d["file"] for d in found["data"]] == ["level.csv", "vehicle.toml"]
    # Numbers made up near the hover of paper-apc.
    (residuals,) = found["residuals"].values()
    assert residuals["relative_rms"] < 0.1
    lift, drag = [text for text in found["remarks"] if "m^2 (" in text]
    assert lift.startswith("lift_area ") and drag.startswith("drag_area_x ")
    verdicts = " improves the fit: ", " does not improve the fit: "
    assert all(any(verdict in text for verdict in verdicts) for text in (lift, drag))


def test_without_steady_segments_all_forces_are_fitted(run: Run) -> None:
    Path("vehicle.toml").write_text(agile.vehicle())
    agile.write(LOG, Path("log.csv"))
    vehicle = ["log.csv", "--vehicle", "vehicle.toml"]
    quick = ["--free", ",".join((*FREE, "drag_area_x")), "--starts", "1", "--folds", "0"]
    found, out = fitted(run, "flight", *vehicle, *quick, "--samples", "40")
    assert found["kind"] == "flight" and found["rows"] == 6 * 40
    assert any("fewer than 4 steady segments of 2 s" in told for told in found["remarks"])
    assert "note: fewer than 4 steady segments" in out
    checked = json.loads(run("check", "out.toml", *vehicle, "--format", "json").out)
    assert list(checked["loads"]) == [
        *(f"force_{axis}_N" for axis in "xyz"),
        *(f"moment_{axis}_Nm" for axis in "xyz"),
    ]
    upward = checked["loads"]["force_z_N"]
    # In fits of whole flights the main part is the envelope.
    assert found["envelope"]["percentiles"] == [1.0, 99.0]
    assert sum(one["rows"] for one in upward["by_envelope"].values()) == checked["rows"] == 400
    longer = ["--seconds", "3", "--method", "level", "-o", "no.toml"]
    refused(run("fit", "flight", *vehicle, *quick, *longer), "no steady segment of 3 s")
    assert not Path("no.toml").exists()


ASKED: list[dict[str, Any]] = []


def made_up(
    _: object, flights: Sequence[RecordedFlight], steps: Sequence[Step], __: object, **settings: Any
) -> list[FittedStep]:
    """Each step has half of the error of the one before it."""
    ASKED.append({"flights": flights, "steps": steps, **settings})
    found = []
    for number, step in enumerate(steps):
        for left_out in range(len(flights)):
            offs = [np.full((len(f.passed), 3), 0.5**number) for f in flights]
            off = tuple(AxisErrors(one, one) for one in offs)
            found.append(FittedStep(step.name, left_out, {"c_l1": 5.0}, off, off))
    return found


@pytest.fixture
def flown(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Write two logs with columns of a prediction, and the vehicle file; replace the fits."""
    monkeypatch.setattr("propmap.fit.comparison.fit_terms", made_up)
    ASKED.clear()
    Path("vehicle.toml").write_text(agile.vehicle())
    predicted = {f"other_f{a}": np.full_like(LOG["t"], k + 1.0) for k, a in enumerate("xyz")}
    for name in ("first.csv", "second.csv"):
        agile.write(LOG | predicted, Path(name))
    return ["first.csv", "second.csv", "--vehicle", "vehicle.toml"]


def test_the_page_and_what_was_asked(run: Run, flown: list[str]) -> None:
    told = run("fit", "terms", *flown, "-o", "page", "--samples", "40", "--low-pass", "5")
    assert told.code == 0 and "wrote page/index.html and 4 other files" in told.out
    page = Path("page/index.html").read_text()
    assert "terms reduce the error" in page and "prediction in the file" in page
    (asked,) = ASKED
    assert asked["samples"] == 40 and [f.name for f in asked["flights"]] == ["first", "second"]
    steps = asked["steps"]
    assert steps[0].vertical and not any(step.vertical for step in steps[1:])
    names = [set(step.choice.free) for step in steps]
    assert "drag_area_x" in names[1] and "drag_area_x" not in names[3]
    assert {"sensor_x", "clock_offset"} <= names[2] - names[1]
    assert names[4] - names[3] == {"wake_ahead", "wake_beside", "wake_downwash", "wake_share"}
    assert names[7] - names[4] == {"untwist", "download_area_x", "download_area_y", "plate_area"}
    # Without mounts the rotor drag is that of the blades.
    assert all(step.choice.fixed["drag_factor"] == 1.0 for step in steps[:3])
    first = asked["flights"][0]
    np.testing.assert_allclose(first.prediction, [[1.0, 2.0, 3.0]] * len(first.passed), atol=1e-6)
    # Columns of a prediction by name.
    chosen = ["--prediction", "other_fz,other_fy,other_fx", "-o", "named"]
    assert run("fit", "terms", *flown, *chosen).code == 0
    np.testing.assert_allclose(ASKED[1]["flights"][0].prediction[5], [3.0, 2.0, 1.0], atol=1e-6)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["first.csv"], "two logs have the name 'first'; give each flight once"),
        (["--prediction", "a,b,c"], "--prediction: 'a' is not a column; name three columns"),
        (["--prior-from", "none"], "fit terms needs a prior"),
        (["-o", "taken"], "'mine.txt'"),
    ],
)
def test_bad_input_in_one_line(run: Run, flown: list[str], more: list[str], said: str) -> None:
    Path("taken").mkdir()
    Path("taken/mine.txt").write_text("kept")
    refused(run("fit", "terms", *flown, "-o", "page", *more), said)
    assert not Path("page").exists() and Path("taken/mine.txt").read_text() == "kept"


SIMULATE = ["simulate", "flight", "--vehicle", "vehicle.toml", "--airfoil", "paper-apc"]
SIMULATE += ["--speeds", "9,11,13", "-o", "flight.csv"]


def test_a_flight_is_written_and_read_back(run: Run) -> None:
    Path("vehicle.toml").write_text(VEHICLE)
    done = run(*SIMULATE, "--noise", "0.02", "--seed", "4")
    assert (done.code, done.err) == (0, "")
    for text in ("force error of 2.00%", "c_l1", "alpha_0", "weak", "1/rad", "95 %"):
        assert text in done.out
    assert "wrote flight.csv: 3 speeds" in done.out
    # The table that is printed makes the vehicle file read the log.
    table = done.out[done.out.index("[log]") :]
    Path("vehicle.toml").write_text(VEHICLE + table)
    log = read_flight_log("flight.csv", read_vehicle("vehicle.toml"))
    found = operating_points(log, steady_segments(log))
    assert found.speed == pytest.approx([9.0, 11.0, 13.0], abs=0.03)
    assert "--force" in run(*SIMULATE).err
    # Without noise the log is the trim.
    sensors = (f"--{n}-noise=0" for n in ("rotor", "velocity", "attitude", "accelerometer"))
    again = run(*SIMULATE, "--noise", "0", *sensors, "--force", "--no-expectation")
    assert again.code == 0
    assert "vehicle.toml already describes this log" in again.out
    assert "95 %" not in again.out and "[log]" not in again.out
    read = read_vehicle("vehicle.toml")
    log = read_flight_log("flight.csv", read)
    law = propmap.airfoil("paper-apc").with_corrections(["pitt-peters", "radial-friction"])
    points = trim(read.vehicle, law, np.array([9.0, 11.0, 13.0]))
    # The file has nine digits.
    assert log.rotor_speed[0] == pytest.approx(points.rotor_speed[0], rel=1e-8)
    assert log.velocity[-1] == pytest.approx(points.velocity[2], abs=1e-7)
