"""Files that someone has broken on purpose: one line, or a right reading, and nothing left over."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from propmap.cli import sweep
from propmap.export import export_table
from propmap.table import LoadTable
from tests.cli.conftest import ROTOR, Run, refused
from tests.cli.fit_inputs import VEHICLE
from tests.table.conftest import invented_content

from . import samples

POINTS = ["--rpm", "2000,3000", "--speed", "0", "--beta", "0"]


@pytest.fixture
def table() -> Path:
    LoadTable(invented_content()).save("map.npz")
    return Path("map.npz")


def test_a_table_that_unpacks_to_gigabytes(
    run: Run, table: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("propmap.table.files.MOST_UNPACKED", 10_000)
    refused(run("show", table), "map.npz: the file unpacks to", "more than any table")


def test_a_table_whose_header_says_to_be_huge(run: Run, table: Path) -> None:
    header = io.BytesIO()
    about: Any = {"descr": "<f8", "fortran_order": False, "shape": (10**15,)}
    np.lib.format.write_array_header_1_0(header, about)
    with zipfile.ZipFile(table, "w") as file:
        file.writestr("info.npy", header.getvalue() + bytes(80))
    refused(run("show", table), "map.npz: the file is not a table, or it is damaged")


def test_a_path_with_bytes_that_are_no_text(run: Run) -> None:
    Path("bl\udce9.csv").write_text(samples.CSV)
    done = run("predict", "bl\udce9.csv", "--rpm", "3000", "--format", "csv")
    assert done.code == 0
    refused(run("sweep", "bl\udce9.csv", *POINTS, "-o", "s.nc"), "not UTF-8; rename")
    assert [path.name for path in Path().iterdir()] == ["bl\udce9.csv"]


def test_null_characters(run: Run, tmp_path: Path) -> None:
    content = invented_content()
    content.info["propeller"]["name"] = "n" * 150 + "\0\u4e2d"
    paths = export_table(LoadTable(content), "c", tmp_path / "to")
    assert all("\0" not in path.read_text(encoding="utf-8") for path in paths)
    Path("vehicle.toml").write_text(VEHICLE.replace("apc-8x6e", "a\\u0000.csv"))
    refused(run("trim", "vehicle.toml"), "vehicle.toml")
    Path("vehicle.toml").write_text(VEHICLE.replace("test quadrotor", "/*\\u0000"))
    assert run("trim", "vehicle.toml", "--speed", "5").code == 0


def test_of_runs_beside_each_other_one_writes(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    compute = sweep.Sweep.run

    def meanwhile(*arguments: Any) -> Any:
        Path("s.nc").write_bytes(b"of another run")
        return compute(*arguments)

    monkeypatch.setattr(sweep.Sweep, "run", meanwhile)
    refused(run("sweep", *ROTOR, *POINTS, "-o", "s.nc"), "s.nc: another run has written this file")
    assert Path("s.nc").read_bytes() == b"of another run"
    assert [path.name for path in Path().iterdir()] == ["s.nc"]
