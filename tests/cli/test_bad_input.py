"""Bad input to every command: exit code 2, one line with the cause, and no file."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from propmap.model.airfoil import parameter_set
from tests.cases import samples
from tests.fit.fit_records import fit_text

from .conftest import POINT, ROTOR, Run
from .fit_inputs import LEVEL, VEHICLE, tunnel_table
from .invented_tables import invented
from .test_aircraft import POWERED

HEADER = "rpm,speed_mps,beta_deg\n"
LOADS = "rpm,speed_mps,beta_deg,thrust_N\n5000,5,0,1.5\n"
LEVEL_HEADER = LEVEL.partition("\n")[0] + "\n"
LAW = parameter_set("paper-apc").to_toml()
PLATE = "".join(f"{a},1e5,{math.sin(math.radians(2 * a))},1\n" for a in range(-180, 181, 20))
FILES: dict[str, bytes] = {
    "no_rpm.csv": b"speed_mps,beta_deg\n1,2\n",
    "empty.csv": b"",
    "header.csv": HEADER.encode(),
    "text.csv": (HEADER + "4000,5,edgewise\n").encode(),
    "nan.csv": (HEADER + "4000,5,90\n4000,nan,90\n").encode(),
    "negative.csv": (HEADER + "4000,-5,90\n").encode(),
    "short.csv": (HEADER + "4000,5\n").encode(),
    "binary.csv": bytes(range(256)),
    "latin.csv": HEADER.encode() + b"4000,5,90\xb0\n",
    "no_loads.csv": (HEADER + "4000,5,90\n").encode(),
    "other_rpm.csv": b"rpm,speed_mps,beta_deg,thrust_N\n9000,5,90,1\n",
    "taken.nc": b"precious",
    "degrees.toml": LAW.replace("alpha_0 = 0.", "alpha_0 = 20.").encode(),
    "good.csv": tunnel_table().encode(),
    "empty_load.csv": LOADS.replace("1.5", "").encode(),
    "two.csv": (LOADS + "5000,5,0,1.5\n").encode(),
    "negative_rpm.csv": (LOADS + "-5000,5,0,1.5\n").encode(),
    "nan_load.csv": (LOADS + "5000,6,0,nan\n").encode(),
    "sample_static.txt": b"RPM CT CP\n3000 0.1\n",
    "sample.txt": b"J CT CP eta\n0.2 0.1 0.04 0.5\n",
    "header_5000.txt": b"J CT CP eta\n",
    "words_5000.txt": b"J CT CP eta\n0.2 much 0.04 0.5\n",
    "set.toml": LAW.encode(),
    "damaged.toml": (LAW + '[fit]\nkind = "tunnel"\n').encode(),
    "vehicle.toml": VEHICLE.encode(),
    "level.csv": LEVEL.encode(),
    "six.csv": (LEVEL_HEADER.replace("rpm_4", "rpm_4,rpm_5,rpm_6") + "0,0,1,1,1,1,1,1\n").encode(),
    "nan_level.csv": (LEVEL_HEADER + "0,0,5000,5000,nan,5000\n").encode(),
    "no_speed.csv": b"speed_mps,thrust_N\n0,1\n",
    "weight.csv": b"rpm,weight\n5000,1\n",
    "two_thrusts.csv": b"rpm,thrust_N,thrust_g\n5000,1,100\n",
    "no_unit.csv": b"rpm,Thrust,torque_Nm\n5000,1,0.03\n",
    "flying.csv": b"rpm,speed_mps,thrust_N\n5000,4,1\n",
    "grams.csv": b"rpm,thrust_N\n5000,300\n6000,440\n",
    "old.toml": fit_text().replace("covered", "covers").encode(),
    "whole.toml": fit_text().encode(),
    "flown.toml": fit_text(kind="level flight").encode(),
    "quad.toml": POWERED.encode(),
    "words.csv": b"speed_mps,climb_mps,duration_s\nfast,0,10\n",
    "legs.csv": b"speed_mps,climb_mps,duration_s\n0,2,20\n10,0,120\n",
    "plate.csv": ("alpha_deg,re,cl,cd\n" + PLATE).encode(),
    "text.toml": (LAW + 'corrections = "tip-loss"\n').encode(),
    "foo.toml": (LAW + 'corrections = ["foo"]\n').encode(),
    "twice.toml": (LAW + 'corrections = ["tip-loss", "tip-loss"]\n').encode(),
    "deep.toml": f"schema = 1\nx = {'[' * 5000}{']' * 5000}\n".encode(),
    "skew.toml": fit_text(covariance=np.array([[1.0, 0.5], [0.1, 1.0]])).encode(),
    "wide.toml": fit_text(covariance=np.diag([1e300, 1.0])).encode(),
    "carbon.txt": samples.UIUC.encode(),
    "blade.xrotor": samples.XROTOR.encode(),
    "PER3.dat": samples.PERFILE.encode(),
    "loads.dat": b"J CT CP eta\n0.1 0.1 0.05 0.2\n",
    "xfoil.dat": b" alpha    CL        CD\n 1 2 3\n",
    "stl.dat": b"solid blade\n facet normal 0 0 1\n",
    "naca.dat": b"NACA 4412\n 1.0000 0.0013\n 0.95 0.01\n",
    "aerodyn.dat": b"BlSpn BlCrvAC BlSwpAC BlCrvAng BlTwist BlChord BlAFID\n0 0 0 0 0 1 1\n",
    "bad.npz": b"PK\x03\x04" + bytes(500),
}
PREDICT = ["predict", *ROTOR]
GRID = ["--rpm", "4000:5000:2", "--speed", "10", "--beta", "80"]
SWEEP = ["sweep", *ROTOR]
MAP = ["plot", "map", *ROTOR, "--rpm", "4000", "-o"]
TUNNEL = ["fit", "tunnel", "apc-8x6e"]
TO = ["-o", "out.toml"]
NO_PRIOR = ["--prior-from", "none"]  # to collect the prior takes longer than all else
GOOD = [*TUNNEL, "good.csv", *TO, *NO_PRIOR]
FLIGHT = ["fit", "flight", "--vehicle", "vehicle.toml", *TO]
STATIC = ["fit", "static", "--prop", "apc-8x6e", *TO]
RANGES = ["--rpm", "4000:4400", "--speed", "14:16", "--beta", "75:90", "--tolerance", "5%"]
TABLE = ["table", *ROTOR, *RANGES, "-o", "out.npz"]
EXPORT = ["export", "-o", "to"]
REPORT = ["report", "-o", "out"]
TRIM = ["trim", "quad.toml", "--airfoil", "apc-8x6e-2019"]
CHOOSE = ["choose", "quad.toml"]
SIMULATE = ["simulate", "flight", "--vehicle", "vehicle.toml", "--airfoil", "paper-apc"]
SECTION = "plate.csv: this is a section table, but the command needs"
SIMULATE += ["--speeds", "9,11,13", "-o", "flight.csv"]

CASES: list[tuple[list[str], str]] = [
    (["predict", "apc-8x6f", "--airfoil", "paper-apc", *POINT], "apc-8x6e"),
    (["predict", "nowhere.txt", "--airfoil", "paper-apc", *POINT], "no such file"),
    (["predict", "apc-8x6e", "--airfoil", "paper-apx", *POINT], "paper-apc"),
    (["predict", "apc-8x6e", "--airfoil", "degrees.toml", *POINT], "radians"),
    (["predict", "apc-8x6e", "--airfoil", "text.toml", *POINT], "is 'tip-loss': write a list"),
    (["predict", "apc-8x6e", "--airfoil", "foo.toml", *POINT], "correction 'foo' is not known"),
    (["predict", "apc-8x6e", "--airfoil", "twice.toml", *POINT], "tip-loss is given twice"),
    (["predict", "apc-8x6e", "--airfoil", "deep.toml", *POINT], "recursion"),
    (["predict", "apc-8x6e", "--airfoil", "skew.toml", *POINT], "not symmetric"),
    (["predict", "apc-8x6e", "--airfoil", "wide.toml", *POINT], "a variance is 1e+300"),
    (
        ["predict", "apc-8x6e", "--airfoil", "blade.xrotor", *POINT],
        "use it as the argument PROP",
    ),
    (["predict", "carbon.txt", "--radius", "0.1", *POINT], "no number of blades; pass --blades"),
    (["predict", "./PER3.dat", *POINT], "this is a PERFILE of APC, with computed loads"),
    (["predict", "./loads.dat", *POINT], "UIUC loads"),
    (["predict", "./xfoil.dat", *POINT], "XFOIL"),
    (["predict", "./stl.dat", *POINT], "STL surface"),
    (["predict", "./naca.dat", *POINT], "coordinates of an airfoil"),
    (["predict", "./aerodyn.dat", *POINT], "AeroDyn blade"),
    (["predict", "--airfoil", "paper-apc", *POINT], "PROP"),
    ([*PREDICT, "--rpm", "fast", "--speed", "1", "--beta", "0"], "'--rpm'"),
    ([*PREDICT, "--rpm", "-4000", "--speed", "1", "--beta", "0"], "rpm is negative"),
    ([*PREDICT, "--rpm", "4000", "--speed", "-1", "--beta", "0"], "speed is negative"),
    ([*PREDICT, "--rpm", "nan", "--speed", "1", "--beta", "0"], "rpm is nan"),
    ([*PREDICT, "--rpm", "4000", "--speed", "1", "--beta", "400"], "more than a turn"),
    (PREDICT, "--rpm is missing"),
    ([*PREDICT, *POINT, "--rho", "-1"], "density"),
    ([*PREDICT, *POINT, "--rho", "1", "--altitude", "100"], "a standard atmosphere are given"),
    ([*PREDICT, *POINT, "--root-cutout", "0.2"], "root cut-out"),
    ([*PREDICT, *POINT, "--blades", "0"], "blades"),
    ([*PREDICT, *POINT, "--height", "-1"], "height is negative"),
    ([*PREDICT, *POINT, "--height", "0.01"], "less than half the radius"),
    ([*PREDICT, *POINT, "--accuracy", "perfect"], "perfect"),
    ([*PREDICT, *POINT, "--color", "red"], "--color"),
    ([*PREDICT, *POINT, "-o", "nowhere/out.json"], "nowhere"),
    ([*PREDICT, *POINT, "-o", "folder"], "folder"),
    ([*PREDICT, *POINT, "--points", "nan.csv"], "--rpm"),
    ([*PREDICT, "--points", "no_rpm.csv"], "column rpm is missing"),
    ([*PREDICT, "--points", "empty.csv"], "empty"),
    ([*PREDICT, "--points", "header.csv"], "no row"),
    ([*PREDICT, "--points", "text.csv"], "line 2, column beta_deg: 'edgewise'"),
    ([*PREDICT, "--points", "nan.csv"], "line 3, column speed_mps"),
    ([*PREDICT, "--points", "negative.csv"], "line 2, column speed_mps"),
    ([*PREDICT, "--points", "short.csv"], "line 2, column beta_deg"),
    ([*PREDICT, "--points", "binary.csv"], "binary data"),
    ([*PREDICT, "--points", "latin.csv"], "is not a number"),
    ([*SWEEP, *GRID, "-o", "out.txt"], ".nc"),
    ([*SWEEP, *GRID, "-o", "taken.nc"], "--force"),
    ([*SWEEP, *GRID], "output"),
    ([*SWEEP, "--rpm", "1:2", "--speed", "1", "--beta", "0", "-o", "out.nc"], "1:2"),
    ([*SWEEP, "--rpm", "1:2:1", "--speed", "1", "--beta", "0", "-o", "out.nc"], "N is 1"),
    ([*SWEEP, "--rpm", "2:1:3", "--speed", "1", "--beta", "0", "-o", "out.nc"], "increase"),
    ([*SWEEP, "--rpm", "1", "--speed", "-1:1:3", "--beta", "0", "-o", "out.nc"], "negative"),
    ([*SWEEP, "--rpm", "1:9:9999", "--speed", "1:9:9999", "--beta", "0", "-o", "o.nc"], "points"),
    ([*MAP, "out.bmp"], ".png"),
    ([*MAP, "out.png", "--measured", "no_loads.csv"], "thrust_N"),
    ([*MAP, "out.png", "--measured", "other_rpm.csv"], "9000"),
    ([*MAP, "out.png", "--beta", "0:90:8"], "at most 7"),
    (["plot", "disk", *ROTOR, *POINT[:4], "--beta", "nan", "-o", "out.png"], "beta"),
    (["plot"], "command"),
    (["props", "show", "apc-8x6f"], "apc-8x6e"),
    (["airfoils", "show", "paper"], "paper-apc"),
    (["fly"], "fly"),
    (["table", *ROTOR, "--height", "1"], "--height"),
    # Fits and checks.
    ([*GOOD, "--free", "c_l1,alpha"], "'alpha' is not a parameter; choose from alpha_0"),
    ([*GOOD, "--free", "c_l1,lift_area"], "lift_area has no effect in a tunnel test"),
    ([*GOOD, "--free", "c_l1,mount_area"], "add drag to the loads"),
    ([*GOOD, "--fix", "c_d0"], "--fix 'c_d0' has no '='; write --fix c_l1=6.0"),
    ([*GOOD, "--fix", "c_d0=small"], "--fix c_d0: 'small' is not a number"),
    ([*GOOD, "--prior", "c_l2=2.0"], "--prior c_l2 has no standard deviation; write --prior"),
    (
        [*TUNNEL, "good.csv", *TO, "--prior-from", "apcfs"],
        "'apcfs' is not a family of identified propellers",
    ),
    ([*GOOD, "--loads", "drag"], "good.csv has no drag; fit thrust, torque"),
    ([*GOOD, "--loads", "thrust,lift"], "'lift' is not a load; choose from thrust"),
    ([*GOOD, "--loads", "thrust,thrust"], "thrust is named twice"),
    ([*GOOD, "--weight", "thrust"], "--weight 'thrust' has no number; write --weight thrust=2"),
    ([*GOOD, "--weight", "thrust=0"], "the weight of thrust is 0; give a number above 0"),
    ([*GOOD, "--weight", "thurst=2"], "'thurst' has a weight but is not fitted; fit thrust"),
    ([*TUNNEL, "good.csv", "-o", "out.csv"], ".toml"),
    ([*GOOD, "--picture", "out.bmp"], ".png"),
    ([*TUNNEL, "nowhere.csv", *TO, *NO_PRIOR], "neither a file nor a measurement of the catalogue"),
    ([*TUNNEL, "uiuc-8x6", *TO, *NO_PRIOR], "uiuc-8x6e"),
    (
        [*TUNNEL, "no_loads.csv", *TO, *NO_PRIOR],
        "there is no column with a load; add one of thrust_N",
    ),
    ([*TUNNEL, "empty_load.csv", *TO, *NO_PRIOR], "not used: 'thrust_N' (blank)"),
    ([*TUNNEL, "two.csv", *TO, *NO_PRIOR], "2 measured numbers for 5 free parameters"),
    ([*TUNNEL, "negative_rpm.csv", *TO, *NO_PRIOR], "line 3, column rpm: -5000 is negative"),
    ([*TUNNEL, "nan_load.csv", *TO, *NO_PRIOR], "line 3, column thrust_N: nan is not a finite"),
    ([*TUNNEL, "sample.txt", *TO, *NO_PRIOR], "the rotational speed is not in the file's name"),
    ([*TUNNEL, "sample_static.txt", *TO, *NO_PRIOR], "line 2: found 2 values, expected 3"),
    ([*TUNNEL, "header_5000.txt", *TO, *NO_PRIOR], "no row below the header"),
    ([*TUNNEL, "words_5000.txt", *TO, *NO_PRIOR], "words_5000.txt: line 2"),
    (["check", "nowhere.toml", "good.csv"], "no such file"),
    (["check", "skew.toml", "good.csv"], "not symmetric"),
    (["check", "damaged.toml", "good.csv"], "the table [fit] cannot be read"),
    (["check", "set.toml", "level.csv", "--vehicle", "vehicle.toml"], "no accelerations"),
    (["check", "set.toml", "good.csv", "--prop", "apc-8x6e", "-o", "nowhere/out.json"], "nowhere"),
    (["fit", "flight", "level.csv", *TO], "vehicle"),
    ([*FLIGHT, "level.csv", "--method", "balance"], "no accelerations; fit it with --method level"),
    ([*FLIGHT, "level.csv", "--free", "c_l1,wing_c_l1"], "the vehicle has no wing"),
    ([*FLIGHT, "six.csv"], "the vehicle has 4 rotors"),
    ([*FLIGHT, "nan_level.csv"], "line 2, column rpm_3"),
    ([*FLIGHT, "good.csv"], "no body_frame; add body_frame"),
    (["fit", "flight", "level.csv", "--vehicle", "nowhere.toml", *TO], "nowhere.toml"),
    ([*STATIC, "no_speed.csv"], "line 1: column rpm is missing"),
    ([*STATIC, "weight.csv"], "not used: 'weight'; add one of thrust_N"),
    ([*STATIC, "two_thrusts.csv"], "'thrust_N' and 'thrust_g' both contain thrust"),
    ([*STATIC, "no_unit.csv"], "'Thrust' has no known unit; name it thrust_N"),
    ([*STATIC, "flying.csv"], "fit such data with propmap fit tunnel"),
    ([*STATIC, "grams.csv"], "thrust looks like grams"),
    ([*GOOD, "--airfoil", "plate.csv"], SECTION),
    ([*FLIGHT, "level.csv", "--airfoil", "plate.csv"], SECTION),
    ([*SIMULATE, "--airfoil", "plate.csv"], SECTION),
    (["airfoils", "show", "plate.csv"], SECTION),
    (["check", "set.toml", "good.csv"], "the file has no table [fit]; add --prop NAME"),
    # Tables, exports and reports.
    ([*TABLE, "--tolerance", "much"], "not a fraction"),
    ([*TABLE, "--tolerance", "0.001%"], "must be between 0.20% and 10%"),
    ([*TABLE, "--rpm", "4000"], "not a range"),
    ([*TABLE, "--rpm", "5000:4000"], "do not increase"),
    ([*TABLE, "-o", "map.csv"], "extension"),
    ([*TABLE, "-o", "set.toml/map.npz"], "there is no folder 'set.toml"),
    ([*TABLE, "-o", "set.toml/folder/map.nc"], "there is no folder 'set.toml"),
    (["export", "map.npz", "--to", "c", "-o", "set.toml/to"], "there is no folder 'set.toml"),
    ([*EXPORT, "map.npz", "--to", "cpp"], "cpp is not made from a table, but from a propeller"),
    ([*EXPORT, "quad.toml", "--to", "cpp"], "cpp is not made from a vehicle and a table"),
    ([*TABLE, "-o", "bad.npz"], "--force"),
    (["show", "bad.npz"], "not a table, or it is damaged"),
    (["show", "bad.npz", "--format", "csv"], "use --format json"),
    ([*EXPORT, "map.npz", "--to", "px4"], "--to px4 needs a vehicle file"),
    ([*EXPORT, "set.toml", "--to", "ardupilot"], "set.toml"),
    ([*EXPORT, "quad.toml", "--to", "px4", "--prop", "apc-8x6e"], "leave it out"),
    ([*EXPORT, "quad.toml", "--to", "px4", "--table", "map.npz"], "the table is for"),
    ([*EXPORT, "quad.toml", "--to", "px4", "--speed", "3,x"], "--speed '3,x'"),
    ([*EXPORT, "map.npz", "--to", "c", "--speed", "3,4"], "--speed does not apply"),
    ([*EXPORT, "map.npz", "--to", "c", "--no-wakes"], "--no-wakes does not apply to --to c"),
    ([*EXPORT, "map.npz", "--to", "mujoco"], "mujoco is not made from a table"),
    ([*EXPORT, "set.toml", "--to", "c"], "--prop"),
    ([*EXPORT, "deep.toml", "--to", "c"], "recursion"),
    ([*EXPORT, "map.npz", "--prop", "apc-8x6e", "--to", "c"], "leave it out"),
    ([*REPORT, "absent.npz"], "no such file"),
    ([*REPORT, "level.csv"], "give a fit (.toml) or a table (.npz)"),
    ([*REPORT, "set.toml"], "there is no table [fit]"),
    (
        [*REPORT, "old.toml"],
        "the table [fit] cannot be read: Object missing required field covered",
    ),
    ([*REPORT, "map.npz", "--data", "tunnel.csv"], "--data and --vehicle apply to fits"),
    ([*REPORT, "whole.toml", "--data", "absent.csv"], "neither a file nor a measurement"),
    ([*REPORT, "whole.toml", "--vehicle", "vehicle.toml"], "add them with --data"),
    ([*REPORT, "flown.toml", "--data", "level.csv"], "add --vehicle FILE"),
    (
        [*REPORT, "map.npz", "-o", "folder"],
        "contains 'mine.txt', which this command does not write",
    ),
    ([*REPORT, "map.npz", "-o", "no/out"], "there is no folder"),
    # Aircraft and simulated flights.
    (["trim", "none.toml"], "none.toml"),
    (["trim", "deep.toml"], "recursion"),
    ([*TRIM, "--table", "x.npz"], "leave these out"),
    ([*TRIM, "--speed=-1"], "speed is negative"),
    ([*TRIM, "--climb", "fast"], "cannot be read"),
    ([*TRIM, "--max-rpm", "0"], "above 0"),
    ([*TRIM, "--speed", "0,5", "--wind", "nan"], "headwind"),
    ([*TRIM, "--charge", "80"], "1 for a full battery"),
    ([*TRIM, "--mission", "words.csv"], "line 2"),
    ([*TRIM, "--mission", "legs.csv", "--climb", "2"], "legs define"),
    ([*TRIM, "--picture", "p.bmp"], "extension"),
    ([*TRIM, "-o", "x.nc", "--format", "json"], "NetCDF"),
    ([*TRIM, "--speed", "5", "--bank", "89"], "80 degrees"),
    ([*CHOOSE, "--speed", "9", "--diameter", "big"], "in inches"),
    ([*CHOOSE, "--speed", "9", "--diameter", "40:50"], "no propeller of the catalogue"),
    ([*CHOOSE, "--speed", "0"], "above 0"),
    (CHOOSE, "cruise has no speed"),
    ([*CHOOSE, "--task", "loiter"], "choose from hover"),
    ([*CHOOSE, "--task", "none.csv"], "none.csv"),
    ([*CHOOSE, "--task", "hover", "--by", "range"], "cannot be ranked by range"),
    (["choose", "vehicle.toml", "--task", "hover", "--by", "time"], "no [battery]"),
    ([*CHOOSE, "--speed", "9", "--thrust-margin", "0.5"], "thrust must carry the weight"),
    ([*CHOOSE, "--speed", "9", "--airfoil", "paper-apc"], "without --propeller"),
    ([*SIMULATE, "--vehicle", "absent.toml"], "absent.toml: no such file"),
    ([*SIMULATE, "--speeds", "fast"], "--speeds 'fast' cannot be read"),
    ([*SIMULATE, "--speeds", "0.5:14.5"], "A:B:N"),
    ([*SIMULATE, "--noise", "-0.01"], "--noise is -0.01"),
    ([*SIMULATE, "--noise", "1"], "times the weight"),
    ([*SIMULATE, "--velocity-noise", "-1"], "--velocity-noise"),
    ([*SIMULATE, "--radius", "0"], "radius of the circle is 0 m"),
    ([*SIMULATE, "--dwell", "0.1"], "each speed lasts 0.1 s"),
    ([*SIMULATE, "--free", "wing_c_l1"], "no wing"),
    ([*SIMULATE, "--speeds", "10,70"], "70 m/s cannot be flown"),
    ([*SIMULATE, "-o", "flight.txt"], "extension"),
]


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """All files; no command may change them."""
    folder = tmp_path_factory.mktemp("files")
    for name, content in FILES.items():
        (folder / name).write_bytes(content)
    invented().save(folder / "map.npz")
    (folder / "folder").mkdir()
    (folder / "folder" / "mine.txt").write_text("mine")
    return folder


def contents(folder: Path) -> dict[Path, bytes | None]:
    return {path: path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


@pytest.mark.usefixtures("brief")
@pytest.mark.parametrize(
    ("arguments", "says"), CASES, ids=[f"{i}-{case[1]}" for i, case in enumerate(CASES)]
)
def test_one_line_and_no_file(
    run: Run, place: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], says: str
) -> None:
    monkeypatch.chdir(place)
    before = contents(place)
    done = run(*arguments)
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith("propmap: error: ")
    assert done.err.count("\n") == 1 and done.err.endswith("\n")
    assert says in done.err
    assert contents(place) == before
