"""The compiled core is there and suits this processor, and other builds give its loads."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from propmap import core

LOADS = """
import importlib.util, sys
import numpy as np

if len(sys.argv) > 2:
    spec = importlib.util.spec_from_file_location("propmap._core_v3", sys.argv[2])
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    sys.modules["propmap._core"] = module
import propmap as pm
from propmap import core

assert (core.instructions() == "x86-64-v3") == (len(sys.argv) > 2)
random = np.random.default_rng(7)
omega, speed, beta = random.uniform([200, 0, 0], [1000, 20, np.pi], (4000, 3)).T
blade, law = pm.propeller("apc-8x6e"), pm.airfoil("paper-soft")
loss = pm.Model(blade, law, corrections=(pm.correction("tip-loss"),))
found = []
for model in (pm.Model(blade, law), loss, pm.catalogue_model("APC 8x6E")):
    rotor = pm.Rotor(model)
    loads, rest = rotor.loads(omega, speed, beta), rotor.loads(omega, 0.0, 0.0)
    found += [loads.thrust / rest.thrust, loads.drag / rest.thrust, loads.torque / rest.torque]
np.save(sys.argv[1], found)
"""


def test_core_is_the_build_for_this_processor() -> None:
    assert core.instructions() in ("native", "generic", core.best_instructions())


@pytest.mark.slow
def test_a_build_with_shorter_vectors_gives_these_loads(tmp_path: Path) -> None:
    """AVX-512 has vectors twice as long as AVX2."""
    if core.best_instructions() != "x86-64-v4":
        pytest.skip(f"{core.best_instructions()} has no longer vectors than x86-64-v3")
    cmake = Path(sys.executable).with_name("cmake")
    options = ["-DPROPMAP_PORTABLE=ON", f"-DPython_EXECUTABLE={sys.executable}"]
    options += ["-GNinja", "-DCMAKE_BUILD_TYPE=Release", "-S", str(Path(__file__).parents[2])]
    subprocess.run([cmake, *options, "-B", tmp_path], check=True)
    subprocess.run([cmake, "--build", tmp_path, "--target", "_core_v3"], check=True)
    (module,) = tmp_path.glob("_core_v3.*.so")
    found = []
    for own in ([], [str(module)]):
        file = tmp_path / f"{len(own)}.npy"
        subprocess.run([sys.executable, "-c", LOADS, file, *own], check=True)
        found.append(np.load(file))
    assert found[0].shape == (9, 4000)
    np.testing.assert_allclose(found[0], found[1], rtol=0.0, atol=1e-12)
