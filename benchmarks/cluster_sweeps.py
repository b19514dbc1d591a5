"""One sweep with and without workers: times, whether results are the same, and memory."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.cluster_rotor import LARGE, SMALL, grid, rotor, usage
from propmap.cluster import DaskWorkers, connected
from propmap.sweep.run import sweep_to_store
from propmap.tasks import InTurn


def one_sweep(shape: tuple[int, int, int], cluster: str, path: str) -> dict[str, Any]:
    """A whole sweep in this process and its workers: times [s] and peaks of memory [MB]."""
    start = time.perf_counter()
    with contextlib.ExitStack() as stack:
        workers = stack.enter_context(connected(cluster)) if cluster else InTurn()
        sweep_to_store(rotor(), grid(shape), Path(path), workers=workers)
        wall, peaks = time.perf_counter() - start, {}
        if isinstance(workers, DaskWorkers):
            peaks = workers.client.run(usage)
    own = usage()
    return {
        "wall_s": wall,
        "processor_s": own["processor_s"] + sum(one["processor_s"] for one in peaks.values()),
        "client_peak_MB": own["peak_MB"],
        "worker_peaks_MB": sorted(one["peak_MB"] for one in peaks.values()),
    }


def sweeps() -> dict[str, Any]:
    """Both sizes, by this process and by two workers, each in a process of its own."""
    found: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, shape in (("1e5", SMALL), ("2e6", LARGE)):
            contents = []
            for who, cluster in (("one_process", ""), ("local_2", "local:2")):
                path = f"{folder}/{name}-{who}.zarr"
                command = [sys.executable, "-m", "benchmarks.cluster_sweeps", name, cluster, path]
                told = subprocess.run(command, check=True, capture_output=True, text=True)
                found[f"{name}_{who}"] = json.loads(told.stdout.splitlines()[-1])
                contents.append(_contents(Path(path)))
            found[f"{name}_same_bits"] = contents[0] == contents[1]
            size = sum(len(content) for content in contents[0].values())
            found[f"{name}_bytes_per_point"] = size / np.prod(shape)
            found[f"{name}_files"] = len(contents[0])
    for what in ("wall_s", "processor_s"):
        found[f"ratio_of_{what}"] = found["2e6_local_2"][what] / found["2e6_one_process"][what]
    return found


def _contents(path: Path) -> dict[str, bytes]:
    return {
        str(file.relative_to(path)): file.read_bytes()
        for file in path.rglob("*")
        if file.is_file() and file.parent != path
    }


if __name__ == "__main__":
    _, points, where, store = sys.argv
    print(json.dumps(one_sweep(SMALL if points == "1e5" else LARGE, where, store)))
