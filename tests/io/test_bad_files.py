"""Whatever is wrong with a file, the reader says so in one line with a remedy."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from propmap.catalogue.lookup import propeller
from propmap.errors import InputError
from propmap.io.geometry import (
    read_apc_pe0,
    read_geometry_file,
    read_propeller_csv,
    read_propeller_toml,
    read_uiuc_geometry,
)
from propmap.model.propeller import Propeller

from . import samples

Writer = Callable[[str | bytes], Path]
READERS = [
    read_apc_pe0,
    read_uiuc_geometry,
    read_propeller_csv,
    read_propeller_toml,
    read_geometry_file,
]


def message_of(read: Callable[[], Any]) -> str:
    with pytest.raises(InputError) as caught:
        read()
    message = str(caught.value)
    assert message.isprintable(), "one line, no control characters"
    return message


def edited(text: str, *pairs: str) -> str:
    """``text`` with each old part replaced by the new one that follows it."""
    for old, new in zip(pairs[::2], pairs[1::2], strict=True):
        assert old in text
        text = text.replace(old, new)
    return text


CSV, UIUC, PE0, TOML = samples.CSV, samples.UIUC, samples.PE0, samples.TOML
HALF_DEGREES = "# blades: 2\nradius_m,chord_m,twist_deg\n" + "".join(
    f"{r},0.01,{t}\n" for r, t in [(0.02, 0.6), (0.04, 0.5), (0.06, 0.4), (0.1, 0.2)]
)

CSV_CASES = {
    "missing column": (edited(CSV, ",twist_deg", ",chord_mm"), "both contain the chord"),
    "unknown unit": (edited(CSV, "chord_m", "chord_ells"), "'chord_ells' has no known", "chord_m"),
    "two separators": (edited(CSV, "m,chord_m,", "m;chord_m,"), "separated by commas"),
    "unsorted": (edited(CSV, "0.06,", "0.03,"), "line 6", "unsorted", "sort the rows"),
    "repeated station": (edited(CSV, "0.06,", "0.04,"), "line 6", "repeated", "one row per"),
    "first station at 0": (edited(CSV, "0.02,", "0,"), "start with the hub radius"),
    "negative chord": (edited(CSV, "0.022", "-0.022"), "line 6", "negative chord"),
    "chord all zero": (
        edited(CSV, "0.015", "0", "0.021", "0", "0.022", "0", "0.017", "0", "0.004", "0"),
        "give the chord",
    ),
    "NaN": (edited(CSV, "0.022", "nan"), "line 6: chord_m", "finite", "correct it"),
    "too few stations": (CSV[: CSV.index("0.08")], "found 3 stations", "add stations"),
    "comments only": ("# blades: 2\n", "name the columns"),
    "degrees that look like radians": (HALF_DEGREES, "looks like radians", "named twist_rad"),
    "no blades": (edited(CSV, "# blades: 3\n", ""), "pass --blades 2"),
    "many blades": (edited(CSV, "blades: 3", "blades: 300"), "from 1 to 12"),
    "no radius": (edited(CSV, "radius_m", "r_over_R"), "pass --radius"),
    "radius disagrees": (edited(CSV, "# blades", "# radius_m: 0.2\n# blades"), "correct it"),
    "r_over_R above 1": (
        edited(
            CSV, "radius_m", "r_over_R", "# blades", "# radius_m: 0.1\n# blades", "0.10,", "10,"
        ),
        "line 9: r/R is 10",
        "divide by the tip radius",
    ),
    "product too large": (
        edited(CSV, "0.10,", "1e308,", "0.022", "1e9", "chord_m", "c_over_R"),
        "line 6: chord is inf",
    ),
}

UIUC_CASES = {
    "another header": (edited(UIUC, "r/R    c/R     beta", "J CT CP eta"), "*_geom.txt"),
    "ragged": (edited(UIUC, "0.220   21.00", "0.220"), "line 4", "complete the row"),
    "beyond the tip": (edited(UIUC, "1.00 ", "1.05 "), "line 6", "divide by"),
    "no tip": (edited(UIUC, "1.00   0.040   10.00\n", ""), "add the tip"),
}

PE0_CASES = {
    "no table": (edited(PE0, "STATION", "WHERE"), "as APC publishes it"),
    "other unit": (edited(PE0, "(IN)       (IN)   ", "(MM)       (MM)   "), "convert"),
    "no rows": (samples.PE0_HEADER + samples.PE0_TRAILER, "found a header and no rows"),
    "ragged": (edited(PE0, "23.0000     -0.0100", "23.0000-0.0100"), "found 6 values"),
    "cut off": (edited(PE0, "RADIUS:  2.50", "RADIUS:  3.50"), "RADIUS", "correct it"),
    "hub beyond the tip": (edited(PE0, "HUBTRA:  0.50", "HUBTRA:  2.45"), "root cut-out"),
}

TOML_CASES = {
    "not TOML": (edited(TOML, "blades = 2", "blades = "), "not TOML", "syntax"),
    "newer schema": (edited(TOML, "schema = 1", "schema = 2"), "update propmap"),
    "unknown field": (edited(TOML, "family", "famly"), "'famly'", "did you mean family?"),
    "no array": (edited(TOML, "chord_m = [", "chord_m = 1 # ["), "write chord_m = [...]"),
    "blades as truth": (edited(TOML, "blades = 2", "blades = true"), "pass --blades"),
    "name not text": (edited(TOML, '"hand-made"', "3"), "write name = "),
    "deep nesting": ("schema = " + "[" * 100_000, "not TOML"),
}


def read_uiuc(path: Path) -> Propeller:
    return read_uiuc_geometry(path, radius=0.1)


FORMATS: dict[Callable[[Path], Propeller], dict[str, tuple[str, ...]]] = {
    read_propeller_csv: CSV_CASES,
    read_uiuc: UIUC_CASES,
    read_apc_pe0: PE0_CASES,
    read_propeller_toml: TOML_CASES,
}


@pytest.mark.parametrize(
    ("read", "case"), [(read, case) for read, cases in FORMATS.items() for case in cases]
)
def test_bad_files(written: Writer, read: Callable[[Path], Propeller], case: str) -> None:
    content, *words = FORMATS[read][case]
    path = written(content)
    message = message_of(lambda: read(path))
    assert str(path) in message
    for word in words:
        assert word in message


NO_TEXT: dict[str, tuple[bytes, str]] = {
    "empty": (b"", "give a geometry file"),
    "binary": (b"\x7fELF\x00\x01\x02\x00", "give a text file"),
    "latin-1": ("# name: h\xe9lice\n".encode("latin-1") + CSV.encode(), "save the file as UTF-8"),
    "utf-16": (CSV.encode("utf-16"), "save it as UTF-8"),
    "huge": (b"0.1,0.2\n" * 700_000, "not a geometry file"),
}


@pytest.mark.parametrize("case", NO_TEXT)
def test_no_text(written: Writer, case: str) -> None:
    content, remedy = NO_TEXT[case]
    path = written(content)
    assert remedy in message_of(lambda: read_geometry_file(path))


@pytest.mark.parametrize("read", [*READERS, propeller])
def test_no_file(tmp_path: Path, read: Callable[..., Any]) -> None:
    assert "name a file inside it" in message_of(lambda: read(tmp_path))
    for name in ("none.csv", "nu\0ll", "long" * 2000, "two\nlines"):
        path = f"{tmp_path}/{name}"
        assert "check the path" in message_of(lambda path=path: read(path))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert "save the data to a file" in message_of(lambda: read_geometry_file(tmp_path / "pipe"))


def test_links_in_a_circle(tmp_path: Path) -> None:
    (tmp_path / "a").symlink_to(tmp_path / "b")
    (tmp_path / "b").symlink_to(tmp_path / "a")
    assert "check the path" in message_of(lambda: read_geometry_file(tmp_path / "a"))


@pytest.mark.parametrize("content", [UIUC, CSV, PE0, TOML], ids=["uiuc", "csv", "pe0", "toml"])
def test_bad_arguments(written: Writer, content: str) -> None:
    path, radius = written(content), 0.1 if content == UIUC else None
    for blades in (0, 13, 2.5, "two", True):
        message = message_of(
            lambda blades=blades: read_geometry_file(path, blades=blades, radius=radius)
        )
        assert "pass --blades 2" in message
    remedy = "pass --radius" if content == UIUC else "omit the radius"
    for wrong in (-0.1, float("nan"), None if content == UIUC else 0.5):
        assert remedy in message_of(lambda wrong=wrong: read_geometry_file(path, radius=wrong))


@pytest.mark.parametrize("content", ["hello\n", "t,x,y\n1,2,3\n", "{}\n", "# only\n"])
def test_unknown_format(written: Writer, content: str) -> None:
    path = written(content)
    assert "give an APC PE0 file, a UIUC geometry file" in message_of(lambda: propeller(path))


@settings(max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    content=st.sampled_from([CSV, UIUC, PE0, TOML]),
    where=st.floats(0.0, 1.0),
    cut=st.integers(0, 12),
    junk=st.text(max_size=8) | st.sampled_from(["-", "1e9", ",", "\n", "nan", '"', "\x0c", "#"]),
)
def test_damage_gives_a_blade_or_an_input_error(
    written: Writer, content: str, where: float, cut: int, junk: str
) -> None:
    start = int(where * len(content))
    path = written((content[:start] + junk + content[start + cut :]).encode("utf-8", "ignore"))
    try:
        assert read_geometry_file(path, radius=0.1).radius > 0.0
    except InputError as error:
        assert str(error).isprintable()
