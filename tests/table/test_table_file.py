"""Table files: whole or not at all, without pickle, and refused in one line."""

from __future__ import annotations

import contextlib
import json
import warnings
import zipfile
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import propmap
from propmap.loads import LOADS
from propmap.table import Certificate, LoadTable
from propmap.table.files import FORMAT, FORMAT_VERSION
from propmap.table.interpolation import TableContent

from .conftest import invented_content, random_points


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
    assert "not a table" in _refusal(tmp_path / "one.npy")
    np.savez(tmp_path / "other.npz", a=np.ones(3))
    assert "does not describe a table" in _refusal(tmp_path / "other.npz")


def test_pickles_are_not_read(tmp_path: Path) -> None:
    class Trap:
        def __reduce__(self) -> tuple[Any, ...]:
            return (pytest.fail, ("a pickle was executed",))

    path = tmp_path / "map.npz"
    np.savez(path, info=np.array([Trap()], dtype=object), allow_pickle=True)
    _refusal(path)


# --- Forged tables: wrong contents with a valid checksum -----------------------------------------

CERTIFICATE: dict[str, Any] = {
    field.name: dict.fromkeys(LOADS, 0.001) if str(field.type).startswith("dict") else 1
    for field in fields(Certificate)
}


def parts_of(content: TableContent) -> tuple[dict[str, Any], dict[str, Any]]:
    """Head and arrays of the file of a table, with every sixth knot."""
    rows, columns = np.arange(0, 26, 5), np.arange(0, 31, 5)
    coefficients = content.coefficients[:, :, rows][..., columns].astype(np.float32)
    arrays = {
        "advance": content.advance[rows],
        "beta": content.beta[columns],
        "omega": content.omega,
        "speed": content.speed,
        "coefficients": coefficients,
        "cells": np.zeros((5, 6), np.uint8),
        "deviations": 0.01 * np.abs(coefficients),
    }
    head = {"format": FORMAT, "format_version": FORMAT_VERSION, "certificate": CERTIFICATE}
    return json.loads(json.dumps({**content.info, **head})), arrays


@contextlib.contextmanager
def quietly() -> Iterator[None]:
    """Without NumPy's warnings on numbers that no table has."""
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@quietly()
def forge(path: Path, head: dict[str, Any], arrays: dict[str, Any]) -> None:
    """Write a table with the checksum of its contents, if these have one."""
    flat = {n: np.ravel(a) if n in ("advance", "beta", "omega", "speed") else a
            for n, a in arrays.items()}  # fmt: skip
    # Without arrays or numbers there is no checksum.
    with contextlib.suppress(Exception):
        digest = TableContent.sha256.fget(SimpleNamespace(**{"deviations": None, **flat}))  # type: ignore[attr-defined]
        head = {"sha256": digest, **head}
    np.savez(path, info=np.array(json.dumps(head)), **arrays)


def exchanged(coefficients: np.ndarray, one: int, other: int) -> np.ndarray:
    order = np.arange(len(LOADS))
    order[[one, other]] = other, one
    return coefficients[:, order]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda h, _: h.update(format_version=FORMAT_VERSION + 1), "format version"),
        (lambda h, _: h.update(format="other"), "format is 'other'"),
        (lambda h, _: h.update(loads=["thrust", "lift"]), "this propmap has thrust, drag"),
        (lambda h, _: h.update(sha256="0"), "do not match the checksum"),
        (lambda h, _: h.pop("air"), "air.density_kg_m3"),
        (lambda h, _: h["propeller"].update(radius_m=-1.0), "radius is -1.0"),
        (lambda h, _: h["propeller"].update(radius_m=100.0), "advance is 0 to 0.435275, but"),
        (lambda _, a: a.update(speed=3.6 * a["speed"]), "radius allow 0 to 1.56699"),
        (lambda h, _: h.update(certificate={"points": 1}), "certificate: tolerance is missing"),
        (lambda h, _: h["certificate"].update(points=np.nan), "points is missing or not a finite"),
        (lambda h, _: h["certificate"].update(points=-1), "points is missing or not a finite"),
        (lambda h, _: h["certificate"].update(tolerance=1e-4), "the errors exceed the tolerance"),
        (lambda _, a: a.pop("beta"), "has no beta"),
        (lambda _, a: a.update(beta=a["beta"][::-1]), "do not increase"),
        (lambda _, a: a.update(beta=np.degrees(a["beta"])), "between 0 and pi"),
        (lambda _, a: a.update(beta=a["beta"][:-1]), "shape"),
        (lambda _, a: a.update(omega=a["omega"] - 500.0), "must not include 0"),
        (lambda _, a: a.update(coefficients=a["coefficients"] * np.float32(1e3)), "too large"),
        (lambda _, a: a["coefficients"][0, 1].fill(np.nan), "some loads, but not all"),
        (lambda _, a: a.update(deviations=a["deviations"] / np.float32(0)), "infinite"),
        (lambda _, a: a.update(coefficients=exchanged(a["coefficients"], 0, 1)), "in-plane load"),
        (lambda _, a: a["cells"].fill(255), "a cell has the flags 255"),
        (lambda _, a: a.update(cells=a["cells"] + np.uint16(256)), "wrong type (uint16)"),
    ],
)
def test_a_forged_table_is_refused(
    invented: LoadTable, tmp_path: Path, change: Any, message: str
) -> None:
    head, arrays = parts_of(invented.content)
    with quietly():
        change(head, arrays)
    forge(tmp_path / "map.npz", head, arrays)
    assert message in _refusal(tmp_path / "map.npz")


