"""A folder of a report is there with all its files, or as it was before."""

from __future__ import annotations

from pathlib import Path

import pytest

from propmap.errors import InputError
from propmap.report.html import check_folder, write_folder

FILES = {"index.html": "<p>β</p>", "a.csv": b"1\n"}


def _held(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir()}


def test_all_files_and_nothing_beside(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    write_folder(folder, FILES)
    assert _held(folder) == {"index.html": "<p>β</p>".encode(), "a.csv": b"1\n"}
    assert list(tmp_path.iterdir()) == [folder]


def test_an_earlier_run_is_replaced_as_a_whole(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    write_folder(folder, FILES)
    write_folder(folder, {"index.html": "new", "a.csv": "2\n"})
    assert _held(folder) == {"index.html": b"new", "a.csv": b"2\n"}
    assert list(tmp_path.iterdir()) == [folder]


@pytest.mark.parametrize("there", [False, True])
def test_what_fails_half_way_leaves_no_trace(tmp_path: Path, there: bool) -> None:
    folder = tmp_path / "out"
    if there:
        write_folder(folder, FILES)
    broken = {"index.html": "new", "a.csv": None}
    with pytest.raises(TypeError):
        write_folder(folder, broken)  # type: ignore[arg-type]
    assert folder.exists() == there
    if there:
        assert _held(folder)["index.html"] == "<p>β</p>".encode()
    assert list(tmp_path.iterdir()) == ([folder] if there else [])


def test_other_files_are_never_removed(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(InputError, match=r"thesis\.tex.*choose a new or an empty folder"):
        write_folder(tmp_path, FILES)
    assert (tmp_path / "thesis.tex").read_text() == "years of work"
    (tmp_path / "thesis.tex").rename(tmp_path / "a.csv")
    (tmp_path / "index.html").mkdir()
    with pytest.raises(InputError, match=r"index\.html"):
        check_folder(tmp_path, FILES)


def test_places_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="not a folder"):
        check_folder(tmp_path / "file", FILES)
    with pytest.raises(
        InputError, match=r"out: there is no folder [^;]*; make it or choose another$"
    ):
        check_folder(tmp_path / "no" / "out", FILES)
