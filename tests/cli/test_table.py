"""`propmap table`: the file, the certificate shown, and one-line errors."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest
import xarray

import propmap
from propmap.table import LoadTable, build_table

from .conftest import ROTOR, Run

SMALL = ["--rpm", "4000:4400", "--speed", "14:16", "--beta", "75:90", "--tolerance", "5%"]


@pytest.fixture(autouse=True)
def _short_certificate(monkeypatch: pytest.MonkeyPatch) -> None:
    brief = functools.partial(build_table, certificate_points=512)
    monkeypatch.setattr("propmap.table.build.build_table", brief)


def test_a_table_is_filed_and_its_certificate_shown(run: Run, tmp_path: Path) -> None:
    done = run("table", *ROTOR, *SMALL, "-o", "map.npz")
    assert (done.code, done.err) == (0, "")
    assert [p.name for p in tmp_path.iterdir()] == ["map.npz"]
    assert "Certificate" in done.out and "tolerance 5.00% holds on" in done.out
    table = LoadTable.load("map.npz", propeller=propmap.propeller("apc-8x6e"))
    assert table.envelope["beta"] == pytest.approx(np.radians([75.0, 90.0]))
    assert table.info["command"].startswith("propmap table apc-8x6e")
    assert table.certificate["holds"]


def test_netcdf(run: Run) -> None:
    assert run("table", *ROTOR, *SMALL, "-o", "map.nc").code == 0
    with xarray.open_dataset("map.nc", engine="h5netcdf") as found:
        assert found["thrust"].dims == ("omega", "advance", "beta")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--tolerance", "much"], "no share"),
        (["--tolerance", "-1%"], "no share"),
        (["--tolerance", "0.001%"], "must lie between 0.20% and 10%"),
        (["--tolerance", "80%"], "must lie between"),
        (["--rpm", "4000"], "no range"),
        (["--rpm", "5000:4000"], "do not rise"),
        (["--rpm", "0:4000"], "advance ratio is infinite"),
        (["--beta", "0:270"], "between 0 and pi"),
        (["-o", "map.csv"], "ending"),
        (["-o", "absent/map.npz"], "no folder"),
    ],
)
def test_what_cannot_be_is_told_in_one_line(
    run: Run, tmp_path: Path, arguments: list[str], message: str
) -> None:
    done = run("table", *ROTOR, *SMALL, "-o", "map.npz", *arguments)
    assert done.code == 2
    assert message in done.err
    assert done.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_existing_files_are_kept(run: Run, tmp_path: Path) -> None:
    (tmp_path / "map.npz").write_text("mine")
    assert "--force" in run("table", *ROTOR, *SMALL, "-o", "map.npz").err
    assert (tmp_path / "map.npz").read_text() == "mine"


def test_an_interrupted_build_leaves_nothing(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(propmap.Rotor, "loads", stop)
    assert run("table", *ROTOR, *SMALL, "-o", "map.npz").code == 130
    assert list(tmp_path.iterdir()) == []
