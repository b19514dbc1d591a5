"""A rotor in C++: the core's installed headers give the loads that Python gets."""

from __future__ import annotations

import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import propmap as pm
from propmap.export import export_rotor
from propmap.loads import LOADS
from propmap.results import STATUSES
from propmap.rotor import include_folder

from .needed import program

EXAMPLE = Path(__file__).parents[2] / "examples" / "cpp"
FLAGS = ["-std=c++20", "-Wall", "-Wextra", "-pedantic", "-Werror"]
"""Instructions and contraction are those of an installation from source."""
FAST = ["-O2", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math"]
QUICKLY_COMPILED = [*FLAGS, "-Og", *FAST[1:]]


def points(count: int = 1000) -> np.ndarray:
    """Omega [rad/s], v_axial and v_inplane [m/s]; hover, descent and standstill too."""
    random = np.random.default_rng(45)
    found = random.uniform([150.0, -15.0, 0.0], [1000.0, 20.0, 20.0], (count, 3))
    found[::10, 2] = 0.0
    found[::50, 1:] = 0.0
    found[-1] = 0.0
    return found


def tabulated() -> pm.Rotor:
    """A rotor with tabulated section coefficients and every correction that a rotor can have."""
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
        "prandtl-glauert",
        "radial-friction",
    )
    blade = replace(pm.propeller("apc-8x6e"), name="tabulated")
    model = pm.Model(blade, law, corrections=tuple(map(pm.correction, names)))
    return pm.Rotor(model, accuracy="fine")


def test_loads_are_those_of_python(tmp_path: Path) -> None:
    """The example of the documentation for two rotors, in one program that CMake builds."""
    asked = {
        "apc_8x6e": (pm.Rotor(pm.catalogue_model("APC 8x6E")), points()),
        "tabulated": (tabulated(), points(100)),
    }
    example, text, lines = (EXAMPLE / "loads.cpp").read_text(), "", []
    for name, (rotor, at) in asked.items():
        (header,) = export_rotor(rotor, "cpp", tmp_path)
        assert header.stem == name
        text += example.replace("apc_8x6e", name).replace("int main()", f"void {name}()")
        lines += [" ".join(map(repr, row)) for row in at.tolist()] + ["end"]
    text += '\nint main() { apc_8x6e(); (void)std::scanf("%*s"); tabulated(); }\n'
    (tmp_path / "loads.cpp").write_text(text)
    shutil.copy(EXAMPLE / "CMakeLists.txt", tmp_path)
    cmake, built = Path(sys.executable).with_name("cmake"), tmp_path / "build"
    given = [f"-Dpropmap_ROOT={include_folder().parent}", "-S", tmp_path, "-B", built]
    given += [
        f"-DCMAKE_CXX_COMPILER={program('c++')}",
        f"-DCMAKE_CXX_FLAGS={' '.join(QUICKLY_COMPILED)}",
    ]
    subprocess.run([cmake, *given], check=True, capture_output=True)
    subprocess.run([cmake, "--build", built], check=True, capture_output=True)
    told = "\n".join(lines)
    done = subprocess.run([built / "loads"], input=told, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    found = np.array([line.split() for line in done.stdout.splitlines()], dtype=np.float64)
    for rotor, at in asked.values():
        omega, along, across = at.T
        own = rotor.loads_at_velocity(omega, np.stack([across, 0.0 * across, along], axis=-1))
        loads = np.stack([getattr(own, name) for name in LOADS], axis=-1)
        assert np.isfinite(loads).all()
        mine, found = found[: len(at)], found[len(at) :]
        np.testing.assert_allclose(mine[:, :6], loads, rtol=1e-12, atol=1e-12 * abs(loads).max())
        assert [STATUSES[int(k)] for k in mine[:, 6]] == own.status.tolist()
    assert found.size == 0
