"""`propmap wind`: table, files and picture, the check by a measured airspeed, and bad input."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.flight import agile

from .conftest import Run, refused
from .fit_inputs import FREE

pytestmark = pytest.mark.usefixtures("brief", "filters_once", "pictures_as_they_fall")

MEASURED = 'air_speed = "pitot"\n'


@pytest.fixture
def flown(run: Run) -> list[str]:
    """A fit and its log with a measured airspeed; the arguments of the command."""
    columns = agile.agile(rate=50.0, duration=8.0)
    velocity = np.stack([columns[name] for name in agile.VECTORS["velocity"]], axis=1)
    columns["pitot"] = np.linalg.norm(velocity, axis=1)
    agile.write(columns, Path("log.csv"))
    Path("vehicle.toml").write_text(agile.vehicle() + MEASURED)
    asked = ["log.csv", "--vehicle", "vehicle.toml", "--method", "balance"]
    quick = ["--free", ",".join((*FREE, "drag_factor")), "--starts", "1", "--samples", "60"]
    assert run("fit", "flight", *asked, *quick, "-o", "fit.toml").code == 0
    return ["wind", "fit.toml", *asked[:3]]


def test_table_files_and_picture(run: Run, flown: list[str]) -> None:
    shown = run(*flown, "--picture", "wind.png")
    assert shown.code == 0 and Path("wind.png").stat().st_size > 10_000
    printed = " ".join(shown.out.split())
    assert "mean wind" in printed and "100% in the 95 % band" in printed
    found: dict[str, Any] = json.loads(run(*flown, "--format", "json").out)
    assert printed.endswith(found["summary"])
    rows = found["samples"]
    assert len(rows) == pytest.approx(5 * 8, abs=4)
    for row in rows:
        for name in ("wind_east", "wind_up", "airspeed"):
            low, middle, high = (row[f"{name}{end}_mps"] for end in ("_low_95", "", "_high_95"))
            assert low < middle < high
    # The flight was in still air.
    assert np.all(np.abs(found["mean_mps"]) < found["mean_half_width_95_mps"])
    assert run(*flown, "-o", "wind.csv").code == 0
    head, first = Path("wind.csv").read_text().splitlines()[:2]
    assert head.startswith("time_s,wind_east_mps,wind_east_low_95_mps")
    assert float(first.split(",")[1]) == rows[0]["wind_east_mps"]


def test_a_stated_wind_is_ignored(run: Run, flown: list[str]) -> None:
    before = run(*flown, "--format", "json").out
    text = Path("vehicle.toml").read_text().replace("[log]", "[log]\nwind = [3.0, 1.0, 0.0]")
    Path("vehicle.toml").write_text(text)
    assert run(*flown, "--format", "json").out == before


def test_bad_input(run: Run, flown: list[str]) -> None:
    text = Path("fit.toml").read_text()
    Path("level.toml").write_text(text.replace('kind = "flight"', 'kind = "level flight"'))
    words = "level.toml", "level flight fit", "--method balance"
    refused(run("wind", "level.toml", *flown[2:]), *words)
    refused(run("wind", "vehicle.toml", *flown[2:]), "vehicle.toml")
    vehicle = Path("vehicle.toml").read_text()
    for left_out in ("specific_force", "velocity"):
        kept = (line for line in vehicle.splitlines() if not line.startswith(left_out + " "))
        Path("vehicle.toml").write_text("\n".join(kept))
        refused(run(*flown), left_out.replace("_", " ")[:8])
    Path("vehicle.toml").write_text(vehicle)
    refused(run(*flown, "-o", "nowhere/wind.csv"), "nowhere")
    refused(run(*flown, "--picture", "wind.txt"), ".png")
    Path("log.csv").write_text(Path("log.csv").read_text().splitlines()[0] + "\n")
    refused(run(*flown), "log.csv")
