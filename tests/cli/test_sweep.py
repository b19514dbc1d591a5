"""`propmap sweep` and `propmap study`: grids, units, provenance, and files that appear whole."""

from __future__ import annotations

import csv
import socket
from pathlib import Path

import numpy as np
import pytest
import xarray

import propmap
from propmap.cli import sweep
from propmap.io.csv import OperatingPoints

from .conftest import ROTOR, Run, refused

pytestmark = pytest.mark.usefixtures("pictures_as_they_fall")

GRID = ["--rpm", "4000,4200", "--speed", "14:16:2", "--beta", "80:90:2"]
AXES = (np.array([4000.0, 4200.0]), np.array([14.0, 16.0]), np.array([80.0, 90.0]))
SWEEP = ["sweep", *ROTOR, *GRID, "-o"]


def rows_of(name: str) -> list[dict[str, str]]:
    with Path(name).open(newline="") as file:
        return list(csv.DictReader(file))


def test_netcdf_holds_the_loads(run: Run, rotor: propmap.Rotor, tmp_path: Path) -> None:
    done = run(*SWEEP, "out.nc")
    assert (done.code, done.err) == (0, "")
    assert [p.name for p in tmp_path.iterdir()] == ["out.nc"]
    loads = OperatingPoints.grid(*AXES).loads(rotor)
    with xarray.open_dataset("out.nc", engine="h5netcdf") as found:
        assert dict(found.sizes) == {"rpm": 2, "speed": 2, "beta": 2}
        for name, axis in zip(("rpm", "speed_mps", "beta_deg"), AXES, strict=True):
            assert (found[name].values == axis).all() and found[name].attrs["units"]
        for name in found.data_vars:
            assert found[name].attrs["long_name"]
            if name != "status":
                assert found[name].attrs["units"]
                expected = getattr(loads, str(name)).reshape(2, 2, 2)
                np.testing.assert_array_equal(found[name].values, expected)
        meanings = found["status"].attrs["flag_meanings"].split()
        assert [meanings[code] for code in found["status"].values.ravel()] == list(loads.status)
        attributes = found.attrs
    assert attributes["propmap_version"] == propmap.__version__
    assert (attributes["propeller"], attributes["airfoil_c_l1"]) == ("apc-8x6e", 5.3)
    assert attributes["command"].startswith("propmap sweep apc-8x6e --airfoil paper-apc")
    assert len(attributes["geometry_sha256"]) == 64
    assert attributes["created"].endswith("+00:00")


def test_a_sweep_contains_both_directions_of_rotation(run: Run) -> None:
    done = run("sweep", *ROTOR, "--rpm", "-4000,4000", *GRID[2:], "-o", "out.csv")
    assert done.code == 0 and "the propeller turns backward" in done.err
    rows = rows_of("out.csv")
    assert [row["status"] == "reversed" for row in rows] == [
        float(row["rpm"]) < 0.0 for row in rows
    ]


def test_nothing_is_left_when_writing_is_interrupted(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(path: Path, content: bytes) -> None:
        with path.open("wb") as file:
            file.write(content[: len(content) // 2])
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "write_bytes", stop)
    done = run(*SWEEP, "out.nc")
    assert (done.code, done.err.count("\n")) == (130, 1)
    assert list(tmp_path.iterdir()) == []


def test_a_sweep_is_streamed_and_announced(run: Run) -> None:
    done = run(*SWEEP, "map.zarr")
    assert (done.code, done.out) == (0, "wrote map.zarr: 8 points\n")
    assert "8 operating points in 1 task, up to 592 bytes; about" in done.err
    assert run(*SWEEP, "map.nc").code == 0
    streamed, whole = xarray.open_zarr("map.zarr"), xarray.open_dataset("map.nc")
    assert set(streamed.data_vars) == set(whole.data_vars)
    xarray.testing.assert_allclose(streamed, whole)
    refused(run(*SWEEP, "map.zarr"), "complete; pass --force")
    assert "created with another model" in run(*SWEEP, "map.zarr", "--rho", "1.1").err
    assert run(*SWEEP, "map.zarr", "--rho", "1.1", "--force").code == 0


def test_what_is_not_a_store_is_left_alone(run: Run) -> None:
    Path("map.zarr").mkdir()
    Path("map.zarr/thesis.txt").write_text("mine")
    for more in ([], ["--force"]):
        refused(run(*SWEEP, "map.zarr", *more), "not a store of propmap")
    assert Path("map.zarr/thesis.txt").read_text() == "mine"


def test_much_is_asked_for_and_too_much_refused(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    many = ["--rpm", "1000:9000:100000", "--speed", "1:20:100000", "--beta", "1:90:10000"]
    done = run("sweep", *ROTOR, *many, "-o", "map.zarr")
    assert done.code == 2 and "7.4 PB" in done.err.splitlines()[-1]
    assert list(tmp_path.iterdir()) == []
    monkeypatch.setattr(sweep, "ASK_ABOVE_BYTES", 100.0)
    monkeypatch.setattr("sys.stdin.isatty", lambda: False, raising=False)
    done = run(*SWEEP, "map.zarr")
    assert done.code == 2 and "needs a confirmation; pass --yes" in done.err
    assert run(*SWEEP, "map.zarr", "--yes").code == 0


@pytest.mark.parametrize(
    ("file", "cluster", "told"),
    [
        ("map.zarr", "local:0", "asks for '0' workers; give a number from 1"),
        ("map.nc", "localhost", "not an address; write local, local:4"),
        ("map.zarr", "tcp://localhost:99999", "not an address"),
        ("map.zarr", "tcp://localhost:PORT", "no scheduler answers within 0.1 s; start one"),
    ],
)
def test_wrong_clusters_are_one_line(
    run: Run, monkeypatch: pytest.MonkeyPatch, file: str, cluster: str, told: str
) -> None:
    monkeypatch.setattr("propmap.cluster.ANSWER_WITHIN", 0.1)
    with socket.socket() as free:
        free.bind(("localhost", 0))
        cluster = cluster.replace("PORT", str(free.getsockname()[1]))
        refused(run(*SWEEP, file, "--cluster", cluster), told)


STUDY = """
schema = 1
[propeller]
name = "apc-8x6e"
airfoil = "paper-apc"
[sampling]
method = "full-factorial"
[vary]
diameter_in = [7.5, 8.0, 8.5]
pitch_in = [5.0, 6.0, 7.0]
[points]
rpm = 5000.0
speed_mps = [0.0, 10.0]
beta_deg = 60.0
"""


def test_a_study_ends_in_a_dataset(run: Run) -> None:
    done = run("study", "study.toml", "-o", "study.nc")
    assert (done.code, done.err.count("\n")) == (2, 1)
    Path("study.toml").write_text(STUDY)
    done = run("study", "study.toml", "-o", "study.nc")
    assert done.code == 0
    assert "wrote" in done.out and "9 designs, 18 points" in done.out
    found = xarray.open_dataset("study.nc")
    assert dict(found.sizes) == {"design": 9, "rpm": 1, "speed": 2, "beta": 1}
    assert found["diameter"].attrs["units"] == "m"
    # More pitch, more thrust; more diameter too.
    thrust = found["thrust"].values[:, 0, 0, 0].reshape(3, 3)
    assert (thrust[1:] > thrust[:-1]).all()
    assert (thrust[:, 1:] > thrust[:, :-1]).all()
