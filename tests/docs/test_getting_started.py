"""The newcomer's page, as written, in an empty folder and without any extra."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from importlib.metadata import distribution
from pathlib import Path

import numpy as np
import pytest

from .pages import ROOT, steps

PAGE = ROOT / "docs" / "getting-started.md"
INSTALL = "pip install propmap\n"
EXTRAS = "dask dash distributed h5netcdf jax matplotlib mujoco pandas plotly pyulog xarray zarr"


def without_extras(folder: Path) -> dict[str, str]:
    """This interpreter's commands, as if the base alone were installed."""
    hidden = f"import sys\nsys.modules.update(dict.fromkeys({EXTRAS.split()}))\n"
    (folder / "sitecustomize.py").write_text(hidden)
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    others = filter(None, [str(folder), os.environ.get("PYTHONPATH")])
    return {**os.environ, "PATH": path, "PYTHONPATH": os.pathsep.join(others)}


@pytest.mark.slow
def test_a_newcomer_flies_a_table_in_an_empty_folder(
    tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    environment = without_extras(tmp_path_factory.mktemp("hidden"))
    printed = {}
    for step in steps(PAGE):
        if step.kind == "file":
            (tmp_path / step.name).write_text(step.text, encoding="utf-8")
        elif step.kind == "run" and step.text != INSTALL:
            command = ["bash", "-euo", "pipefail", "-c", step.text]
            done = subprocess.run(
                command, cwd=tmp_path, env=environment, capture_output=True, text=True
            )
            assert done.returncode == 0, f"line {step.line}: {done.stderr}"
            printed[step.text.split()[0], step.text.split()[1]] = done.stdout
    flown = np.array(re.findall(r"(\d+) s +(\S+) m/s +(\S+) W", printed["python", "fly.py"]), float)
    in_c = np.array(re.findall(r"(\d+) s +(\S+) m/s +(\S+) W", printed["cd", "firmware"]), float)
    np.testing.assert_array_equal(flown, in_c)
    # It ends where ``trim`` has the vehicle at this angle, with the table's tolerance.
    trimmed = [line.split("│") for line in printed["propmap", "trim"].splitlines() if "│" in line]
    speed, pitch = np.array([[float(cell) for cell in row[1:3]] for row in trimmed]).T
    assert flown[-1, 1] == pytest.approx(np.interp(15.0, pitch, speed), rel=0.02)
    assert flown.shape == (5, 3) and np.all(np.diff(flown[:, 1]) > 0.0)


def test_the_page_installs_the_package_by_its_name() -> None:
    """Where ``make wheels`` runs this, the package is its wheel."""
    assert next(step.text for step in steps(PAGE) if step.kind == "run") == INSTALL
    assert distribution("propmap").read_text("METADATA")
