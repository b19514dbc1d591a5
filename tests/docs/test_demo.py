"""`make demo` compares models with measurements, and writes pictures and their figures."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from propmap.fit.least_squares import rms

from .pages import ROOT


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
