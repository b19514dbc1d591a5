"""`propmap fit static`: a thrust stand in; constants, and what flight can be trusted to, out."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from propmap.catalogue.identified import PARAMETERS
from propmap.model.airfoil import parameter_set

from .conftest import Run
from .fit_inputs import STAND, fit_record, uiuc_files

pytestmark = pytest.mark.usefixtures("brief")

PROP = ["--prop", "apc-8x6e"]
FREE = ["--free", "c_l1,zero_lift_angle", "--prior-from", "family"]
GRAM = 9.80665e-3


def changes(out: str) -> list[tuple[int, int]]:
    """Per cent before and after, row by row."""
    return [(int(a), int(b)) for a, b in re.findall(r"(\d+)% -> (\d+)%", out)]


@pytest.fixture
def stand(tmp_path: Path) -> Path:
    (tmp_path / "stand.csv").write_text(STAND)
    return tmp_path / "stand.csv"


def test_a_stand_narrows_what_the_family_leaves_open(run: Run, stand: Path) -> None:
    done = run("fit", "static", stand, *PROP, "-o", "fit.toml")
    assert done.code == 0
    note, wrote = done.err.splitlines()
    assert note.startswith(
        "note: the prior of the section constants is from 16 propellers of the family apce"
    )
    assert "without the catalogue constants of" in note and "--prior-from none" in note
    assert wrote == "wrote fit.toml"
    found = fit_record(Path("fit.toml"))
    assert found["free"] == list(PARAMETERS)
    assert any("16 propellers of the family apce" in text for text in found["remarks"])
    law = parameter_set("fit.toml")
    assert 4.5 < law.c_l1 < 7.0 and law.zero_lift_angle < 0.0 and 1.0 < law.c_d < 5.0
    for name, told in found["parameters"].items():
        mean, deviation = told["prior"]
        assert "of the prior's deviation is left" in told["verdict"]
        assert abs(told["value"] - mean) < 3.0 * deviation, name
    told = changes(done.out)
    assert len(told) >= 10
    (before, after), *_ = told  # thrust at rest
    assert 6 <= before <= 16 and after <= 4
    assert all(after <= before + 2 for before, after in told)
    moving = told[2:8:2]  # thrust at J = 0.2, 0.4, 0.6 along the axis
    assert [after for _, after in moving] == sorted(after for _, after in moving)


@pytest.mark.parametrize(
    ("header", "factors"),
    [
        ("rpm;thrust_g;torque_Ncm", (1.0 / GRAM, 100.0)),
        ("rpm;thrust_kg;torque_mNm", (1e-3 / GRAM, 1e3)),
        ("rpm;thrust_N;power_W", (1.0, None)),
    ],
)
def test_units_and_dialects_of_stands(
    run: Run, stand: Path, header: str, factors: tuple[float, float | None]
) -> None:
    assert run("fit", "static", stand, *PROP, *FREE, "-o", "want.toml").code == 0
    lines = [header]
    for line in STAND.splitlines()[1:]:
        rpm, thrust, torque = (float(cell) for cell in line.split(","))
        turn = rpm * np.pi / 30.0 if factors[1] is None else factors[1]
        cells = (f"{rpm:.0f}", f"{thrust * factors[0]:.9f}", f"{torque * turn:.9f}")
        lines.append(";".join(cells).replace(".", ","))
    Path("other.csv").write_text("\n".join(lines) + "\n")
    assert run("fit", "static", "other.csv", *PROP, *FREE, "-o", "found.toml").code == 0
    want, found = parameter_set("want.toml"), parameter_set("found.toml")
    assert found.c_l1 == pytest.approx(want.c_l1, rel=1e-5)
    assert found.zero_lift_angle == pytest.approx(want.zero_lift_angle, rel=1e-5)


def test_uiuc_s_static_files_and_no_file_to_write(run: Run, tmp_path: Path) -> None:
    flying, static = uiuc_files(tmp_path)
    done = run("fit", "static", static, *PROP, *FREE)
    assert done.code == 0 and "wrote" not in done.err and "sd before -> after" in done.out
    refused = run("fit", "static", flying, *PROP)
    assert refused.code == 2 and "propmap fit tunnel" in refused.err


def test_the_battery_s_power_is_pointed_out(run: Run) -> None:
    rows = [
        f"{rpm},{9e-8 * rpm**2:.4f},{1.6 * 1.5e-9 * rpm**3 * np.pi / 30.0:.3f}"
        for rpm in range(3000, 7000, 500)
    ]
    Path("electric.csv").write_text("\n".join(["rpm,thrust_N,power_W", *rows]) + "\n")
    done = run("fit", "static", "electric.csv", *PROP, *FREE)
    assert done.code == 0 and "if it is battery power" in " ".join(done.out.split())


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("speed_mps,thrust_N\n0,1\n", "line 1: column rpm is missing"),
        (
            "rpm,weight\n5000,1\n",
            "no column with a load; columns: not used: 'weight'; add one of thrust_N",
        ),
        ("rpm,thrust_N,thrust_g\n5000,1,100\n", "'thrust_N' and 'thrust_g' both contain thrust"),
        (
            "rpm,Thrust,torque_Nm\n5000,1,0.03\n",
            "'Thrust' has no known unit; name it thrust_N",
        ),
        ("rpm,thrust_N,torque (stone)\n5000,2,0.4\n", "'torque (stone)' has no known unit"),
        ("rpm,speed_mps,thrust_N\n5000,4,1\n", "fit such data with propmap fit tunnel"),
        ("rpm,thrust_N\n5000,much\n", "line 2, column thrust_N"),
        ("rpm,thrust_N\n", "there is no row below the header"),
        ("rpm,thrust_N\n5000,\n6000,\n", "'thrust_N' (blank)"),
        ("rpm,thrust_N\n5000,300\n6000,440\n", "thrust looks like grams"),
    ],
)
def test_bad_files_in_one_line(run: Run, text: str, says: str) -> None:
    Path("bad.csv").write_text(text)
    done = run("fit", "static", "bad.csv", *PROP, "-o", "out.toml")
    assert (done.code, done.out, done.err.count("\n")) == (2, "", 1)
    assert says in done.err and "bad.csv" in done.err
    assert not Path("out.toml").exists()


def test_without_a_propeller(run: Run, stand: Path) -> None:
    done = run("fit", "static", stand)
    assert done.code == 2 and "--prop" in done.err
