"""`propmap predict`: the figures are those of ``Rotor.loads``, to the last digit."""

from __future__ import annotations

import csv
import io
import json
import sys
from dataclasses import replace
from pathlib import Path
from types import FrameType

import numpy as np
import pytest

import propmap
from propmap.cli.output import json_text
from propmap.io.csv import PREDICT_COLUMNS, OperatingPoints, csv_text
from propmap.loads import LOADS
from tests.fit.fit_records import ENVELOPE, fit_text

from .conftest import BETA, POINT, ROTOR, RPM, SPEED, Run

FIELDS = {load.column: name for name, load in LOADS.items()} | {"power_W": "power"}
OMEGA = np.pi / 30.0
POINTS = (
    np.array([4000.0, 4100.25, 4000.0]),
    np.array([14.0, 14.5, 16.0]),
    np.array([80.0, 85.5, 90.0]),
)


@pytest.fixture
def points_csv(tmp_path: Path) -> Path:
    path = tmp_path / "points.csv"
    path.write_text(
        "beta_deg,note,rpm,speed_mps\n80,first,4000,14\n85.5,second,4100.25,14.5\n90,,4000,16\n"
    )
    return path


def test_json_of_one_point_is_the_rotor_s_loads(run: Run, rotor: propmap.Rotor) -> None:
    done = run("predict", *ROTOR, *POINT, "--format", "json")
    assert (done.code, done.err) == (0, "")
    found = json.loads(done.out)
    assert tuple(found) == PREDICT_COLUMNS
    assert (found["rpm"], found["speed_mps"], found["beta_deg"]) == (RPM, SPEED, BETA)
    loads = rotor.loads(np.array([RPM]) * OMEGA, np.array([SPEED]), np.radians([BETA]))
    assert {column: found[column] for column in FIELDS} == {
        column: getattr(loads, field)[0] for column, field in FIELDS.items()
    }
    shown = run("predict", *ROTOR, *POINT).out
    for text in ("thrust", "hover model", "reverse flow", "inflow solutions", "rolling moment"):
        assert text in shown


def test_points_to_json_csv_and_files(run: Run, rotor: propmap.Rotor, points_csv: Path) -> None:
    rpm, speed, beta = POINTS
    loads = rotor.loads(rpm * OMEGA, speed, np.radians(beta))
    asked = ["predict", *ROTOR, "--points", points_csv]
    listed = json.loads(run(*asked, "--format", "json").out)
    rows = list(csv.DictReader(io.StringIO(run(*asked, "--format", "csv").out)))
    assert tuple(rows[0]) == PREDICT_COLUMNS
    assert len(listed) == len(rows) == 3
    for i, (one, row) in enumerate(zip(listed, rows, strict=True)):
        for column, field in FIELDS.items():
            assert one[column] == float(row[column]) == getattr(loads, field)[i]
        assert one["status"] == row["status"] == "ok"
    for name, start in (("out.json", "[\n"), ("out.csv", "rpm,speed_mps")):
        done = run(*asked, "-o", name)
        assert (done.code, done.out) == (0, "") and Path(name).read_text().startswith(start)
    # One row is still a list.
    points_csv.write_text("rpm,speed_mps,beta_deg\r\n4000,14,80\r\n\r\n")
    assert len(json.loads(run(*asked, "--format", "json").out)) == 1


def test_points_beyond_the_data_of_a_fit_are_told(run: Run, tmp_path: Path) -> None:
    (tmp_path / "fit.toml").write_text(fit_text(envelope=ENVELOPE))
    law = ["predict", "apc-8x6e", "--airfoil", "fit.toml", "--rpm", "5000", "--format", "json"]
    assert run(*law, "--speed", "5", "--beta", "60").err == ""
    beyond = run(*law, "--speed", "18", "--beta", "60").err
    assert beyond.startswith("note: the point is outside the fitted data: V sin(beta)")
    assert "(data 0 to 0.25)" in beyond
    down = run(*law, "--speed", "5", "--beta", "170").err
    assert "V cos(beta)/(Omega R) down to -0.0926 (data -0.05 to 0.2)" in down


def test_what_did_not_converge_is_null_and_empty(rotor: propmap.Rotor) -> None:
    zero, unknown = np.array([0.0]), dict.fromkeys([*LOADS, "power"], np.array([np.nan]))
    loads = rotor.loads(zero, zero, zero)
    lost = replace(loads, status=np.array(["not_converged"]), **unknown)
    rows = OperatingPoints(zero, zero, zero).rows(lost)
    found = json.loads(json_text(rows[0]))
    assert (found["thrust_N"], found["status"]) == (None, "not_converged")
    cells = csv_text(PREDICT_COLUMNS, rows).splitlines()[1].split(",")
    assert cells == ["0.0"] * 3 + [""] * (len(LOADS) + 1) + ["not_converged"]


