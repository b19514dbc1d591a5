"""Tunnel rows, a vehicle and level flights as files, small enough for quick fits."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import propmap
from propmap.catalogue.lookup import measurement

if TYPE_CHECKING:
    from .conftest import Run

# One pair of free parameters, so that all fits here share their compiled programs.
FREE = ("c_l1", "zero_lift_angle")
QUICK = ["--free", ",".join(FREE), "--starts", "1", "--folds", "0"]
UIUC = measurement("uiuc-8x6e")
TURNS = UIUC.omega / (2.0 * np.pi)
ONE_SPEED = round(float(TURNS[UIUC.speed > 0.0][0]) * 60.0)
CHECKED = {"rows", "rms", "relative_rms", "bias", "worst", "hover_rms"}


def picked() -> np.ndarray:
    """Some rows of one rotational speed, then some static ones."""
    flying = np.flatnonzero(np.isclose(TURNS * 60.0, ONE_SPEED, atol=1.0) & (UIUC.speed > 0.0))
    return np.concatenate([flying[:9], np.flatnonzero(UIUC.speed == 0.0)[:5]])


def tunnel_table() -> str:
    """The picked rows of the catalogue's measurement as CSV; the air has its own density."""
    density = propmap.Air().density / UIUC.air_density
    loads = (UIUC.loads[name] * density for name in ("thrust", "torque"))
    columns = (TURNS * 60.0, UIUC.speed, 0.0 * TURNS, *loads)
    rows = (",".join(repr(float(column[k])) for column in columns) for k in picked())
    return "\n".join(["rpm,speed_mps,beta_deg,thrust_N,torque_Nm", *rows]) + "\n"


VEHICLE = """schema = 1
name = "test quadrotor"
frame = "flu"
mass = 0.93
propeller = "apc-8x6e"
""" + "".join(
    f'[[rotors]]\nposition = [{x}, {y}, 0.0]\nspin = "{spin}"\n'
    for x, y, spin in ((-0.1, -0.1, "cw"), (0.1, -0.1, "ccw"), (-0.1, 0.1, "ccw"), (0.1, 0.1, "cw"))
)
LEVEL = "speed_mps,pitch_deg,rpm_1,rpm_2,rpm_3,rpm_4\n" + "".join(
    f"{v},{0.15 * v * v},{rpm},{rpm},{rpm},{rpm}\n"
    for v, rpm in ((0, 5620), (0, 5630), (3, 5580), (6, 5500), (8, 5560), (9, 5600), (10, 5680))
)

STAND = "rpm,thrust_N,torque_Nm\n" + "".join(
    f"{rpm},{9e-8 * rpm**2:.4f},{1.5e-9 * rpm**2:.5f}\n" for rpm in range(3000, 7000, 500)
)


def fit_record(path: Path) -> dict[str, Any]:
    """The table [fit] of a fit file."""
    return tomllib.loads(path.read_text(encoding="utf-8"))["fit"]


def fitted(run: Run, *arguments: object) -> tuple[dict[str, Any], str]:
    """Run `propmap fit`; return the table [fit] of out.toml and the printed text."""
    fit = Path("out.toml")
    done = run("fit", *arguments, "-o", fit)
    assert (done.code, done.err) == (0, f"wrote {fit}\n"), done.err
    return fit_record(fit), done.out
