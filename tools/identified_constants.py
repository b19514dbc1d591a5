"""Write the bundled constants of the APC 8x6E, fitted to the wind-tunnel campaign of 2019.

Usage: python -m tools.identified_constants

Runs ``COMMAND`` and keeps its section law, rounded, as
src/propmap/catalogue/airfoils/apc-8x6e-2019.toml.  To be run again whenever the recommended model
changes: the constants belong to it, but are offered to every model, so that the corrections with
which they were found are left out.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import tomli_w

from propmap.fit.files import read_fit
from propmap.io.csv import replacing
from propmap.model.airfoil import DISCREPANCIES, Airfoil, SectionUncertainty
from propmap.model.corrections import MODELS

NAME = "apc-8x6e-2019"
TARGET = Path(__file__).resolve().parent.parent / "src/propmap/catalogue/airfoils" / f"{NAME}.toml"
DATA = "Gill, D'Andrea, Drones 3(4):77, 2019, doi 10.3390/drones3040077, eqs. 95-102"
FREE = ("c_l1", "c_d", "alpha_0", "zero_lift_angle", "c_d0")
COMMAND = [
    "propmap", "fit", "tunnel", "apc-8x6e", "gill-dandrea-2019-8x6e", "--loads", "thrust,torque",
    "--free", ",".join(FREE), "--fix", "c_l2=2",
]  # fmt: skip
"""c_l2, the lift beyond stall, is held at the value of two of the three sets of Table I: these data
do not determine it."""

DECIMALS = 5
"""Digits of the constants; their 95 % intervals are a hundred times as wide or more."""


def main() -> None:
    """Fit and write."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{NAME}.toml"
        command = [sys.executable, "-m", *COMMAND, "--output", str(file)]
        subprocess.run(command, check=True)
        found = read_fit(file).airfoil
    assert found.uncertainty is not None  # a fit has it
    known = replace(found.uncertainty, another_tunnel=True)
    with replacing(TARGET) as part:
        part.write_text(_text(found, known), encoding="utf-8")


def _text(found: Airfoil, known: SectionUncertainty) -> str:
    """Name, source, constants and their uncertainty, as a parameter file."""
    source = (
        f"Fitted to thrust and torque of {DATA}, with the recommended model "
        f"({', '.join(MODELS['recommended'])}), by {' '.join(COMMAND)}"
    )
    constants = ("c_l1", "c_l2", "c_d", "alpha_0", "zero_lift_angle", "c_d0")
    rounded = known.as_dict()
    rounded["covariance"] = [[float(f"{v:.6g}") for v in row] for row in rounded["covariance"]]
    for name in DISCREPANCIES:
        rounded[name] = float(f"{rounded[name]:.4g}")
    lines = [
        "schema = 1",
        f'name = "{NAME}"',
        f'source = "{source}"',
        *(f"{name} = {round(getattr(found, name), DECIMALS)!r}" for name in constants),
    ]
    return "\n".join(lines) + f"\n\n{tomli_w.dumps({'uncertainty': rounded})}"


if __name__ == "__main__":
    main()
