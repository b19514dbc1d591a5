"""How fast on a GPU: `make bench-accelerator`.  Writes results/accelerator.json.

Needs JAX with the accelerator's plugin, for NVIDIA `pip install 'jax[cuda12]'` in the same
environment; without one it says so and measures nothing.  The mixed oblique batch of
`benchmarks.speed`, in float64 and float32; errors against twice the nodes of "fine" in float64, at
random points that are fresh in each run; and the share of the device's peak that blade elements
reach in the largest batch, see `benchmarks.roofline`.
"""

from __future__ import annotations

import functools
import sys
import time
from typing import Any

import jax
import numpy as np

import propmap
from benchmarks.convergence import dense
from benchmarks.results_file import machine, write_results
from benchmarks.roofline import operations_per_point, share_of_peak
from benchmarks.speed import median_seconds, oblique
from propmap.engine.evaluation import evaluate, prepare
from propmap.loads import LOADS, error_scales
from propmap.model.model import Model
from propmap.rotor import PRECISIONS, Rotor

SIZES = (10_000, 100_000, 1_000_000)
"""Operating points."""

CHECKED = 500
"""Points that are compared with the reference."""


def measure(sizes: tuple[int, ...] = SIZES, checked: int = CHECKED) -> dict[str, Any]:
    """Points per second by batch and precision, and errors, on the device that JAX computes on."""
    device = jax.devices()[0]
    blade, section = propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")
    seed = time.time_ns() % 2**32
    found: dict[str, Any] = {"machine": machine(), "device": device.device_kind, "seed": seed}
    flow, truth, scale = reference(Rotor(Model(blade, section)), seed, checked)
    asked = operations_per_point(Rotor(Model(blade, section)), checked)
    found |= asked
    for precision in PRECISIONS:
        rotor = Rotor(Model(blade, section), precision=precision)
        loads = rotor.loads(*flow)
        errors = {
            name: float(np.nanmax(np.abs(getattr(loads, name) - truth[name]) / scale[name]))
            for name in LOADS
        }
        per_second = {}
        for size in sizes:
            call = functools.partial(rotor.loads, *oblique(size))
            per_second[str(size)] = size / median_seconds(call, 3)
        lost = int(np.isnan(loads.thrust).sum())
        found[precision] = {
            "points_per_second": per_second,
            "largest_error_of_static": errors,
            "not_found": lost,
            **share_of_peak(precision, per_second[str(sizes[-1])], asked["operations_per_point"]),
        }
    memory = device.memory_stats() or {}
    found["peak_megabytes"] = memory.get("peak_bytes_in_use", 0) / 2**20
    return found


def reference(rotor: Rotor, seed: int, count: int) -> tuple[Any, dict[str, Any], dict[str, Any]]:
    """Random oblique points, their loads with far more nodes, and the static loads to scale by."""
    rng = np.random.default_rng(seed)
    omega, speed, beta = (a[rng.integers(0, SIZES[0], count)] for a in oblique(SIZES[0]))
    speed, beta = speed * rng.uniform(0.9, 1.0, count), beta * rng.uniform(0.9, 1.0, count)
    ready, still = prepare(rotor.arrays), np.zeros(count)
    flow = (omega, speed * np.cos(beta), speed * np.sin(beta))
    best, static = (evaluate(ready, dense(), *f) for f in (flow, (omega, still, still)))
    scale = error_scales(static.loads._asdict(), rotor.model.propeller.radius)
    return (omega, speed, beta), best.loads._asdict(), scale


def main() -> None:
    """Measure, print, and write the results."""
    if jax.default_backend() == "cpu":
        sys.exit("JAX finds no accelerator here: nothing measured (pip install 'jax[cuda12]'?)")
    found = measure()
    print(found["device"])
    for precision in PRECISIONS:
        for size, rate in found[precision]["points_per_second"].items():
            print(f"{precision}, batch of {size}: {rate:.3g} points per second")
        print(f"{precision}: largest errors {found[precision]['largest_error_of_static']}")
        print(f"{precision}: {found[precision]['share']:.1%} of the device's peak")
    print(f"peak memory of the device: {found['peak_megabytes']:.0f} MB")
    print(write_results("accelerator.json", found))


if __name__ == "__main__":
    main()
