"""`propmap trim` and `propmap choose`: tables, files, pictures, and one-line errors."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import pytest
import xarray

from .conftest import Run

BARE = """schema = 1
name = "test quad"
frame = "flu"
mass = 1.2
propeller = "apc-8x6e"
""" + "".join(
    f'[[rotors]]\nposition = [{x}, {y}, 0.0]\nspin = "{spin}"\n'
    for x, y, spin in (
        (0.16, 0.16, "cw"),
        (-0.16, 0.16, "ccw"),
        (-0.16, -0.16, "cw"),
        (0.16, -0.16, "ccw"),
    )
)
POWERED = (
    BARE
    + """[body]
drag_area = [0.015, 0.015, 0.03]
[motor]
kv_rpm_per_volt = 920
resistance = 0.12
no_load_current = 0.6
maximum_current = 20
[esc]
efficiency = 0.95
[battery]
cells = 4
capacity_mAh = 5000
resistance = 0.02
"""
)
QUIET = ["--speed", "9", "--no-bands"]
TRIM = ["trim", "quad.toml", "--airfoil", "apc-8x6e-2019"]


@pytest.fixture(autouse=True)
def _vehicle(_workplace: None) -> None:
    Path("quad.toml").write_text(POWERED)
    Path("bare.toml").write_text(BARE)
    Path("words.csv").write_text("speed_mps,climb_mps,duration_s\nfast,0,10\n")
    Path("legs.csv").write_text("speed_mps,climb_mps,duration_s\n0,2,20\n10,0,120\n")


@pytest.mark.usefixtures("brief")
def test_wakes_count_unless_they_are_left_out(run: Run) -> None:
    Path("wakes.toml").write_text(POWERED + "[wakes]\nahead = 2.0\ndownwash = 0.5\n")
    told = {}
    for name, more in (("quad", ()), ("wakes", ()), ("wakes", ("--no-wakes",))):
        done = run("trim", f"{name}.toml", *TRIM[2:], *QUIET, *more, "--format", "json")
        assert done.code == 0, done.err
        told[name, len(more)] = json.loads(done.out)["states"][0]
    plain, on, off = told.values()
    assert off == plain
    front, rear = (on[f"rpm_{k}"] - plain[f"rpm_{k}"] for k in (1, 2))
    assert front < -10.0 and rear > 10.0
    shown = run("trim", "wakes.toml", *TRIM[2:], *QUIET)
    assert "in each other's wakes" in shown.out
    refused = run("export", "wakes.toml", "--airfoil", "apc-8x6e-2019", "--to", "px4", "-o", "out")
    assert refused.code == 2 and refused.err.count("\n") == 1
    assert "[wakes] is given" in refused.err and "--no-wakes" in refused.err
    plain_map = run("export", "map.npz", "--to", "c", "-o", "out", "--no-wakes")
    assert "--no-wakes does not apply to --to c" in plain_map.err


@pytest.mark.slow
def test_a_power_curve(run: Run) -> None:
    done = run(*TRIM, "--speed", "0,8,16", "--picture", "power.png")
    assert done.code == 0
    for text in ("hover: ", "least power", "best range", "top speed", "limited by", "throttle"):
        assert text in done.out
    assert Path("power.png").read_bytes()[:4] == b"\x89PNG"
    as_json = run(*TRIM, "--speed", "0,8,16", "--format", "json")
    told = json.loads(as_json.out)
    assert [row["speed_mps"] for row in told["states"]] == [0.0, 8.0, 16.0]
    assert told["performance"]["hover"]["power"] == pytest.approx(
        told["states"][0]["electrical_power_W"]
    )
    run(*TRIM, "--speed", "0,8,16", "--climb=0,2", "-o", "map.nc")
    with xarray.open_dataset("map.nc", engine="h5netcdf") as found:
        assert found.electrical_power_W.shape == (2, 3) and found.rpm.dims[-1] == "rotor"
        assert found.electrical_power_W[0, 0].item() == pytest.approx(
            told["states"][0]["electrical_power_W"]
        )
        assert (found.shaft_power_W[1] > found.shaft_power_W[0]).all()


@pytest.mark.slow
def test_what_is_missing_is_said(run: Run) -> None:
    done = run("trim", "bare.toml", "--airfoil", "apc-8x6e-2019", "--speed", "5", "--format", "csv")
    assert "shaft power (no [motor])" in done.err
    (row,) = csv.DictReader(io.StringIO(done.out))
    assert float(row["shaft_power_W"]) > 50.0 and row["electrical_power_W"] == ""


@pytest.mark.slow
def test_a_mission_and_a_turn(run: Run) -> None:
    done = run(*TRIM, "--mission", "legs.csv")
    assert done.code == 0 and "Wh in" in done.out and "legs.csv" in done.out
    told = json.loads(run(*TRIM, "--mission", "legs.csv", "--format", "json").out)
    course = told["over_time"]
    assert course["time_s"][0] == 0.0 and course["time_s"][-1] == 140.0
    assert course["charge"][0] == 1.0 and course["charge"] == sorted(course["charge"])[::-1]
    assert told["legs"][-1]["charge"] == course["charge"][-1]
    run(*TRIM, "--mission", "legs.csv", "--picture", "course.svg")
    assert Path("course.svg").read_text(encoding="utf-8").startswith("<?xml")
    turned = run(*TRIM, "--speed", "0,6", "--bank", "20", "--format", "csv")
    (row,) = csv.DictReader(io.StringIO(turned.out))
    assert float(row["roll_deg"]) == pytest.approx(20.0, abs=1.0)
    assert "a turn needs airspeed" in turned.err


@pytest.mark.slow
def test_choosing(run: Run) -> None:
    chosen = ["choose", "quad.toml", "--speed", "10", "--diameter", "9:9", "--blades", "3"]
    done = run(*chosen, "--propeller", "apc-8x6e", "--picture", "front.png", "--top", "4")
    assert done.code == 0 and Path("front.png").exists()
    assert "1 beats it" in done.out and "top speeds are limited by" in done.out
    assert "ranked by" in done.out and "apc-8x6e" in done.out
    listed = run(*chosen, "--format", "csv", "--task", "legs.csv", "--top", "2")
    rows = list(csv.DictReader(io.StringIO(listed.out)))
    assert rows and all(float(row["energy_J"]) > 0.0 for row in rows)
    assert float(rows[1]["probability_first_beats"]) >= 0.5
    longest = run(*chosen[:2], *chosen[4:], "--task", "hover", "--by", "time", "--format", "json")
    rows = json.loads(longest.out)["propellers"]
    times = [row["time_s"] for row in rows]
    assert times == sorted(times, reverse=True)
    assert [row["hover_time_s"] for row in rows] == times
    assert all(row["cruise_power_W"] is None for row in rows)


BAD = {
    "no vehicle": (["trim", "none.toml"], "none.toml"),
    "no loads with a table": ([*TRIM, "--table", "x.npz"], "leave these out"),
    "a negative speed": ([*TRIM, "--speed=-1"], "speed is negative"),
    "speeds that fall": ([*TRIM, "--speed", "5,3"], "do not increase"),
    "a climb in words": ([*TRIM, "--climb", "fast"], "cannot be read"),
    "max rpm of 0": ([*TRIM, "--max-rpm", "0"], "above 0"),
    "wind that is no number": ([*TRIM, "--speed", "0,5", "--wind", "nan"], "headwind"),
    "charge in percent": ([*TRIM, "--charge", "80"], "1 for a full battery"),
    "a mission of words": ([*TRIM, "--mission", "words.csv"], "line 2"),
    "a mission and a climb": ([*TRIM, "--mission", "legs.csv", "--climb", "2"], "legs define"),
    "no such picture": ([*TRIM, "--picture", "p.bmp"], "extension"),
    "NetCDF and JSON": ([*TRIM, "-o", "x.nc", "--format", "json"], "NetCDF"),
    "a bank too steep": ([*TRIM, "--speed", "5", "--bank", "89"], "80 degrees"),
    "a diameter in words": (
        ["choose", "quad.toml", "--speed", "9", "--diameter", "big"],
        "in inches",
    ),
    "a diameter that falls": (
        ["choose", "quad.toml", "--speed", "9", "--diameter", "10:9"],
        "in inches",
    ),
    "no such diameter": (
        ["choose", "quad.toml", "--speed", "9", "--diameter", "40:50"],
        "no propeller of the catalogue",
    ),
    "no speed": (["choose", "quad.toml", "--speed", "0"], "above 0"),
    "a cruise without speed": (["choose", "quad.toml"], "cruise has no speed"),
    "another task": (["choose", "quad.toml", "--task", "loiter"], "choose from hover"),
    "no such mission": (["choose", "quad.toml", "--task", "none.csv"], "none.csv"),
    "a mission of words to choose by": (
        ["choose", "quad.toml", "--task", "words.csv"],
        "line 2",
    ),
    "a hover by range": (
        ["choose", "quad.toml", "--task", "hover", "--by", "range"],
        "not ranked by range",
    ),
    "a time without a battery": (
        ["choose", "bare.toml", "--task", "hover", "--by", "time"],
        "no [battery]",
    ),
    "no margin": (
        ["choose", "quad.toml", "--speed", "9", "--thrust-margin", "0.5"],
        "less thrust than weight",
    ),
    "a law for nothing": (
        ["choose", "quad.toml", "--speed", "9", "--airfoil", "paper-apc"],
        "without --propeller",
    ),
}


@pytest.mark.usefixtures("brief")
@pytest.mark.parametrize("case", BAD)
def test_errors_are_one_line(case: str, run: Run) -> None:
    arguments, told = BAD[case]
    done = run(*arguments)
    lines = [line for line in done.err.splitlines() if "error" in line]
    assert done.code == 2 and len(lines) == 1 and told in lines[0]
    assert "Traceback" not in done.err
