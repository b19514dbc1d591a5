"""`propmap sweep -o map.zarr` and `propmap study` as a user types them; clusters that are wrong."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest
import xarray

from propmap.cli import sweep

from .conftest import ROTOR, Run

pytestmark = pytest.mark.usefixtures("brief", "pictures_as_they_fall")

GRID = ["--rpm", "4000,4200", "--speed", "14:16:2", "--beta", "80:90:2"]

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
[picture]
quantity = "thrust"
speed_mps = 10.0
"""


def test_a_sweep_is_streamed_and_announced(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "map.zarr"
    done = run("sweep", *ROTOR, *GRID, "-o", path)
    assert done.code == 0
    assert done.out == f"wrote {path}: 8 points\n"
    assert "8 operating points in 1 task, up to 592 bytes; about" in done.err
    assert run("sweep", *ROTOR, *GRID, "-o", tmp_path / "map.nc").code == 0
    streamed, whole = xarray.open_zarr(path), xarray.open_dataset(tmp_path / "map.nc")
    assert set(streamed.data_vars) == set(whole.data_vars)
    xarray.testing.assert_allclose(streamed, whole)
    again = run("sweep", *ROTOR, *GRID, "-o", path)
    assert (again.code, again.err.count("\n")) == (2, 1)
    assert "complete; pass --force" in again.err
    other = run("sweep", *ROTOR, *GRID, "--rho", "1.1", "-o", path)
    assert "created with another model" in other.err
    assert run("sweep", *ROTOR, *GRID, "--rho", "1.1", "-o", path, "--force").code == 0


def test_what_is_not_a_store_is_left_alone(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "map.zarr"
    path.mkdir()
    (path / "thesis.txt").write_text("mine")
    for more in ([], ["--force"]):
        done = run("sweep", *ROTOR, *GRID, "-o", path, *more)
        assert (done.code, done.err.count("\n")) == (2, 1)
        assert "not a store of propmap" in done.err
    assert (path / "thesis.txt").read_text() == "mine"


def test_much_is_asked_for(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep, "ASK_ABOVE_BYTES", 100.0)
    monkeypatch.setattr("sys.stdin.isatty", lambda: False, raising=False)
    done = run("sweep", *ROTOR, *GRID, "-o", tmp_path / "map.zarr")
    assert done.code == 2
    assert "needs a confirmation; pass --yes" in done.err
    assert run("sweep", *ROTOR, *GRID, "-o", tmp_path / "map.zarr", "--yes").code == 0


def test_a_disk_that_is_too_small_is_told_before(run: Run, tmp_path: Path) -> None:
    many = ["--rpm", "1000:9000:100000", "--speed", "1:20:100000", "--beta", "1:90:10000"]
    done = run("sweep", *ROTOR, *many, "-o", tmp_path / "map.zarr")
    assert done.code == 2
    assert "7.4 PB" in done.err.splitlines()[-1]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("cluster", "told"),
    [
        ("local:0", "asks for '0' workers; give a number from 1"),
        ("local:many", "asks for 'many' workers"),
        ("localhost", "not an address; write local, local:4"),
        ("tcp://localhost", "not an address"),
        ("tcp://localhost:99999", "not an address"),
        ("tcp://localhost:PORT", "no scheduler answers within 0.5 s; start one"),
    ],
)
def test_wrong_clusters_are_one_line(
    run: Run,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    cluster: str,
    told: str,
) -> None:
    monkeypatch.setattr("propmap.cluster.ANSWER_WITHIN", 0.5)
    with socket.socket() as free:
        free.bind(("localhost", 0))
        cluster = cluster.replace("PORT", str(free.getsockname()[1]))
        done = run("sweep", *ROTOR, *GRID, "-o", tmp_path / "map.zarr", "--cluster", cluster)
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert told in done.err


def test_only_a_store_is_written_by_many(run: Run, tmp_path: Path) -> None:
    done = run("sweep", *ROTOR, *GRID, "-o", tmp_path / "map.nc", "--cluster", "local:2")
    assert "use the file extension .zarr" in done.err


@pytest.mark.parametrize("ending", ["nc", "zarr"])
def test_a_study_ends_in_a_dataset_and_a_picture(run: Run, tmp_path: Path, ending: str) -> None:
    file, path = tmp_path / "study.toml", tmp_path / f"study.{ending}"
    file.write_text(STUDY)
    done = run("study", file, "-o", path, "--picture", "surface.png")
    assert done.code == 0
    assert "wrote" in done.out and "9 designs, 18 points" in done.out
    assert "thrust at 5000 rpm, speed 10 m/s, beta 60 degree" in done.out
    assert (tmp_path / "surface.png").stat().st_size > 10_000
    found = xarray.open_zarr(path) if ending == "zarr" else xarray.open_dataset(path)
    assert dict(found.sizes) == {"design": 9, "rpm": 1, "speed": 2, "beta": 1}
    assert found["diameter"].attrs["units"] == "m"
    # More pitch, more thrust; more diameter too.
    thrust = found["thrust"].values[:, 0, 0, 0].reshape(3, 3)
    assert (thrust[1:] > thrust[:-1]).all()
    assert (thrust[:, 1:] > thrust[:, :-1]).all()


def test_a_study_of_a_missing_file_is_one_line(run: Run, tmp_path: Path) -> None:
    done = run("study", tmp_path / "none.toml", "-o", tmp_path / "study.nc")
    assert (done.code, done.err.count("\n")) == (2, 1)


def test_a_run_that_never_began_is_not_in_the_way(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "map.zarr"
    command = ["sweep", "apc-8x6e", "--speed", "0", "--beta", "0", "-o", str(path)]
    refused = run(*command, "--rpm", "4000", "--cluster", "local:0")
    assert refused.code == 2 and path.exists()
    outcome = run(*command, "--rpm", "5000")
    assert outcome.code == 0, outcome.err
    again = run(*command, "--rpm", "4000")
    assert again.code == 2 and "another set of operating points" in again.err
