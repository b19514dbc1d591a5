"""Reports: pictures, numbers and tables in text; folders are whole or as before."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.report.html import (
    MINUS,
    MISSING,
    as_svg,
    check_folder,
    csv_of_columns,
    csv_of_rows,
    new_figure,
    number,
    sentence,
    style,
    write_folder,
)


def test_the_same_figure_gives_the_same_bytes() -> None:
    def drawn() -> bytes:
        with style():
            figure = new_figure(3.0, 2.0)
            figure.subplots().plot([0.0, 1.0], [0.0, 1.0], label="line")
            return as_svg(figure)

    first = drawn()
    assert first == drawn() and b"<svg" in first and b"<text" not in first


def test_numbers_and_sentences() -> None:
    assert [number(value) for value in (1.23456, 2585.0, 0.0000314159, 0.0)] == [
        "1.23", "2580", "0.0000314", "0"
    ]  # fmt: skip
    assert number(-0.5) == f"{MINUS}0.5" and number(None) == number(float("nan")) == MISSING
    assert sentence("no data") == "No data." and sentence("é is 0.") == "É is 0."


def test_rows_and_columns_as_csv() -> None:
    text = csv_of_rows("set a_N b_N", [("x", 1.0 / 3.0, float("nan")), ("y", 1e-20, None)])
    assert text == "set,a_N,b_N\nx,0.333333,\ny,0,\n"
    first = {"set": "x", "a": np.array([1.5, 2.0])[:, None], "b": np.arange(2)}
    text = csv_of_columns([first, {"set": "y", "a": 3.0, "b": None}])
    assert text == "set,a,b\nx,1.5,0\nx,1.5,1\nx,2,0\nx,2,1\ny,3,\n"


FILES = {"index.html": "<p>β</p>", "a.csv": b"1\n"}


def _held(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir()}


def test_a_run_replaces_an_earlier_one_or_fails_without_a_trace(tmp_path: Path) -> None:
    folder, broken = tmp_path / "out", {"index.html": "new", "a.csv": None}
    with pytest.raises(TypeError):
        write_folder(folder, broken)  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []
    write_folder(folder, FILES)
    with pytest.raises(TypeError):
        write_folder(folder, broken)  # type: ignore[arg-type]
    assert _held(folder) == {"index.html": "<p>β</p>".encode(), "a.csv": b"1\n"}
    write_folder(folder, {"index.html": "new", "a.csv": "2\n"})
    assert _held(folder) == {"index.html": b"new", "a.csv": b"2\n"}
    assert list(tmp_path.iterdir()) == [folder]


def test_other_files_are_never_removed(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(InputError, match=r"thesis\.tex.*choose a new or an empty folder"):
        write_folder(tmp_path, FILES)
    assert (tmp_path / "thesis.tex").read_text() == "years of work"
    no_folder = r"out: there is no folder [^;]*; create it or choose another$"
    for name, message in (("thesis.tex", "not a folder"), ("no/out", no_folder)):
        with pytest.raises(InputError, match=message):
            check_folder(tmp_path / name, FILES)
    (tmp_path / "thesis.tex").unlink()
    (tmp_path / "index.html").mkdir()
    with pytest.raises(InputError, match=r"index\.html"):
        check_folder(tmp_path, FILES)
