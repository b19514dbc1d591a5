"""Files that someone has broken on purpose: one line, or a right reading, and nothing left over."""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from propmap.export import export_table
from propmap.table import LoadTable
from tests.cli.conftest import Run
from tests.cli.fit_inputs import STAND, VEHICLE
from tests.table.conftest import invented_content

from . import samples
from .test_files_and_columns import FREE, PROP, refused

Arrays = dict[str, Any]


@pytest.fixture
def table() -> Path:
    LoadTable(invented_content()).save("map.npz")
    return Path("map.npz")


def rewritten(path: Path, change: Callable[[dict[str, Any], Arrays], None]) -> None:
    with np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    head = json.loads(str(arrays.pop("info")[()]))
    change(head, arrays)
    np.savez(path, info=np.array(json.dumps(head)), **arrays)


def set_all(name: str, value: float) -> Callable[[dict[str, Any], Arrays], None]:
    def change(_: dict[str, Any], arrays: Arrays) -> None:
        arrays[name] = np.full_like(arrays[name], value)

    return change


def one_larger(_: dict[str, Any], arrays: Arrays) -> None:
    arrays["coefficients"][0, 0, 0, 0] *= 1.01


DAMAGES: dict[str, tuple[Callable[[dict[str, Any], Arrays], None], str]] = {
    "cells out of range": (set_all("cells", 255), "a cell has the flags 255"),
    "no numbers": (set_all("coefficients", np.nan), "checksum"),
    "one number changed": (one_larger, "checksum"),
    "no checksum": (lambda head, _: head.pop("sha256"), "checksum"),
}


@pytest.mark.parametrize("case", DAMAGES)
def test_a_damaged_table(run: Run, table: Path, case: str) -> None:
    change, says = DAMAGES[case]
    rewritten(table, change)
    refused(run("show", table), "map.npz", says)


def test_a_table_that_unpacks_to_gigabytes(
    run: Run, table: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("propmap.table.files.MOST_UNPACKED", 10_000)
    refused(run("show", table), "map.npz: the file unpacks to", "more than any table")


@pytest.mark.parametrize("shape", [(10**9,), (10**15,)])
def test_a_table_whose_header_says_to_be_huge(run: Run, table: Path, shape: tuple[int]) -> None:
    header = io.BytesIO()
    about: Any = {"descr": "<f8", "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(header, about)
    with zipfile.ZipFile(table, "w") as file:
        file.writestr("info.npy", header.getvalue() + bytes(80))
    refused(run("show", table), "map.npz: the file is not a table, or it is damaged")


# -------------------------------------------------------------------------------------------------
# Names.


@pytest.mark.parametrize("name", ["n" * 150, "a/*b*/c", "x\0y", "\u00fc\u00df \u4e2d"])
def test_names_of_propellers_in_exports(tmp_path: Path, name: str) -> None:
    content = invented_content()
    content.info["propeller"]["name"] = name
    for target in ("c", "jsbsim", "gazebo", "csv"):
        paths = export_table(LoadTable(content), target, tmp_path / target)
        assert sorted(paths) == sorted((tmp_path / target).iterdir())
        for path in paths:
            text = path.read_text(encoding="utf-8")
            assert "\0" not in text
            if path.suffix == ".h":
                assert not re.search(r"/\*(?:(?!\*/).)*/\*", text, re.DOTALL)


def test_a_path_with_bytes_that_are_no_text(run: Run) -> None:
    Path("bl\udce9.csv").write_text(samples.CSV)
    done = run("predict", "bl\udce9.csv", "--rpm", "3000", "--format", "csv")
    assert done.code == 0
    sweep = ["--rpm", "2000,3000", "--speed", "0", "--beta", "0"]
    refused(run("sweep", "bl\udce9.csv", *sweep, "-o", "s.nc"), "not UTF-8; rename")
    assert [path.name for path in Path().iterdir()] == ["bl\udce9.csv"]


@pytest.mark.parametrize("name", ["a\\u0000.csv", "/*\\u0000"])
def test_a_null_character_in_a_vehicle(run: Run, name: str) -> None:
    Path("vehicle.toml").write_text(VEHICLE.replace("apc-8x6e", name))
    refused(run("trim", "vehicle.toml"), "vehicle.toml")
    Path("vehicle.toml").write_text(VEHICLE.replace("test quadrotor", name))
    assert run("trim", "vehicle.toml", "--speed", "5").code == 0


ROTOR = ["apc-8x6e", "--airfoil", "paper-apc"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["predict", "deep.toml", "--rpm", "3000"],
        ["predict", "apc-8x6e", "--rpm", "3000", "--airfoil", "deep.toml"],
        ["check", "deep.toml", "uiuc-8x6e"],
        ["trim", "deep.toml"],
        ["export", "deep.toml", "--to", "c", "-o", "out"],
        ["study", "deep.toml", "-o", "out.nc"],
        ["report", "deep.toml", "-o", "out"],
    ],
)
def test_toml_nested_deep(run: Run, arguments: list[str]) -> None:
    Path("deep.toml").write_text(f"schema = 1\nx = {'[' * 5000}{']' * 5000}\n")
    refused(run(*arguments), "deep.toml", "recursion")
    assert not Path("out").exists() and not Path("out.nc").exists()


# -------------------------------------------------------------------------------------------------
# Covariances, and runs beside each other.


@pytest.mark.usefixtures("brief")
@pytest.mark.parametrize(
    ("matrix", "says"),
    [
        ("[[1.0, 0.5], [0.1, 1.0]]", "not symmetric"),
        ("[[1e300, 0], [0, 1]]", "a variance is 1e+300"),
    ],
)
def test_covariances_that_are_none(run: Run, matrix: str, says: str) -> None:
    Path("stand.csv").write_text(STAND)
    assert run("fit", "static", "stand.csv", *PROP, *FREE, "-o", "fit.toml").code == 0
    text = Path("fit.toml").read_text()
    found = re.search(r"^covariance = \[.*?^\]", text, re.DOTALL | re.MULTILINE)
    assert found
    Path("fit.toml").write_text(text.replace(found[0], f"covariance = {matrix}"))
    for arguments in (
        ["predict", "apc-8x6e", "--rpm", "3000", "--airfoil", "fit.toml"],
        ["check", "fit.toml", "uiuc-8x6e"],
    ):
        refused(run(*arguments), "fit.toml", says)


def test_of_runs_beside_each_other_one_writes(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    from propmap.cli import sweep

    compute = sweep._compute

    def meanwhile(evaluation: Any) -> Any:
        Path("s.nc").write_bytes(b"of another run")
        return compute(evaluation)

    monkeypatch.setattr(sweep, "_compute", meanwhile)
    points = ["--rpm", "2000,3000", "--speed", "0", "--beta", "0", "-o", "s.nc"]
    refused(run("sweep", *ROTOR, *points), "s.nc: another run has written this file")
    assert Path("s.nc").read_bytes() == b"of another run"
    assert [path.name for path in Path().iterdir()] == ["s.nc"]
