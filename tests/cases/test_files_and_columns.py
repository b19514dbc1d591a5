"""Files as people have them, by the command that they type: read and said how, or one line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from propmap.cli import main
from propmap.io.geometry import read_geometry_file
from propmap.model.airfoil import parameter_set
from tests.cli.conftest import Outcome, Run
from tests.cli.fit_inputs import STAND, fit_record

from . import samples

CASES = Path(__file__).resolve().parents[3] / "shared" / "cases"
PROP = ["--prop", "apc-8x6e"]
FREE = ["--free", "c_l1,zero_lift_angle", "--prior-from", "family"]
ROWS = [
    (rpm, t, q) for rpm, t, q in (map(float, line.split(",")) for line in STAND.splitlines()[1:])
]


def refused(done: Outcome, *words: str) -> None:
    assert (done.code, done.out) == (2, "")
    *_, last = done.err.splitlines()
    assert last.startswith("propmap: error: ")
    for word in words:
        assert word in last
    assert "Traceback" not in done.err


def loads_of(run: Run, *arguments: object) -> tuple[dict[str, Any], str]:
    done = run("predict", *arguments, "--rpm", "5000", "--format", "json", "--no-bands")
    assert done.code == 0, done.err
    return json.loads(done.out), done.err


# -------------------------------------------------------------------------------------------------
# Columns of stands.


def stand_csv(header: str, *columns: int) -> str:
    return "\n".join([header, *(",".join(repr(row[k]) for k in columns) for row in ROWS)]) + "\n"


STANDS = {
    "a stand's own names": (samples.stand(ROWS), "'Thrust (gf)' is thrust in gf"),
    "capitals": (stand_csv("RPM,THRUST_N,Torque_Nm", 0, 1, 2), "'RPM' is the rotational speed"),
    "symbols": (stand_csv("rpm,T [N],Q_Nm", 0, 1, 2), "'Q_Nm' is torque in Nm"),
    "with a unit that no load has": (
        "rpm,Thrust (N),Torque (N-m),Power (%)\n"
        + "".join(f"{r},{t},{q},50\n" for r, t, q in ROWS),
        "not used: 'Power (%)'",
    ),
    "rows that stand still": (
        stand_csv("RPM1 - RPM,Thrust - N,Torque - N*m", 0, 1, 2).replace(
            "\n", "\n0,5,0.1\n,5,\n", 1
        ),
        "2 of 10 rows have no rpm: omitted",
    ),
    "units beneath": (
        stand_csv("Drehzahl,Thrust,Q_avg\n1/min,N,N m", 0, 1, 2),
        "'Q_avg [N m]' is torque in N m",
    ),
    "averages": (stand_csv("RPM_avg,Thrust (N) ,Torque_mean (N-m)", 0, 1, 2), "'RPM_avg' is the"),
    "a title above": (
        "T-Motor F80,,\n" + stand_csv("RPM,Thrust (N),Torque (Nm)", 0, 1, 2),
        "'RPM' is",
    ),
    "a power beside": (stand_csv("rpm,thrust_N,torque_Nm,power", 0, 1, 2, 0), "not used: 'power'"),
}


@pytest.mark.usefixtures("brief")
@pytest.mark.parametrize("case", STANDS)
def test_stands_are_read_and_said_how(run: Run, case: str) -> None:
    Path("plain.csv").write_text(STAND)
    assert run("fit", "static", "plain.csv", *PROP, *FREE, "-o", "want.toml").code == 0
    text, says = STANDS[case]
    Path("stand.csv").write_text(text)
    done = run("fit", "static", "stand.csv", *PROP, *FREE, "-o", "found.toml")
    assert done.code == 0
    assert says in done.err
    assert any(says in remark for remark in fit_record(Path("found.toml"))["remarks"])
    want, found = parameter_set("want.toml"), parameter_set("found.toml")
    assert found.c_l1 == pytest.approx(want.c_l1, rel=1e-5)


@pytest.mark.usefixtures("brief")
def test_a_stand_s_file_that_is_no_utf_8(run: Run) -> None:
    Path("stand.csv").write_bytes(samples.stand(ROWS).encode("latin-1"))
    done = run("fit", "static", "stand.csv", *PROP, *FREE)
    assert done.code == 0 and "'Torque (N\u00b7m)' is torque in N\u00b7m" in done.err


@pytest.mark.usefixtures("brief")
def test_of_a_stand_s_columns_none_goes_without_a_word(run: Run) -> None:
    Path("stand.csv").write_text(samples.stand(ROWS))
    done = run("fit", "static", "stand.csv", *PROP, *FREE)
    told = next(line for line in done.err.splitlines() if "columns:" in line)
    for name in samples.STAND_NAMES.split(","):
        assert f"'{name}'" in told
    # The speed that was not measured is not the one that is taken.
    assert "'Motor Electrical Speed (RPM)' is the rotational speed" in told
    assert "'Motor Optical Speed (RPM)' (blank)" in told
    assert "'Electrical Power (W)' (electrical, not of the shaft)" in told


@pytest.mark.usefixtures("brief")
def test_a_blank_torque_leaves_the_thrust(run: Run) -> None:
    text = "rpm,thrust_N,torque_Nm\n" + "".join(f"{rpm},{t},\n" for rpm, t, _ in ROWS)
    Path("blank.csv").write_text(text)
    done = run("fit", "static", "blank.csv", *PROP, *FREE, "-o", "fit.toml")
    assert done.code == 0 and "not used: 'torque_Nm' (blank)" in done.err
    assert list(fit_record(Path("fit.toml"))["residuals"]) == ["thrust"]


@pytest.mark.usefixtures("brief")
def test_voltage_times_current_is_no_power_of_the_shaft(run: Run) -> None:
    text = "RPM,Thrust(g),Voltage (V),Current (A),Power (W)\n" + "".join(
        f"{rpm},{t / 9.80665e-3},11.1,{rpm / 1e3},{round(11.1 * rpm / 1e3, 1)}\n"
        for rpm, t, _ in ROWS
    )
    Path("maker.csv").write_text(text)
    done = run("fit", "static", "maker.csv", *PROP, *FREE, "-o", "fit.toml")
    assert done.code == 0
    assert "power equals voltage times current: it is electrical and not used" in done.err
    assert list(fit_record(Path("fit.toml"))["residuals"]) == ["thrust"]


def test_electrical_rpm_alone_is_no_rpm(run: Run) -> None:
    Path("esc.csv").write_text(stand_csv("eRPM,thrust_N", 0, 1))
    refused(run("fit", "static", "esc.csv", *PROP), "'eRPM' is electrical", "pole pairs")


def test_speeds_that_a_stand_did_not_measure_are_named(run: Run, tmp_path: Path) -> None:
    head = "Thrust (gf),Torque (N·m),Motor Electrical Speed (RPM),Motor Optical Speed (RPM)"
    (tmp_path / "log.csv").write_text(f"{head}\n6.4,0.0007,0,0\n7.8,0.0008,0,\n")
    done = run("fit", "static", "log.csv", "--prop", "apc-8x6e", "-o", "fit.toml")
    assert done.code == 2 and "'Motor Electrical Speed (RPM)'" in done.err
    assert "all rows are empty or 0; measure the rotational speed" in done.err


def test_points_at_rest_need_rpm_alone(run: Run) -> None:
    Path("points.csv").write_text("Rotation speed (rpm)\n4000\n5000\n")
    done = run("predict", "apc-8x6e", "--points", "points.csv", "--format", "csv")
    assert done.code == 0 and done.out.count("\n") == 3
    assert "'Rotation speed (rpm)' is the rotational speed" in done.err
    assert "all rows are assumed to be at V = 0" in done.err


@pytest.mark.usefixtures("brief")
@pytest.mark.parametrize("change", [("", ""), ("RPM", "# static\nRPM"), (" ", ",")])
def test_coefficients_of_uiuc_with_comments_and_commas(run: Run, change: tuple[str, str]) -> None:
    Path("static.txt").write_text("RPM CT CP\n3000 0.1 0.05\n4000 0.1 0.049\n".replace(*change))
    done = run("fit", "static", "static.txt", *PROP, *FREE, "-o", "fit.toml")
    assert done.code == 0, done.err
    assert fit_record(Path("fit.toml"))["rows"] == 4


# -------------------------------------------------------------------------------------------------
# Fits that explain nothing.


@pytest.mark.usefixtures("brief")
def test_a_fit_that_leaves_most_is_refused_with_the_cause(run: Run) -> None:
    text = "rpm,thrust_N,torque_Nm\n" + "".join(f"{rpm},{t},{-q}\n" for rpm, t, q in ROWS)
    Path("sign.csv").write_text(text)
    asked = ("fit", "static", "sign.csv", *PROP, *FREE, "-o", "fit.toml")
    refused(run(*asked), "% of the torque", "its sign looks reversed", "--accept")
    assert not Path("fit.toml").exists()
    assert run(*asked, "--accept").code == 0
    assert Path("fit.toml").exists()


# -------------------------------------------------------------------------------------------------
# Geometry.

GEOMETRIES = {
    "blade_geom.txt": (samples.UIUC, "2 blades assumed"),
    "commented.txt": ("# blade of the UIUC database\n" + samples.UIUC, "2 blades assumed"),
    "commas_geom.csv": (samples.UIUC.replace(" ", ","), "2 blades assumed"),
    "blade.prop": (samples.QPROP, "a QPROP propeller: its section law is not read"),
    "blade.xrotor": (samples.XROTOR, "an XROTOR file: its section law is not read"),
    "saved.xrotor": (
        samples.XROTOR.replace("!   #stations    #blades", "!   II Nblds"),
        "an XROTOR file: its section law is not read",
    ),
    "inches.prop": (samples.QPROP.replace(" 2        ! Nb", " 2 3.937008 ! Nb"), "QPROP"),
    "metres.prop": (samples.QPROP.replace(" 2        ! Nb", " 2 0.1 0.02 ! Nb"), "QPROP"),
    "script.bem": (samples.BEM.replace("Num_Blade:", "Num_Blades:"), "in meters"),
    "blade.bem": (samples.BEM, "diameter is assumed to be in meters"),
    "spelled.csv": (
        "# blades: 2\nRadius [mm];Chord (cm);Twist [\u00b0];t/c\n"
        + "".join(f"{r * 100!r};{c * 10!r};{b};0.1\n" for r, c, b in samples.BLADE),
        "not used: 't/c'",
    ),
}


@pytest.mark.parametrize("name", GEOMETRIES)
def test_geometry_of_other_programs(run: Run, name: str) -> None:
    text, says = GEOMETRIES[name]
    Path("want.csv").write_text(samples.CSV)
    Path(name).write_text(text)
    radius = ["--radius", "0.1"] if "r/R c/R" in text or "r/R,c/R" in text else []
    want, _ = loads_of(run, "want.csv")
    found, told = loads_of(run, name, *radius)
    assert says in told
    for load in ("thrust_N", "torque_Nm", "power_W"):
        assert found[load] == pytest.approx(want[load], rel=1e-9)


THREE = {
    "blade_5x4x3_geom.txt": samples.UIUC,
    "hq_three_blade.txt": samples.UIUC,
    "tri-blade_geom.txt": samples.UIUC,
    "da4052_5.0x4.92_3b_geom.txt": samples.UIUC,
    "said.txt": "# blades = 3\n" + samples.UIUC,
    "title.csv": "# my 3-blade propeller\n" + samples.CSV.split("\n", 1)[1],
    "three.prop": samples.QPROP.replace(" 2        ! Nb", " 3        ! Nb"),
    "three.bem": samples.BEM.replace("Num_Blade: 2", "Num_Blade: 3"),
}


@pytest.mark.parametrize("name", THREE)
def test_three_blades_are_three(run: Run, name: str) -> None:
    Path("want.csv").write_text(samples.CSV)
    Path(name).write_text(THREE[name])
    radius = ["--radius", "0.1"] if "r/R c/R" in THREE[name] else []
    want, _ = loads_of(run, "want.csv", "--blades", "3")
    found, _ = loads_of(run, name, *radius)
    assert found["thrust_N"] == pytest.approx(want["thrust_N"], rel=1e-9)
    two, _ = loads_of(run, name, *radius, "--blades", "2")
    assert two["thrust_N"] < 0.9 * found["thrust_N"]


def test_blades_that_nothing_tells_are_asked_for(run: Run) -> None:
    Path("carbon.txt").write_text(samples.UIUC)
    done = run("predict", "carbon.txt", "--rpm", "5000", "--radius", "0.1")
    refused(done, "no number of blades; pass --blades")


def test_a_tip_that_a_program_leaves_out_is_added(tmp_path: Path) -> None:
    """XROTOR's stations lie between the edges of its elements."""
    path = tmp_path / "short.xrotor"
    path.write_text(samples.XROTOR.replace("  1.00  0.040  10", "  0.99  0.046  10"))
    blade = read_geometry_file(path)
    assert blade.radius == pytest.approx(0.1)
    assert blade.chord[-1] == pytest.approx(0.1 * np.interp(1.0, [0.99, 1.0], [0.046, 0.0394737]))
    path.write_text(samples.XROTOR.replace("  1.00  0.040  10", "  0.90  0.046  10"))
    with pytest.raises(ValueError, match=r"the radius is 0\.09 m at the last station, but 0\.1 m"):
        read_geometry_file(path)


