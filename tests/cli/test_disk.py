"""`propmap table` and `propmap export` on a full disk and in folders that cannot be written to.

A limit on the size of files stands in for the full disk: the operating system itself refuses to
write on, in the middle of a file, to whatever library is writing.
"""

from __future__ import annotations

import os
import resource
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from .conftest import Outcome, Run
from .invented_tables import invented


@contextmanager
def full_after(size: int) -> Iterator[None]:
    """Files may not grow beyond so many bytes."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    # Else Python would leave the first part of what it compiled of a module imported within, and
    # from then on fail to import it.
    with_bytecode, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        sys.dont_write_bytecode = with_bytecode


@pytest.fixture
def _built(monkeypatch: pytest.MonkeyPatch) -> None:
    """`propmap table` without the building."""
    monkeypatch.setattr("propmap.table.build.build_table", lambda *_, **__: invented())


TABLE = ["table", "apc-8x6e", "--airfoil", "paper-apc", "--rpm", "3000:6000", "--speed", "0:8"]


def _refused(done: Outcome) -> None:
    assert done.code == 2
    assert done.err.startswith("propmap: error: ")
    assert done.err.count("\n") == 1
    assert "Traceback" not in done.err


@pytest.mark.usefixtures("_built")
@pytest.mark.parametrize("name", ["map.npz", "map.nc"])
def test_a_full_disk_leaves_no_table_or_the_one_that_was_there(
    run: Run, tmp_path: Path, name: str
) -> None:
    with full_after(1000):
        done = run(*TABLE, "-o", name)
    _refused(done)
    assert f"{name}: File too large" in done.err
    assert list(tmp_path.iterdir()) == []
    assert run(*TABLE, "-o", name).code == 0
    before = (tmp_path / name).read_bytes()
    with full_after(1000):
        _refused(run(*TABLE, "-o", name, "--force"))
    assert [p.name for p in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_bytes() == before


@pytest.mark.parametrize("target", ["c", "nc"])
def test_a_full_disk_leaves_no_export(run: Run, tmp_path: Path, target: str) -> None:
    invented().save("map.npz")
    with full_after(500):
        done = run("export", "map.npz", "--to", target, "-o", "to")
    _refused(done)
    assert "propmap: error: to/invented" in done.err or "to/README" in done.err
    assert [p.name for p in tmp_path.iterdir()] == ["map.npz"]


@pytest.mark.usefixtures("_built")
def test_a_read_only_folder_gets_no_table_and_no_export(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Permissions do not stop root, so that only the answer to the question is changed."""
    folder, access = tmp_path / "locked", os.access
    folder.mkdir()
    monkeypatch.setattr(
        os, "access", lambda path, mode: Path(path) != folder and access(path, mode)
    )
    _refused(run(*TABLE, "-o", folder / "map.npz"))
    invented().save("map.npz")
    for place in (folder, folder / "new"):
        done = run("export", "map.npz", "--to", "multinomial", "-o", place)
        _refused(done)
        assert str(folder) in done.err
    assert list(folder.iterdir()) == []


@pytest.mark.usefixtures("_built")
def test_a_place_below_a_file_is_refused(run: Run, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    for arguments in (
        [*TABLE, "-o", "file/map.npz"],
        [*TABLE, "-o", "file/folder/map.nc"],
        ["export", "map.npz", "--to", "c", "-o", "file/to"],
    ):
        done = run(*arguments)
        _refused(done)
        assert "there is no folder 'file" in done.err
    assert (tmp_path / "file").read_text() == "mine"
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
