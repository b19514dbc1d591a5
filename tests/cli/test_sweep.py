"""`propmap sweep`: the grid, its units and provenance, and files that appear whole."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import xarray

import propmap
from propmap.io.csv import PREDICT_COLUMNS, OperatingPoints

from .conftest import ROTOR, Run

GRID = ["--rpm", "4000,4200", "--speed", "14:16:2", "--beta", "80:90:2"]
AXES = (np.array([4000.0, 4200.0]), np.array([14.0, 16.0]), np.array([80.0, 90.0]))


def test_netcdf_holds_the_loads(run: Run, rotor: propmap.Rotor, tmp_path: Path) -> None:
    path = tmp_path / "out.nc"
    done = run("sweep", *ROTOR, *GRID, "-o", path)
    assert (done.code, done.err) == (0, "")
    assert [p.name for p in tmp_path.iterdir()] == ["out.nc"]
    loads = OperatingPoints.grid(*AXES).loads(rotor)
    with xarray.open_dataset(path, engine="h5netcdf") as found:
        assert dict(found.sizes) == {"rpm": 2, "speed": 2, "beta": 2}
        for name, axis in zip(("rpm", "speed_mps", "beta_deg"), AXES, strict=True):
            assert (found[name].values == axis).all()
            assert found[name].attrs["units"]
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
    assert attributes["propeller"] == "apc-8x6e"
    assert attributes["airfoil_c_l1"] == 5.3
    assert attributes["command"].startswith("propmap sweep apc-8x6e --airfoil paper-apc")
    assert len(attributes["geometry_sha256"]) == 64
    assert attributes["created"].endswith("+00:00")


def test_csv_has_a_row_per_point(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    assert run("sweep", *ROTOR, *GRID, "-o", path).code == 0
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 8
    assert tuple(rows[0])[: len(PREDICT_COLUMNS)] == PREDICT_COLUMNS
    assert [row["beta_deg"] for row in rows[:2]] == ["80.0", "90.0"]


def test_force_replaces(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    path.write_text("old")
    assert run("sweep", *ROTOR, *GRID, "-o", path, "--force").code == 0
    assert path.read_text().startswith("rpm")


@pytest.mark.parametrize(("fault", "code"), [(KeyboardInterrupt, 130), (OSError, 2)])
def test_nothing_is_left_when_writing_stops(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: type[Exception], code: int
) -> None:
    def stop(path: Path, content: bytes) -> None:
        with path.open("wb") as file:
            file.write(content[: len(content) // 2])
        raise fault(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", stop)
    done = run("sweep", *ROTOR, *GRID, "-o", tmp_path / "out.nc")
    assert done.code == code
    assert done.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_standard_deviations_are_variables_with_units(run: Run, tmp_path: Path) -> None:
    grid = ["--rpm", "5000", "--speed", "5", "--beta", "60:80:2"]
    path = tmp_path / "out.nc"
    assert run("sweep", "apc 10x5e", *grid, "--std-by-source", "-o", path).code == 0
    with xarray.open_dataset(path, engine="h5netcdf") as found:
        assert found["thrust_std"].attrs["units"] == "N"
        assert found["thrust_std"].attrs["long_name"].startswith("standard deviation of")
        assert found["roll_moment_std"].attrs["units"] == "N m"
        assert found["power_std_tunnel"].attrs["long_name"].endswith("from tunnel only")
        parts = [found[f"thrust_std_{s}"] for s in ("parameters", "discrepancy", "tunnel")]
        total = np.sqrt(sum(part.values**2 for part in parts))
        np.testing.assert_allclose(found["thrust_std"].values, total)
        expected = found["thrust_std"].values.ravel()
    table = tmp_path / "out.csv"
    assert run("sweep", "apc 10x5e", *grid, "-o", table).code == 0
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["thrust_std_N"]) for row in rows] == expected.tolist()
    assert run("sweep", "apc 10x5e", *grid, "--no-bands", "-o", table, "--force").code == 0
    assert "std" not in table.read_text()
