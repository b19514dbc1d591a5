"""`propmap export`: from a table or a fit to files, and one-line errors."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.table import LoadTable
from tests.export.test_vehicle_export import TEXT
from tests.fit.fit_records import fit_text

from .conftest import Run, refused
from .invented_tables import invented

QUAD = TEXT.replace("blade.csv", "apc-8x6e")
DELIVERY = Path(__file__).parents[2] / "examples" / "aircraft" / "delivery.toml"


@pytest.fixture(autouse=True)
def _map(tmp_path: Path) -> None:
    invented().save(tmp_path / "map.npz")


def test_a_table_is_exported(run: Run) -> None:
    done = run("export", "map.npz", "--to", "gazebo", "-o", "sim")
    assert (done.code, done.err) == (0, "")
    assert done.out == "wrote sim/invented_motor.sdf\nwrote sim/README-gazebo.txt\n"
    again = run("export", "map.npz", "--to", "gazebo", "-o", "sim")
    assert again.code == 2 and "--force" in again.err
    assert run("export", "map.npz", "--to", "gazebo", "-o", "sim", "--force").code == 0


def test_a_parameter_set_with_a_propeller_and_a_fit_with_its_own(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[tuple[propmap.Rotor, dict[str, Any]]] = []

    def record(rotor: propmap.Rotor, **named: Any) -> LoadTable:
        calls.append((rotor, named))
        return invented()

    monkeypatch.setattr("propmap.table.build.build_table", record)
    (tmp_path / "law.toml").write_text(propmap.airfoil("paper-apc").to_toml())
    done = run("export", "law.toml", "--prop", "apc-8x6e", "--to", "npz", "-o", "to")
    assert done.code == 0
    assert done.err.startswith(
        "building a table of apc-8x6e, paper-apc + pitt-peters + radial-friction, at 1880 to"
    )
    (tmp_path / "fit.toml").write_text(fit_text(air=propmap.Air(1.1)))
    assert run("export", "fit.toml", "--to", "csv", "-o", "to").code == 0
    (rotor, named), (fitted, _) = calls
    assert rotor.model.propeller.name == "apc-8x6e" and rotor.model.airfoil.name == "paper-apc"
    assert named["speed"] == (0.0, 20.0) and named["beta"] == (0.0, np.pi)
    assert (fitted.model.propeller.name, fitted.model.air.density) == ("apc-8x6e", 1.1)
    assert {"README-csv.txt", "README-npz.txt"} < {p.name for p in (tmp_path / "to").iterdir()}


def test_a_table_without_hover_is_refused_in_one_line(run: Run) -> None:
    content = invented().content
    LoadTable(replace(content, speed=np.array([2.0, 8.0]))).save("fast.npz")
    done = run("export", "fast.npz", "--to", "gazebo", "-o", "to")
    refused(done, "fast.npz: the table has no loads at rest, its speed begins at 2 m/s")
    refused(done, "build the table with --speed 0:...")
    assert not Path("to").exists()


def test_a_vehicle_goes_into_an_autopilot(run: Run, tmp_path: Path) -> None:
    shutil.copy(DELIVERY, tmp_path / "quad.toml")
    asked = ["--airfoil", "paper-apc", "--speed", "3:9:2"]
    done = run("export", "quad.toml", "--to", "ardupilot", "-o", "ap", *asked)
    assert done.code == 0 and done.err.count("\n") == 2 and "bare rotors" in done.err
    assert "wrote ap/delivery_quadcopter_ardupilot.param\n" in done.out
    note = (tmp_path / "ap" / "README-ardupilot.md").read_text()
    assert "rotors: paper-apc + pitt-peters + radial-friction" in note
    assert "| 3 |" in note and "| 9 |" in note and "battery at 100%" in note
    again = ["export", "quad.toml", "--to", "ardupilot", "-o", "ap", *asked, "--charge", "0.5"]
    assert "--force" in run(*again).err
    mounted = ["--model", "paper", "--correction", "installed:factor=1,area_m2=0.001"]
    done = run(*again, "--force", *mounted)
    assert done.code == 0 and "installed rotors (installed:factor=1" in done.err
    changed = (tmp_path / "ap" / "README-ardupilot.md").read_text()
    assert "rotors: paper-apc + installed" in changed and "battery at 50%" in changed


@pytest.mark.parametrize("target", ["c", "mujoco"])
def test_a_broken_vehicle_is_told_by_its_reader(run: Run, target: str) -> None:
    Path("bad.toml").write_text(QUAD.replace("[[rotors]]", "[[rotor]]"))
    for name, message in (("bad.toml", "'rotor'"), ("absent.toml", "no such file")):
        done = run("export", name, "--table", "map.npz", "--to", target, "-o", "to")
        refused(done, name, message)
        assert done.err == run("trim", name).err


def test_a_propeller_goes_to_cpp(run: Run) -> None:
    done = run("export", "APC 8x6E", "--to", "cpp", "-o", "cpp", "--model", "paper")
    assert done.code == 0 and Path("cpp/apc_8x6e.hpp").exists()
