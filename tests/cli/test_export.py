"""`propmap export`: from a table or a fit to files, and one-line errors."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.export import EXPORTS
from propmap.table import LoadTable
from tests.export.test_vehicle_export import TEXT
from tests.fit.fit_records import fit_text

from .conftest import Run
from .invented_tables import invented

QUAD = TEXT.replace("blade.csv", "apc-8x6e")
DELIVERY = Path(__file__).parents[2] / "examples" / "aircraft" / "delivery.toml"


@pytest.fixture(autouse=True)
def _map(tmp_path: Path) -> None:
    invented().save(tmp_path / "map.npz")


@pytest.fixture
def built(monkeypatch: pytest.MonkeyPatch) -> list[tuple[propmap.Rotor, dict[str, Any]]]:
    """What would be built; the invented table comes instead."""
    calls = []

    def record(rotor: propmap.Rotor, **named: Any) -> LoadTable:
        calls.append((rotor, named))
        return invented()

    monkeypatch.setattr("propmap.table.build.build_table", record)
    return calls


def test_a_table_is_exported(run: Run, tmp_path: Path) -> None:
    done = run("export", "map.npz", "--to", "gazebo", "-o", "sim")
    assert (done.code, done.err) == (0, "")
    assert done.out == "wrote sim/invented_motor.sdf\nwrote sim/README-gazebo.txt\n"
    assert sorted(p.name for p in (tmp_path / "sim").iterdir()) == [
        "README-gazebo.txt",
        "invented_motor.sdf",
    ]
    again = run("export", "map.npz", "--to", "gazebo", "-o", "sim")
    assert again.code == 2 and "--force" in again.err
    assert run("export", "map.npz", "--to", "gazebo", "-o", "sim", "--force").code == 0


def test_help_lists_every_export(run: Run) -> None:
    told = " ".join(run("export", "--help").out.split())
    assert all(f"{export.target} ({export.writes})" in told for export in EXPORTS)


def test_a_parameter_set_with_a_propeller(
    run: Run, tmp_path: Path, built: list[tuple[propmap.Rotor, dict[str, Any]]]
) -> None:
    (tmp_path / "law.toml").write_text(propmap.airfoil("paper-apc").to_toml())
    done = run("export", "law.toml", "--prop", "apc-8x6e", "--to", "npz", "-o", "to")
    assert done.code == 0
    assert done.err.startswith(
        "building a table of apc-8x6e, paper-apc + pitt-peters + radial-friction, at 1880 to"
    )
    ((rotor, named),) = built
    assert rotor.model.propeller.name == "apc-8x6e" and rotor.model.airfoil.name == "paper-apc"
    assert named["speed"] == (0.0, 20.0) and named["beta"] == (0.0, np.pi)


def test_a_fit_brings_its_propeller_and_air(
    run: Run, tmp_path: Path, built: list[tuple[propmap.Rotor, dict[str, Any]]]
) -> None:
    (tmp_path / "fit.toml").write_text(fit_text(air=propmap.Air(1.1)))
    assert run("export", "fit.toml", "--to", "csv", "-o", "to").code == 0
    ((rotor, _),) = built
    assert (rotor.model.propeller.name, rotor.model.air.density) == ("apc-8x6e", 1.1)
    assert (tmp_path / "to" / "README-csv.txt").exists()


@pytest.mark.parametrize("target", ["multinomial", "gazebo", "rotorpy", "jsbsim"])
def test_a_table_without_hover_is_refused_in_one_line(
    run: Run, tmp_path: Path, target: str
) -> None:
    content = invented().content
    LoadTable(replace(content, speed=np.array([2.0, 8.0]))).save("fast.npz")
    done = run("export", "fast.npz", "--to", target, "-o", "to")
    assert done.code == 2
    assert done.err == (
        "propmap: error: fast.npz: the table has no loads at rest, its speed begins at 2 m/s; this "
        "target's model needs hover: build the table with --speed 0:...\n"
    )
    assert not (tmp_path / "to").exists()


def test_a_vehicle_goes_into_an_autopilot(run: Run, tmp_path: Path) -> None:
    shutil.copy(DELIVERY, tmp_path / "quad.toml")
    asked = ["--airfoil", "paper-apc", "--speed", "3:9:2"]
    done = run("export", "quad.toml", "--to", "ardupilot", "-o", "ap", *asked)
    assert done.code == 0 and done.err.count("\n") == 2 and "bare rotors" in done.err
    assert done.out == (
        "wrote ap/delivery_quadcopter_ardupilot.param\nwrote ap/README-ardupilot.md\n"
    )
    note = (tmp_path / "ap" / "README-ardupilot.md").read_text()
    assert (
        "rotors: paper-apc + pitt-peters + radial-friction" in note
        and "standard deviations: none" in note
    )
    assert "| 3 |" in note and "| 9 |" in note and "battery at 100%" in note
    again = ["export", "quad.toml", "--to", "ardupilot", "-o", "ap", *asked, "--charge", "0.5"]
    assert "--force" in run(*again).err
    mounted = ["--model", "paper", "--correction", "installed:factor=1,area_m2=0.001"]
    done = run(*again, "--force", *mounted)
    assert done.code == 0 and "installed rotors (installed:factor=1" in done.err
    changed = (tmp_path / "ap" / "README-ardupilot.md").read_text()
    assert "rotors: paper-apc + installed" in changed and "battery at 50%" in changed


@pytest.mark.parametrize("target", ["c", "rotorpy", "mujoco"])
@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "no such file"),
        ("schema = ", "TOML"),
        (QUAD.replace("[[rotors]]", "[[rotor]]"), "'rotor'"),
        (QUAD[: QUAD.index("[[rotors]]")], "rotors"),
    ],
    ids=["absent", "no TOML", "misspelt", "without rotors"],
)
def test_a_broken_vehicle_is_told_by_its_reader(
    run: Run, tmp_path: Path, target: str, text: str | None, message: str
) -> None:
    if text is not None:
        (tmp_path / "bad.toml").write_text(text)
    done = run("export", "bad.toml", "--table", "map.npz", "--to", target, "-o", "to")
    assert done.code == 2 and done.err.count("\n") == 1
    assert done.err == run("trim", "bad.toml").err
    assert "bad.toml" in done.err and message in done.err and "leave it out" not in done.err


def test_mujoco_takes_a_vehicle_alone(run: Run) -> None:
    assert "no such file" in run("export", "absent.toml", "--to", "mujoco", "-o", "to").err
    assert (
        "mujoco is not made from a table"
        in run("export", "map.npz", "--to", "mujoco", "-o", "to").err
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["map.npz", "--to", "px4", "-o", "to"], "--to px4 needs a vehicle file"),
        (["absent.toml", "--to", "px4", "-o", "to"], "no such file"),
        (["law.toml", "--to", "ardupilot", "-o", "to"], "law.toml"),
        (["quad.toml", "--to", "px4", "--prop", "apc-8x6e", "-o", "to"], "leave it out"),
        (["quad.toml", "--to", "px4", "--table", "map.npz", "-o", "to"], "the table is for"),
        (["quad.toml", "--to", "px4", "--speed", "3,x", "-o", "to"], "--speed '3,x'"),
        (["map.npz", "--to", "c", "--speed", "3,4", "-o", "to"], "--speed does not apply"),
        (["map.npz", "--to", "csv", "--charge", "0", "-o", "to"], "--charge does not apply"),
        (["map.npz", "--to", "ros", "-o", "to"], "no target 'ros'"),
        (["absent.npz", "--to", "c", "-o", "to"], "no such file"),
        (["absent.toml", "--to", "c", "-o", "to"], "no such file"),
        (["bad.npz", "--to", "c", "-o", "to"], "not a table, or it is damaged"),
        (["law.toml", "--to", "c", "-o", "to"], "--prop"),
        (["map.npz", "--prop", "apc-8x6e", "--to", "c", "-o", "to"], "leave it out"),
        (["map.npz", "--to", "c", "-o", "map.npz"], "this is a file"),
        (["map.npz", "--to", "c", "-o", "absent/to"], "no folder"),
        (["map.npz", "-o", "to"], "--to"),
        (["map.npz", "--to", "c"], "--output"),
    ],
)
def test_what_cannot_be_is_told_in_one_line(
    run: Run, tmp_path: Path, arguments: list[str], message: str
) -> None:
    (tmp_path / "bad.npz").write_bytes((tmp_path / "map.npz").read_bytes()[:500])
    (tmp_path / "law.toml").write_text(propmap.airfoil("paper-apc").to_toml())
    shutil.copy(DELIVERY, tmp_path / "quad.toml")
    done = run("export", *arguments)
    assert done.code == 2
    assert message in done.err
    assert done.err.count("\n") == 1
    assert not (tmp_path / "to").exists()


def test_a_propeller_goes_to_cpp_and_nothing_else_does(run: Run, tmp_path: Path) -> None:
    done = run("export", "APC 8x6E", "--to", "cpp", "-o", "cpp", "--model", "paper")
    assert done.code == 0 and (tmp_path / "cpp" / "apc_8x6e.hpp").exists()
    for source, what in (("map.npz", "a table"), (str(DELIVERY), "a vehicle and a table")):
        done = run("export", source, "--to", "cpp", "-o", "no")
        assert done.code == 2 and f"cpp is not made from {what}, but from a propeller" in done.err
    assert not (tmp_path / "no").exists()
