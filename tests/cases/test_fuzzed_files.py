"""Three hundred damaged files: every reader says one line or reads what is there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import propmap
from propmap.cli import main
from propmap.cli.fit_flight import read_flights
from propmap.errors import InputError
from propmap.fit.files import is_fit, read_fit
from propmap.fit.tunnel import read_tunnel
from propmap.io.csv import LOAD_COLUMNS, read_points
from propmap.io.geometry import read_geometry_file
from propmap.io.sections import read_section_table
from propmap.model.airfoil import read_airfoil
from propmap.table import LoadTable
from propmap.vehicle.files import read_vehicle
from tests.cli.conftest import brief_commands
from tests.cli.fit_inputs import LEVEL, STAND, VEHICLE
from tests.io import samples as geometry
from tests.table.conftest import invented_content

from . import samples
from .test_files_and_columns import FREE, PROP

BLADE = propmap.propeller("apc-8x6e")
ROWS = [(3000.0, 0.8, 0.014), (4000.0, 1.4, 0.024), (5000.0, 2.2, 0.038)]
LAW = "schema = 1\nc_l1 = 5.3\nc_l2 = 1.7\nc_d = 1.8\nalpha_0 = 0.36\nzero_lift_angle = -0.07\n"


def tunnel(path: Path) -> np.ndarray:
    return read_tunnel([str(path)], BLADE, propmap.Air()).omega


def points(path: Path) -> np.ndarray:
    return read_points(path, LOAD_COLUMNS)[0].rpm


def blade(path: Path) -> np.ndarray:
    return read_geometry_file(path, radius=0.1 if "geom" in path.name else None).chord


def polar(path: Path) -> np.ndarray:
    return read_section_table(path).lift


def law(path: Path) -> float:
    return read_airfoil(path).c_l1


def fit(path: Path) -> float:
    return read_fit(path).airfoil.c_l1 if is_fit(path) else 0.0


def vehicle(path: Path) -> float:
    return read_vehicle(path).vehicle.mass


def level(path: Path) -> np.ndarray:
    other = path.with_name("vehicle.toml")
    other.write_text(VEHICLE)
    try:
        file = read_vehicle(other)
        return read_flights([path], file, "level", seconds=2.0, samples=100).log.rotor_speed
    finally:
        other.unlink()


def table(path: Path) -> np.ndarray:
    return LoadTable.load(path).content.coefficients


READERS: dict[str, tuple[Callable[[Path], Any], dict[str, str]]] = {
    "tunnel": (
        tunnel,
        {
            "stand.csv": samples.stand(ROWS),
            "points.csv": "rpm;speed_mps;beta_deg;thrust_N\n4000;1,5;80;1,25\n",
            "uiuc_1_3008.txt": "J CT CP eta\n0.1 0.1 0.05 0.2\n0.2 0.09 0.05 0.3\n",
            "static.txt": "RPM CT CP\n3000 0.1 0.05\n4000 0.1 0.05\n",
            "PER3.dat": samples.PERFILE,
        },
    ),
    "blade": (
        blade,
        {
            "a_geom.txt": samples.UIUC,
            "a.csv": samples.CSV,
            "a.pe0": geometry.PE0,
            "a.toml": geometry.TOML,
            "a.prop": samples.QPROP,
            "a.xrotor": samples.XROTOR,
            "a.bem": samples.BEM,
        },
    ),
    "polar": (polar, {f"{k}.dat": text for k, text in enumerate(samples.POLARS.values())}),
    "law": (law, {"law.toml": LAW}),
    "vehicle": (vehicle, {"quad.toml": VEHICLE}),
    "level": (level, {"level.csv": LEVEL}),
}
FILES = [(kind, name) for kind, (_, files) in READERS.items() for name in files]
JUNK = [
    "-",
    "1e9",
    "1e999",
    ",",
    ";",
    "\n",
    "nan",
    '"',
    "\x0c",
    "#",
    "[",
    "(",
    "\0",
    "r/R",
    "=",
    "!",
]
EDITS = st.lists(
    st.tuples(st.floats(0.0, 1.0), st.integers(0, 40), st.text(max_size=8) | st.sampled_from(JUNK)),
    min_size=1,
    max_size=3,
)
Edits = list[tuple[float, int, str]]
QUIET = {"deadline": None, "suppress_health_check": [HealthCheck.function_scoped_fixture]}


def damaged(content: bytes, edits: Edits) -> bytes:
    for where, cut, junk in edits:
        start = int(where * len(content))
        inserted = junk.encode("utf-8", "surrogatepass")
        content = content[:start] + inserted + content[start + cut :]
    return content


def read_or_refused(read: Callable[[Path], Any], path: Path) -> None:
    try:
        found = read(path)
    except InputError as error:
        assert str(error).isprintable()
    else:
        assert np.isfinite(found).all()


@settings(max_examples=200, **QUIET)  # type: ignore[arg-type]
@given(file=st.sampled_from(FILES), edits=EDITS)
def test_one_line_or_a_right_reading(tmp_path: Path, file: tuple[str, str], edits: Edits) -> None:
    kind, name = file
    own, files = READERS[kind]
    path = tmp_path / name
    path.write_bytes(damaged(files[name].encode(), edits))
    for read in {own, tunnel, points, blade, polar}:
        read_or_refused(read, path)
    path.unlink()
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """A table and a fit, which take longer to make."""
    folder = tmp_path_factory.mktemp("whole")
    LoadTable(invented_content()).save(folder / "map.npz")
    (folder / "stand.csv").write_text(STAND)
    asked = ["fit", "static", str(folder / "stand.csv"), *PROP, *FREE]
    with brief_commands():
        assert main([*asked, "-o", str(folder / "fit.toml")]) == 0
    return {name: (folder / name).read_bytes() for name in ("map.npz", "fit.toml")}


@settings(max_examples=50, **QUIET)  # type: ignore[arg-type]
@given(name=st.sampled_from(["map.npz", "fit.toml"]), edits=EDITS)
def test_tables_and_fits(tmp_path: Path, whole: dict[str, bytes], name: str, edits: Edits) -> None:
    path = tmp_path / name
    path.write_bytes(damaged(whole[name], edits))
    read_or_refused(table if name == "map.npz" else fit, path)
    path.unlink()


@settings(max_examples=50, **QUIET)  # type: ignore[arg-type]
@given(file=st.sampled_from(FILES), edits=EDITS)
def test_commands_write_all_or_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], file: tuple[str, str], edits: Edits
) -> None:
    kind, name = file
    path, output = tmp_path / name, tmp_path / "out.csv"
    path.write_bytes(damaged(READERS[kind][1][name].encode(), edits))
    for asked in (
        ["predict", str(path), "--rpm", "3000", "--radius", "0.1"],
        ["predict", "apc-8x6e", "--airfoil", str(path), "--rpm", "3000"],
        ["predict", "apc-8x6e", "--points", str(path)],
    ):
        code = main([*asked, "--format", "csv", "-o", str(output)])
        told = capsys.readouterr().err
        assert code in (0, 2) and told.count("propmap: error: ") == (code == 2)
        assert output.exists() == (code == 0)
        output.unlink(missing_ok=True)
        assert [one.name for one in tmp_path.iterdir()] == [name]
    path.unlink()


@pytest.mark.parametrize("file", FILES)
def test_what_is_damaged_was_whole(tmp_path: Path, file: tuple[str, str]) -> None:
    kind, name = file
    own, files = READERS[kind]
    path = tmp_path / name
    path.write_text(files[name])
    assert np.size(own(path)) > 0
    for other in {tunnel, blade, polar} - {own}:
        with pytest.raises(InputError, match=name):
            other(path)
