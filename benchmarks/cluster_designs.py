"""What a point of a task and a design of a study cost a core."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from benchmarks.cluster_rotor import LARGE, grid, model
from propmap.io.csv import OperatingPoints
from propmap.rotor import Rotor
from propmap.study.run import Study
from propmap.sweep.run import POINTS_PER_TASK, Sweep


def designs() -> dict[str, Any]:
    """Processor time of a core [s]: per point of a task, and per design of a study."""
    from propmap.tasks import on_cores

    found: dict[str, Any] = {}
    whole = grid(LARGE)
    with on_cores(1):
        for accuracy in ("standard", "fine"):
            sweep = Sweep(Rotor(model("recommended"), accuracy=accuracy), whole)
            rng = np.random.default_rng(2)
            size = POINTS_PER_TASK if accuracy == "standard" else 4096
            part = OperatingPoints(
                rng.uniform(3000.0, 8000.0, size),
                rng.uniform(0.0, 20.0, size),
                rng.uniform(0.0, 180.0, size),
            )
            found[f"point_{accuracy}_s"] = _least(lambda s=sweep, p=part: s.values(p)) / size
        axes = {
            "rpm": np.linspace(3000.0, 8000.0, 4),
            "speed_mps": np.linspace(0.0, 20.0, 5),
            "beta_deg": np.linspace(0.0, 180.0, 5),
        }
        varied = {"diameter": np.array([0.18, 0.24]), "pitch": np.array([0.1, 0.18])}
        study = Study(Rotor(model("recommended")), varied, axes, 64)
        some = study.part((0, 0, 0, 0), (16, 4, 5, 5))
        found["design_points"] = 100
        found["design_s"] = _least(lambda: study.values(some)) / 16
    return found


def _least(action: Any) -> float:
    """Least processor time [s] of three runs, after one that compiles."""
    action()
    times = []
    for _ in range(3):
        start = time.process_time()
        action()
        times.append(time.process_time() - start)
    return min(times)
