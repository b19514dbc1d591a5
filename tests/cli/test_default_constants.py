"""Without --airfoil a propeller has the constants that are known for it, and a note says which."""

from __future__ import annotations

import functools
import json
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.catalogue.expected import expected_constants, size_of
from propmap.catalogue.identified import LIFT_LAW, all_identified, identified, one_of_each
from propmap.catalogue.lookup import meant_by
from propmap.table import LoadTable, build_table

from .conftest import POINT, Run

BLADE = "radius_mm,chord_mm,twist_deg\n20,18,35\n50,20,22\n80,16,15\n100,8,12\n"


def thrust_with(prop: str, law: propmap.Airfoil) -> float:
    blade = propmap.propeller(prop, blades=2)
    model = propmap.Model(blade, law, corrections=propmap.corrections_of("recommended"))
    loads = propmap.Rotor(model).loads(4000.0 * np.pi / 30.0, 14.0, np.radians(80.0))
    return float(loads.thrust)


@pytest.mark.parametrize("prop", ["apc-8x6e", "APC 8x6E", "kyosho 11x9"])
def test_identified_constants(run: Run, prop: str) -> None:
    name = propmap.propeller(prop).name
    found = identified(name, 2)
    assert found is not None
    done = run("predict", prop, *POINT, "--format", "json")
    assert done.code == 0 and done.err.count("\n") == 1
    assert done.err.startswith(f"note: constants identified from {found.rows} rows of ")
    wanted = pytest.approx(thrust_with(name, found.airfoil), rel=1e-9)
    assert json.loads(done.out)["thrust_N"] == wanted
    assert f"airfoil {name} identified + pitt-peters" in run("predict", prop, *POINT).out


def test_constants_of_the_family(run: Run) -> None:
    blade = propmap.propeller("apc-8x6sf")
    size = size_of(meant_by("apc-8x6sf"), blade)
    assert size == pytest.approx((8 * 0.0254, 6 * 0.0254))
    law = expected_constants("apcsf", size, "maker").airfoil
    done = run("predict", "apc-8x6sf", *POINT, "--format", "json")
    assert done.code == 0 and done.err.count("\n") == 1
    assert "propellers of its family, apcsf" in done.err
    wanted = pytest.approx(thrust_with("apc-8x6sf", law), rel=1e-9)
    assert json.loads(done.out)["thrust_N"] == wanted


def test_constants_of_any_propeller(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    path.write_text(BLADE)
    done = run("predict", path, "--blades", "2", *POINT, "--format", "json")
    assert done.code == 0
    assert "small propellers, none of its family" in done.err
    blade = propmap.propeller(str(path), blades=2)
    law = expected_constants(size=size_of(None, blade)).airfoil
    wanted = pytest.approx(thrust_with(str(path), law), rel=1e-9)
    assert json.loads(done.out)["thrust_N"] == wanted


def test_a_law_that_is_named_is_used_without_a_note(run: Run) -> None:
    assert run("predict", "apc-8x6e", "--airfoil", "paper-apc", *POINT).err == ""


def test_expected_constants_lie_among_those_of_their_propellers() -> None:
    every = all_identified()
    for family in ("apcsf", "grcp", None):
        law, told, *_ = expected_constants(family)
        members = [one for one in every if family in (None, one.family)]
        members = one_of_each(members) if family else members
        assert f"{len(members)} " in told
        for name in ("c_l1", "c_d", "alpha_0", "zero_lift_angle", "c_d0"):
            values = [getattr(one.airfoil, name) for one in members]
            spread = max(values) - min(values)
            own = getattr(law, name)
            assert min(values) - spread < own < max(values) + spread, (family, name)
        assert law.lift_law == LIFT_LAW


@pytest.mark.slow
def test_a_table_by_name_tells_how_uncertain_its_constants_are(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    brief = functools.partial(build_table, certificate_points=512)
    monkeypatch.setattr("propmap.table.build.build_table", brief)
    envelope = ["--rpm", "5000:5400", "--speed", "2:4", "--beta", "75:90", "--tolerance", "5%"]
    path = tmp_path / "x.npz"
    done = run("table", "apc-8x6e", *envelope, "-o", path)
    assert done.code == 0, done.err
    assert "covariance of c_l1, c_l2, c_d, alpha_0, zero_lift_angle, c_d0" in done.out
    info = LoadTable.load(path).info
    assert info["airfoil"]["name"] == "apc-8x6e identified"
    assert info["airfoil_covariance"]["names"][0] == "c_l1"
