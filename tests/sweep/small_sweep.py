"""A small sweep, which tests run, kill and run again; ``python -m`` runs it alone."""

from __future__ import annotations

import functools
import sys
from pathlib import Path
from typing import Any

import numpy as np

import propmap
from propmap.rotor import Rotor
from propmap.sweep.points import Grid
from propmap.sweep.run import Sweep, sweep_to_store

POINTS_PER_TASK = 6

GRID = Grid(np.linspace(3000.0, 7000.0, 4), np.linspace(0.0, 15.0, 5), np.linspace(0.0, 180.0, 6))
"""20 tasks of 6 points, hover, descent and oblique flight among them."""


@functools.cache
def rotor() -> Rotor:
    model = propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"))
    return Rotor(model)


def sweep() -> Sweep:
    return Sweep(rotor(), GRID, points_per_task=POINTS_PER_TASK)


def swept(path: Path, **more: Any) -> dict[str, bytes]:
    """Run the sweep, or what is left of it, into a store; files of the store, by name."""
    sweep_to_store(rotor(), GRID, path, points_per_task=POINTS_PER_TASK, **more)
    return contents(path)


def contents(path: Path) -> dict[str, bytes]:
    """Files of a store with results, by name; what tells of the run is left out."""
    return {
        str(file.relative_to(path)): file.read_bytes()
        for file in sorted(path.rglob("*"))
        if file.is_file() and file.parent != path
    }


def finished(path: Path) -> dict[str, int]:
    """When the tasks that are done were written, by the name of a file."""
    files = (path / name for name in contents(path) if name.startswith("status/c"))
    # A process that is killed while it writes leaves a temporary file, which no reader sees.
    return {str(one): one.stat().st_mtime_ns for one in files if one.suffix != ".partial"}


if __name__ == "__main__":
    where, *cluster = sys.argv[1:]
    if cluster:
        from propmap.cluster import connected

        with connected(cluster[0]) as workers:
            swept(Path(where), workers=workers)
    else:
        swept(Path(where))
