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
LAW = parameter_set("paper-apc").to_toml()
PLATE = "".join(f"{a},1e5,{math.sin(math.radians(2 * a))},1\n" for a in range(-180, 181, 20))
FILES: dict[str, bytes] = {
    "no_rpm.csv": b"speed_mps,beta_deg\n1,2\n",
    "text.csv": (HEADER + "4000,5,edgewise\n").encode(),
    "nan.csv": (HEADER + "4000,5,90\n4000,nan,90\n").encode(),
    "no_loads.csv": (HEADER + "4000,5,90\n").encode(),
    "other_rpm.csv": b"rpm,speed_mps,beta_deg,thrust_N\n9000,5,90,1\n",
    "taken.nc": b"precious",
    "good.csv": tunnel_table().encode(),
    "outlier.csv": tunnel_table().replace("\n", "\n4500,5,0,500,.1\n", 1).encode(),
    "huge.csv": tunnel_table().replace("\n", "\n4500,5,0,1e300,.1\n", 1).encode(),
    "unnamed.csv": b"rpm,U (m/s),thrust_N\n4000,0,3\n4000,3,2\n",
    "advance.csv": b"rpm,J,thrust_N\n4000,0,3\n4000,.3,2\n",
    "sample.txt": b"J CT CP eta\n0.2 0.1 0.04 0.5\n",
    "set.toml": LAW.encode(),
    "damaged.toml": (LAW + '[fit]\nkind = "tunnel"\n').encode(),
    "vehicle.toml": VEHICLE.encode(),
    "level.csv": LEVEL.encode(),
    "flying.csv": b"rpm,speed_mps,thrust_N\n5000,4,1\n",
    "old.toml": fit_text().replace("covered", "covers").encode(),
    "whole.toml": fit_text().encode(),
    "flown.toml": fit_text(kind="level flight").encode(),
    "quad.toml": POWERED.encode(),
    "legs.csv": b"speed_mps,climb_mps,duration_s\n0,2,20\n10,0,120\n",
    "plate.csv": ("alpha_deg,re,cl,cd\n" + PLATE).encode(),
    "deep.toml": f"schema = 1\nx = {'[' * 5000}{']' * 5000}\n".encode(),
    "blade.xrotor": samples.XROTOR.encode(),
    "PER3.dat": samples.PERFILE.encode(),
    "xfoil.dat": b" alpha    CL        CD\n 1 2 3\n",
    "stl.dat": b"solid blade\n facet normal 0 0 1\n",
    "aerodyn.dat": b"BlSpn BlCrvAC BlSwpAC BlCrvAng BlTwist BlChord BlAFID\n0 0 0 0 0 1 1\n",
    "bad.npz": b"PK\x03\x04" + bytes(500),
    "skew.toml": fit_text(covariance=np.array([[1.0, 0.5], [0.1, 1.0]])).encode(),
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
    (["predict", "", *POINT], "the name of the propeller is empty"),
    (["predict", "HQ 5x4.3x3", *POINT, "--blades", "0"], "the number of blades is '0'"),
    ([*TRIM, "--bank", "30", "--speed", "0"], "give speeds above 0 for a turn"),
    (["predict", "nowhere.txt", "--airfoil", "paper-apc", *POINT], "no such file"),
    (["predict", "apc-8x6e", "--airfoil", "deep.toml", *POINT], "recursion"),
    (
        ["predict", "apc-8x6e", "--airfoil", "blade.xrotor", *POINT],
        "use it as the argument PROP",
    ),
    (["predict", "./PER3.dat", *POINT], "this is a PERFILE of APC, with computed loads"),
    (["predict", "./xfoil.dat", *POINT], "XFOIL"),
    (["predict", "./stl.dat", *POINT], "STL surface"),
    (["predict", "./aerodyn.dat", *POINT], "AeroDyn blade"),
    (["predict", "--airfoil", "paper-apc", *POINT], "PROP"),
    ([*PREDICT, "--rpm", "nan", "--speed", "1", "--beta", "0"], "rpm is nan"),
    (PREDICT, "--rpm is missing"),
    ([*PREDICT, *POINT, "--rho", "1", "--altitude", "100"], "a standard atmosphere are given"),
    ([*PREDICT, *POINT, "--root-cutout", "0.2"], "root cut-out"),
    ([*PREDICT, *POINT, "--height", "0.01"], "less than 0.3 radii"),
    ([*PREDICT, *POINT, "--accuracy", "perfect"], "perfect"),
    ([*PREDICT, *POINT, "--std-by-source", "--no-bands"], "--std-by-source is given with --no-b"),
    (["predict", "vehicle.toml", "--rpm", "9"], "this is a vehicle file, not a geometry file; use"),
    (
        [*PREDICT, *POINT, "--airfoil", "vehicle.toml"],
        "this is a vehicle file, not a parameter set",
    ),
    ([*TUNNEL, "outlier.csv", *TO], "at 4500 rpm and 5 m/s, C_T is "),
    ([*TUNNEL, "huge.csv", *TO], "at 4500 rpm and 5 m/s, C_T is "),
    ([*TUNNEL, "unnamed.csv", *TO], "'U (m/s)' may be the airspeed or the advance"),
    (["fit", "static", "--prop", "apc-8x6e", *TO, "unnamed.csv"], "may be the airspeed"),
    (["predict", "apc-8x6e", "--points", "advance.csv"], "'J' may be the airspeed"),
    (["trim", "set.toml"], "this is a parameter set, not a vehicle file; use it with --airfoil"),
    ([*GOOD, "--bare"], "No such option: --bare"),
    ([*PREDICT, *POINT, "-o", "nowhere/out.json"], "nowhere"),
    ([*PREDICT, *POINT, "--points", "nan.csv"], "--rpm"),
    ([*PREDICT, "--points", "no_rpm.csv"], "column rpm is missing"),
    ([*PREDICT, "--points", "text.csv"], "line 2, column beta_deg: 'edgewise'"),
    ([*SWEEP, *GRID, "-o", "taken.nc"], "--force"),
    ([*SWEEP, *GRID], "output"),
    ([*SWEEP, "--rpm", "1:2", "--speed", "1", "--beta", "0", "-o", "out.nc"], "1:2"),
    ([*MAP, "out.png", "--measured", "no_loads.csv"], "thrust_N"),
    ([*MAP, "out.png", "--measured", "other_rpm.csv"], "9000"),
    ([*MAP, "out.png", "--beta", "0:90:8"], "at most 7"),
    (["plot"], "command"),
    (["fly"], "fly"),
    (["table", *ROTOR, "--height", "1"], "--height"),
    # Fits and checks.
    ([*GOOD, "--free", "c_l1,mount_area"], "add drag to the loads"),
    ([*GOOD, "--fix", "c_d0"], "--fix 'c_d0' has no '='; write --fix c_l1=6.0"),
    ([*TUNNEL, "good.csv", *TO, "--prior-from", "apcfs"], "'apcfs' is not a family of identified"),
    ([*GOOD, "--weight", "thrust"], "--weight thrust: '' is not a number; give a number"),
    ([*TUNNEL, "good.csv", "-o", "out.csv"], ".toml"),
    ([*TUNNEL, "nowhere.csv", *TO, *NO_PRIOR], "neither a file nor a measurement of the catalogue"),
    ([*TUNNEL, "sample.txt", *TO, *NO_PRIOR], "the rotational speed is not in the file's name"),
    (["check", "damaged.toml", "good.csv"], "the table [fit] cannot be read"),
    (["check", "set.toml", "level.csv", "--vehicle", "vehicle.toml"], "no accelerations"),
    (["fit", "flight", "level.csv", *TO], "vehicle"),
    ([*FLIGHT, "level.csv", "--method", "balance"], "no accelerations; fit it with --method level"),
    ([*FLIGHT, "good.csv"], "keys without a column: 'time', 'velocity', 'rates', 'rotor_speed'"),
    ([*STATIC, "flying.csv"], "fit such data with propmap fit tunnel"),
    ([*GOOD, "--airfoil", "plate.csv"], SECTION),
    (["check", "set.toml", "good.csv"], "the file has no table [fit]; add --prop NAME"),
    # Tables, exports and reports.
    ([*TABLE, "--tolerance", "much"], "not a fraction"),
    ([*TABLE, "-o", "map.csv"], "extension"),
    ([*EXPORT, "map.npz", "--to", "cpp"], "cpp is not made from a table, but from a propeller"),
    ([*EXPORT, "apc-8x6e", "--to", "mujoco"], "--to mujoco needs a vehicle file"),
    ([*EXPORT, "apc-8x6e", "--to", "c", "--table", "map.npz"], "--table does not apply"),
    ([*EXPORT, "map.npz", "--to", "c", "--airfoil", "paper-apc"], "--airfoil does not apply"),
    ([*TABLE, "-o", "bad.npz"], "--force"),
    (["show", "bad.npz", "--format", "csv"], "use --format json"),
    ([*EXPORT, "map.npz", "--to", "px4"], "--to px4 needs a vehicle file"),
    ([*EXPORT, "quad.toml", "--to", "px4", "--prop", "apc-8x6e"], "leave it out"),
    ([*EXPORT, "quad.toml", "--to", "px4", "--speed", "3,x"], "--speed '3,x'"),
    ([*EXPORT, "set.toml", "--to", "c"], "--prop"),
    ([*REPORT, "level.csv"], "give a fit (.toml) or a table (.npz)"),
    ([*REPORT, "old.toml"], "cannot be read: Object missing required field covered"),
    ([*REPORT, "map.npz", "--data", "tunnel.csv"], "--data and --vehicle apply to fits"),
    ([*REPORT, "whole.toml", "--vehicle", "vehicle.toml"], "add them with --data"),
    ([*REPORT, "flown.toml", "--data", "level.csv"], "add --vehicle FILE"),
    ([*REPORT, "map.npz", "-o", "folder"], "'mine.txt', which this command does not write"),
    # Aircraft and simulated flights.
    ([*TRIM, "--table", "x.npz"], "leave these out"),
    ([*TRIM, "--speed", "0,5", "--wind", "nan"], "headwind"),
    ([*TRIM, "--charge", "80"], "1 for a full battery"),
    ([*TRIM, "--mission", "legs.csv", "--climb", "2"], "legs define"),
    ([*CHOOSE, "--task", "hover", "--by", "range"], "cannot be ranked by range"),
    (["choose", "vehicle.toml", "--task", "hover", "--by", "time"], "no [battery]"),
    ([*CHOOSE, "--speed", "9", "--airfoil", "paper-apc"], "without --propeller"),
    ([*SIMULATE, "--speeds", "0.5:14.5"], "A:B:N"),
    ([*SIMULATE, "--noise", "-0.01"], "--noise is -0.01"),
    ([*SIMULATE, "--speeds", "10,70"], "70 m/s cannot be flown"),
    ([*SIMULATE, "-o", "flight.txt"], "extension"),
    (["predict", "apc-8x6e", "--airfoil", "skew.toml", *POINT], "not symmetric"),
    ([*PREDICT, "--rpm", "4000", "--speed", "1", "--beta", "400"], "more than a turn"),
    ([*SWEEP, "--rpm", "1:2:1", "--speed", "1", "--beta", "0", "-o", "out.nc"], "N is 1"),
    ([*SWEEP, "--rpm", "2:1:3", "--speed", "1", "--beta", "0", "-o", "out.nc"], "increase"),
    ([*SWEEP, "--rpm", "1:9:9999", "--speed", "1:9:9999", "--beta", "0", "-o", "o.nc"], "points"),
    ([*GOOD, "--loads", "thrust,thrust"], "thrust is named twice"),
    ([*GOOD, "--weight", "thrust=0"], "the weight of thrust is 0; give a number above 0"),
    ([*GOOD, "--weight", "thurst=2"], "'thurst' has a weight but is not fitted; fit thrust"),
    ([*TABLE, "--tolerance", "0.001%"], "must be between 0.20% and 10%"),
    ([*TRIM, "--climb", "fast"], "cannot be read"),
    ([*TRIM, "--max-rpm", "0"], "above 0"),
    ([*CHOOSE, "--speed", "9", "--diameter", "big"], "in inches"),
    ([*SIMULATE, "--noise", "1"], "times the weight"),
    ([*SIMULATE, "--velocity-noise", "-1"], "--velocity-noise"),
    ([*SIMULATE, "--radius", "0"], "radius of the circle is 0 m"),
    ([*SIMULATE, "--dwell", "0.1"], "each speed lasts 0.1 s"),
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
