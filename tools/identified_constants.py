"""Fit the bundled constants of the APC 8x6E to the wind-tunnel campaign of 2019.

Usage: python -m tools.identified_constants

The tool runs ``COMMAND`` and writes the rounded section law to
src/propmap/catalogue/airfoils/apc-8x6e-2019.toml.  Run it again after every change of the
recommended model, because the constants are valid for that model.  The file omits the corrections
of the fit, so that every model accepts the constants.
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
"""c_l2, the lift past stall, is fixed at its value in two of the three sets of Table I: the data do
not determine it."""

DECIMALS = 5
"""Decimals of the constants; their 95 % intervals are at least a hundred times as wide."""


def main() -> None:
    """Fit the constants and write the file."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{NAME}.toml"
        command = [sys.executable, "-m", *COMMAND, "--output", str(file)]
        subprocess.run(command, check=True)
        found = read_fit(file).airfoil
    assert found.uncertainty is not None  # for type checkers: every fit has an uncertainty
    known = replace(found.uncertainty, another_tunnel=True)
    with replacing(TARGET) as part:
        part.write_text(_text(found, known), encoding="utf-8")


def _text(found: Airfoil, known: SectionUncertainty) -> str:
    """Return the parameter file: name, source, constants and their uncertainty."""
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
