"""The section law and the mount of a propeller: known, expected, or a table."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray

import propmap
from propmap.catalogue.expected import expected_constants, size_of
from propmap.catalogue.identified import identified
from propmap.catalogue.lookup import meant_by
from propmap.model.corrections import TYPICAL_AREA, TYPICAL_FACTOR
from tests.io import samples

from .conftest import BETA, POINT, RPM, SPEED, Run
from .fit_inputs import VEHICLE
from .invented_tables import certificate, invented

AT = (RPM * np.pi / 30.0, SPEED, np.radians(BETA))


def thrust_with(prop: str, law: propmap.Airfoil | propmap.SectionTable, blades: int = 2) -> float:
    blade = propmap.propeller(prop, blades=blades)
    model = propmap.Model(blade, law, corrections=propmap.model_corrections("recommended"))
    return float(propmap.Rotor(model).loads(*AT).thrust)


def predicted(run: Run, prop: object, *more: str) -> tuple[dict[str, float], str]:
    """The loads, and the one note; another one is of points where bands were not compared."""
    done = run("predict", prop, *POINT, *more, "--format", "json")
    first, *others = done.err.splitlines()
    assert done.code == 0 and all("the bands were not compared" in line for line in others)
    return json.loads(done.out), first


@pytest.mark.parametrize("prop", ["APC 8x6E", "kyosho 11x9"])
def test_identified_constants(run: Run, prop: str) -> None:
    name = propmap.propeller(prop).name
    found = identified(name, 2)
    assert found is not None
    loads, told = predicted(run, prop)
    assert told.startswith(f"note: constants identified from {found.rows} rows of ")
    assert loads["thrust_N"] == pytest.approx(thrust_with(name, found.airfoil), rel=1e-9)
    assert f"airfoil {name} identified + pitt-peters" in run("predict", prop, *POINT).out


@pytest.mark.parametrize(
    ("prop", "known", "said"),
    [
        ("apc-8x6sf", ("apcsf", "maker"), "propellers of its family, apcsf"),
        ("./mine.csv", (None, "measured"), "small propellers, none of its family"),
    ],
)
def test_constants_of_the_family_or_of_all(
    run: Run, prop: str, known: tuple[str | None, str], said: str
) -> None:
    rows = "20,18,35\n50,20,22\n80,16,15\n100,8,12\n"
    Path("mine.csv").write_text(f"# blades: 2\nradius_mm,chord_mm,twist_deg\n{rows}")
    meant = None if known[0] is None else meant_by(prop)
    law = expected_constants(known[0], size_of(meant, propmap.propeller(prop)), known[1]).airfoil
    loads, told = predicted(run, prop)
    assert said in told
    assert loads["thrust_N"] == pytest.approx(thrust_with(prop, law), rel=1e-9)


def test_a_blade_of_its_maker(run: Run) -> None:
    assert "blade of the manufacturer's file" in predicted(run, "APC 5x4E-3")[1]


@pytest.mark.parametrize(
    ("title", "says"),
    [
        ("10x7SF", "identified from 117 rows of 'apcsf 10.0x7.0 - 2'"),
        ("10x7.3SF", "10 propellers of its family, apcsf, with the blade of the manufacturer"),
        ("0x7E", "none of its family"),
    ],
)
def test_a_file_of_apc_has_the_constants_of_its_series(title: str, says: str, run: Run) -> None:
    Path("mine.PE0").write_text(samples.PE0.replace("5x4T ", f"{title} "))
    assert says in predicted(run, "./mine.PE0", "--no-bands")[1]


def test_drag_is_that_of_the_installed_rotor_or_of_bare_blades(run: Run) -> None:
    (whole, _), (bare, _) = (predicted(run, "apc 8x6e", *more) for more in ([], ["--bare"]))
    blades = bare["drag_N"]
    across, along = SPEED * np.sin(np.radians(BETA)), SPEED * np.cos(np.radians(BETA))
    rotor = propmap.Rotor(propmap.catalogue_model("apc 8x6e"))
    inflow = np.asarray(rotor.loads(*AT).mean_inflow)
    mount = 0.5 * 1.225 * TYPICAL_AREA[0] * 0.1016**2 * across * np.hypot(across, along + inflow)
    assert whole["drag_N"] == pytest.approx(TYPICAL_FACTOR[0] * blades + mount, rel=1e-6)
    assert whole["thrust_N"] == bare["thrust_N"] and whole["torque_Nm"] == bare["torque_Nm"]
    # Nothing else is known of the mount: a factor of about two either way.
    assert 0.25 < whole["drag_std_N"] / whole["drag_N"] < 0.45
    assert bare["drag_std_N"] < 0.15 * blades


def test_drag_that_a_fit_did_not_measure_is_that_of_the_installed_rotor(
    run: Run, tunnel_fit: Path
) -> None:
    law = propmap.airfoil(tunnel_fit)
    own = ["apc-8x6e", "--airfoil", str(tunnel_fit), *POINT, "--format", "json"]
    whole, bare = (json.loads(run("predict", *own, *more).out) for more in ([], ["--bare"]))
    model = propmap.Model(propmap.propeller("apc-8x6e"), law)
    loads = propmap.Rotor(model).loads(*AT)
    assert whole["drag_N"] == pytest.approx(float(loads.drag), rel=1e-9)
    assert whole["drag_N"] > TYPICAL_FACTOR[0] * bare["drag_N"]
    assert whole["drag_std_N"] > 0.25 * whole["drag_N"] > bare["drag_std_N"]
    assert whole["thrust_N"] == bare["thrust_N"] and whole["torque_Nm"] == bare["torque_Nm"]
    # The rotor of an aircraft is installed as well.
    Path("vehicle.toml").write_text(VEHICLE)
    trim = ["trim", "vehicle.toml", "--airfoil", str(tunnel_fit), "--speed", "8", "--no-bands"]
    assert "installed rotors" in run(*trim).out


PLATE = ["apc-8x6e", "--airfoil", "plate.csv"]
NOTE = "the table covers 1e+05 to 6e+05; outside, its nearest row is used"


@pytest.fixture
def plate(tmp_path: Path) -> propmap.SectionTable:
    text = "alpha_deg,re,cl,cd\n"
    for re in (1e5, 6e5):
        for a in np.linspace(-180.0, 180.0, 73):
            lift, drag = np.sin(2.0 * np.radians(a)), 0.02 + np.sin(np.radians(a)) ** 2
            text += f"{a},{re},{lift},{drag * (1e5 / re) ** 0.2}\n"
    (tmp_path / "plate.csv").write_text(text)
    law = propmap.airfoil(tmp_path / "plate.csv")
    assert isinstance(law, propmap.SectionTable)
    return law


def test_loads_are_those_of_a_section_table(run: Run, plate: propmap.SectionTable) -> None:
    done = run("predict", *PLATE, *POINT, "--format", "json")
    assert done.code == 0 and NOTE in done.err and done.err.count("\n") == 1
    wanted = pytest.approx(thrust_with("apc-8x6e", plate), rel=1e-9)
    assert json.loads(done.out)["thrust_N"] == wanted
    assert "airfoil plate" in run("predict", *PLATE, *POINT).out
    rows = Path("plate.csv").read_text().splitlines(keepends=True)
    Path("one.csv").write_text("".join(rows[:74]))
    one = run("predict", "apc-8x6e", "--airfoil", "one.csv", *POINT)
    assert "the table has one Reynolds number, which is used everywhere" in one.err


def test_sweep_check_and_export_take_a_table(
    run: Run, tunnel_csv: Path, monkeypatch: pytest.MonkeyPatch, plate: propmap.SectionTable
) -> None:
    done = run("sweep", *PLATE, *POINT, "-o", "x.nc")
    assert done.code == 0 and NOTE in done.err
    found = xarray.load_dataset("x.nc").attrs
    assert found["airfoil_name"] == "plate"
    assert found["corrections"] == "pitt-peters, radial-friction"
    checked = run("check", "plate.csv", tunnel_csv, "--prop", "apc-8x6e", "--format", "json")
    assert checked.code == 0 and NOTE in checked.err
    assert json.loads(checked.out)["rows"] == 14
    built: list[propmap.Rotor] = []
    record = "propmap.export.built_tables.build_table"
    table = invented(certificate=certificate(0))
    monkeypatch.setattr(record, lambda rotor, **_: built.append(rotor) or table)
    done = run("export", "plate.csv", "--prop", "apc-8x6e", "--to", "csv", "-o", "to")
    assert done.code == 0 and NOTE in done.err
    assert built[0].model.airfoil == plate.with_corrections(["pitt-peters", "radial-friction"])
