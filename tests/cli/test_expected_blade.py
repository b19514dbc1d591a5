"""A propeller that was not measured is predicted by its designation, and a note says so."""

from __future__ import annotations

import json

import numpy as np
import pytest

import propmap
from propmap.catalogue.expected import ExpectedBlade, expected_constants, size_of
from propmap.catalogue.lookup import designated

from .conftest import Run


@pytest.mark.parametrize(
    ("prop", "family", "blades", "said"),
    [
        ("5x4.3x3", None, 3, "no maker is named: the geometry is the mean of 123 propellers of 27"),
        (
            "APC 12x6.5E",
            "apce",
            2,
            "no measured blade of this size: the geometry is the mean of 13",
        ),
    ],
)
def test_predict(run: Run, prop: str, family: str | None, blades: int, said: str) -> None:
    point = ["--rpm", "20000", "--speed", "15", "--beta", "80"]
    if family:
        point[1] = "6000"
    done = run("predict", prop, *point, "--format", "json")
    assert done.code == 0
    assert done.err.startswith(f"note: {said}") and done.err.count("\n") == 1
    blade, meant = propmap.propeller(prop), designated(prop)
    assert isinstance(meant, ExpectedBlade) and meant.family == family
    law = expected_constants(family, size_of(meant, blade), meant.geometry).airfoil
    assert blade.blades == blades
    model = propmap.Model(blade, law, corrections=propmap.corrections_of("recommended"))
    loads = propmap.Rotor(model).loads(float(point[1]) * np.pi / 30.0, 15.0, np.radians(80.0))
    assert json.loads(done.out)["thrust_N"] == pytest.approx(float(loads.thrust), rel=1e-9)


def test_props_show(run: Run) -> None:
    done = run("props", "show", "HQ 5x4.3x3")
    assert done.code == 0
    assert "HQ 5x4.3x3: 3 blades" in done.out and "source: not measured" in done.out
    assert "hq names no series known here" in done.err


@pytest.mark.parametrize("prop", ["0x5", "5x", "abc"])
def test_nonsense_is_one_line(run: Run, prop: str) -> None:
    done = run("predict", prop, "--rpm", "6000", "--speed", "5", "--beta", "90")
    assert done.code != 0 and done.out == ""
    assert "did you mean" in done.err and done.err.count("\n") == 1
