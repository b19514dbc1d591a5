"""Time of whole processes, from their start to their end."""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src"


def python_process(
    arguments: Sequence[str], repeats: int, folder: Path | None = None
) -> dict[str, float]:
    """Medians of ``repeats`` of Python with these ``arguments``, run in ``folder`` [s].

    The processor time is that of all cores and of the processes started in turn.
    """
    # As installing does, so that the first is like the others.
    subprocess.run([sys.executable, "-m", "compileall", "-q", SOURCE], check=True)
    wall, processor = [], []
    for _ in range(repeats):
        before, start = _children_seconds(), time.perf_counter()
        subprocess.run(
            [sys.executable, *arguments],
            check=True,
            stdout=subprocess.DEVNULL,
            cwd=folder,
        )
        wall.append(time.perf_counter() - start)
        processor.append(_children_seconds() - before)
    return {"wall_s": statistics.median(wall), "processor_s": statistics.median(processor)}


def whole_process(
    arguments: Sequence[str], repeats: int, folder: Path | None = None
) -> dict[str, float]:
    """Time of `propmap` with these ``arguments``."""
    return python_process(["-m", "propmap", *arguments], repeats, folder)


def _children_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
