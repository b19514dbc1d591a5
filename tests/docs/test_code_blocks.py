"""Every code block of README and the documentation runs, in order, in one empty folder.

Cells of notebook pages (``{code-cell}``) are run by the documentation's build.
"""

from __future__ import annotations

import os
import shutil
import site
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap import catalogue, core
from propmap.flight.simulate import SensorNoise, fly, trim
from propmap.vehicle.files import read_vehicle
from tests.io.test_section_tables import xfoil
from tests.vehicle.write_px4_log import write_ulog

from .pages import ROOT, Step, edited, steps

DOCS = ROOT / "docs"
WRITTEN = {"_build", "generated", "propellers"}
"""Folders that the documentation's build writes."""

PAGES = sorted(p for p in DOCS.rglob("*.md") if not WRITTEN & set(p.parts))
FOLLOWED = [p for p in (ROOT / "README.md", *PAGES) if p.name != "getting-started.md"]
"""The page on getting started is followed without extras, by a test of its own."""

BUILT = ("pip install", "make ")
"""What begins a block that installs or builds: CI itself does that, from a fresh clone."""

OTHER = {"toml", "text", "xml"}
OTHER |= {"{toctree}", "{include}", "{eval-rst}", "{literalinclude}", "{math}"}
"""Blocks that show a file's form or are the documentation's own directives."""

OPTIMIZED = "-DCMAKE_BUILD_TYPE=Release"
UNOPTIMIZED = f"{OPTIMIZED} -DCMAKE_CXX_FLAGS_RELEASE=-O0"
"""The page's core is built a few times as fast; what it computes there is little."""

NEEDS = {f"# needs {name}": name for name in ("rotorpy", "casadi", "mujoco")}


def px4_logs(folder: Path) -> None:
    """Two flights of the page's vehicle as PX4 would log them."""
    file = read_vehicle(shutil.copy(ROOT / "examples" / "px4" / "vehicle.toml", folder))
    for seed, name in enumerate(("flight.ulg", "another.ulg", "log.ulg")):
        points = trim(file.vehicle, propmap.airfoil("paper-apc"), np.linspace(1.0, 12.0, 6))
        log = fly(points, noise=SensorNoise(), seed=seed, rate=50.0)
        write_ulog(log, folder / name, file.vehicle)


