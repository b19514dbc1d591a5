"""`propmap props`, `propmap airfoils`, and the program as a process of its own."""

from __future__ import annotations

import csv
import io
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import propmap
from propmap import catalogue
from propmap.catalogue.identified import PARAMETERS, identified, identified_without_blade

from .conftest import POINT, ROTOR, Run


def test_props_lists_everything(run: Run) -> None:
    rows = json.loads(run("props", "--format", "json").out)
    others = [one.propeller for one in identified_without_blade()]
    assert [row["name"] for row in rows] == [*catalogue.names(), *others]
    assert run("props").out.count("\n") > len(rows)
    found = csv.DictReader(io.StringIO(run("props", "thin", "8x6", "--format", "csv").out))
    assert [row["name"] for row in found] == ["apc-8x6e"]
    assert "0 propellers" in run("props", "zeppelin").out


def test_props_show_prints_stations_and_outline(run: Run) -> None:
    done = run("props", "show", "apc-8x6e")
    for text in ("twist [deg]", "45.04", "█", "Landing Products"):
        assert text in done.out


def test_props_show_tells_the_identified_constants(run: Run) -> None:
    one = identified("uiuc-nr640-5x3.16", 3)
    assert one is not None
    out = run("props", "show", "uiuc-nr640-5x3.16", "--blades", "3").out
    deviations = one.covariance.diagonal() ** 0.5
    for name, value, deviation in zip(PARAMETERS, one.constants, deviations, strict=True):
        (row,) = [line for line in out.splitlines() if f"│ {name} " in line]
        assert f"{value:.4f}" in row and f"{deviation:.4f}" in row
    for text in (f"verdict: {one.verdict}", one.tested, f"{one.rpm_high:.0f} rpm", "with 2 and 4"):
        assert text in out


def test_airfoil_shown_is_an_airfoil_file(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(run("airfoils", "show", "paper-soft").out)
    assert propmap.airfoil(path) == propmap.airfoil("paper-soft")
    rows = json.loads(run("airfoils", "--format", "json").out)
    assert [row["name"] for row in rows] == propmap.airfoil_names()


def test_help_and_version(run: Run) -> None:
    for arguments in ([], ["predict", "--help"], ["props", "--help"]):
        done = run(*arguments)
        assert (done.code, done.err) == (0, "") and "Usage" in done.out
    assert run("--version").out == f"propmap {propmap.__version__}\n"


def test_a_process_predicts_and_fails_in_one_line(run: Run) -> None:
    command = [sys.executable, "-m", "propmap", "predict"]
    named: dict[str, Any] = {"capture_output": True, "text": True, "encoding": "utf-8"}
    done = subprocess.run([*command, *ROTOR, *POINT, "--format", "json"], check=False, **named)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == run("predict", *ROTOR, *POINT, "--format", "json").out
    done = subprocess.run([*command, "apc-8x6q", *POINT], check=False, **named)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
