"""The package imports without its heavy parts."""

from __future__ import annotations

import subprocess
import sys


def test_import_brings_neither_jax_nor_scipy_nor_matplotlib() -> None:
    code = (
        "import sys, propmap\n"
        "propmap.propeller('apc-8x6e'), propmap.airfoil('paper-apc'), propmap.Air()\n"
        "heavy = {'jax', 'scipy', 'matplotlib', 'xarray', 'pandas'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
        "assert propmap.Rotor.__name__ == 'Rotor'\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
