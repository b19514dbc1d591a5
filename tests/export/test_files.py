"""What is written: copies of the table, all files or none, and what is refused."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import xarray

from propmap.errors import InputError
from propmap.export import AUTOPILOTS, EXPORTS, TARGETS, export_table, find_export
from propmap.loads import LOADS
from propmap.table import LoadTable

from .conftest import invented_content


def test_npz_and_netcdf_are_the_table(table: LoadTable, tmp_path: Path) -> None:
    path, note = export_table(table, "npz", tmp_path / "to")
    assert [p.name for p in (path, note)] == ["apc_8x6e.npz", "README-npz.txt"]
    again = LoadTable.load(path)
    np.testing.assert_array_equal(again.content.coefficients, table.content.coefficients)
    assert again.info == table.info
    path, _ = export_table(table, "nc", tmp_path / "to")
    with xarray.open_dataset(path, engine="h5netcdf") as found:
        np.testing.assert_array_equal(found["torque"], table.content.coefficients[:, 2])


def test_csv_is_the_table(tmp_path: Path) -> None:
    content = invented_content(gap=True)
    path, _ = export_table(LoadTable(content), "csv", tmp_path)
    with path.open(newline="") as file:
        head, *rows = csv.reader(file)
    assert head == [
        "omega_rad_s", "advance", "beta_rad", *(f"{name}_coefficient" for name in LOADS)
    ]  # fmt: skip
    numbers = np.array([[float(word or "nan") for word in row] for row in rows])
    expected = content.coefficients.transpose(0, 2, 3, 1).reshape(-1, len(LOADS))
    np.testing.assert_array_equal(numbers[:, 3:].astype(np.float32), expected.astype(np.float32))
    np.testing.assert_array_equal(np.unique(numbers[:, 1]), content.advance)


def test_every_target_writes_files_and_a_note_into_one_folder(tmp_path: Path) -> None:
    """Of a propeller whose name is no name of a file, a variable or an XML comment."""
    odd = LoadTable(invented_content(name='9x4 "quick" -->*/\n"""é'))
    for target in TARGETS:
        before = set(tmp_path.iterdir())
        paths = export_table(odd, target, tmp_path)
        assert set(paths) == set(tmp_path.iterdir()) - before
        *written, note = paths
        assert note.name == f"README-{target}.txt" and written
        text = note.read_text()
        assert text.startswith(f"propmap export: {target}\n") and str(tmp_path) not in text
        assert "Error against the table" in text or "Nothing is simplified" in text
        for path in written:
            assert path.name.startswith("prop_9x4_quick")
            if path.suffix == ".py":
                compile(path.read_text(), path.name, "exec")


def test_existing_files_are_kept(invented: LoadTable, tmp_path: Path) -> None:
    (tmp_path / "README-gazebo.txt").write_text("mine")
    with pytest.raises(InputError, match="--force"):
        export_table(invented, "gazebo", tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["README-gazebo.txt"]
    export_table(invented, "gazebo", tmp_path, replace=True)
    assert (tmp_path / "README-gazebo.txt").read_text() != "mine"


def test_all_files_or_none(
    invented: LoadTable, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write = Path.write_text

    def full(path: Path, *arguments: object, **named: object) -> int:
        if "README" in path.name:
            raise OSError(28, "No space left on device", str(path))
        return write(path, *arguments, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(OSError, match="No space"):
        export_table(invented, "c", tmp_path / "to")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "there").mkdir()
    with pytest.raises(OSError, match="No space"):
        export_table(invented, "multinomial", tmp_path / "there")
    assert list((tmp_path / "there").iterdir()) == []


def test_every_export_is_found_and_can_be_made() -> None:
    for export in EXPORTS:
        assert find_export(export.target, export.source) is export
        assert callable(export.make())


def test_bad_targets_and_folders(invented: LoadTable, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no target 'ros'; choose one of c, multinomial"):
        export_table(invented, "ros", tmp_path)
    for target in AUTOPILOTS:
        message = f"{target} is not made from a table, but from a vehicle"
        with pytest.raises(InputError, match=message):
            export_table(invented, target, tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="this is a file"):
        export_table(invented, "csv", tmp_path / "file")
    with pytest.raises(
        InputError, match=r"b: there is no folder [^;]*; create it or choose another$"
    ):
        export_table(invented, "csv", tmp_path / "a" / "b")
    (tmp_path / "invented.csv").mkdir()
    with pytest.raises(InputError, match="this is a folder"):
        export_table(invented, "csv", tmp_path, replace=True)
