"""`propmap predict`: the figures are those of ``Rotor.loads``, to the last digit."""

from __future__ import annotations

import csv
import io
import json
import sys
from pathlib import Path
from types import FrameType

import numpy as np
import pytest

import propmap
from propmap.io.csv import PREDICT_COLUMNS, OperatingPoints
from propmap.loads import LOADS
from propmap.results import Loads
from tests.fit.fit_records import ENVELOPE, fit_text

from .conftest import BETA, POINT, POINTS, ROTOR, RPM, SPEED, Run

FIELDS = {load.column: name for name, load in LOADS.items()} | {"power_W": "power"}
OMEGA = np.pi / 30.0


def test_json_of_one_point_is_the_rotor_s_loads(run: Run, rotor: propmap.Rotor) -> None:
    done = run("predict", *ROTOR, *POINT, "--format", "json")
    assert (done.code, done.err) == (0, "")
    found = json.loads(done.out)
    assert tuple(found) == PREDICT_COLUMNS
    assert (found["rpm"], found["speed_mps"], found["beta_deg"]) == (RPM, SPEED, BETA)
    loads = rotor.loads(np.array([RPM]) * OMEGA, np.array([SPEED]), np.radians([BETA]))
    for column, field in FIELDS.items():
        assert found[column] == getattr(loads, field)[0], column
    assert found["status"] == loads.status[0]


def test_points_to_json_and_csv(run: Run, rotor: propmap.Rotor, points_csv: Path) -> None:
    rpm, speed, beta = POINTS
    loads = rotor.loads(rpm * OMEGA, speed, np.radians(beta))
    listed = json.loads(run("predict", *ROTOR, "--points", points_csv, "--format", "json").out)
    table = run("predict", *ROTOR, "--points", points_csv, "--format", "csv").out
    rows = list(csv.DictReader(io.StringIO(table)))
    assert tuple(rows[0]) == PREDICT_COLUMNS
    assert len(listed) == len(rows) == 3
    for i, (one, row) in enumerate(zip(listed, rows, strict=True)):
        for column, values in {"rpm": rpm, "speed_mps": speed, "beta_deg": beta}.items():
            assert one[column] == float(row[column]) == values[i]
        for column, field in FIELDS.items():
            assert one[column] == float(row[column]) == getattr(loads, field)[i]
        assert one["status"] == row["status"] == "ok"


def test_points_beyond_the_data_of_a_fit_are_told(run: Run, tmp_path: Path) -> None:
    (tmp_path / "fit.toml").write_text(fit_text(envelope=ENVELOPE))
    law = ["apc-8x6e", "--airfoil", "fit.toml", "--rpm", "5000", "--format", "json"]
    inside = run("predict", *law, "--speed", "5", "--beta", "60")
    assert (inside.code, inside.err) == (0, "")
    beyond = run("predict", *law, "--speed", "18", "--beta", "60")
    assert beyond.err.startswith("note: the point lies beyond the data of the fit: V sin(beta)")
    assert "up to 0.29" in beyond.err and "(data 0 to 0.25)" in beyond.err
    down = run("predict", *law, "--speed", "5", "--beta", "170").err
    assert "V cos(beta)/(Omega R) down to -0.0926 (data -0.05 to 0.2)" in down