JSON = st.sampled_from([None, True, -1, 0, 1.5, 10**400, np.nan, np.inf, "x", [], {}, [[0.1]]])
UNITS = st.sampled_from([1e-3, 0.0254, np.pi / 180.0, np.pi / 30.0, 0.3048, 3.6, 60.0, 1e3, -1.0])
NUMBERS = st.sampled_from([np.nan, np.inf, -np.inf, -1.0, 0.0, 0.3, 1e-320, 1e300]) | st.floats()
TYPES = st.sampled_from(["f2", "f4", ">f8", "i8", "u2", "c16", "?", "U3", "M8[s]"])


@st.composite
@quietly()
def forgeries(draw: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Change entries of the head, and numbers, shapes, types, units and order of the arrays."""
    head, arrays = parts_of(invented_content())
    for _ in range(draw(st.integers(1, 2))):
        if draw(st.booleans()):
            at = head
            while isinstance(at[key := draw(st.sampled_from(sorted(at)))], dict) and at[key]:
                if draw(st.integers(0, 3)) == 0:
                    break
                at = at[key]
            old = at[key]
            scaled = isinstance(old, float) and draw(st.booleans())
            at[key] = old * draw(UNITS) if scaled else draw(JSON)
            continue
        name = draw(st.sampled_from(sorted(arrays)))
        array = np.array(arrays[name])
        kind = draw(st.sampled_from(["number", "shape", "type", "unit", "order", "loads"]))
        if kind == "number" and array.size and array.dtype.kind == "f":
            array.flat[draw(st.integers(0, array.size - 1))] = draw(NUMBERS)
        elif kind == "shape":
            shape = tuple(draw(st.lists(st.integers(0, 7), max_size=4)))
            array = np.resize(array, shape)
        elif kind == "type":
            array = array.astype(draw(TYPES))
        elif kind == "unit" and array.dtype.kind == "f":
            array = (array * draw(UNITS)).astype(array.dtype)
        elif kind == "order" and array.ndim:
            array = np.flip(array, draw(st.integers(0, array.ndim - 1)))
        elif name == "coefficients" and array.shape[1:2] == (len(LOADS),):
            array = exchanged(array, *draw(st.tuples(*2 * [st.integers(0, len(LOADS) - 1)])))
        arrays[name] = array
    return head, arrays


@pytest.mark.slow
def test_a_thousand_forged_tables_are_refused_or_right(tmp_path: Path) -> None:
    """A table that opens has the loads of its knots, inside axes that its envelope determines."""
    path, found = tmp_path / "map.npz", {"refused": 0, "right": 0}

    @settings(max_examples=1000, deadline=None, derandomize=True, database=None)
    @given(forgeries())
    def refused_or_right(parts: tuple[dict[str, Any], dict[str, Any]]) -> None:
        head, arrays = parts
        forge(path, head, arrays)
        try:
            table = LoadTable.load(path)
        except propmap.InputError as error:
            assert "\n" not in str(error) and path.name in str(error)
            found["refused"] += 1
            return
        found["right"] += 1
        radius, density = head["propeller"]["radius_m"], head["air"]["density_kg_m3"]
        assert radius > 0.0 and density > 0.0 and repr(table)
        advance, beta, (slow, fast) = arrays["advance"], arrays["beta"], arrays["omega"]
        assert advance[-1] == pytest.approx(arrays["speed"][1] / (slow * radius), rel=1e-5)
        omega, j, b = (x.ravel() for x in np.meshgrid([slow, fast], advance, beta, indexing="ij"))
        speed = j * omega * radius
        loads = table.loads(omega, speed, b)
        flown = (speed >= arrays["speed"][0]) & (speed <= arrays["speed"][1])
        # A knot without a value leaves no value at its neighbors either, and a status says so.
        lost = np.isnan(loads.thrust)
        assert set(loads.status[lost]) <= {"no_value", "outside"} and loads.inside[flown].all()
        known = arrays["coefficients"].transpose(0, 2, 3, 1).reshape(-1, len(LOADS))
        assert lost[flown & np.isnan(known[:, 0])].all() and lost.mean() < 0.9
        for load, coefficient in zip(LOADS.values(), known.T, strict=True):
            scale = density * np.pi * radius ** (4 + load.moment) * omega**2
            got, want = getattr(loads, load.name), coefficient.astype(np.float64) * scale
            assert (np.isnan(got) == lost).all()
            np.testing.assert_allclose(
                got[~lost], want[~lost], rtol=1e-6, atol=1e-9 * omega.max() ** 2
            )

    refused_or_right()
    assert min(found.values()) > 50, found


def test_a_certificate_needs_the_place_of_every_largest_error(
    invented: LoadTable, tmp_path: Path
) -> None:
    head, arrays = parts_of(invented.content)
    path = tmp_path / "map.npz"
    backward = {**CERTIFICATE, "max_omega": dict.fromkeys(LOADS, -1.0)}
    for certificate in (CERTIFICATE, backward):
        forge(path, {**head, "certificate": certificate}, arrays)
        assert LoadTable.load(path).certificate == certificate
    forge(path, {**head, "certificate": {**CERTIFICATE, "max_omega": {"thrust": 1.0}}}, arrays)
    assert "max_omega is missing or" in _refusal(path)


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
