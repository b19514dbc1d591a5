"""Fitted on one real flight and checked on another, through the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from propmap.cli import main

ROOT = Path(__file__).parents[2]
VEHICLE = ROOT / "examples" / "neurobem" / "vehicle.toml"
FLIGHTS = ROOT.parent / "shared" / "data" / "flight"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not FLIGHTS.is_dir(), reason="the flights are not here"),
]


def test_half_the_hover_model_s_vertical_error_on_a_flight_not_seen(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fit, vehicle = tmp_path / "fit.toml", ["--vehicle", str(VEHICLE)]
    seen = str(FLIGHTS / "neurobem_20210218171908.csv")
    unseen = str(FLIGHTS / "neurobem_20210218172600.csv")
    # With constants as propellers have them it is 0.56 of the hover model's error: this blade is
    # known roughly, and without a prior the constants make up for it.
    free = ["--prior-from", "none", "--accept"]
    assert main(["fit", "flight", seen, *vehicle, *free, "-o", str(fit)]) == 0
    assert "balance of all forces at all times is fitted instead" in capsys.readouterr().out
    assert main(["check", str(fit), unseen, *vehicle, "--format", "json"]) == 0
    found = json.loads(capsys.readouterr().out)
    axes = [f"force_{axis}_N" for axis in "xyz"] + [f"moment_{axis}_Nm" for axis in "xyz"]
    assert list(found["loads"]) == axes
    assert found["rows"] > 1000
    vertical = found["loads"]["force_z_N"]
    assert vertical["rms"] <= 0.55 * vertical["hover_rms"]
    for name in ("force_x_N", "force_y_N"):
        assert found["loads"][name]["rms"] < found["loads"][name]["hover_rms"]
