"""The blade object: its defaults, its checks, and finding one by name."""

from __future__ import annotations

import pickle
from dataclasses import FrozenInstanceError
from typing import Any

import numpy as np
import pytest

from propmap.catalogue.lookup import propeller
from propmap.errors import InputError
from propmap.model.propeller import Propeller

GOOD: dict[str, Any] = {
    "name": "p",
    "blades": 2,
    "station": [0.02, 0.04, 0.07, 0.1],
    "chord": [0.01, 0.02, 0.02, 0.0],
    "twist": [0.6, 0.4, 0.3, 0.2],
}


def test_radius_root_and_diameter() -> None:
    blade = Propeller(**GOOD)
    assert (blade.radius, blade.diameter, blade.root) == (0.1, 0.2, 0.02)
    assert blade.with_root_cutout(0.03).root == 0.03
    assert blade.root_cutout is None


def test_arrays_are_read_only_copies() -> None:
    station = np.array(GOOD["station"])
    blade = Propeller(**{**GOOD, "station": station})
    station[0] = 5.0
    assert blade.station[0] == 0.02
    assert blade.chord.dtype == np.float64
    with pytest.raises(ValueError, match="read-only"):
        blade.chord[0] = 1.0
    with pytest.raises(FrozenInstanceError):
        blade.blades = 3  # type: ignore[misc]


def test_equal_blades_are_equal_and_hash_alike() -> None:
    assert Propeller(**GOOD) == Propeller(**GOOD)
    assert hash(Propeller(**GOOD)) == hash(Propeller(**GOOD))
    for field, value in {
        "name": "q",
        "blades": 3,
        "chord": [0.01, 0.02, 0.021, 0.0],
        "root_cutout": 0.03,
    }.items():
        assert Propeller(**{**GOOD, field: value}) != Propeller(**GOOD)
    assert Propeller(**GOOD) != "p"
    assert pickle.loads(pickle.dumps(Propeller(**GOOD))) == Propeller(**GOOD)


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("station", [0.02, 0.04, np.nan, 0.1], ["station 2", "finite"]),
        ("station", [[0.02, 0.04], [0.07, 0.1]], ["one length"]),
        ("station", [20.0, 40.0, 70.0, 100.0], ["at most 20 m", "check the units"]),
        ("chord", [0.01, 0.2, 0.02, 0.0], ["station 1", "units"]),
        ("twist", [35.0, 30.0, 20.0, 10.0], ["station 0", "looks like degrees", "twist_deg"]),
        ("blades", 2.0, ["whole number"]),
        ("root_cutout", 0.01, ["between 0.02 m", "first station"]),
    ],
)
def test_impossible_blades(field: str, value: object, words: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        Propeller(**{**GOOD, field: value})
    assert str(caught.value).isprintable()
    for word in words:
        assert word in str(caught.value)


def test_error_keeps_its_parts_and_survives_pickling() -> None:
    error = InputError("found x, expected y", "do z", "file")
    assert str(error) == "file: found x, expected y; do z"
    assert (error.found, error.remedy, error.where) == ("found x, expected y", "do z", "file")
    copy = pickle.loads(pickle.dumps(error))
    assert (str(copy), copy.remedy) == (str(error), "do z")


def test_a_catalogue_name_in_any_case() -> None:
    assert propeller("APC-8x6E") == propeller("apc-8x6e")
    changed = propeller("apc-8x6e", blades=3, root_cutout=0.03, radius=0.1016)
    assert (changed.blades, changed.root) == (3, 0.03)
    with pytest.raises(InputError, match="omit the radius"):
        propeller("apc-8x6e", radius=0.2)
    with pytest.raises(InputError) as caught:
        propeller("")
    assert str(caught.value).isprintable()
