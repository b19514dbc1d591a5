"""Whatever is wrong with the input: exit code 2, one line that says so, and no file."""

from __future__ import annotations

from pathlib import Path

import pytest

from .conftest import POINT, ROTOR, Run

HEADER = "rpm,speed_mps,beta_deg\n"
AIRFOIL = "schema = 1\nc_l1 = 5.3\nc_l2 = 1.7\nc_d = 1.8\nalpha_0 = 0.36\n"
FILES: dict[str, bytes] = {
    "no_rpm.csv": b"speed_mps,beta_deg\n1,2\n",
    "twice.csv": b"rpm,rpm,speed_mps,beta_deg\n1,1,1,2\n",
    "empty.csv": b"",
    "blank.csv": b"\n\n \n",
    "header.csv": HEADER.encode(),
    "text.csv": (HEADER + "4000,5,edgewise\n").encode(),
    "nan.csv": (HEADER + "4000,5,90\n4000,nan,90\n").encode(),
    "infinite.csv": (HEADER + "inf,5,90\n").encode(),
    "negative.csv": (HEADER + "4000,-5,90\n").encode(),
    "short.csv": (HEADER + "4000,5\n").encode(),
    "quote.csv": (HEADER + '"4000,5,90\n').encode(),
    "binary.csv": bytes(range(256)),
    "latin.csv": HEADER.encode() + b"4000,5,90\xb0\n",
    "no_loads.csv": (HEADER + "4000,5,90\n").encode(),
    "other_rpm.csv": b"rpm,speed_mps,beta_deg,thrust_N\n9000,5,90,1\n",
    "taken.nc": b"precious",
    "unknown.toml": (AIRFOIL + "c_l3 = 1.0\n").encode(),
    "missing.toml": b"schema = 1\nc_l1 = 5.3\nc_l2 = 1.7\nalpha_0 = 0.36\n",
    "degrees.toml": AIRFOIL.replace("0.36", "20.6").encode(),
    "not.toml": b"c_l1: 5.3\n",
    "not_a_blade.txt": b"hello\n",
}
PREDICT = ["predict", *ROTOR]
GRID = ["--rpm", "4000:5000:2", "--speed", "10", "--beta", "80"]
SWEEP = ["sweep", *ROTOR]
MAP = ["plot", "map", *ROTOR]