def test_every_option_of_the_rotor_changes_the_loads(run: Run) -> None:
    def thrust(*options: str) -> float:
        done = run("predict", *ROTOR, *POINT, *options, "--format", "json")
        assert done.code == 0, done.err
        return float(json.loads(done.out)["thrust_N"])

    plain = thrust()
    for options in (
        ["--rho", "1.0"],
        ["--mu", "3e-5"],
        ["--altitude", "1000"],
        ["--temperature-offset", "20"],
        ["--root-cutout", "0.05"],
        ["--blades", "3"],
        ["--airfoil", "paper-soft"],
    ):
        assert thrust(*options) != plain, options
    assert thrust("--radius", "0.1016") == plain


STD = [load.column_of("std") for load in LOADS.values()] + ["power_std_W"]
NAMED = ("apc 10x5e", "--rpm", "6000", "--speed", "10", "--beta", "60")


def test_standard_deviations_of_the_loads_of_a_propeller_by_name(
    run: Run, points_csv: Path
) -> None:
    found = json.loads(run("predict", *NAMED, "--std-by-source", "--format", "json").out)
    assert set(found) > {*PREDICT_COLUMNS, *STD}
    assert all(found[column] > 0.0 for column in STD)
    assert found["power_std_W"] == pytest.approx(found["torque_std_Nm"] * 6000.0 * OMEGA)
    parts = [found[f"thrust_std_{name}_N"] for name in ("parameters", "discrepancy", "tunnel")]
    assert found["thrust_std_N"] == pytest.approx(np.sqrt(np.sum(np.square(parts))))
    assert "thrust_std_geometry_N" not in found  # it was measured
    guessed = run("predict", "APC 12x6.5E", *NAMED[1:], "--std-by-source", "--format", "json")
    assert json.loads(guessed.out)["thrust_std_geometry_N"] > 0.0
    (row,) = csv.DictReader(io.StringIO(run("predict", *NAMED, "--format", "csv").out))
    assert tuple(row) == (*PREDICT_COLUMNS, *STD)
    assert [float(row[column]) for column in STD] == [found[column] for column in STD]
    shown = run("predict", *NAMED, "--std-by-source").out
    assert "std. dev." in shown and f"{found['thrust_std_N']:.2g}" in shown
    assert "by tunnel" in shown
    assert "std. dev." not in run("predict", *NAMED, "--no-bands").out
    several = run("predict", "apc 10x5e", "--points", points_csv).out
    assert "s(T)" in several and "s(Q)" in several


def test_constants_of_which_a_fit_knows_nothing_are_named(run: Run, tmp_path: Path) -> None:
    law = propmap.airfoil("paper-apc")
    assert isinstance(law, propmap.Airfoil)
    covariance = np.array([[0.04, np.inf], [np.inf, np.inf]])
    known = propmap.SectionUncertainty(propmap.SectionCovariance(("c_l1", "c_l2"), covariance))
    (tmp_path / "law.toml").write_text(law.with_parameters(uncertainty=known).to_toml())
    done = run("predict", "apc-8x6e", "--airfoil", tmp_path / "law.toml", *NAMED[1:])
    assert "note: standard deviations exclude c_l2" in done.err and "std. dev." in done.out


def test_height_above_ground_is_an_option_and_a_column(
    run: Run, rotor: propmap.Rotor, tmp_path: Path
) -> None:
    found = json.loads(run("predict", *ROTOR, *POINT, "--height", 0.08, "--format", "json").out)
    assert found["height_m"] == 0.08
    near = rotor.loads(RPM * OMEGA, SPEED, np.radians(BETA), height=0.08)
    assert found["thrust_N"] == pytest.approx(float(near.thrust), rel=1e-14)
    below = json.loads(run("predict", *ROTOR, *POINT, "--ceiling", 0.08, "--format", "json").out)
    assert (
        below["ceiling_m"] == 0.08
        and below["thrust_N"] > rotor.loads(RPM * OMEGA, SPEED, np.radians(BETA)).thrust.item()
    )
    file = tmp_path / "points.csv"
    file.write_text(f"height_m,rpm,speed_mps,beta_deg\n0.08,{RPM},{SPEED},{BETA}\n0.5,6000,0,0\n")
    done = run("predict", *ROTOR, "--points", file, "--format", "csv")
    rows = list(csv.DictReader(io.StringIO(done.out)))
    assert float(rows[0]["thrust_N"]) == found["thrust_N"]
    assert float(rows[1]["height_m"]) == 0.5
    file.write_text("rpm,speed_mps,beta_deg,height_m\n6000,0,0,\n")
    assert "line 2, column height_m" in run("predict", *ROTOR, "--points", file).err


def test_the_way_to_the_core_leads_through_few_files(run: Run) -> None:
    """The call uses functions of at most 26 files, see docs/architecture.md."""
    assert run("predict", "apc-8x6e", *POINT).code == 0  # imports are no part of the way
    root, files = Path(propmap.__file__).parent, set()

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            files.add(frame.f_code.co_filename)

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        run("predict", "apc-8x6e", *POINT)
    finally:
        sys.setprofile(before)
    way = {Path(name).relative_to(root).as_posix() for name in files if root in Path(name).parents}
    assert {"cli/app.py", "cli/predict.py", "rotor.py", "operating_points.py"} <= way
    assert len(way) <= 26, sorted(way)