# -------------------------------------------------------------------------------------------------
# Polars.


@pytest.mark.parametrize("name", samples.POLARS)
def test_polars_of_other_programs(run: Run, name: str) -> None:
    Path("want.csv").write_text(
        "alpha_deg,re,cl,cd\n" + "".join(f"{a},50000,{c},{d}\n" for a, c, d in samples.POLAR)
    )
    Path("polar.dat").write_text(samples.POLARS[name])
    want, _ = loads_of(run, "apc-8x6e", "--airfoil", "want.csv")
    found, _ = loads_of(run, "apc-8x6e", "--airfoil", "polar.dat")
    assert found["thrust_N"] == pytest.approx(want["thrust_N"], rel=1e-6)
    assert found["torque_Nm"] == pytest.approx(want["torque_Nm"], rel=1e-6)


# -------------------------------------------------------------------------------------------------
# Computed loads, and files in the wrong place.


@pytest.mark.usefixtures("brief")
@pytest.mark.parametrize("text", [samples.PERFILE, samples.PERFILE_OF_2022])
def test_computed_loads_are_called_computed(run: Run, text: str) -> None:
    Path("PER3_8x6E.dat").write_text(text)
    quick = ["--free", "c_l1,zero_lift_angle", "--starts", "1", "--folds", "0"]
    done = run("fit", "tunnel", "apc-8x6e", "PER3_8x6E.dat", *quick, "-o", "fit.toml")
    assert done.code == 0
    says = "PER3_8x6E.dat: computed by APC, not measured"
    assert says in done.err and says in fit_record(Path("fit.toml"))["remarks"]
    assert fit_record(Path("fit.toml"))["rows"] == 10
    assert says in run("check", "fit.toml", "PER3_8x6E.dat").err


