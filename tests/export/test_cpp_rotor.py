"""A rotor in C++: the core's installed headers give the loads that Python gets."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import propmap as pm
from propmap.export import export_rotor
from propmap.loads import LOADS
from propmap.results import STATUSES
from propmap.rotor import include_folder

from .needed import program

EXAMPLE = Path(__file__).parents[2] / "examples" / "cpp" / "loads.cpp"
FLAGS = ["-std=c++20", "-Wall", "-Wextra", "-pedantic", "-Werror"]
"""Instructions and contraction are those of an installation from source."""
FAST = ["-O2", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math"]
CHECKED = ["-O1", "-march=native", "-ffp-contract=fast", "-fsanitize=address,undefined"]


def points(count: int = 1000) -> np.ndarray:
    """Omega [rad/s], v_axial and v_inplane [m/s]; hover, descent and standstill too."""
    random = np.random.default_rng(45)
    found = random.uniform([150.0, -15.0, 0.0], [1000.0, 20.0, 20.0], (count, 3))
    found[::10, 2] = 0.0
    found[::50, 1:] = 0.0
    found[-1] = 0.0
    return found


def compiled(rotor: pm.Rotor, folder: Path, options: list[str], at: np.ndarray) -> np.ndarray:
    """Loads and status (N, 7) at points by the example on the header of ``rotor``."""
    (header,) = export_rotor(rotor, "cpp", folder)
    name = header.stem
    text = EXAMPLE.read_text().replace("apc_8x6e", name)
    (folder / "loads.cpp").write_text(text)
    build = [program("c++"), *FLAGS, *options, "-I", include_folder(), "loads.cpp", "-o", "loads"]
    subprocess.run(build, cwd=folder, check=True)
    asked = "\n".join(" ".join(map(repr, row)) for row in at.tolist())
    done = subprocess.run([folder / "loads"], input=asked, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    return np.array([line.split() for line in done.stdout.splitlines()], dtype=np.float64)


def agrees(rotor: pm.Rotor, at: np.ndarray, found: np.ndarray) -> None:
    omega, along, across = at.T
    own = rotor.loads_at_velocity(omega, np.stack([across, 0.0 * across, along], axis=-1))
    loads = np.stack([getattr(own, name) for name in LOADS], axis=-1)
    assert np.isfinite(loads).all()
    np.testing.assert_allclose(found[:, :6], loads, rtol=1e-12, atol=1e-12 * abs(loads).max())
    assert [STATUSES[int(k)] for k in found[:, 6]] == own.status.tolist()


@pytest.mark.parametrize(
    "options", [FAST, pytest.param(CHECKED, marks=pytest.mark.slow)], ids=["fast", "checked"]
)
def test_loads_are_those_of_python(tmp_path: Path, options: list[str]) -> None:
    rotor = pm.Rotor(pm.known_model("APC 8x6E"))
    agrees(rotor, points(), compiled(rotor, tmp_path, options, points()))


def test_a_tabulated_law_with_all_that_changes_it(tmp_path: Path) -> None:
    angle = np.linspace(-np.pi, np.pi, 73)
    lift, drag = np.sin(2.0 * angle)[None], 0.02 + np.sin(angle)[None] ** 2
    lift[:, [0, -1]] = 0.0
    law = pm.SectionTable(angle, np.array([1e5]), lift, drag)
    names = (
        "blade-to-hub",
        "blade-untwist:tip_angle=0.02",
        "tip-loss",
        "hub-loss",
        "coleman",
        "stall-delay",
    )
    corrections = tuple(map(pm.correction, (*names, "prandtl-glauert", "radial-friction")))
    model = pm.Model(pm.propeller("apc-8x6e"), law, corrections=corrections)
    rotor = pm.Rotor(model, accuracy="fine")
    agrees(rotor, points(100), compiled(rotor, tmp_path, FAST, points(100)))


def test_cmake_finds_the_headers(tmp_path: Path) -> None:
    export_rotor(pm.Rotor(pm.known_model("APC 8x6E")), "cpp", tmp_path)
    for name in ("loads.cpp", "CMakeLists.txt"):
        (tmp_path / name).write_text((EXAMPLE.parent / name).read_text())
    cmake, built = Path(sys.executable).with_name("cmake"), tmp_path / "build"
    given = [f"-Dpropmap_ROOT={include_folder().parent}", "-S", tmp_path, "-B", built]
    subprocess.run([cmake, *given], check=True, capture_output=True)
    subprocess.run([cmake, "--build", built], check=True, capture_output=True)
    hover = subprocess.run([built / "loads"], input="600 0 0", text=True, capture_output=True)
    thrust = float(hover.stdout.split()[0])
    assert thrust == pytest.approx(
        float(pm.Rotor(pm.known_model("APC 8x6E")).loads(600, 0, 0).thrust)
    )
