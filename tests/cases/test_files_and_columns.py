"""Files in the layouts that people have: read with a note, or refused in one line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.errors import InputError
from propmap.fit.tunnel import TunnelData, measured_loads
from propmap.io.geometry import read_geometry_file
from propmap.io.sections import read_section_table
from propmap.units import GRAVITY
from tests.cli.conftest import Run, refused
from tests.cli.fit_inputs import STAND, fit_record
from tests.fit.fit_records import fit_text

from . import samples

PROP = ["--prop", "apc-8x6e"]
FREE = ["--free", "c_l1,zero_lift_angle", "--prior-from", "family"]
BLADE = propmap.propeller("apc-8x6e")
ROWS = [
    (rpm, t, q) for rpm, t, q in (map(float, line.split(",")) for line in STAND.splitlines()[1:])
]


def loads_of(run: Run, *arguments: object) -> tuple[dict[str, Any], str]:
    done = run("predict", *arguments, "--rpm", "5000", "--format", "json", "--no-bands")
    assert done.code == 0, done.err
    return json.loads(done.out), done.err


def read(text: str | bytes) -> tuple[TunnelData, str]:
    """Return the measured loads and the remarks on the columns."""
    Path("stand.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    found = measured_loads(Path("stand.csv"), at_rest=True)(BLADE, propmap.Air())
    return found, "; ".join(found.remarks)


def stand_csv(
    header: str, columns: tuple[int, ...] = (0, 1, 2), factors: tuple[float, ...] = (1.0, 1.0, 1.0)
) -> str:
    rows = (",".join(repr(row[k] * factors[k]) for k in columns) for row in ROWS)
    return "\n".join([header, *rows]) + "\n"


GRAMS = stand_csv("rpm,thrust_g,torque_Ncm", factors=(1.0, 1e3 / GRAVITY, 1e2))
STILL = stand_csv("RPM1 - RPM,Thrust - N,Torque - N*m").replace("\n", "\n0,5,0.1\n,5,\n", 1)
POWER = "".join(f"{rpm},{t},{q * rpm * np.pi / 30.0!r}\n" for rpm, t, q in ROWS)
STANDS: dict[str, tuple[str | bytes, str]] = {
    "no UTF-8": (samples.stand(ROWS).encode("latin-1"), "'Torque (N\u00b7m)' is torque in N"),
    "symbols": (stand_csv("rpm,T [N],Q_Nm"), "'Q_Nm' is torque in Nm"),
    "g, N cm and decimal commas": (GRAMS.replace(",", ";").replace(".", ","), ""),
    "kg and mN m": (stand_csv("rpm,thrust_kg,torque_mNm", factors=(1.0, 1.0 / GRAVITY, 1e3)), ""),
    "shaft power": ("rpm,thrust_N,power_W\n" + POWER, "power is assumed to be shaft power"),
    "power of two kinds": (
        "RPM,Thrust - N,Mechanical (W),Electrical (W)\n" + POWER.replace("\n", ",90\n"),
        "'Electrical (W)' (electrical, not of the shaft); power is assumed to be shaft power",
    ),
    "power in %": (stand_csv("rpm,T [N],Q_Nm,Power (%)", (0, 1, 2, 0)), "not used: 'Power (%)'"),
    "rows that stand still": (STILL, "2 of 10 rows have no rpm and are omitted"),
    "units beneath": (stand_csv("Drehzahl,Thrust,Q_avg\n1/min,N,N m"), "'Q_avg [N m]' is torque"),
    "a qualifier and a level speed": (
        stand_csv(
            "Speed (level) (km/h),Revolutions (rpm),Thrust - Motor 1 (N),Torque - 1 - N m",
            (2, 0, 1, 2),
        ),
        "not used: 'Speed (level) (km/h)'",
    ),
    "a title above": ("T-Motor F80,,\n" + stand_csv("RPM,Thrust (N),Torque (Nm)"), "'RPM' is"),
}


@pytest.mark.parametrize("case", STANDS)
def test_stands_are_read_and_said_how(case: str) -> None:
    text, says = STANDS[case]
    found, told = read(text)
    assert says in told and bool(says) is bool(told)
    want, _ = read(STAND)
    np.testing.assert_allclose(found.omega, want.omega, rtol=1e-12)
    for load in ("thrust", "torque"):
        np.testing.assert_allclose(found.loads[load], want.loads[load], rtol=1e-9)


@pytest.mark.usefixtures("brief")
def test_of_a_stand_s_columns_none_goes_without_a_word(run: Run) -> None:
    Path("stand.csv").write_text(samples.stand(ROWS))
    done = run("fit", "static", "stand.csv", *PROP, *FREE, "-o", "fit.toml")
    told = next(line for line in done.err.splitlines() if "columns:" in line)
    for name in samples.STAND_NAMES.split(","):
        assert f"'{name}'" in told
    # The speed that was not measured is not the one that is taken.
    assert "'Motor Electrical Speed (RPM)' is the rotational speed" in told
    assert "'Electrical Power (W)' (electrical, not of the shaft)" in told
    assert told.removeprefix("note: ") in fit_record(Path("fit.toml"))["remarks"]


def test_a_blank_torque_and_the_battery_s_power_leave_the_thrust() -> None:
    blank = stand_csv("rpm,thrust_N,torque_Nm", (0, 1)).replace("\n", ",\n").replace("Nm,", "Nm")
    found, told = read(blank)
    assert "not used: 'torque_Nm' (blank)" in told and list(found.loads) == ["thrust"]
    rows = "".join(f"{n},{t},11.1,{n / 1e3},{round(11.1 * n / 1e3, 1)}\n" for n, t, _ in ROWS)
    found, told = read(f"RPM,Thrust(N),Voltage (V),Current (A),Power (W)\n{rows}")
    assert list(found.loads) == ["thrust"]
    assert "power equals voltage times current: it is electrical and not used" in told


def test_several_propellers_in_a_file_are_refused() -> None:
    """Tables of manufacturers write the name in the first row of each propeller or in all rows."""
    rows = [f"{rpm},{thrust}" for rpm, thrust, _ in ROWS]
    for other in ("16x5.4", "", "15x5"):
        names = ["15x5", *[""] * (len(rows) - 2), other]
        cells = [f"{name},{row}" for name, row in zip(names, rows, strict=True)]
        text = "\n".join(["Prop (inch),RPM,Thrust (N)", *cells])
        if other == "16x5.4":
            with pytest.raises(InputError, match=r"names 2 propellers: '15x5', '16x5\.4'; keep"):
                read(text)
        else:
            assert read(text)[0].loads["thrust"].size == len(rows)


def test_speeds_that_a_stand_did_not_measure() -> None:
    with pytest.raises(InputError, match=r"'eRPM' \(electrical: divide.*pole pairs"):
        read(stand_csv("eRPM,thrust_N", (0, 1)))
    head = "Thrust (gf),Motor Electrical Speed (RPM),Motor Optical Speed (RPM)"
    with pytest.raises(InputError, match=r"rpm is missing; .*Speed \(RPM\)' \(blank\)"):
        read(f"{head}\n6.4,0,0\n7.8,0,\n")


@pytest.mark.parametrize(
    ("header", "says"),
    [
        ("rmp,Thrust (N),Zeit", "rpm is missing; the columns are 'rmp' (like rpm), 'Thrust (N)'"),
        ("rpm,thrust_N,torque_Nm\n4,000,1,1", "stand.csv: line 2: found 4 fields separated by"),
        (
            'rpm,thrust_N,torque_Nm\n"4,000",1,1',
            "'4,000' is not a number; write a number without a unit and",
        ),
        ("rpm,Thrust - 1 (N),Thrust - 2 (N)", "'Thrust - 1 (N)' and 'Thrust - 2 (N)' both"),
        ("RPM (electrical),Thrust (N),El. Power (W)", "'RPM (electrical)' (electrical: divide"),
        ("rpm,Thrust (std) (N),Torque", "column 'Torque' has no known unit"),
    ],
)
def test_a_refusal_lists_the_columns(header: str, says: str) -> None:
    with pytest.raises(InputError) as caught:
        read(stand_csv(header))
    assert says in str(caught.value)
    Path("blade.csv").write_text("# blades: 2\nr (mm),Chord (mm),slope\n10,5,2\n20,4,1\n")
    with pytest.raises(
        InputError, match=r"the twist; the columns are 'r \(mm\)' \(the station\), 'Ch"
    ):
        read_geometry_file(Path("blade.csv"))


def test_points_at_rest_need_rpm_alone(run: Run) -> None:
    Path("points.csv").write_text("Rotation speed (rpm)\n4000\n5000\n")
    done = run("predict", "apc-8x6e", "--points", "points.csv", "--format", "csv")
    assert done.code == 0 and done.out.count("\n") == 3
    assert "'Rotation speed (rpm)' is the rotational speed" in done.err
    assert "all rows are assumed to be at V = 0" in done.err


def test_coefficients_of_uiuc_with_comments_and_commas() -> None:
    text = "RPM CT CP\n3000 0.1 0.05\n4000 0.1 0.049\n"
    want, found = read(text)[0], read("# static\n" + text.replace(" ", ","))[0]
    assert found.omega.tolist() == want.omega.tolist()
    assert found.loads["torque"].tolist() == want.loads["torque"].tolist()


@pytest.mark.usefixtures("brief")
def test_a_fit_that_leaves_most_is_refused_with_the_cause(run: Run) -> None:
    text = "rpm,thrust_N,torque_Nm\n" + "".join(f"{rpm},{t},{-q}\n" for rpm, t, q in ROWS)
    Path("sign.csv").write_text(text)
    asked = ("fit", "static", "sign.csv", *PROP, *FREE, "-o", "fit.toml")
    refused(run(*asked), "% of the torque", "its sign looks reversed", "--accept")
    assert not Path("fit.toml").exists()
    assert run(*asked, "--accept").code == 0
    remark = next(one for one in fit_record(Path("fit.toml"))["remarks"] if "accepted" in one)
    assert "although the rms error is" in remark


@pytest.mark.parametrize(
    ("times", "says"), [(2.2, ""), (3.0, "c_l1, c_d0"), (4.0, "c_l1, c_d0, zero_lift_angle")]
)
def test_constants_at_their_bounds_are_refused(run: Run, times: float, says: str) -> None:
    free = ["--free", "c_l1,c_d0,zero_lift_angle", "--prior-from", "none"]
    Path("more.csv").write_text(stand_csv("rpm,thrust_N", (0, 1), (1.0, times)))
    done = run("fit", "static", "more.csv", *PROP, *free, "-o", "fit.toml")
    assert Path("fit.toml").exists() is not bool(says)
    if says:
        refused(done, f"{says} are at their bounds, so no file", "--accept")


XROTOR, BEM = "an XROTOR file: its section law is not read", "diameter is assumed to be in meters"
GEOMETRIES = {
    "blade_geom.txt": (samples.UIUC, "2 blades assumed", 2),
    "commas_geom.csv": (samples.UIUC.replace(" ", ","), "2 blades assumed", 2),
    "da4052_5.0x4.92_3b_geom.txt": (samples.UIUC, "", 3),
    "said.txt": ("# blades = 3\n" + samples.UIUC, "", 3),
    "title.csv": ("# my 3-blade propeller\n" + samples.CSV.split("\n", 1)[1], "", 3),
    "blade.prop": (samples.QPROP, "a QPROP propeller: its section law is not read", 2),
    "meters.prop": (samples.QPROP.replace(" 2        ! Nb", " 3 0.1 0.02 ! Nb"), "QPROP", 3),
    "blade.xrotor": (samples.XROTOR, XROTOR, 2),
    "saved.xrotor": (samples.XROTOR.replace("#stations    #blades", "II Nblds"), XROTOR, 2),
    "three.bem": (samples.BEM.replace("Num_Blade: 2", "Num_Blades: 3"), BEM, 3),
    "spelled.csv": (
        "# blades: 2\nRadius [mm];Chord (cm);Twist [\u00b0];t/c\n"
        + "".join(f"{r * 100!r};{c * 10!r};{b};0.1\n" for r, c, b in samples.BLADE),
        "not used: 't/c'",
        2,
    ),
}


@pytest.mark.parametrize("name", GEOMETRIES)
def test_geometry_of_other_programs(run: Run, name: str) -> None:
    text, says, blades = GEOMETRIES[name]
    Path("want.csv").write_text(samples.CSV)
    Path(name).write_text(text)
    radius = ["--radius", "0.1"] if "r/R" in text and "c/R beta" in text.replace(",", " ") else []
    want, _ = loads_of(run, "want.csv", "--blades", blades)
    found, told = loads_of(run, name, *radius)
    assert says in told
    for load in ("thrust_N", "torque_Nm", "power_W"):
        assert found[load] == pytest.approx(want[load], rel=1e-9)


def test_a_tip_that_a_program_leaves_out_is_added() -> None:
    """XROTOR's stations lie between the edges of its elements."""
    path = Path("short.xrotor")
    path.write_text(samples.XROTOR.replace("  1.00  0.040  10", "  0.99  0.046  10"))
    blade = read_geometry_file(path)
    assert blade.radius == pytest.approx(0.1)
    assert blade.chord[-1] == pytest.approx(0.1 * np.interp(1.0, [0.99, 1.0], [0.046, 0.0394737]))
    path.write_text(samples.XROTOR.replace("  1.00  0.040  10", "  0.90  0.046  10"))
    with pytest.raises(ValueError, match=r"the radius is 0\.09 m at the last station, but 0\.1 m"):
        read_geometry_file(path)