def test_one_row_is_still_a_list(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "one.csv"
    path.write_text("rpm,speed_mps,beta_deg\r\n4000,14,80\r\n\r\n")
    found = json.loads(run("predict", *ROTOR, "--points", path, "--format", "json").out)
    assert isinstance(found, list)
    assert len(found) == 1


@pytest.mark.parametrize(("name", "start"), [("out.json", "[\n"), ("out.csv", "rpm,speed_mps")])
def test_the_ending_chooses_the_format(
    run: Run, points_csv: Path, tmp_path: Path, name: str, start: str
) -> None:
    done = run("predict", *ROTOR, "--points", points_csv, "-o", tmp_path / name)
    assert (done.code, done.out) == (0, "")
    assert (tmp_path / name).read_text().startswith(start)
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted([name, "points.csv"])


def test_table_shows_the_hover_model_and_diagnostics(run: Run, points_csv: Path) -> None:
    one = run("predict", *ROTOR, *POINT).out
    for text in ("thrust", "hover model", "reverse flow", "roots of (11)", "rolling moment"):
        assert text in one
    assert "[deg]" in run("predict", *ROTOR, "--points", points_csv).out


def test_what_did_not_converge_is_null_and_empty(capsys: pytest.CaptureFixture[str]) -> None:
    from propmap.cli.output import json_text
    from propmap.io.csv import csv_text

    nan, zero = np.array([np.nan]), np.array([0.0])
    lost = Loads(
        **dict.fromkeys(LOADS, nan),
        power=nan,
        status=np.array(["not_converged"]),
        roots=np.array([0]),
        reverse_flow=zero,
        vortex_ring=zero,
        mean_inflow=zero,
    )
    rows = OperatingPoints(zero, zero, zero).rows(lost)
    found = json.loads(json_text(rows[0]))
    assert found["thrust_N"] is None
    assert found["status"] == "not_converged"
    cells = csv_text(PREDICT_COLUMNS, rows).splitlines()[1].split(",")
    assert cells == ["0.0"] * 3 + [""] * (len(LOADS) + 1) + ["not_converged"]
    assert capsys.readouterr().out == ""


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


def test_standard_deviations_stand_beside_the_loads_of_a_propeller_by_name(run: Run) -> None:
    assert STD[:3] == ["thrust_std_N", "drag_std_N", "torque_std_Nm"]
    assert STD[3:5] == ["roll_moment_std_Nm", "side_force_std_N"]
    found = json.loads(run("predict", *NAMED, "--format", "json").out)
    assert tuple(found) == (*PREDICT_COLUMNS, *STD)
    assert all(found[column] > 0.0 for column in STD)
    assert found["power_std_W"] == pytest.approx(found["torque_std_Nm"] * 6000.0 * OMEGA)
    (row,) = csv.DictReader(io.StringIO(run("predict", *NAMED, "--format", "csv").out))
    assert [float(row[column]) for column in STD] == [found[column] for column in STD]
    shown = run("predict", *NAMED).out
    assert "std. dev." in shown and f"{found['thrust_std_N']:.2g}" in shown


def test_standard_deviations_by_source_and_none(run: Run) -> None:
    found = json.loads(run("predict", *NAMED, "--std-by-source", "--format", "json").out)
    parts = [found[f"thrust_std_{name}_N"] for name in ("parameters", "discrepancy", "tunnel")]
    assert found["thrust_std_N"] == pytest.approx(np.sqrt(np.sum(np.square(parts))))
    assert "thrust_std_geometry_N" not in found  # it was measured
    assert "by tunnel" in run("predict", *NAMED, "--std-by-source").out
    plain = json.loads(run("predict", *NAMED, "--no-bands", "--format", "json").out)
    assert tuple(plain) == PREDICT_COLUMNS
    assert "std. dev." not in run("predict", *NAMED, "--no-bands").out
    guessed = run("predict", "5x4.3x3", *NAMED[1:], "--std-by-source", "--format", "json")
    assert json.loads(guessed.out)["thrust_std_geometry_N"] > 0.0


def test_constants_of_which_a_fit_knows_nothing_are_named(run: Run, tmp_path: Path) -> None:
    law = propmap.airfoil("paper-apc")
    assert isinstance(law, propmap.Airfoil)
    covariance = np.array([[0.04, np.inf], [np.inf, np.inf]])
    known = propmap.SectionUncertainty(propmap.SectionCovariance(("c_l1", "c_l2"), covariance))
    (tmp_path / "law.toml").write_text(law.with_parameters(uncertainty=known).to_toml())
    done = run("predict", "apc-8x6e", "--airfoil", tmp_path / "law.toml", *NAMED[1:])
    assert "note: standard deviations exclude c_l2" in done.err and "std. dev." in done.out


def test_a_table_of_points_shows_those_of_thrust_and_torque(run: Run, points_csv: Path) -> None:
    shown = run("predict", "apc 10x5e", "--points", points_csv).out
    assert "s(T)" in shown and "s(Q)" in shown and "standard deviations" in shown


def test_height_above_ground_is_an_option_and_a_column(
    run: Run, rotor: propmap.Rotor, tmp_path: Path
) -> None:
    at = (RPM * OMEGA, SPEED, np.radians(BETA))
    found = json.loads(run("predict", *ROTOR, *POINT, "--height", 0.08, "--format", "json").out)
    assert found["height_m"] == 0.08
    near = float(rotor.loads(*at, height=0.08).thrust)
    assert found["thrust_N"] == pytest.approx(near, rel=1e-14)
    assert near > rotor.loads(*at).thrust
    file = tmp_path / "points.csv"
    file.write_text(f"height_m,rpm,speed_mps,beta_deg\n0.08,{RPM},{SPEED},{BETA}\n0.5,6000,0,0\n")
    done = run("predict", *ROTOR, "--points", file, "--format", "csv")
    rows = list(csv.DictReader(io.StringIO(done.out)))
    assert float(rows[0]["thrust_N"]) == found["thrust_N"]
    assert float(rows[1]["height_m"]) == 0.5


@pytest.mark.parametrize(
    ("height", "said"), [("-1", "height is negative"), ("0.01", "less than half the radius")]
)
def test_heights_that_cannot_be_are_refused(run: Run, height: str, said: str) -> None:
    done = run("predict", *ROTOR, *POINT, "--height", height)
    assert done.code != 0 and said in done.err


def test_an_empty_height_in_a_file_is_named(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "points.csv"
    file.write_text("rpm,speed_mps,beta_deg,height_m\n6000,0,0,\n")
    done = run("predict", *ROTOR, "--points", file)
    assert done.code != 0 and "line 2, column height_m" in done.err


def test_a_table_has_no_height(run: Run) -> None:
    assert "--height" in run("table", *ROTOR, "--height", 1).err


def test_the_way_to_the_core_leads_through_few_files(run: Run) -> None:
    """Functions of at most so many files are called; see docs/architecture.md."""
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
    assert len(way) <= 25, sorted(way)
