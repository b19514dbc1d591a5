"""A propeller that was not measured is predicted by its designation, and a note says so."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.catalogue.expected import ExpectedBlade, expected_constants, size_of
from propmap.catalogue.lookup import designated

from .conftest import Run


@pytest.mark.parametrize(
    ("prop", "family", "blades", "said"),
    [
        (
            "5x4.3x3",
            None,
            3,
            "read as 5 x 4.3 in, 3 blades; no manufacturer is named: the geometry is the mean of "
            "123 propellers of 27",
        ),
        (
            "APC 12x6.5E",
            "apce",
            2,
            "read as 12 x 6.5 in, two blades assumed (--blades 3, or x3 at the end, for three); no "
            "measured blade of this size: the geometry is the mean of 13",
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
    assert "read as 5 x 4.3 in, 3 blades; no blade of HQProp was measured" in done.err


def test_a_file_with_a_number_of_blades_in_its_title(run: Run, tmp_path: Path) -> None:
    path, rows = (
        tmp_path / "blade.csv",
        "0.01,0.01,30\n0.03,0.013,20\n0.05,0.012,16\n0.0635,0.006,12\n",
    )
    path.write_text(f"# name: HQ 5x4.3x3\nradius_m,chord_m,twist_deg\n{rows}")
    point = ["predict", str(path), "--rpm", "9000", "--speed", "0", "--beta", "0"]
    assert "note: 3 blades, from the title of the file\n" in run(*point).err
    said = run(*point, "--blades", "2").err
    assert "note: the title states 3 blades; 2 are used, from --blades\n" in said
    assert "title" not in run(*point, "--blades", "3").err
    path.write_text("# blades: 2\n" + path.read_text())
    done = run(*point)
    assert "note: the title states 3 blades; 2 are used, from the data of the file\n" in done.err
    assert "HQ 5x4.3x3, 2 blades" in done.out


@pytest.mark.parametrize("prop", ["0x5", "5x", "abc"])
def test_nonsense_is_one_line(run: Run, prop: str) -> None:
    done = run("predict", prop, "--rpm", "6000", "--speed", "5", "--beta", "90")
    assert done.code != 0 and done.out == ""
    assert "did you mean" in done.err and done.err.count("\n") == 1