@pytest.mark.parametrize("name", samples.POLARS)
def test_polars_of_other_programs(name: str) -> None:
    Path("polar.dat").write_text(samples.POLARS[name])
    table = read_section_table(Path("polar.dat"))
    degrees, lift, drag = np.array(samples.POLAR).T
    rows = table.lift[0], table.drag[0]
    found = [np.interp(np.radians(degrees), table.angle, row) for row in rows]
    np.testing.assert_allclose(found, [lift, drag], rtol=1e-9)


@pytest.mark.usefixtures("brief")
def test_computed_loads_are_called_computed(run: Run) -> None:
    Path("PER3_8x6E.dat").write_text(samples.PERFILE)
    quick = ["--free", "c_l1,zero_lift_angle", "--starts", "1", "--folds", "0"]
    done = run("fit", "tunnel", "apc-8x6e", "PER3_8x6E.dat", *quick, "-o", "fit.toml")
    says, told = "PER3_8x6E.dat: computed by APC, not measured", fit_record(Path("fit.toml"))
    assert says in done.err and says in told["remarks"] and told["rows"] == 10
    assert says in run("check", "fit.toml", "PER3_8x6E.dat").err
    want, (later, told) = read(samples.PERFILE)[0], read(samples.PERFILE_OF_2022)
    assert "computed by APC" in told
    assert later.loads["thrust"].tolist() == want.loads["thrust"].tolist()


def test_hover_needs_rpm_alone_and_several_roots_are_explained(run: Run) -> None:
    still, told = loads_of(run, "apc-8x6e", "--airfoil", "paper-apc")
    assert (still["speed_mps"], still["beta_deg"], still["status"]) == (0.0, 0.0, "multiple_roots")
    assert "multiple_roots in 1 of 1 points: near stall" in told
    done = run("predict", "apc-8x6e", "--rpm", "0")
    assert done.code == 0 and " -0 " not in done.out


def test_constants_of_another_propeller_are_pointed_out(run: Run) -> None:
    Path("fit.toml").write_text(fit_text())
    _, told = loads_of(run, "apc-11x7e", "--airfoil", "fit.toml")
    assert "fit.toml were fitted to another propeller: apc-8x6e, 2 blades" in told
    _, told = loads_of(run, "apc-8x6e", "--airfoil", "fit.toml")
    assert "another propeller" not in told
