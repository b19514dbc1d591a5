"""Section tables where a command takes a section law, and their refusal where it cannot."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray

import propmap

from .conftest import POINT, Run
from .fit_inputs import VEHICLE
from .invented_tables import invented

pytestmark = pytest.mark.usefixtures("brief")

ROTOR = ["apc-8x6e", "--airfoil", "plate.csv"]
NOTE = "the table covers 1e+05 to 6e+05; outside, its nearest row is used"


@pytest.fixture(autouse=True)
def _table(_workplace: None) -> None:
    text = "alpha_deg,re,cl,cd\n"
    for re in (1e5, 6e5):
        for a in np.linspace(-180.0, 180.0, 73):
            lift, drag = np.sin(2.0 * np.radians(a)), 0.02 + np.sin(np.radians(a)) ** 2
            text += f"{a},{re},{lift},{drag * (1e5 / re) ** 0.2}\n"
    Path("plate.csv").write_text(text)


def test_loads_are_those_of_the_table(run: Run) -> None:
    done = run("predict", *ROTOR, *POINT, "--format", "json")
    assert done.code == 0 and NOTE in done.err and done.err.count("\n") == 1
    law = propmap.airfoil("plate.csv")
    recommended = propmap.model_corrections("recommended")
    model = propmap.Model(propmap.propeller("apc-8x6e"), law, corrections=recommended)
    rotor = propmap.Rotor(model)
    wanted = rotor.loads(4000.0 * np.pi / 30.0, 14.0, np.radians(80.0))
    assert json.loads(done.out)["thrust_N"] == pytest.approx(float(wanted.thrust), rel=1e-9)
    assert "airfoil plate" in run("predict", *ROTOR, *POINT).out
    rows = Path("plate.csv").read_text().splitlines(keepends=True)
    Path("one.csv").write_text("".join(rows[:74]))
    one = run("predict", "apc-8x6e", "--airfoil", "one.csv", *POINT)
    assert "the table has one Reynolds number, which is used everywhere" in one.err
    # Inside the table's range there is nothing to say.
    dense = run("predict", *ROTOR, *POINT, "--rho", "11")
    assert (dense.code, dense.err.count("\n")) == (0, 1)
    assert dense.err.startswith("note: the air density is 11 kg/m^3")


def test_sweep_check_and_export_take_a_table(
    run: Run, tunnel_csv: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    axes = ["--rpm", "4000", "--speed", "14", "--beta", "80"]
    done = run("sweep", *ROTOR, *axes, "-o", "x.nc")
    assert done.code == 0 and NOTE in done.err
    found = xarray.load_dataset("x.nc").attrs
    assert found["airfoil_name"] == "plate"
    assert found["corrections"] == "pitt-peters, radial-friction"
    checked = run("check", "plate.csv", tunnel_csv, "--prop", "apc-8x6e", "--format", "json")
    assert checked.code == 0 and NOTE in checked.err
    assert json.loads(checked.out)["rows"] == 14
    built: list[propmap.Rotor] = []
    record = "propmap.table.build.build_table"
    monkeypatch.setattr(record, lambda rotor, **_: built.append(rotor) or invented())
    done = run("export", "plate.csv", "--prop", "apc-8x6e", "--to", "csv", "-o", "to")
    assert done.code == 0 and NOTE in done.err
    assert built[0].model.airfoil == propmap.airfoil("plate.csv").with_corrections(
        ["pitt-peters", "radial-friction"]
    )


@pytest.mark.parametrize(
    "command",
    [
        ["fit", "tunnel", "apc-8x6e", "uiuc-8x6e", "-o", "fit.toml"],
        ["fit", "flight", "level.csv", "--vehicle", "vehicle.toml", "-o", "fit.toml"],
        ["simulate", "flight", "--vehicle", "vehicle.toml", "--speeds", "5,9", "-o", "log.csv"],
        ["airfoils", "show"],
    ],
)
def test_what_needs_constants_says_so(run: Run, command: list[str]) -> None:
    Path("vehicle.toml").write_text(VEHICLE)
    option = [] if command[0] == "airfoils" else ["--airfoil"]
    done = run(*command, *option, "plate.csv")
    assert (done.code, done.out, done.err.count("\n")) == (2, "", 1)
    assert "plate.csv: this is a section table, but the command needs" in done.err
