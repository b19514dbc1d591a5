"""A correction given to any command acts, or the command refuses it in one line."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer

import propmap
from propmap.cli.app import app
from propmap.model.airfoil import parameter_set
from propmap.table import LoadTable
from propmap.tasks import InTurn

from .conftest import POINT, ROTOR, Run, refused
from .fit_inputs import LEVEL, QUICK, STAND, VEHICLE, fit_record
from .invented_tables import certificate, invented

pytestmark = pytest.mark.usefixtures("brief")

TIP_LOSS = ["--correction", "tip-loss"]
THREE = ("pitt-peters", "radial-friction", "tip-loss")
ENVELOPE = ["--rpm", "4000:4400", "--speed", "14:16", "--beta", "75:90", "--tolerance", "5%"]
FLOWN = ["--vehicle", "vehicle.toml"]
FLIGHT = [*FLOWN, "--airfoil", "paper-apc", "--speeds", "9,11,13"]

Found = Callable[[str], Any]
"""Returns the loads of a run, from the printed text or from the written file."""


def _file(name: str) -> Found:
    return lambda _: Path(name).read_bytes()


def _parameters(_: str) -> list[float]:
    return [one["value"] for one in fit_record(Path("fit.toml"))["parameters"].values()]


def _drawn(_: str) -> list[Any]:
    """The curves of the picture that was drawn last."""
    return [np.asarray(line.get_ydata()).tolist() for ax in KEPT[-1].axes for line in ax.lines]


KEPT: list[Any] = []
"""Pictures that would have been written."""

MAKERS: dict[str, tuple[list[str], Found]] = {
    "predict": ([*ROTOR, *POINT, "--format", "json"], json.loads),
    "sweep": ([*ROTOR, *POINT, "-o", "x.csv", "--force"], _file("x.csv")),
    "table": (
        [*ROTOR, *ENVELOPE, "-o", "x.npz", "--force"],
        lambda _: LoadTable.load("x.npz").content.coefficients.tolist(),
    ),
    "export": (
        ["law.toml", "--prop", "apc-8x6e", "--to", "csv", "-o", "to", "--force"],
        _file("to/invented.csv"),
    ),
    "fit tunnel": (["apc-8x6e", "tunnel.csv", *QUICK, "-o", "fit.toml"], _parameters),
    "fit static": (["stand.csv", "--prop", "apc-8x6e", *QUICK, "-o", "fit.toml"], _parameters),
    "fit flight": (["level.csv", *FLOWN, *QUICK, "-o", "fit.toml"], _parameters),
    "simulate flight": ([*FLIGHT, "--no-expectation", "-o", "x.csv", "--force"], _file("x.csv")),
    "trim": (
        ["vehicle.toml", "--airfoil", "paper-apc", "--speed", "0,5", "--format", "json"],
        json.loads,
    ),
    "choose": (
        ["vehicle.toml", "--speed", "5", "--diameter", "5.1:5.2", "--format", "json"],
        json.loads,
    ),
    "check": (
        ["law.toml", "tunnel.csv", "--prop", "apc-8x6e", "--format", "json"],
        lambda out: json.loads(out)["loads"],
    ),
    "plot map": ([*ROTOR, "--rpm", "4000", "--speed", "13:15", "-o", "x.png"], _drawn),
    "plot disk": ([*ROTOR, *POINT, "-o", "x.csv"], _file("x.csv")),
}
"""Commands that make a model: their arguments, and what shows its loads."""

OTHERS = {
    "show", "report", "fit terms", "explore", "study",
    "plot planform", "props list", "props show", "airfoils list", "airfoils show",
    "vehicle from-log", "demo", "wind",
}  # fmt: skip
"""Commands that read a model or make none: they have no such option."""


def _commands(command: Any, path: str = "") -> Iterator[str]:
    """Names of all commands of the app, those in groups too."""
    if not hasattr(command, "commands"):
        yield path
        return
    for name in command.commands:
        yield from _commands(command.get_command(None, name), f"{path} {name}".strip())


ALL = sorted(_commands(typer.main.get_command(app)))


@pytest.fixture(autouse=True)
def _files(tmp_path: Path, tunnel_csv: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "law.toml").write_text(parameter_set("paper-apc").to_toml())
    (tmp_path / "tunnel.csv").write_text(tunnel_csv.read_text())
    (tmp_path / "stand.csv").write_text(STAND)
    (tmp_path / "vehicle.toml").write_text(VEHICLE)
    (tmp_path / "level.csv").write_text(LEVEL)
    monkeypatch.setattr("propmap.report.html.save", lambda figure, _: KEPT.append(figure))


def _brief(rotor: propmap.Rotor, **_: Any) -> LoadTable:
    """An invented table with one true load."""
    table = invented(certificate=certificate(0))
    table.content.coefficients[:] *= float(rotor.loads(420.0, 14.0, 1.4).thrust)
    return table


@pytest.mark.parametrize("name", MAKERS)
def test_a_correction_acts(run: Run, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    # Two steps of a fit tell as much as its end.
    monkeypatch.setattr("propmap.fit.least_squares.FINAL_EVALUATIONS", 2)
    monkeypatch.setattr("propmap.table.build.build_table", _brief)
    monkeypatch.setattr("propmap.export.built_tables.build_table", _brief)
    # It takes most of the time of `trim`, and the powers tell enough.
    found_at_once = "propmap.aircraft.performance.searched"
    monkeypatch.setattr(found_at_once, lambda _, states, __: (30.0, "", states))
    # Processes of their own would know nothing of this.
    in_turn = contextlib.nullcontext(InTurn())
    monkeypatch.setattr("propmap.cli.choose.InProcesses", lambda _: in_turn)
    arguments, found = MAKERS[name]
    results = []
    for added in ([], TIP_LOSS):
        done = run(*name.split(), *arguments, *added)
        assert done.code == 0, done.err
        results.append(found(done.out))
    assert results[0] != results[1]


def test_or_is_refused_in_one_line(run: Run) -> None:
    assert set(ALL) == {*MAKERS, *OTHERS}
    for name in ALL:
        arguments, _ = MAKERS.get(name, ([], None))
        bad = "foo" if name in MAKERS else "tip-loss"
        says = "correction 'foo' is not known" if name in MAKERS else "--correction"
        refused(run(*name.split(), *arguments, "--correction", bad), says)


def test_a_fit_brings_its_corrections(run: Run, tunnel_csv: Path) -> None:
    done = run("fit", "tunnel", "apc-8x6e", tunnel_csv, *QUICK, *TIP_LOSS, "-o", "with.toml")
    told = "model: pitt-peters, radial-friction, tip-loss, installed; commands that use the fit"
    assert told in done.out and parameter_set("with.toml").corrections == (*THREE, "installed")
    predict = ["predict", "apc-8x6e", "--airfoil", "with.toml", *POINT]
    assert (
        "airfoil with + pitt-peters + radial-friction + tip-loss + installed" in run(*predict).out
    )
    # Others than those of the fit are refused, by every command.
    again = ["fit", "tunnel", "apc-8x6e", tunnel_csv, "--airfoil", "with.toml", *QUICK]
    kept = "pitt-peters, radial-friction"
    for command in (predict, ["check", "with.toml", tunnel_csv], [*again, "-o", "b.toml"]):
        done = run(*command, "--correction", "hub-loss")
        refused(done, f"was fitted with {kept}, tip-loss, not with {kept}, hub-loss")
    # Used as a start, it hands them on.
    run(*again, "-o", "on.toml")
    assert parameter_set("on.toml").corrections == (*THREE, "installed")
    checked = json.loads(run("check", "with.toml", tunnel_csv, "--format", "json").out)
    assert tuple(checked["corrections"]) == (*THREE, "installed")


def test_the_model_is_recommended_unless_it_is_named(run: Run, tunnel_csv: Path) -> None:
    model = propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"))
    wanted = propmap.Rotor(model).loads(4000.0 * np.pi / 30.0, 14.0, np.radians(80.0))
    found = json.loads(run("predict", *ROTOR, *POINT, "--model", "paper", "--format", "json").out)
    assert found["roll_moment_Nm"] == pytest.approx(float(wanted.roll_moment), rel=1e-9)
    # An inflow shape takes the place of the model's own.
    done = run("predict", *ROTOR, *POINT, "--correction", "coleman", "--correction", "tip-loss")
    assert "airfoil paper-apc + radial-friction + coleman + tip-loss" in done.out
    # A fit under the paper's model says so, and is used with it.
    run("fit", "tunnel", "apc-8x6e", tunnel_csv, *QUICK, "--model", "paper", "-o", "paper.toml")
    assert parameter_set("paper.toml").corrections == ()
    assert "airfoil paper;" in run("predict", "apc-8x6e", "--airfoil", "paper.toml", *POINT).out
    told = "paper was fitted with the paper's model, not with pitt-peters, radial-friction"
    refused(run("check", "paper.toml", tunnel_csv, "--model", "recommended"), told)
    assert run("predict", *ROTOR, *POINT, "--model", "2017").code == 2
