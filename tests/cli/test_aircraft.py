"""`propmap trim` and `propmap choose`: output, files, pictures, assumptions, one-line errors."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray

from propmap.aircraft.assumptions import assumption_lines, assumptions
from propmap.catalogue.lookup import catalogue_model
from propmap.loads import LOADS
from propmap.rotor import Rotor
from propmap.table import LoadTable
from propmap.units import GRAVITY, RPM
from propmap.vehicle.files import read_vehicle

from .conftest import Run, refused
from .fit_inputs import VEHICLE
from .invented_tables import invented

EXAMPLES = Path(__file__).parents[2] / "examples"
POWERED = (
    (EXAMPLES / "quadrotor.toml").read_text(encoding="utf-8")
    + """[motor]
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
    Path("bare.toml").write_text(VEHICLE)
    Path("legs.csv").write_text("speed_mps,climb_mps,duration_s\n0,2,20\n10,0,120\n")


def test_wakes_count_unless_they_are_left_out(run: Run) -> None:
    Path("wakes.toml").write_text(POWERED + "[wakes]\nahead = 2.0\ndownwash = 0.5\n")
    told = {}
    for name, more in (("quad", ()), ("wakes", ()), ("wakes", ("--no-wakes",))):
        done = run("trim", f"{name}.toml", *TRIM[2:], *QUIET, *more, "--format", "json")
        assert done.code == 0, done.err
        told[name, len(more)] = json.loads(done.out)
    plain, on, off = (each["states"][0] for each in told.values())
    assert off == plain
    front, rear = (on[f"rpm_{k}"] - plain[f"rpm_{k}"] for k in (1, 2))
    assert front < -10.0 and rear > 10.0
    asked = ["export", "wakes.toml", "--airfoil", "apc-8x6e-2019", "--to", "px4", "-o", "out"]
    refused(run(*asked), "[wakes] is given", "--no-wakes")
    assert run(*asked, "--no-wakes").code == 0


@pytest.mark.parametrize(
    ("propeller", "blades", "told"),
    [
        ("HQ 5x4.3x3", None, "read as 5 x 4.3 in, 3 blades"),
        ("5x4.3", 3, "3 blades as requested"),
        ("ancf 12.5x7.5", None, "constants identified from"),
        ("apc-8x6e", 3, "constants predicted"),
    ],
)
def test_a_vehicle_has_the_loads_that_its_propeller_has_by_name(
    run: Run, propeller: str, blades: int | None, told: str
) -> None:
    count = "" if blades is None else f", blades = {blades}"
    given = f'propeller = {{ geometry = "{propeller}"{count} }}'
    Path("x.toml").write_text(VEHICLE.replace('propeller = "apc-8x6e"', given))
    done = run("trim", "x.toml", "--speed", "0", "--no-bands", "--format", "json")
    assert done.code == 0 and told in done.err
    (state,) = json.loads(done.out)["states"]
    vehicle = read_vehicle("x.toml").vehicle
    rotor = Rotor(catalogue_model(propeller, blades, air=vehicle.air))
    omega = state["rpm_1"] * RPM
    loads = rotor.loads(omega, 0.0, 0.0)
    assert 4.0 * loads.thrust.item() == pytest.approx(vehicle.mass * GRAVITY, rel=1e-6)
    assert 4.0 * loads.torque.item() * omega == pytest.approx(state["shaft_power_W"], rel=1e-6)


@pytest.mark.slow
def test_a_power_curve(run: Run) -> None:
    done = run(*TRIM, "--speed", "0,8,16", "--picture", "power.png")
    assert done.code == 0
    for text in ("hover: ", "least power", "best range", "top speed", "limited by", "throttle"):
        assert text in done.out
    assert Path("power.png").read_bytes()[:4] == b"\x89PNG"
    told = json.loads(run(*TRIM, "--speed", "0,8,16", "--format", "json").out)
    assert [row["speed_mps"] for row in told["states"]] == [0.0, 8.0, 16.0]
    hover = pytest.approx(told["states"][0]["electrical_power_W"])
    assert told["performance"]["hover"]["power"] == hover
    run(*TRIM, "--speed", "0,8,16", "--climb=0,2", "-o", "map.nc")
    with xarray.open_dataset("map.nc", engine="h5netcdf") as found:
        assert found.electrical_power_W.shape == (2, 3) and found.rpm.dims[-1] == "rotor"
        assert found.electrical_power_W[0, 0].item() == hover
        assert (found.shaft_power_W[1] > found.shaft_power_W[0]).all()


