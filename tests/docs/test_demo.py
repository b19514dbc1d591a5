"""`make demo` compares models with measurements, and writes pictures and their figures."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from examples.demo import Comparison
from propmap.catalogue.lookup import Measurement
from propmap.fit.least_squares import rms
from propmap.typing import Floats

from .pages import ROOT


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
    assert (mine.rms, mine.relative_rms) == pytest.approx((np.sqrt(0.5), 0.2))
    assert (mine.worst, mine.mean, mine.predicted_rms) == pytest.approx((1.0, 0.5, 4.0))
    assert (zero.worst, zero.relative_rms, zero.predicted_rms) == (4.0, pytest.approx(1.0), 0.0)
    # One of two points differs by 1 between both forms of the data.
    assert errors.band == pytest.approx(0.2)
    (still,) = compared(none, {}).errors(np.full(3, True))
    assert still.models["mine"].relative_rms is still.band is None


@pytest.mark.slow
def test_demo(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "demo"
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / "demo.py", "-o", folder],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    for name in ("demo-loads.png", "demo-disk.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG")
    found = json.loads((folder / "demo.json").read_text())
    groups = {group["title"]: group for group in found["groups"]}
    with (folder / "demo.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    oblique = [row for row in rows if row["measured_drag_N"]]

    def off(name: str) -> float:
        return rms(np.array([float(r[name]) - float(r["measured_thrust_N"]) for r in oblique]))

    errors = {one["load"]: one for one in groups["oblique"]["errors"]}
    thrust = errors["thrust"]
    for model in ("recommended", "paper", "hover"):
        assert thrust["models"][model]["rms"] == pytest.approx(off(f"{model}_thrust_N"))
    assert thrust["band"] * thrust["measured_rms"] == pytest.approx(off("other_form_thrust_N"))
    # The annulus average has no pitching moment; of the published one there is no other form.
    pitch = errors["pitch_moment"]
    assert pitch["models"]["paper"]["predicted_rms"] == 0.0 and pitch["band"] is None
