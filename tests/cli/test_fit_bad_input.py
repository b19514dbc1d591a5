"""Bad input to `propmap fit` and `propmap check`: one line, and no file."""

from __future__ import annotations

from pathlib import Path

import pytest

from propmap.model.airfoil import parameter_set

from .conftest import Run
from .fit_inputs import LEVEL, VEHICLE, picked, tunnel_table

HEADER = "rpm,speed_mps,beta_deg,thrust_N\n"
ROW = "5000,5,0,1.5\n"
LEVEL_HEADER = LEVEL.partition("\n")[0] + "\n"
FILES = {
    "good.csv": tunnel_table(picked()),
    "no_load.csv": "rpm,speed_mps,beta_deg\n5000,5,0\n",
    "empty_load.csv": HEADER + "5000,5,0,\n5000,6,0,\n",
    "two.csv": HEADER + 2 * ROW,
    "negative.csv": HEADER + ROW + "-5000,5,0,1.5\n",
    "nan.csv": HEADER + ROW + "5000,nan,0,1.5\n",
    "nan_load.csv": HEADER + ROW + "5000,6,0,nan\n",
    "text.csv": HEADER + ROW + "5000,6,0,high\n",
    "sample_static.txt": "RPM CT CP\n3000 0.1\n",
    "sample.txt": "J CT CP eta\n0.2 0.1 0.04 0.5\n",
    "header_5000.txt": "J CT CP eta\n",
    "words_5000.txt": "J CT CP eta\n0.2 much 0.04 0.5\n",
    "set.toml": parameter_set("paper-apc").to_toml(),
    "damaged.toml": parameter_set("paper-apc").to_toml() + '[fit]\nkind = "tunnel"\n',
    "flat.toml": parameter_set("paper-apc").to_toml() + "fit = 3\n",
    "wrong_air.toml": parameter_set("paper-apc").to_toml()
    + "[fit]\nbody = 3\nwing = {}\nair = {density = 1.2, viscosity = 2e-5}\n"
    + "[fit.propeller]\nname = 'x'\nblades = 2\nroot = 0.01\nstation_m = [0.01]\n"
    + "chord_m = [0.01]\ntwist_rad = [0.1]\n",
    "broken.toml": "c_l1 = = 5\n",
    "vehicle.toml": VEHICLE,
    "level.csv": LEVEL,
    "six.csv": LEVEL_HEADER.replace("rpm_4", "rpm_4,rpm_5,rpm_6") + "0,0,1,1,1,1,1,1\n",
    "nan_level.csv": LEVEL_HEADER + "0,0,5000,5000,nan,5000\n",
    "two_level.csv": "".join(LEVEL.splitlines(keepends=True)[:3]),
}
TUNNEL = ["fit", "tunnel", "apc-8x6e"]
TO = ["-o", "out.toml"]
NO_PRIOR = ["--prior-from", "none"]
GOOD = [*TUNNEL, "good.csv", *TO]
FLIGHT = ["fit", "flight", "--vehicle", "vehicle.toml", *TO]
CASES: list[tuple[list[str], str]] = [
    ([*GOOD, "--free", "c_l1,alpha"], "'alpha' is not a parameter; choose from alpha_0"),
    ([*GOOD, "--free", ""], "'' is not a parameter"),
    ([*GOOD, "--free", "c_l1,c_l1"], "c_l1 is named twice"),
    ([*GOOD, "--free", "c_l1,lift_area"], "lift_area has no effect in a tunnel test"),
    ([*GOOD, "--free", "c_l1,mount_area"], "add drag to the loads"),
    ([*GOOD, "--fix", "c_d0"], "--fix 'c_d0' has no '='; write --fix c_l1=6.0"),
    ([*GOOD, "--fix", "c_d0=small"], "--fix c_d0: 'small' is not a number"),
    ([*GOOD, "--fix", "c_d0=nan"], "c_d0 is nan"),
    ([*GOOD, "--free", "c_l1", "--fix", "c_l1=5"], "c_l1 is both free and fixed"),
    ([*GOOD, "--fix", "c_d0=0.5"], "give a value from 0 to 0.2"),
    ([*GOOD, "--fix", "cd0=0.01"], "choose from c_d0"),
    ([*GOOD, "--prior", "c_l2=2.0"], "--prior c_l2 has no standard deviation; write --prior"),
    ([*GOOD, "--prior", "c_l2=2.0:0"], "the prior of c_l2 has the standard deviation 0"),
    ([*GOOD, "--prior", "c_l2=two:1"], "'two' is not a number"),
    ([*GOOD, "--prior", "c_l2=nan:1"], "the prior of c_l2"),
    ([*GOOD, "--free", "c_l1", "--prior", "c_d0=0.01:0.01"], "c_d0 has a prior but is not free"),
    ([*GOOD, "--prior-from", "apcfs"], "'apcfs' is not a family of identified propellers"),
    ([*GOOD, "--loads", "drag"], "good.csv has no drag; fit thrust, torque"),
    ([*GOOD, "--loads", "thrust,lift"], "'lift' is not a load; choose from thrust"),
    ([*GOOD, "--weight", "thrust"], "--weight 'thrust' has no number; write --weight thrust=2"),
    ([*GOOD, "--weight", "thrust=0"], "the weight of thrust is 0; give a number above 0"),
    ([*GOOD, "--weight", "thurst=2"], "'thurst' has a weight but is not fitted; fit thrust"),
    ([*GOOD, "--loads", "thrust,thrust"], "thrust is named twice"),
    ([*GOOD, "--starts", "0"], "'--starts'"),
    ([*GOOD, "--rho", "-1"], "density"),
    ([*TUNNEL, "good.csv"], "output"),
    ([*TUNNEL, "good.csv", "-o", "out.csv"], ".toml"),
    ([*TUNNEL, "good.csv", "-o", "nowhere/out.toml"], "nowhere"),
    ([*TUNNEL, "good.csv", *TO, "--picture", "out.bmp"], ".png"),
    (["fit", "tunnel", "apc-8x6f", "good.csv", *TO], "apc-8x6e"),
    ([*TUNNEL, "nowhere.csv", *TO], "neither a file nor a measurement of the catalogue"),
    ([*TUNNEL, "uiuc-8x6", *TO], "uiuc-8x6e"),
    ([*TUNNEL, "no_load.csv", *TO], "there is no column with a load; add one of thrust_N"),
    ([*TUNNEL, "empty_load.csv", *TO], "not used: 'thrust_N' (blank)"),
    ([*TUNNEL, "two.csv", *TO, *NO_PRIOR], "2 measured numbers for 5 free parameters"),
    ([*TUNNEL, "negative.csv", *TO], "line 3, column rpm: -5000 is negative"),
    ([*TUNNEL, "nan.csv", *TO], "line 3, column speed_mps: nan is not a finite"),
    ([*TUNNEL, "nan_load.csv", *TO], "line 3, column thrust_N: nan is not a finite"),
    ([*TUNNEL, "text.csv", *TO], "'high' is not a number"),
    ([*TUNNEL, "sample.txt", *TO], "the rotational speed is not in the file's name"),
    ([*TUNNEL, "sample_static.txt", *TO], "line 2: found 2 values, expected 3"),
    ([*TUNNEL, "header_5000.txt", *TO], "no row below the header"),
    ([*TUNNEL, "words_5000.txt", *TO], "words_5000.txt: line 2"),
    (["check", "set.toml", "good.csv"], "add --prop NAME"),
    (["check", "nowhere.toml", "good.csv"], "no such file"),
    (["check", "broken.toml", "good.csv"], "not valid TOML"),
    (["check", "damaged.toml", "good.csv"], "the table [fit] cannot be read"),
    (["check", "flat.toml", "good.csv"], "fit"),
    (["check", "wrong_air.toml", "good.csv"], "wrong_air.toml"),
    (["check", "damaged.toml", "level.csv", "--vehicle", "vehicle.toml"], "cannot be read"),
    (["check", "set.toml", "level.csv", "--vehicle", "vehicle.toml"], "no accelerations"),
    (["check", "set.toml", "nowhere.csv", "--prop", "apc-8x6e"], "neither a file"),
    (["check", "set.toml", "good.csv", "--prop", "apc-8x6e", "-o", "nowhere/out.json"], "nowhere"),
    (["fit", "flight", "level.csv", *TO], "vehicle"),
    ([*FLIGHT, "level.csv", "--method", "balance"], "no accelerations; fit it with --method level"),
    ([*FLIGHT, "level.csv", "--free", "c_l1,wing_c_l1"], "the vehicle has no wing"),
    ([*FLIGHT, "six.csv"], "the vehicle has 4 rotors"),
    ([*FLIGHT, "nan_level.csv"], "line 2, column rpm_3"),
    ([*FLIGHT, "two_level.csv", *NO_PRIOR], "2 measured numbers for 4 free parameters"),
    ([*FLIGHT, "nowhere.csv"], "nowhere.csv"),
    ([*FLIGHT, "good.csv"], "no body_frame; add body_frame"),
    (["fit", "flight", "level.csv", "--vehicle", "nowhere.toml", *TO], "nowhere.toml"),
]


@pytest.fixture
def workplace(tmp_path: Path) -> Path:
    for name, content in FILES.items():
        (tmp_path / name).write_text(content)
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "says"), CASES, ids=[f"{i}-{case[1]}" for i, case in enumerate(CASES)]
)
def test_one_line_and_no_file(run: Run, workplace: Path, arguments: list[str], says: str) -> None:
    before = {path: path.read_bytes() for path in workplace.rglob("*")}
    done = run(*arguments)
    assert done.code == 2, done.out
    assert done.out == ""
    assert done.err.startswith("propmap: error: ")
    assert done.err.count("\n") == 1 and done.err.endswith("\n")
    assert says in done.err
    assert {path: path.read_bytes() for path in workplace.rglob("*")} == before