WRONG_PLACES = {
    "computed loads as PROP": (
        samples.PERFILE,
        "PERFILE of APC, with computed loads",
        "propmap fit",
    ),
    "measured loads as PROP": ("J CT CP eta\n0.1 0.1 0.05 0.2\n", "UIUC loads", "propmap check"),
    "a polar as PROP": (" alpha    CL        CD\n 1 2 3\n", "XFOIL", "--airfoil"),
    "a surface as PROP": ("solid blade\n facet normal 0 0 1\n", "STL surface", "as CSV"),
    "a section as PROP": ("NACA 4412\n 1.0000 0.0013\n 0.95 0.01\n", "coordinates of an airfoil"),
    "an AeroDyn blade": (
        "6 NumBlNds\nBlSpn BlCrvAC BlSwpAC BlCrvAng BlTwist BlChord BlAFID\n0 0 0 0 0 1 1\n",
        "AeroDyn blade",
    ),
}


@pytest.mark.parametrize("case", WRONG_PLACES)
def test_what_is_not_a_blade_is_called_what_it_is(run: Run, case: str) -> None:
    text, *words = WRONG_PLACES[case]
    Path("given.dat").write_text(text)
    refused(run("predict", "./given.dat", "--rpm", "5000"), "given.dat: this is", *words)


