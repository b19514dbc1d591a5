"""`propmap table` and `propmap export` on a full disk and in folders that cannot be written to.

A limit on the size of files stands in for the full disk.
"""

from __future__ import annotations

import os
import resource
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from .conftest import Run, refused
from .invented_tables import invented


@contextmanager
def full_after(size: int) -> Iterator[None]:
    """Limit the size of files in bytes."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    # Otherwise Python leaves a truncated .pyc of a module that is imported within.
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


@pytest.mark.usefixtures("_built")
@pytest.mark.parametrize("name", ["map.npz", "map.nc"])
def test_a_full_disk_leaves_no_table_or_the_one_that_was_there(
    run: Run, tmp_path: Path, name: str
) -> None:
    with full_after(1000):
        done = run(*TABLE, "-o", name)
    refused(done, f"{name}: File too large")
    assert list(tmp_path.iterdir()) == []
    assert run(*TABLE, "-o", name).code == 0
    before = (tmp_path / name).read_bytes()
    with full_after(1000):
        refused(run(*TABLE, "-o", name, "--force"))
    assert [p.name for p in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_bytes() == before


@pytest.mark.parametrize("target", ["c", "nc"])
def test_a_full_disk_leaves_no_export(run: Run, tmp_path: Path, target: str) -> None:
    invented().save("map.npz")
    with full_after(500):
        done = run("export", "map.npz", "--to", target, "-o", "to")
    refused(done, "error: to/")
    assert [p.name for p in tmp_path.iterdir()] == ["map.npz"]


@pytest.mark.usefixtures("_built")
def test_a_read_only_folder_gets_no_table_and_no_export(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Permissions do not stop root, so that only the answer to the question is changed."""
    folder = tmp_path / "locked"
    folder.mkdir()
    monkeypatch.setattr(os, "access", lambda path, _: Path(path) != folder)
    refused(run(*TABLE, "-o", folder / "map.npz"))
    invented().save("map.npz")
    refused(run("export", "map.npz", "--to", "multinomial", "-o", folder / "new"), str(folder))
    assert list(folder.iterdir()) == []
