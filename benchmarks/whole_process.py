"""Time of a whole `propmap` process: nothing compiled yet, and the same again."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence


def whole_process(arguments: Sequence[str], repeats: int) -> dict[str, float]:
    """Medians of ``repeats`` of the whole process [s], with an empty and with a filled cache."""
    command = [sys.executable, "-m", "propmap", *arguments]

    def run(folder: str) -> float:
        # The command line's own settings of the cache, with another folder.
        settings = {
            "JAX_COMPILATION_CACHE_DIR": folder,
            "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0.3",
            "JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES": "0",
        }
        start = time.perf_counter()
        subprocess.run(command, env=os.environ | settings, check=True, stdout=subprocess.DEVNULL)
        return time.perf_counter() - start

    cold, warm = [], []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as folder:
            cold.append(run(folder))
            warm.append(run(folder))
    return {"empty_cache_s": statistics.median(cold), "warm_cache_s": statistics.median(warm)}
