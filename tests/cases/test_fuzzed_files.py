"""Three hundred damaged files: every reader says one line or reads what is there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import propmap
from propmap.errors import InputError
from propmap.fit.tunnel import read_tunnel
from propmap.io.csv import LOAD_COLUMNS, read_points
from propmap.io.geometry import read_geometry_file
from propmap.io.sections import read_section_table
from tests.io import samples as geometry

from . import samples

ROWS = [(3000.0, 0.8, 0.014), (4000.0, 1.4, 0.024), (5000.0, 2.2, 0.038)]
FILES = {
    "stand.csv": samples.stand(ROWS),
    "points.csv": "rpm;speed_mps;beta_deg;thrust_N\n4000;1,5;80;1,25\n",
    "uiuc_1_3008.txt": "J CT CP eta\n0.1 0.1 0.05 0.2\n0.2 0.09 0.05 0.3\n",
    "static.txt": "RPM CT CP\n3000 0.1 0.05\n4000 0.1 0.05\n",
    "PER3.dat": samples.PERFILE,
    "a_geom.txt": samples.UIUC,
    "a.csv": samples.CSV,
    "a.pe0": geometry.PE0,
    "a.toml": geometry.TOML,
    "a.prop": samples.QPROP,
    "a.xrotor": samples.XROTOR,
    "a.bem": samples.BEM,
    **{f"polar-{k}.dat": text for k, text in enumerate(samples.POLARS.values())},
}
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


@settings(
    max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    name=st.sampled_from(sorted(FILES)),
    edits=st.lists(
        st.tuples(
            st.floats(0.0, 1.0),
            st.integers(0, 40),
            st.text(max_size=8) | st.sampled_from(JUNK),
        ),
        min_size=1,
        max_size=3,
    ),
)
def test_one_line_or_a_right_reading(
    tmp_path: Path, name: str, edits: list[tuple[float, int, str]]
) -> None:
    text = FILES[name]
    for where, cut, junk in edits:
        start = int(where * len(text))
        text = text[:start] + junk + text[start + cut :]
    path = tmp_path / name
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    blade, air = propmap.propeller("apc-8x6e"), propmap.Air()
    for read in (
        lambda: read_geometry_file(path).station,
        lambda: read_geometry_file(path, blades=2, radius=0.1).chord,
        lambda: read_section_table(path).lift,
        lambda: read_tunnel([str(path)], blade, air).omega,
        lambda: read_points(path, LOAD_COLUMNS)[0].rpm,
    ):
        try:
            assert np.isfinite(read()).all()
        except InputError as error:
            assert str(error).isprintable()
    path.unlink()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", sorted(FILES))
def test_what_is_damaged_was_whole(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text(FILES[name])
    readings = 0
    for read in (
        lambda: read_geometry_file(path, blades=None, radius=0.1 if "geom" in name else None),
        lambda: read_section_table(path),
        lambda: read_tunnel([str(path)], propmap.propeller("apc-8x6e"), propmap.Air()),
    ):
        try:
            read()
            readings += 1
        except InputError as error:
            assert name in str(error)
    assert readings == 1
