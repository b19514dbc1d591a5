"""Table files: whole or not at all, without pickle, and refused in one line."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.loads import LOADS
from propmap.table import Certificate, LoadTable
from propmap.table.files import FORMAT_VERSION

from .conftest import random_points


@pytest.fixture
def path(invented: LoadTable, tmp_path: Path) -> Path:
    invented.save(tmp_path / "map.npz")
    return tmp_path / "map.npz"


def test_a_table_answers_alike_before_and_after(invented: LoadTable, path: Path) -> None:
    points = random_points(invented, 500)
    for before, after in zip(
        invented.loads(*points), LoadTable.load(path).loads(*points), strict=True
    ):
        np.testing.assert_array_equal(before, after)
    assert LoadTable.load(path).info == invented.info


def _refusal(path: Path, **options: Any) -> str:
    with pytest.raises(propmap.InputError) as error:
        LoadTable.load(path, **options)
    text = str(error.value)
    assert "\n" not in text
    assert path.name in text
    return text


def test_truncated_files_and_altered_bytes_are_noticed(path: Path) -> None:
    data = path.read_bytes()
    rng = np.random.default_rng(5)
    before = LoadTable.load(path)
    path.write_bytes(data[: int(0.999 * len(data))])
    _refusal(path)
    for place in rng.integers(0, len(data), 30).tolist():
        altered = bytearray(data)
        altered[place] ^= 0x55
        path.write_bytes(altered)
        try:
            after = LoadTable.load(path)
        except propmap.InputError as error:
            assert "\n" not in str(error)
        else:
            # A byte of the archive that says nothing of the table, such as a time stamp.
            np.testing.assert_array_equal(before.content.padded(), after.content.padded())
            assert before.info == after.info


@pytest.mark.parametrize("content", [b"", b"rpm,thrust\n1,2\n", b"PK\x03\x04" + bytes(40)])
def test_foreign_files(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "map.npz"
    path.write_bytes(content)
    assert "not a table" in _refusal(path)


def test_missing_files_folders_and_other_arrays(tmp_path: Path) -> None:
    assert "no such file" in _refusal(tmp_path / "absent.npz")
    (tmp_path / "folder.npz").mkdir()
    _refusal(tmp_path / "folder.npz")
    np.save(tmp_path / "one.npy", np.ones(3))
    assert "single array" in _refusal(tmp_path / "one.npy")
    np.savez(tmp_path / "other.npz", a=np.ones(3))
    assert "does not describe a table" in _refusal(tmp_path / "other.npz")


def test_pickles_are_not_read(tmp_path: Path) -> None:
    class Trap:
        def __reduce__(self) -> tuple[Any, ...]:
            return (pytest.fail, ("a pickle was executed",))

    path = tmp_path / "map.npz"
    np.savez(path, info=np.array([Trap()], dtype=object), allow_pickle=True)
    _refusal(path)


def _rewritten(path: Path, change: Callable[[dict[str, Any], dict[str, Any]], None]) -> None:
    with np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    head = json.loads(str(arrays.pop("info")[()]))
    change(head, arrays)
    np.savez(path, info=np.array(json.dumps(head)), **arrays)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda h, _: h.update(format_version=FORMAT_VERSION + 1), "format version"),
        (lambda h, _: h.update(format="other"), "format is 'other'"),
        (lambda h, _: h.update(loads=["thrust", "lift"]), "this propmap has thrust, drag"),
        (lambda h, _: h.pop("air"), "air.density_kg_m3"),
        (lambda h, _: h["propeller"].update(radius_m=-1.0), "radius"),
        (lambda h, _: h.update(certificate={"points": 1}), "does not contain tolerance"),
        (lambda _, a: a.pop("beta"), "has no beta"),
        (lambda _, a: a.update(beta=a["beta"][::-1]), "do not increase"),
        (lambda _, a: a.update(beta=a["beta"][:-1]), "shape"),
        (lambda _, a: a.update(omega=-a["omega"][::-1]), "positive"),
        (lambda _, a: a.update(coefficients=a["coefficients"] * np.inf), "infinite"),
        (lambda _, a: a.update(cells=a["cells"] + 0.5), "wrong type"),
    ],
)
def test_inconsistent_tables(path: Path, change: Any, message: str) -> None:
    with np.errstate(invalid="ignore"):
        _rewritten(path, change)
    assert message in _refusal(path)


def test_a_table_from_before_the_search_still_opens(path: Path) -> None:
    """Its certificate does not say how many points a search took, nor where the largest are."""
    by_load = dict.fromkeys(LOADS, 0.001)
    told = {
        field.name: by_load if str(field.type).startswith("dict") else 1
        for field in fields(Certificate)
    }
    later = ("search_points", "max_omega", "max_speed", "max_beta")
    old = {name: value for name, value in told.items() if name not in later}
    for certificate in (told, old):
        _rewritten(path, lambda h, _, found=certificate: h.update(certificate=found))
        assert LoadTable.load(path).certificate == certificate
    _rewritten(path, lambda h, _: h.update(certificate={**told, "max_omega": {"thrust": 1.0}}))
    assert "does not contain max_omega" in _refusal(path)


def test_a_table_of_another_propeller(path: Path, rotor: propmap.Rotor, table: LoadTable) -> None:
    assert "expected 'apc-8x6e'" in _refusal(path, propeller=rotor.model.propeller)
    table.save(path)
    LoadTable.load(path, propeller=rotor.model.propeller)


def test_a_failed_write_leaves_nothing(
    invented: LoadTable, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(zipfile.ZipFile, "writestr", full)
    monkeypatch.setattr(np, "savez_compressed", full)
    with pytest.raises(OSError, match="No space"):
        invented.save(tmp_path / "map.npz")
    assert list(tmp_path.iterdir()) == []
