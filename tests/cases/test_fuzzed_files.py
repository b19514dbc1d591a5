"""Damaged files of every kind: every reader says one line or reads what is there."""

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
from propmap.model.airfoil import parameter_set, read_airfoil
from propmap.vehicle.files import read_vehicle
from tests.cli.fit_inputs import LEVEL, VEHICLE
from tests.fit.fit_records import ENVELOPE, fit_text
from tests.io import samples as geometry

from . import samples

BLADE = propmap.propeller("apc-8x6e")
ROWS = [(3000.0, 0.8, 0.014), (4000.0, 1.4, 0.024), (5000.0, 2.2, 0.038)]


def tunnel(path: Path) -> np.ndarray:
    return read_tunnel([str(path)], BLADE, propmap.Air()).omega


def points(path: Path) -> np.ndarray:
    return read_points(path, LOAD_COLUMNS)[0].rpm


def blade(path: Path) -> np.ndarray:
    return read_geometry_file(path, radius=0.1 if "geom" in path.name else None).chord


def polar(path: Path) -> np.ndarray:
    return read_section_table(path).lift


def level(path: Path) -> np.ndarray:
    other = path.with_name("vehicle.toml")
    other.write_text(VEHICLE)
    file = read_vehicle(other)
    other.unlink()
    return read_flights([path], file, "level", seconds=2.0, samples=100).log.rotor_speed


TEXTS: dict[str, tuple[Callable[[Path], Any], str]] = {
    "stand.csv": (tunnel, samples.stand(ROWS)),
    "points.csv": (tunnel, "rpm;speed_mps;beta_deg;thrust_N\n4000;1,5;80;1,25\n"),
    "uiuc_1_3008.txt": (tunnel, "J CT CP eta\n0.1 0.1 0.05 0.2\n0.2 0.09 0.05 0.3\n"),
    "static.txt": (tunnel, "RPM CT CP\n3000 0.1 0.05\n4000 0.1 0.05\n"),
    "PER3.dat": (tunnel, samples.PERFILE),
    "a_geom.txt": (blade, samples.UIUC),
    "a.csv": (blade, samples.CSV),
    "a.pe0": (blade, geometry.PE0),
    "a.toml": (blade, geometry.TOML),
    "a.prop": (blade, samples.QPROP),
    "a.xrotor": (blade, samples.XROTOR),
    "a.bem": (blade, samples.BEM),
    **{f"{k}.dat": (polar, text) for k, text in enumerate(samples.POLARS.values())},
    "law.toml": (lambda path: read_airfoil(path).c_l1, parameter_set("paper-apc").to_toml()),
    "quad.toml": (lambda path: read_vehicle(path).vehicle.mass, VEHICLE),
    "level.csv": (level, LEVEL),
    "fit.toml": (
        lambda path: read_fit(path).airfoil.c_l1 if is_fit(path) else 0.0,
        fit_text(envelope=ENVELOPE),
    ),
}
JUNK = [*'-,;\n"\f#[(\0=!', "1e9", "1e999", "nan", "r/R"]
EDITS = st.lists(
    st.tuples(st.floats(0.0, 1.0), st.integers(0, 40), st.text(max_size=8) | st.sampled_from(JUNK)),
    min_size=1,
    max_size=3,
)
Edits = list[tuple[float, int, str]]
QUIET: Any = {"suppress_health_check": [HealthCheck.function_scoped_fixture]}


def damaged(content: bytes, edits: Edits) -> bytes:
    for where, cut, junk in edits:
        start = int(where * len(content))
        inserted = junk.encode("utf-8", "surrogatepass")
        content = content[:start] + inserted + content[start + cut :]
    return content


@settings(max_examples=120, **QUIET)
@given(name=st.sampled_from(list(TEXTS)), edits=EDITS)
def test_one_line_or_a_right_reading(tmp_path: Path, name: str, edits: Edits) -> None:
    own, text = TEXTS[name]
    path = tmp_path / name
    path.write_bytes(damaged(text.encode(), edits))
    for read in {own, tunnel, points, blade, polar}:
        try:
            found = read(path)
        except InputError as error:
            assert str(error).isprintable()
        else:
            assert np.isfinite(found).all()
    path.unlink()
    assert list(tmp_path.iterdir()) == []


@settings(max_examples=30, **QUIET)
@given(name=st.sampled_from(list(TEXTS)), edits=EDITS)
def test_commands_write_all_or_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, edits: Edits
) -> None:
    path, output = tmp_path / name, tmp_path / "out.csv"
    path.write_bytes(damaged(TEXTS[name][1].encode(), edits))
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


@pytest.mark.parametrize("name", TEXTS)
def test_what_is_damaged_was_whole(tmp_path: Path, name: str) -> None:
    own, text = TEXTS[name]
    (tmp_path / name).write_text(text)
    assert np.size(own(tmp_path / name)) > 0
    for other in {tunnel, blade, polar} - {own}:
        with pytest.raises(InputError, match=name):
            other(tmp_path / name)