def test_a_blade_is_no_polar(run: Run) -> None:
    Path("blade.xrotor").write_text(samples.XROTOR)
    done = run("predict", "apc-8x6e", "--rpm", "5000", "--airfoil", "blade.xrotor")
    refused(done, "this is an XROTOR file, not a section table", "the argument PROP")


# -------------------------------------------------------------------------------------------------
# One point on the command line.


def test_hover_needs_rpm_alone(run: Run) -> None:
    still, _ = loads_of(run, "apc-8x6e")
    assert (still["speed_mps"], still["beta_deg"]) == (0.0, 0.0)
    done = run("predict", "apc-8x6e", "--rpm", "0")
    assert done.code == 0 and " -0 " not in done.out
    done = run("predict", "apc-8x6e", "--rpm", "5000", "--speed", "5", "--beta", "400")
    refused(done, "beta is 400, more than a turn")


def test_several_roots_are_explained(run: Run) -> None:
    done = run("predict", "apc-8x6e", "--airfoil", "paper-apc", "--rpm", "5000", "--format", "csv")
    assert "multiple_roots" in done.out
    assert "multiple_roots in 1 of 1 points: near stall" in done.err


@pytest.mark.usefixtures("brief")
def test_constants_of_another_propeller_are_pointed_out(run: Run) -> None:
    Path("stand.csv").write_text(STAND)
    assert run("fit", "static", "stand.csv", *PROP, *FREE, "-o", "fit.toml").code == 0
    _, told = loads_of(run, "apc-11x7e", "--airfoil", "fit.toml")
    assert "fit.toml were fitted to another propeller: apc-8x6e, 2 blades" in told
    _, told = loads_of(run, "apc-8x6e", "--airfoil", "fit.toml")
    assert "another propeller" not in told


