"""Rotor drag in `propmap fit`: identified with the mount, assumed, or refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.aircraft.ranking import file_candidate
from propmap.model.airfoil import parameter_set
from propmap.model.corrections import Installed

from .conftest import Run, refused
from .fit_inputs import LEVEL, VEHICLE

MOUNT = Installed(1.5, 5e-4)
TRUTH = propmap.Rotor(
    propmap.Model(
        propmap.propeller("apc-8x6e"),
        propmap.airfoil("apc-8x6e-2019"),
        corrections=(*propmap.model_corrections("recommended"), MOUNT),
    )
)
FIT = ["fit", "tunnel", "apc-8x6e", "test.csv", "--starts", "1", "--folds", "0", "-o", "fit.toml"]
PREDICT = ["predict", "apc-8x6e", "--rpm", "5000", "--speed", "8", "--beta", "70"]


def write_test(sign: float = 1.0, *, axial: bool = False) -> None:
    """Write 40 rows of thrust, torque and drag, with noise of 1 %, and of 4 mN on the drag."""
    random, lines = np.random.default_rng(1), ["rpm,speed_mps,beta_deg,thrust_N,torque_Nm,drag_N"]
    for rpm in (3500, 4500, 5500, 6500):
        for speed, beta in (
            (0, 0),
            (4, 30),
            (4, 90),
            (7, 60),
            (7, 90),
            (10, 30),
            (10, 60),
            (10, 80),
        ):
            angle = 0 if axial else beta
            loads = TRUTH.loads(rpm * np.pi / 30.0, float(speed), np.radians(angle))
            noise = 1.0 + 0.01 * random.standard_normal(2)
            drag = sign * float(loads.drag) + 4e-3 * random.standard_normal()
            values = float(loads.thrust) * noise[0], float(loads.torque) * noise[1], drag
            lines.append(f"{rpm},{speed},{angle}," + ",".join(f"{one:.6f}" for one in values))
    Path("test.csv").write_text("\n".join(lines) + "\n")


def predicted_drag(run: Run, *more: str) -> tuple[float, float]:
    found = json.loads(run(*PREDICT, "--airfoil", "fit.toml", *more, "--format", "json").out)
    return found["drag_N"], found["drag_std_N"]


def true_drag(mount: Installed = MOUNT) -> float:
    rotor = propmap.Rotor(TRUTH.model.with_mount(mount))
    return float(rotor.loads(5000.0 * np.pi / 30.0, 8.0, np.radians(70.0)).drag)


def test_measured_drag_identifies_the_mount(run: Run) -> None:
    write_test()
    assert run(*FIT).code == 0
    (text,) = (one for one in parameter_set("fit.toml").corrections or () if "installed" in one)
    mount = propmap.correction(text)
    assert isinstance(mount, Installed) and mount.factor == pytest.approx(1.5, abs=0.3)
    drag, std = predicted_drag(run)
    assert drag == pytest.approx(true_drag(), rel=0.05) and abs(drag - true_drag()) < 2.0 * std
    fixed = run(*FIT[:-1], "fixed.toml", "--fix", "drag_factor=1").out
    assert "mount_area" in fixed and "drag_factor" not in fixed
    # The fitted covariance of the mount does not apply to bare blades.
    drag, std = predicted_drag(run, "--bare")
    assert drag == pytest.approx(true_drag(Installed(1.0, 0.0)), rel=0.1) and std < 0.15 * drag
    # `choose` varies the constants of the section law only.
    assert file_candidate("apc-8x6e", propmap.airfoil("fit.toml")).varied()


def test_without_flow_along_the_disk_the_mount_is_assumed(run: Run) -> None:
    write_test(axial=True)
    assert "rotor drag in oblique flow was not fitted" in run(*FIT).out.replace("\n", " ")
    assert "installed" in (parameter_set("fit.toml").corrections or ())
    drag, std = predicted_drag(run)
    assert abs(drag - true_drag()) < 2.0 * std and std > 0.2 * drag
    # Measured drag replaces the assumed mount of a start fit.
    write_test()
    again = [
        *FIT[:-1],
        "next.toml",
        "--airfoil",
        "fit.toml",
        "--free",
        "c_d,mount_area,drag_factor",
    ]
    assert run(*again).code == 0
    assert "installed" not in (parameter_set("next.toml").corrections or ())


def test_drag_with_the_opposite_sign_is_refused(run: Run) -> None:
    write_test(sign=-1.0)
    refused(run(*FIT), "the rotor drag is negative in most rows of oblique flow", "change its sign")
    assert not Path("fit.toml").exists()


def test_level_flights_do_not_determine_the_mount(run: Run) -> None:
    Path("vehicle.toml").write_text(VEHICLE)
    Path("level.csv").write_text(LEVEL)
    flown = ["fit", "flight", "level.csv", "--vehicle", "vehicle.toml", "--starts", "1"]
    for model, installed in ((), True), (("--model", "paper"), False):
        assert run(*flown, *model, "--accept", "-o", "fit.toml").code == 0
        assert ("installed" in (parameter_set("fit.toml").corrections or ())) is installed


def test_two_mounts_are_refused(run: Run) -> None:
    Path("vehicle.toml").write_text(VEHICLE + "[mount]\narea = 0.001\n")
    given = ["--airfoil", "paper-apc", "--correction", "installed:factor=2"]
    for command in (
        ["trim", "vehicle.toml", "--speed", "5"],
        ["export", "vehicle.toml", "--to", "npz"],
    ):
        output = ["-o", "to"] if command[0] == "export" else []
        refused(run(*command, *given, *output), "--correction installed", "has [mount]")
