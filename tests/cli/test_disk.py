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

from propmap.export import TARGETS

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
@pytest.mark.parametrize("size", [0, 1000])
def test_a_full_disk_leaves_no_table(run: Run, tmp_path: Path, name: str, size: int) -> None:
    with full_after(size):
        done = run(*TABLE, "-o", name)
    _refused(done)
    assert f"{name}: File too large" in done.err
    assert list(tmp_path.iterdir()) == []
    assert run(*TABLE, "-o", name).code == 0


@pytest.mark.usefixtures("_built")
@pytest.mark.parametrize("name", ["map.npz", "map.nc"])
def test_a_full_disk_keeps_the_table_that_was_there(run: Run, tmp_path: Path, name: str) -> None:
    assert run(*TABLE, "-o", name).code == 0
    before = (tmp_path / name).read_bytes()
    with full_after(1000):
        _refused(run(*TABLE, "-o", name, "--force"))
    assert [p.name for p in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_bytes() == before


@pytest.mark.parametrize("target", TARGETS)
def test_a_full_disk_leaves_no_export(run: Run, tmp_path: Path, target: str) -> None:
    invented().save("map.npz")
    with full_after(500):
        done = run("export", "map.npz", "--to", target, "-o", "to")
    _refused(done)
    assert "propmap: error: to/invented" in done.err or "to/README" in done.err
    assert [p.name for p in tmp_path.iterdir()] == ["map.npz"]


@pytest.fixture(params=["permissions", "told", "untold"])
def read_only(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Path]:
    """A folder that cannot be written to, by its permissions or by its file system.

    Permissions do not stop root.  A file system that is read-only tells it when asked, or, as
    some network mounts do, not before a file is made.
    """
    folder = tmp_path / "locked"
    folder.mkdir()
    if request.param == "permissions":
        if os.geteuid() == 0:
            pytest.skip("permissions do not stop root")
        folder.chmod(0o500)
        yield folder
        folder.chmod(0o700)
        return
    access, really_open, mkdir = os.access, Path.open, Path.mkdir

    def refuse(path: Path) -> None:
        if folder in (path, *path.parents):
            raise OSError(30, "Read-only file system", str(path))

    def opened(path: Path, mode: str = "r", *arguments: object, **named: object) -> object:
        if set(mode) & set("wxa+"):
            refuse(path)
        return really_open(path, mode, *arguments, **named)  # type: ignore[call-overload]

    def made(path: Path, *arguments: object, **named: object) -> None:
        refuse(path)
        mkdir(path, *arguments, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(Path, "open", opened)
    monkeypatch.setattr(Path, "mkdir", made)
    if request.param == "told":
        monkeypatch.setattr(
            os, "access", lambda path, mode: Path(path) != folder and access(path, mode)
        )
    yield folder


@pytest.mark.usefixtures("_built")
def test_a_read_only_folder_gets_no_table(run: Run, read_only: Path) -> None:
    _refused(run(*TABLE, "-o", read_only / "map.npz"))
    assert list(read_only.iterdir()) == []


@pytest.mark.parametrize("place", ["", "new"])
def test_a_read_only_folder_gets_no_export(run: Run, read_only: Path, place: str) -> None:
    invented().save("map.npz")
    done = run("export", "map.npz", "--to", "multinomial", "-o", read_only / place)
    _refused(done)
    assert str(read_only) in done.err
    assert list(read_only.iterdir()) == []


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


def test_a_rename_that_fails_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(OSError, match="No space"):
        invented().save(tmp_path / "map.npz")
    assert list(tmp_path.iterdir()) == []
