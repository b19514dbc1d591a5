"""`propmap plot` and `propmap demo` write pictures and the figures behind them."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from propmap.catalogue.lookup import Measurement
from propmap.report.comparison import Comparison
from propmap.report.pictures import MeasuredLoads
from propmap.typing import Floats

from .conftest import POINT, ROTOR, Run

pytestmark = pytest.mark.usefixtures("pictures_as_they_fall")

SIGNATURES = {".png": b"\x89PNG", ".pdf": b"%PDF", ".svg": b"<?xml"}


def _check_picture(path: Path) -> None:
    assert path.read_bytes().startswith(SIGNATURES[path.suffix])


@pytest.mark.parametrize("ending", SIGNATURES)
def test_planform(run: Run, tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"blade{ending}"
    done = run("plot", "planform", "uiuc-apce-9x6", "-o", path)
    assert (done.code, done.out) == (0, f"{path}\n")
    _check_picture(path)
    assert list(tmp_path.iterdir()) == [path]


def test_map_with_measured_points(run: Run, tmp_path: Path) -> None:
    measured = tmp_path / "tunnel.csv"
    measured.write_text("rpm,speed_mps,beta_deg,thrust_N,drag_N\n4010,14,80,1.3,\n4000,15,90,1,1\n")
    path = tmp_path / "map.svg"
    ranges = ["--rpm", "4000", "--speed", "14:16:3", "--beta", "80,90"]
    done = run("plot", "map", *ROTOR, *ranges, "--measured", measured, "-o", path)
    assert done.code == 0, done.err
    text = path.read_text()
    for label in ("thrust T [N]", "rotor drag D [N]", "torque Q [N m]", "V [m/s]", "hover model"):
        assert label in text
    assert "tunnel" in text


def test_disk(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "disk.svg"
    done = run("plot", "disk", *ROTOR, *POINT, "-o", path)
    assert done.code == 0, done.err
    text = path.read_text()
    for label in ("flight", "rotation", "reverse flow", "stalled", "advancing"):
        assert label in text


def test_error_figures() -> None:
    truth, found = np.array([3.0, -4.0, 9.0]), np.array([4.0, -4.0, 0.0])
    none = np.zeros(3)

    def compared(measured: Floats, other: Mapping[str, Floats]) -> Comparison:
        data = Measurement("d", "p", "fit", 1.2, "", "", none, none, none, {"thrust": measured})
        models = {"mine": {"thrust": found}, "zero": {"thrust": none}}
        return Comparison(data, models, np.full(3, "ok"), other)

    both = compared(truth, {"thrust": np.array([3.0, -3.0, 0.0])})
    (errors,) = both.errors(np.array([True, True, False]))
    assert (errors.load, errors.unit, errors.points) == ("thrust", "N", 2)
    assert errors.measured_rms == pytest.approx(np.sqrt(12.5))
    mine, zero = errors.models["mine"], errors.models["zero"]
    assert mine.rms == pytest.approx(np.sqrt(0.5))
    assert mine.relative_rms == pytest.approx(0.2)
    assert (mine.worst, mine.mean) == (1.0, 0.5)
    assert mine.predicted_rms == pytest.approx(4.0)
    assert (zero.worst, zero.relative_rms, zero.predicted_rms) == (4.0, pytest.approx(1.0), 0.0)
    # One of two points differs by 1 between both forms of the data.
    assert errors.band == pytest.approx(0.2)
    (still,) = compared(none, {}).errors(np.full(3, True))
    assert still.models["mine"].relative_rms is None
    assert still.band is None


def test_measured_points_lie_along_their_angle() -> None:
    speed, beta = np.array([4.0, 0.0, 2.0, 3.0]), np.radians([90.0, 0.0, 90.4, 60.0])
    points = MeasuredLoads("", speed, beta, {})
    quarter = 0.5 * np.pi
    assert points.along(quarter, at_rest=False).tolist() == [2, 0]
    assert points.along(quarter, at_rest=True).tolist() == [1, 2, 0]


@pytest.mark.slow
def test_demo(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "new" / "demo"
    done = run("demo", "-o", folder)
    assert done.code == 0, done.err
    assert done.out.splitlines()[-1].endswith("demo-loads.png")
    for name in ("demo-loads.png", "demo-disk.png"):
        _check_picture(folder / name)
    found = json.loads((folder / "demo.json").read_text())
    groups = {group["title"]: group for group in found["groups"]}
    assert {"static", "axial", "oblique", "oblique 90"} <= set(groups)
    with (folder / "demo.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    oblique = [row for row in rows if row["measured_drag_N"]]

    def off(name: str) -> float:
        return float(
            np.sqrt(
                np.mean([(float(r[name]) - float(r["measured_thrust_N"])) ** 2 for r in oblique])
            )
        )

    errors = {one["load"]: one for one in groups["oblique"]["errors"]}
    thrust, roll, pitch = (errors[load] for load in ("thrust", "roll_moment", "pitch_moment"))
    assert thrust["points"] == len(oblique)
    for model in ("recommended", "paper", "hover"):
        assert thrust["models"][model]["rms"] == pytest.approx(off(f"{model}_thrust_N"))
    assert thrust["band"] * thrust["measured_rms"] == pytest.approx(off("other_form_thrust_N"))
    # Fitted loads come out as closely as the data are known; of the others the rolling moment.
    for load in ("thrust", "torque"):
        assert errors[load]["models"]["recommended"]["relative_rms"] < 0.03
    assert roll["models"]["recommended"]["relative_rms"] < 0.06 < roll["band"]
    assert roll["models"]["paper"]["relative_rms"] > 0.2
    assert roll["models"]["hover"]["relative_rms"] == pytest.approx(1.0)
    # The annulus average has no pitching moment; of the published one there is no other form.
    assert pitch["models"]["paper"]["predicted_rms"] == 0.0
    assert pitch["band"] is None
    slanted = [row for row in rows if float(row["measured_pitch_moment_Nm"] or 0.0)]
    assert len(slanted) == 150
    for row in slanted:
        assert (
            float(row["measured_pitch_moment_Nm"]) * float(row["recommended_pitch_moment_Nm"]) > 0
        )