def uiuc_files(folder: Path) -> None:
    """Geometry and loads of a 10-inch propeller in the layout of the UIUC database."""
    blade = propmap.propeller("uiuc-apcsf-10x7")
    fractions = (blade.station / blade.radius, blade.chord / blade.radius, np.degrees(blade.twist))

    def write(name: str, header: str, *columns: np.ndarray) -> None:
        path = folder / f"apcsf_10x7_{name}.txt"
        np.savetxt(path, np.transpose(columns), "%.4f", header=header, comments="")

    write("geom", "r/R c/R beta", *fractions)
    law = propmap.airfoil("paper-apc").with_parameters(zero_lift_angle=-0.07)
    rotor = propmap.Rotor(propmap.Model(blade, law))

    def coefficients(turns: np.ndarray, advance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        loads = rotor.loads(2.0 * np.pi * turns, advance * turns * blade.diameter, 0.0)
        size = rotor.model.air.density * turns**2 * blade.diameter**4
        return loads.thrust / size, 2.0 * np.pi * loads.torque / (size * blade.diameter)

    rpm = np.linspace(2000.0, 6000.0, 6)
    write("static_kt0827", "RPM CT CP", rpm, *coefficients(rpm / 60.0, np.zeros(6)))
    advance, half = np.linspace(0.15, 0.55, 9), np.full(9, 0.5)
    for name, speed in (("kt0828", 3008), ("kt0829", 4018), ("kt0830", 5021)):
        found = coefficients(np.full(9, speed / 60.0), advance)
        write(f"{name}_{speed}", "J CT CP eta", advance, *found, half)


def polars(folder: Path) -> None:
    """Polars of a cambered section at two Reynolds numbers in the layout of XFOIL."""
    (folder / "polars").mkdir()
    for reynolds in (6e4, 1e5):
        text = xfoil(np.arange(-10.0, 16.1, 0.5), reynolds)
        (folder / "polars" / f"{reynolds:g}.txt").write_text(text)


def source(folder: Path) -> None:
    """The package's source and its core, built and to build."""
    copy = folder / "src" / "propmap"
    shutil.copytree(ROOT / "src" / "propmap", copy)
    core.instructions()  # Now it is loaded.
    for name, module in list(sys.modules.items()):
        if name.startswith("propmap._core") and module.__file__ is not None:
            shutil.copy(module.__file__, copy)
    shutil.copytree(ROOT / "core", folder / "core")
    shutil.copy(ROOT / "CMakeLists.txt", folder)


def papers(folder: Path) -> None:
    """The plain reference of the paper's equations, which a checkout contains."""
    shutil.copytree(ROOT / "papers", folder / "papers")


SUPPLIED: dict[str, Callable[[Path], None]] = {
    "docs/architecture.md": source,
    "docs/equations.md": papers,
    "docs/how-to/corrections-and-tables.md": polars,
    "docs/how-to/fit-px4.md": px4_logs,
    "docs/how-to/fit-uiuc.md": uiuc_files,
    "docs/how-to/wind.md": px4_logs,
}
"""What a reader of the page has already: files of others' making."""


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def runs(step: Step) -> bool:
    built = step.kind == "run" and step.text.lstrip().startswith(BUILT)
    return step.kind in ("run", "python") and not built


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """This interpreter's commands."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    cache = str(tmp_path_factory.mktemp("cache"))
    return os.environ | {"PATH": path, "XDG_CACHE_HOME": cache, "MPLBACKEND": "agg"}


def own_source(environment: dict[str, str]) -> dict[str, str]:
    """A page's own copy of the package, for ``python -S``, which knows of no editable one."""
    others = [os.environ.get("PYTHONPATH"), *site.getsitepackages()]
    return environment | {"PYTHONPATH": os.pathsep.join(["src", *filter(None, others)])}


@pytest.mark.slow
@pytest.mark.parametrize("page", [p for p in FOLLOWED if any(map(runs, steps(p)))], ids=name_of)
def test_a_page_can_be_followed(page: Path, tmp_path: Path, environment: dict[str, str]) -> None:
    """From an empty folder, block by block."""
    SUPPLIED.get(name_of(page), lambda _: None)(tmp_path)
    for step in steps(page):
        path = tmp_path / step.name
        if step.kind == "file":
            path.parent.mkdir(exist_ok=True)
            path.write_text(step.text, encoding="utf-8")
        elif step.kind == "edit":
            path.write_text(edited(path.read_text("utf-8"), step), encoding="utf-8")
        elif runs(step) and not lacking(step):
            text = step.text.replace(OPTIMIZED, UNOPTIMIZED)
            command, place = ["bash", "-euo", "pipefail"], environment
            if step.kind == "python" and SUPPLIED.get(name_of(page)) is source:
                command, place = [sys.executable, "-S"], own_source(environment)
            elif step.kind == "python":
                command = [sys.executable]
            command += ["-c", text]
            done = subprocess.run(command, cwd=tmp_path, env=place, capture_output=True, text=True)
            where = f"{name_of(page)}:{step.line}:\n{step.text}"
            assert done.returncode == 0, f"{where}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"


def lacking(step: Step) -> bool:
    """Whether the block says that it needs a package that is not installed here."""
    import importlib.util

    needed = [package for note, package in NEEDS.items() if note in step.text]
    if "cc " in step.text and shutil.which("cc") is None:
        return True
    return any(importlib.util.find_spec(package) is None for package in needed)


def test_every_block_is_of_a_known_kind() -> None:
    """A block that nothing would run is not overlooked."""
    for page in (ROOT / "README.md", *PAGES):
        for step in steps(page):
            where = f"{name_of(page)}:{step.line}: {step.name or step.kind}"
            assert step.kind != "other" or step.name in OTHER, where
            notebook = page.read_text(encoding="utf-8").startswith("---\nfile_format: mystnb")
            assert step.kind != "cell" or notebook, f"{where} is in no notebook"


def test_the_readme_shows_the_example_and_the_catalogue_s_size() -> None:
    first = next(s for s in steps(ROOT / "README.md") if s.kind == "python")
    example = (ROOT / "examples" / "loads.py").read_text(encoding="utf-8")
    lines = [line for line in first.text.splitlines() if line]
    # But for blank lines and what it says of itself.
    assert lines == [line for line in example.splitlines() if line][1:]
    assert len(lines) <= 10
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert f"The catalogue contains {len(catalogue.names())} propellers" in text
