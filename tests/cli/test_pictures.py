"""`propmap plot` and `propmap demo` write pictures and the figures behind them."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from propmap.catalogue.measurements import Measurement
from propmap.report.comparison import Comparison

from .conftest import POINT, ROTOR, Run

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
    other = np.zeros(3)
    axes = (other, other, other)
    data = Measurement("d", "p", "fit", 1.2, "", "", *axes, {"thrust": truth})
    both = Comparison(data, {"thrust": truth}, {"thrust": found}, {"thrust": other}, other)
    (errors,) = both.errors(np.array([True, True, False]))
    assert (errors.load, errors.unit, errors.points) == ("thrust", "N", 2)
    assert errors.measured_rms == pytest.approx(np.sqrt(12.5))
    assert errors.model.rms == pytest.approx(np.sqrt(0.5))
    assert errors.model.relative_rms == pytest.approx(0.2)
    assert (errors.model.worst, errors.model.mean) == (1.0, 0.5)
    assert (errors.hover.worst, errors.hover.relative_rms) == (4.0, pytest.approx(1.0))
    still = Comparison(data, {"thrust": other}, {"thrust": found}, {"thrust": other}, other)
    assert still.errors(np.full(3, True))[0].model.relative_rms is None


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
    error = [float(row["predicted_thrust_N"]) - float(row["measured_thrust_N"]) for row in oblique]
    thrust = next(one for one in groups["oblique"]["errors"] if one["load"] == "thrust")
    assert thrust["points"] == len(oblique)
    assert thrust["model"]["rms"] == pytest.approx(np.sqrt(np.mean(np.square(error))))
    # The model must know what the hover model cannot.
    roll = next(one for one in groups["oblique"]["errors"] if one["load"] == "roll_moment")
    assert roll["model"]["relative_rms"] < 0.1 < roll["hover"]["relative_rms"]