CASES: list[tuple[list[str], str]] = [
    (["predict", "apc-8x6f", "--airfoil", "paper-apc", *POINT], "apc-8x6e"),
    (["predict", "nowhere.txt", "--airfoil", "paper-apc", *POINT], "no such file"),
    (["predict", "not_a_blade.txt", "--airfoil", "paper-apc", *POINT], "not_a_blade.txt"),
    (["predict", "apc-8x6e", "--airfoil", "paper-apx", *POINT], "paper-apc"),
    (["predict", "apc-8x6e", "--airfoil", "nowhere.toml", *POINT], "no such file"),
    (["predict", "apc-8x6e", "--airfoil", "unknown.toml", *POINT], "c_l3"),
    (["predict", "apc-8x6e", "--airfoil", "missing.toml", *POINT], "c_d is missing"),
    (["predict", "apc-8x6e", "--airfoil", "degrees.toml", *POINT], "radians"),
    (["predict", "apc-8x6e", "--airfoil", "not.toml", *POINT], "not valid TOML"),
    (["predict", "--airfoil", "paper-apc", *POINT], "PROP"),
    ([*PREDICT, "--rpm", "fast", "--speed", "1", "--beta", "0"], "'--rpm'"),
    ([*PREDICT, "--rpm", "4000", "--speed", "1", "--beta", "north"], "'--beta'"),
    ([*PREDICT, "--rpm", "-4000", "--speed", "1", "--beta", "0"], "rpm is negative"),
    ([*PREDICT, "--rpm", "4000", "--speed", "-1", "--beta", "0"], "speed is negative"),
    ([*PREDICT, "--rpm", "nan", "--speed", "1", "--beta", "0"], "rpm is nan"),
    ([*PREDICT, "--rpm", "4000", "--speed", "1", "--beta", "inf"], "beta is inf"),
    ([*PREDICT, "--rpm", "4000", "--speed", "1", "--beta", "400"], "more than a turn"),
    (PREDICT, "--rpm is missing"),
    ([*PREDICT, *POINT, "--rho", "-1"], "density"),
    ([*PREDICT, *POINT, "--mu", "0"], "viscosity"),
    ([*PREDICT, *POINT, "--rho", "1", "--altitude", "100"], "twice"),
    ([*PREDICT, *POINT, "--altitude", "1e6"], "altitude"),
    ([*PREDICT, *POINT, "--root-cutout", "0.2"], "root cut-out"),
    ([*PREDICT, *POINT, "--blades", "0"], "blades"),
    ([*PREDICT, *POINT, "--blades", "two"], "'--blades'"),
    ([*PREDICT, *POINT, "--radius", "0.2"], "radius"),
    ([*PREDICT, *POINT, "--accuracy", "perfect"], "perfect"),
    ([*PREDICT, *POINT, "--format", "xml"], "xml"),
    ([*PREDICT, *POINT, "--colour", "red"], "--colour"),
    ([*PREDICT, *POINT, "-o", "nowhere/out.json"], "nowhere"),
    ([*PREDICT, *POINT, "-o", "folder"], "folder"),
    ([*PREDICT, *POINT, "--points", "nan.csv"], "--rpm"),
    ([*PREDICT, "--points", "nowhere.csv"], "no such file"),
    ([*PREDICT, "--points", "folder"], "folder"),
    ([*PREDICT, "--points", "no_rpm.csv"], "column rpm is missing"),
    ([*PREDICT, "--points", "twice.csv"], "twice"),
    ([*PREDICT, "--points", "empty.csv"], "empty"),
    ([*PREDICT, "--points", "blank.csv"], "empty"),
    ([*PREDICT, "--points", "header.csv"], "no row"),
    ([*PREDICT, "--points", "text.csv"], "line 2, column beta_deg: 'edgewise'"),
    ([*PREDICT, "--points", "nan.csv"], "line 3, column speed_mps"),
    ([*PREDICT, "--points", "infinite.csv"], "line 2, column rpm"),
    ([*PREDICT, "--points", "negative.csv"], "line 2, column speed_mps"),
    ([*PREDICT, "--points", "short.csv"], "line 2, column beta_deg"),
    ([*PREDICT, "--points", "quote.csv"], "quote.csv"),
    ([*PREDICT, "--points", "binary.csv"], "binary data"),
    ([*PREDICT, "--points", "latin.csv"], "is not a number"),
    ([*SWEEP, *GRID, "-o", "out.txt"], ".nc"),
    ([*SWEEP, *GRID, "-o", "nowhere/out.nc"], "nowhere"),
    ([*SWEEP, *GRID, "-o", "taken.nc"], "--force"),
    ([*SWEEP, *GRID], "output"),
    ([*SWEEP, "--rpm", "1:2", "--speed", "1", "--beta", "0", "-o", "out.nc"], "1:2"),
    ([*SWEEP, "--rpm", "1:2:x", "--speed", "1", "--beta", "0", "-o", "out.nc"], "1:2:x"),
    ([*SWEEP, "--rpm", "1:2:1", "--speed", "1", "--beta", "0", "-o", "out.nc"], "N is 1"),
    ([*SWEEP, "--rpm", "2:1:3", "--speed", "1", "--beta", "0", "-o", "out.nc"], "increase"),
    ([*SWEEP, "--rpm", "1", "--speed", "1,1", "--beta", "0", "-o", "out.nc"], "increase"),
    ([*SWEEP, "--rpm", "1", "--speed", "-1:1:3", "--beta", "0", "-o", "out.nc"], "negative"),
    ([*SWEEP, "--rpm", "1:9:9999", "--speed", "1:9:9999", "--beta", "0", "-o", "o.nc"], "points"),
    ([*MAP, "--rpm", "4000", "-o", "out.bmp"], ".png"),
    ([*MAP, "--rpm", "4000", "-o", "out.png", "--measured", "no_loads.csv"], "thrust_N"),
    ([*MAP, "--rpm", "4000", "-o", "out.png", "--measured", "other_rpm.csv"], "9000"),
    ([*MAP, "--rpm", "4000", "-o", "out.png", "--beta", "0:90:8"], "at most 7"),
    (["plot", "planform", "apc-8x6f", "-o", "out.png"], "apc-8x6e"),
    (["plot", "disk", *ROTOR, *POINT[:4], "--beta", "nan", "-o", "out.png"], "beta"),
    (["plot"], "command"),
    (["fit"], "Missing command"),
    (["props", "show", "apc-8x6f"], "apc-8x6e"),
    (["airfoils", "show", "paper"], "paper-apc"),
    (["fly"], "fly"),
]


@pytest.fixture
def workplace(tmp_path: Path) -> Path:
    for name, content in FILES.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "folder").mkdir()
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "says"), CASES, ids=[f"{i}-{case[1]}" for i, case in enumerate(CASES)]
)
def test_one_line_and_no_file(run: Run, workplace: Path, arguments: list[str], says: str) -> None:
    before = {path: path.is_dir() or path.read_bytes() for path in workplace.rglob("*")}
    done = run(*arguments)
    assert done.code == 2
    assert done.out == ""
    assert done.err.startswith("propmap: error: ")
    assert done.err.count("\n") == 1
    assert done.err.endswith("\n")
    assert says in done.err
    after = {path: path.is_dir() or path.read_bytes() for path in workplace.rglob("*")}
    assert after == before
