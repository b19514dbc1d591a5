"""The scripts in examples/, which the documentation's pages include, run and print loads."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.export import export_table
from propmap.table import LoadTable, build_table

from ..export.needed import package
from .pages import ROOT

EXAMPLES = ROOT / "examples"
EXPORTED = {
    "rotorpy_hover.py": ("rotorpy", "rotorpy"),
    "rotorpy_dynamic_inflow.py": (None, "rotorpy"),
    "casadi_drag.py": ("multinomial", "casadi"),
    "casadi_gates.py": ("multinomial", "casadi"),
    "gymnasium_hover.py": (None, "gymnasium"),
    "learn_forward_flight.py": (None, "mujoco"),
    "hover_in_mujoco.py": (None, "mujoco"),
}
"""Examples that start from an export, or need a package: the target and the package."""


def derivatives_agree(text: str) -> None:
    (axial,) = re.findall(r"velocity +\[(\S+)", text)
    (difference,) = re.findall(r"differences, axial +(\S+)", text)
    assert float(axial) == pytest.approx(float(difference), rel=0.01)


def newton_arrives(text: str) -> None:
    """The last of Newton's steps ends at the climb that was wanted."""
    assert re.findall(r"(\S+) m/s at the end", text)[-1] == "+0.5000"


def thrust_shoots_over(text: str) -> None:
    """The inflow that lags behind leaves more thrust at first, and none in the end."""
    pairs = np.array(re.findall(r"weight (\S+), without inflow lag (\S+)", text), float)
    excess = pairs[:, 0] - pairs[:, 1]
    assert excess.max() > 0.03 and abs(excess[-1]) < 0.01


def gains_are_learned(text: str) -> None:
    """Cost falls with every line, to less than half, and the vehicle is faster in the end."""
    found = np.array(re.findall(r"cost (\S+); in the end (\S+) m/s", text), float)
    assert (np.diff(found[:, 0]) < 0.0).all() and found[-1, 0] < 0.5 * found[0, 0]
    assert found[-1, 1] > found[0, 1]


def hover_is_stabilized(text: str) -> None:
    """Hover is unstable, with feedback stable; the vehicle arrives."""
    printed = re.findall(r"eigenvalues \[1/s\], (.*?): \[([^]]*)\]", text)
    largest = {
        name: max(float(x) for x in re.findall(r"(?<!\S)-?[\d.]+(?=\s*[-+]|\s|$)", values))
        for name, values in printed
    }
    assert largest["hover"] > 0.3 and max(largest["hover with LQR"], largest["inflow"]) < -1.0
    distances = [float(found) for found in re.findall(r"s: (\S+) m from the target", text)]
    assert distances[0] == 1.5 and distances[-1] < 1e-3


def gates_are_passed(text: str) -> None:
    """The polynomial passes the gates much closer than the hover model, in little more time."""
    found = re.findall(r": (\S+) s, .* at most (\S+) m from the plan", text)
    (duration, off), (sooner, farther) = np.array(found, float)
    assert sooner < duration < 1.05 * sooner and off < 0.08 < 0.2 < farther


CHECKS = {
    "casadi_gates.py": gates_are_passed,
    "hover_in_mujoco.py": hover_is_stabilized,
    "differentiate_rotor.py": derivatives_agree,
    "rotorpy_dynamic_inflow.py": thrust_shoots_over,
    "differentiate_table.py": newton_arrives,
    "learn_forward_flight.py": gains_are_learned,
}
"""What an example prints, beyond that it prints numbers."""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def table() -> LoadTable:
    """Coarse, and wide enough for the examples."""
    blade, law = propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")
    recommended = propmap.correction("pitt-peters"), propmap.correction("radial-friction")
    model = propmap.Model(blade, law, corrections=recommended)
    ranges = {"omega": (250.0, 1000.0), "speed": (0.0, 9.0), "beta": (0.0, np.pi)}
    brief = {"tolerance": 0.05, "certificate_points": 512}
    return build_table(propmap.Rotor(model), **ranges, **brief)


SCRIPTS = sorted(path.name for path in EXAMPLES.glob("*.py") if path.name != "demo.py")
"""Examples except the demo, which test_demo.py runs."""


def test_drake_s_example_slows_down() -> None:
    """Without a controller: rotor drag and body drag, and a nose that the rotors lift."""
    package("pydrake")
    script = EXAMPLES / "drake" / "rotor_forces.py"
    done = subprocess.run([sys.executable, script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    vectors = np.array([row.split() for row in re.findall(r"\[([^]]+)\]", done.stdout)], float)
    forward, pitching = vectors[::2, 0], vectors[1::2, 1]
    assert (np.diff([10.0, *forward]) < -0.2).all() and (np.diff([0.0, *pitching]) < -0.3).all()


@pytest.mark.parametrize(
    ("command", "lag", "message"),
    [
        ([np.nan] * 4, 0.03, "not finite"),
        ([np.inf] * 4, 0.03, "not finite"),
        ([-2000.0] * 4, 0.03, "no loads at this operating point .*outside"),
        ([700.0] * 3, 0.03, "size=4 for input port 'command'"),
        ([700.0] * 4, -0.03, "time_constant is -0.03 s"),
        ([700.0] * 4, np.nan, "time_constant is nan s"),
    ],
)
def test_drake_s_example_refuses_bad_input(
    table: LoadTable, command: list[float], lag: float, message: str
) -> None:
    package("pydrake")
    from examples.drake.rotor_forces import Simulator, flying

    vehicle = propmap.read_vehicle(EXAMPLES / "quadrotor.toml").vehicle

    def fly() -> None:
        diagram = flying(propmap.VehicleForces(vehicle, table), lag)
        simulator = Simulator(diagram)
        context = simulator.get_mutable_context()
        rotors = diagram.GetSubsystemByName("rotors").GetMyMutableContextFromRoot(context)
        rotors.SetContinuousState([700.0] * 4)
        diagram.GetInputPort("command").FixValue(context, command)
        simulator.AdvanceTo(0.2)

    with pytest.raises((ValueError, RuntimeError), match=message):
        fly()


@pytest.mark.parametrize("name", SCRIPTS)
def test_an_example_runs(name: str, table: LoadTable, tmp_path: Path) -> None:
    target, needed = EXPORTED.get(name, (None, None))
    if needed is not None:
        package(needed)
    table.save(tmp_path / "map.npz")
    if target is not None:
        export_table(table, target, tmp_path)
    shutil.copy(EXAMPLES / name, tmp_path)
    command, quiet = [sys.executable, name], os.environ | {"MPLBACKEND": "agg"}
    done = subprocess.run(command, cwd=tmp_path, env=quiet, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.strip()
    # The table's example asks once outside the envelope, on purpose, and prints nan.
    allowed = 1 if name == "query_table.py" else 0
    assert len(re.findall(r"\bnan\b", done.stdout)) == allowed, done.stdout
    CHECKS.get(name, lambda _: None)(done.stdout)
