"""The page on getting started, as written, in an empty folder with the wheel and no extra."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import propmap

from .pages import ROOT, steps

PAGE = ROOT / "docs" / "getting-started.md"
INSTALL = "pip install propmap\n"


@pytest.mark.skipif(
    ROOT in Path(propmap.__file__).parents, reason="`make wheels` tests the page with the wheel"
)
def test_a_newcomer_flies_a_table_in_an_empty_folder(tmp_path: Path) -> None:
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    printed = {}
    first, *others = steps(PAGE)
    assert first.text == INSTALL
    for step in others:
        if step.kind == "file":
            (tmp_path / step.name).write_text(step.text, encoding="utf-8")
        elif step.kind == "run":
            command = ["bash", "-euo", "pipefail", "-c", step.text]
            done = subprocess.run(
                command,
                cwd=tmp_path,
                env=os.environ | {"PATH": path},
                capture_output=True,
                text=True,
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