@pytest.mark.slow
def test_a_mission_and_a_turn(run: Run) -> None:
    done = run(*TRIM, "--mission", "legs.csv")
    assert done.code == 0 and "Wh in" in done.out and "legs.csv" in done.out
    assert "body drag area 0.015 m^2 along x" in done.out
    told = json.loads(run(*TRIM, "--mission", "legs.csv", "--format", "json").out)
    assert told["assumptions"]["power"] == "electrical power"
    course = told["over_time"]
    assert course["time_s"][0] == 0.0 and course["time_s"][-1] == 140.0
    assert course["charge"][0] == 1.0 and course["charge"] == sorted(course["charge"])[::-1]
    turned = run(*TRIM, "--speed", "0,6", "--bank", "20", "--format", "csv")
    (row,) = csv.DictReader(io.StringIO(turned.out))
    assert float(row["roll_deg"]) == pytest.approx(20.0, abs=1.0)
    assert "a turn needs airspeed" in turned.err


@pytest.mark.slow
def test_choosing(run: Run) -> None:
    chosen = ["choose", "quad.toml", "--speed", "10", "--diameter", "9:9", "--blades", "3"]
    done = run(*chosen, "--propeller", "apc-8x6e", "--picture", "front.png", "--top", "4")
    assert done.code == 0 and Path("front.png").exists()
    assert "1 beats it" in done.out and "limit of the top speed" in done.out
    assert "ranked by" in done.out and "apc-8x6e" in done.out
    listed = run(*chosen, "--format", "csv", "--task", "legs.csv", "--top", "2")
    _, second, *_ = csv.DictReader(io.StringIO(listed.out))
    assert float(second["energy_J"]) > 0.0 and float(second["probability_first_beats"]) >= 0.5
    assert "each propeller as listed; air" in listed.err
    longest = run(*chosen[:2], *chosen[4:], "--task", "hover", "--by", "time", "--format", "json")
    told = json.loads(longest.out)
    assert told["assumptions"]["constants"] == "different for each propeller"
    rows = told["propellers"]
    times = [row["time_s"] for row in rows]
    assert times == [row["hover_time_s"] for row in rows] == sorted(times, reverse=True)


LOWER = VEHICLE[VEHICLE.index("[[rotors]]") :].replace("0.0]", "-0.08]")
COAXIAL = VEHICLE + LOWER.replace('"c', '"cc').replace('"ccc', '"c')  # against the upper ones
MOUNTED = POWERED.replace("[esc]\nefficiency = 0.95\n", "") + "[mount]\narea = 0.0008\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (COAXIAL, ("no body drag", "shaft power (no [motor])", "8 rotors above each other: lower")),
        (MOUNTED, ("lossless speed controllers", "drag of [mount]", "air 1.225 kg/m^3; con")),
    ],
    ids=["coaxial", "mounted"],
)
def test_assumptions_of_an_aircraft(text: str, words: tuple[str, ...]) -> None:
    Path("x.toml").write_text(text)
    lines = assumption_lines(assumptions(read_vehicle("x.toml").vehicle, None))
    assert all(any(word in line for line in lines) for word in words), lines


def test_every_output_lists_the_assumptions(run: Run) -> None:
    run(*TRIM, *QUIET, "-o", "x.txt")
    notes, shown = run(*TRIM, *QUIET, "--format", "csv").err, Path("x.txt").read_text()
    for word in ("body drag area 0.015 m^2 along x", "bare rotors", "constants: apc-8x6e-2019"):
        assert word in notes and word in shown
    told = json.loads(run(*TRIM, *QUIET, "--format", "json").out)["assumptions"]
    assert told["body_drag"] == "body drag area 0.015 m^2 along x, 0.03 m^2 along z"
    run(*TRIM, *QUIET, "-o", "x.nc")
    with xarray.open_dataset("x.nc", engine="h5netcdf") as found:
        assert all(found.attrs[f"assumed_{name}"] == text for name, text in told.items())


