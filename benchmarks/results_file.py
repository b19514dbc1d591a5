"""Where results go, and what machine they come from."""

from __future__ import annotations

import json
import os
import platform
from pathlib import Path
from typing import Any

import numpy as np

import propmap
from propmap import core
from propmap.io.csv import replacing

RESULTS = Path(__file__).with_name("results")


def write_results(name: str, found: dict[str, Any]) -> Path:
    """Write ``found`` as ``results/name``, whole or not at all; the path."""
    RESULTS.mkdir(exist_ok=True)
    path = RESULTS / name
    with replacing(path) as part:
        part.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
    return path


def machine() -> dict[str, Any]:
    """Processor, cores and versions; the load says whether others were at work."""
    return {
        "cpu": _cpu_model(),
        "cores": os.cpu_count() or 1,
        "load_before": round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None,
        "system": platform.system(),
        "python": platform.python_version(),
        "instructions": core.instructions(),
        "numpy": np.__version__,
        "propmap": propmap.__version__,
    }


def _cpu_model() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
