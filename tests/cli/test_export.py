"""`propmap export`: from a table or a fit to files, and one-line errors."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.aircraft.trim import Aircraft
from propmap.export import TARGETS
from propmap.model.corrections import Installed
from propmap.table import LoadTable, build_table
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
    names = ("invented_gz.sdf", "invented_gazebo_classic.sdf", "README-gazebo.txt")
    assert done.out.splitlines() == [f"wrote sim/{name}" for name in names]
    again = run("export", "map.npz", "--to", "gazebo", "-o", "sim")
    assert again.code == 2 and "--force" in again.err
    assert run("export", "map.npz", "--to", "gazebo", "-o", "sim", "--force").code == 0
    unnumbered = run("export", "map.npz", "--to", "gazebo", "-o", "no", "--link", "front")
    refused(unnumbered, "link name 'front' does not contain {}", "rotor_{}")


COARSE = {"tolerance": 0.1, "certificate_points": 64}
Calls = list[tuple[propmap.Rotor, dict[str, Any]]]


@pytest.fixture
def built(monkeypatch: pytest.MonkeyPatch) -> Calls:
    """Rotors and ranges of the tables that commands build; coarse tables up to 7 m/s."""
    calls: Calls = []

    def coarse(rotor: propmap.Rotor, **named: Any) -> LoadTable:
        calls.append((rotor, named))
        return build_table(rotor, **named | COARSE | {"speed": (0.0, 7.0)})

    monkeypatch.setattr("propmap.export.built_tables.build_table", coarse)
    return calls


def test_a_parameter_set_with_a_propeller_and_a_fit_with_its_own(
    run: Run, tmp_path: Path, built: Calls
) -> None:
    (tmp_path / "law.toml").write_text(propmap.airfoil("paper-apc").to_toml())
    done = run("export", "law.toml", "--prop", "apc-8x6e", "--to", "npz", "-o", "to")
    assert done.code == 0
    assert done.err.startswith(
        "building a table of apc-8x6e, paper-apc + pitt-peters + radial-friction, at 4605 to"
    )
    (tmp_path / "fit.toml").write_text(fit_text(air=propmap.Air(1.1)))
    assert run("export", "fit.toml", "--to", "csv", "-o", "to").code == 0
    (rotor, named), (fitted, _) = built
    assert rotor.model.propeller.name == "apc-8x6e" and rotor.model.airfoil.name == "paper-apc"
    assert named["speed"] == (0.0, 20.0) and named["beta"] == (0.0, np.pi)
    assert np.array(named["omega"]) * 0.1016 == pytest.approx([49.0, 105.0])
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
    refused(run(*again), "README-ardupilot.md: the file exists")  # before any computation
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


def test_the_name_of_a_propeller_goes_to_every_target_of_a_table(
    run: Run, monkeypatch: pytest.MonkeyPatch, built: Calls
) -> None:
    assert run("export", "DJI 9450", "--to", "npz", "-o", "npz").code == 0
    ((rotor, _),) = built
    assert rotor.model.propeller.name == "DJI 9450"
    assert rotor.model.correction_of(Installed) is not None
    found = LoadTable.load("npz/dji_9450.npz")
    monkeypatch.setattr("propmap.export.built_tables.build_table", lambda *_, **__: found)
    for target in set(TARGETS) - {"npz"}:
        done = run("export", "DJI 9450", "--to", target, "-o", target)
        assert done.code == 0 and f"wrote {target}/" in done.out
        assert "building a table of DJI 9450" in done.err
        assert "s: errors at most" in done.err and "at 64 points" in done.err


@pytest.mark.slow
def test_the_table_of_a_vehicle_covers_hover_and_the_top_speed(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("quad.toml").write_text(QUAD)
    built: Calls = []

    def record(rotor: propmap.Rotor, **named: Any) -> LoadTable:
        built.append((rotor, named))
        return build_table(rotor, **named | COARSE)

    monkeypatch.setattr("propmap.export.built_tables.build_table", record)
    done = run("export", "quad.toml", "--to", "npz", "-o", "to")
    assert done.code == 0 and "rotors in each other's wakes" in done.err
    ((_, named),) = built
    (path,) = Path("to").glob("*.npz")
    craft = Aircraft(propmap.read_vehicle("quad.toml").vehicle, LoadTable.load(path))
    speeds = np.array([0.0, 0.5, 0.9]) * named["speed"][1]
    states = craft.steady(speeds, margin=False)
    assert states.found.all()
    low, high = named["omega"]
    hover = states.rotor_speed[0].mean()
    assert low < 0.75 * hover and high == pytest.approx(1.5 * hover, rel=0.02)
    # At the top speed the rotors turn at their largest speed.
    assert states.rotor_speed[-1].max() == pytest.approx(high, rel=0.03)
    # Twice the weight can be lifted.
    assert (high / hover) ** 2 > 2.0


def test_a_mount_is_part_of_the_built_table_and_of_the_cpp_header(run: Run, built: Calls) -> None:
    Path("quad.toml").write_text(QUAD + "[mount]\narea = 0.0015\n")
    assert run("export", "quad.toml", "--to", "gazebo", "-o", "gz").code == 0
    ((rotor, _),) = built
    assert rotor.model.correction_of(Installed).area_m2 == 0.0015
    assert run("export", "quad.toml", "--to", "cpp", "-o", "cpp").code == 0
    assert "rotor.mount_area = 0.0015" in Path("cpp/apc_8x6e.hpp").read_text()
    Path("quad.toml").write_text(QUAD + "[mount]\narea = [0.001, 0.002, 0.001, 0.002]\n")
    refused(run("export", "quad.toml", "--to", "gazebo", "-o", "no"), "different areas in [mount]")
    assert not Path("no").exists()


MISSPELLED = {"blade.csv": "cpp", "maap.npz": "csv", "quadd.toml": "jsbsim", "no/apc-8x6e": "c"}


@pytest.mark.parametrize("name", MISSPELLED)
def test_a_misspelled_file_is_no_propeller(run: Run, name: str) -> None:
    refused(run("export", name, "--to", MISSPELLED[name], "-o", "to"), f"{name}: no such file")
    assert not Path("to").exists()