def test_without_a_body_and_a_motor(run: Run) -> None:
    shown = run("trim", "bare.toml", *TRIM[2:], "--speed", "0:16:3", "--no-bands").out
    figures = {line.partition(":")[0]: line for line in shown.splitlines() if ": " in line}
    for name in ("hover", "least power, longest time", "best range"):
        assert ("without body drag" in figures[name]) == (name != "hover")
    assert figures["top speed"] == "top speed: unknown"
    done = run("trim", "bare.toml", *QUIET, "--format", "csv")
    for word in ("shaft power (no [motor])", "installed rotors", "constants: apc-8x6e identified"):
        assert word in done.err
    (row,) = csv.DictReader(io.StringIO(done.out))
    assert float(row["shaft_power_W"]) > 50.0 and row["electrical_power_W"] == ""
    unknown = (
        "thrust margin and top speed are unknown: add [battery], or maximum_current or "
        "maximum_rpm in [motor], or pass --max-rpm"
    )
    assert row["thrust_margin"] == "" and unknown in done.err
    told = run("trim", "bare.toml", "--speed", "0:8:2", "--no-bands", "--format", "json").out
    found = json.loads(told)["performance"]
    assert found["fastest"] is None and found["top_speed_limit"] == "unknown"
    limited = run("trim", "bare.toml", *QUIET, "--max-rpm", "9000", "--format", "csv")
    (row,) = csv.DictReader(io.StringIO(limited.out))
    assert float(row["thrust_margin"]) > 1.0 and unknown not in limited.err
    refused(run("choose", "bare.toml", "--task", "fast"), "--task fast", unknown)


EDGE = POWERED.replace('"cw"', '"?"', 1).replace('"ccw"', '"cw"', 1).replace('"?"', '"ccw"')


@pytest.mark.parametrize(
    "command",
    [
        ["trim", "NAME", *QUIET],
        ["export", "NAME", "--to", "px4", "--speed", "3,6", "-o", "to"],
    ],
    ids=["trim", "export"],
)
def test_rotors_that_cannot_command_yaw_are_noted(run: Run, command: list[str]) -> None:
    """The front rotors turn ccw, the rear rotors cw: yaw is a multiple of pitch."""
    Path("edge.toml").write_text(EDGE)
    words = "rotor speeds alone cannot command yaw without pitch (0% of yaw is independent)"
    for name, noted in (("edge.toml", True), ("quad.toml", False)):
        done = run(*[name if word == "NAME" else word for word in command])
        assert done.code == 0 and (words in done.err) is noted
        if command[0] == "export":
            assert (words.capitalize() in Path("to/README-px4.md").read_text()) is noted
            for path in Path("to").iterdir():
                path.unlink()


def test_a_table_need_not_have_the_speed_that_is_tried_first(run: Run) -> None:
    """Rotors are tried at a tip speed of 60 m/s first, 5639 rpm; the table begins above."""
    quadrotor, content = EXAMPLES / "quadrotor.toml", invented().content
    vehicle = read_vehicle(quadrotor).vehicle
    blade, air = vehicle.propeller, vehicle.air
    content.coefficients[:, ~np.isin(list(LOADS), ["thrust", "torque"])] = 0.0
    sha = blade.fingerprint()
    described = {"name": blade.name, "radius_m": blade.radius, "geometry_sha256": sha}
    medium = {"density_kg_m3": air.density, "viscosity_Pa_s": air.viscosity}
    at_rest = content.coefficients[0, list(LOADS).index("thrust"), 0, 0]
    per_square = at_rest * air.density * np.pi * blade.radius**4
    hover = np.sqrt(vehicle.mass * GRAVITY / 4.0 / per_square) * 30.0 / np.pi
    omega = np.array([6000.0, 8000.0]) * np.pi / 30.0
    speed = np.array([0.0, content.advance[-1] * omega[0] * blade.radius])
    info = {"propeller": described, "air": medium}
    content = replace(content, omega=omega, speed=speed, info=info)
    asked = ["trim", quadrotor, "--table", "map.npz", "--speed", "0:4:2", "--format", "csv"]
    LoadTable(content).save("map.npz")
    done = run(*asked)
    still = next(csv.DictReader(io.StringIO(done.out)))
    assert float(still["rpm_1"]) == pytest.approx(hover, rel=1e-4)
    Path("map.npz").unlink()
    LoadTable(replace(content, speed=np.array([3.0, speed[1]]))).save("map.npz")
    outside = "the rotors have no loads (outside); give loads that cover hover"
    assert outside in run(*asked).err