# -------------------------------------------------------------------------------------------------
# The cases themselves, where they are.

FIRST_CASES = {
    "upper_rpm.csv": ("'RPM' is the rotational speed", PROP),
    "q_dropped.csv": ("'Q_Nm' is torque in Nm", ["--prop", "apc-10x5e"]),
    "blank_torque.csv": ("'torque_Nm' (blank)", ["--prop", "7x5"]),
    "thrust_only.csv": ("thrust", ["--prop", "7x5"]),
}


@pytest.mark.skipif(not CASES.is_dir(), reason="the cases are not here")
@pytest.mark.usefixtures("brief")
@pytest.mark.parametrize("name", FIRST_CASES)
def test_stands_of_the_cases(run: Run, name: str) -> None:
    says, prop = FIRST_CASES[name]
    done = run("fit", "static", CASES / name, *prop, *FREE)
    assert done.code == 0 and says in done.err


@pytest.mark.skipif(not CASES.is_dir(), reason="the cases are not here")
def test_every_file_of_the_cases_is_read_or_refused_in_one_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for file in sorted(CASES.glob("*.*")):
        for arguments in (
            ["predict", str(file), "--rpm", "3000", "--radius", "0.127"],
            ["predict", "apc-8x6e", "--rpm", "3000", "--airfoil", str(file)],
            ["predict", "apc-8x6e", "--points", str(file)],
        ):
            assert main(arguments) in (0, 2), arguments
            assert capsys.readouterr().err.count("propmap: error") <= 1
