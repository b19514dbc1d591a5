"""The core is the build for this processor, and the other builds of a wheel have the same loads."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from propmap import core

LOADS = """
import importlib.util, sys
from pathlib import Path
import numpy as np

name = Path(sys.argv[2]).name.split(".")[0]
spec = importlib.util.spec_from_file_location(f"propmap.{name}", sys.argv[2])
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
sys.modules["propmap._core"] = module
import propmap as pm
from propmap import core

assert core.instructions() == name.replace("_core_", "x86-64-")
random = np.random.default_rng(7)
omega, speed, beta = random.uniform([200, 0, 0], [1000, 20, np.pi], (1000, 3)).T
blade, law = pm.propeller("apc-8x6e"), pm.airfoil("paper-soft")
loss = pm.Model(blade, law, corrections=(pm.correction("tip-loss"),))
found = []
for model in (pm.Model(blade, law), loss, pm.catalogue_model("APC 8x6E")):
    rotor = pm.Rotor(model)
    loads, rest = rotor.loads(omega, speed, beta), rotor.loads(omega, 0.0, 0.0)
    found += [loads.thrust / rest.thrust, loads.drag / rest.thrust, loads.torque / rest.torque]
np.save(sys.argv[1], found)
"""
BUILDS = sorted(core.HEADERS.parent.glob("_core_v*.so"))
"""Of a wheel, from the shortest vectors to the longest; an installation from source has none."""


def test_core_is_the_build_for_this_processor() -> None:
    assert core.instructions() in ("native", "generic", core.best_instructions())


@pytest.mark.skipif(not BUILDS, reason="only wheels have several builds; make wheels tests them")
def test_all_builds_have_the_same_loads(tmp_path: Path) -> None:
    found = []
    for build in BUILDS:
        if build.name.split(".")[0].replace("_core_", "x86-64-") <= core.best_instructions():
            file = tmp_path / f"{build.name}.npy"
            subprocess.run([sys.executable, "-c", LOADS, file, build], check=True)
            found.append(np.load(file))
    assert len(found) > 1 and found[0].shape == (9, 1000)
    # The oldest level rounds products before it adds them: 1.2e-11 in the search for the inflow.
    for loads in found[:-1]:
        np.testing.assert_allclose(loads, found[-1], rtol=0.0, atol=1e-10)
