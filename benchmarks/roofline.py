"""What share of the processor's peak is reached: `make bench-roofline`.

Writes results/roofline.json.  The peak is measured, on whatever device JAX computes:
multiplications and additions in registers, with nothing to fetch.  Beside it stand the operations
that the blade elements of a load evaluation ask for, as XLA counts them; survey, folds, bounds and
the choice of steps are not counted, nor what is computed for points that wait for others.  A point
has a few numbers to fetch and hundreds of thousands of operations, so that memory is no limit.
"""

from __future__ import annotations

import functools
from typing import Any
from unittest import mock

import jax
import jax.numpy as jnp
import numpy as np

import propmap
from benchmarks.results_file import machine, write_results
from benchmarks.speed import BATCH, median_seconds, oblique
from propmap.engine.accuracy import accuracy
from propmap.engine.batch import Block
from propmap.engine.evaluation import evaluate_flow, prepare
from propmap.engine.programs import Flow
from propmap.model.model import Model
from propmap.physics.element import Annulus, Station, element_forces
from propmap.rotor import PRECISIONS, Rotor
from propmap.solve import disk
from propmap.solve.disk import DiskSolution
from propmap.typing import Floats

CHAINS, LINKS = 8, 32
"""Chains of operations per number that do not wait for each other, and operations in each."""

NUMBERS = 1 << 22
"""Of which the chains begin."""

COUNTED = 512
"""Points whose evaluations are counted, and elements whose operations are."""

MOST_EVALUATIONS = 60


def peak_per_second(precision: str) -> float:
    """Floating-point operations per second at the most, one multiplication or addition each."""

    @jax.jit
    def chains(start: Any, factor: Any, more: Any) -> Any:
        total = jnp.zeros_like(start)
        for chain in range(CHAINS):
            x = start + chain
            for _ in range(LINKS):
                x = x * factor + more
            total = total + x
        return total

    with jax.enable_x64(precision == PRECISIONS[0]):
        kind = jnp.dtype(precision)
        start = jnp.linspace(0.0, 1.0, NUMBERS, dtype=kind)
        factor, more = jnp.asarray(0.5, kind), jnp.asarray(0.25, kind)
        seconds = median_seconds(lambda: chains(start, factor, more).block_until_ready(), 9)
    return 2.0 * CHAINS * LINKS * NUMBERS / seconds


def element_operations(rotor: Rotor) -> dict[str, float]:
    """Operations per blade element, by XLA's count: of a force with its slope; of both forces."""
    one: Any = np.ones(COUNTED)
    station, blade = Station(one, one, one, one, one, one), rotor.arrays.blade
    ends = (blade.blades, blade.root, blade.tip)
    at = Annulus(station, one, one, one, *ends, rotor.arrays.law)

    def of(forces: Any) -> float:
        # What an annulus takes once for all of its elements is given, and not counted.
        cost: Any = jax.jit(forces).lower(at, one, one).cost_analysis()
        return float(cost["flops"] + cost.get("transcendentals", 0.0)) / COUNTED

    with jax.enable_x64(True):
        return {
            "slope": of(lambda *a: element_forces(*a)[::2]),
            "forces": of(lambda *a: element_forces(*a)[:2]),
        }


def elements_per_point(rotor: Rotor, batch: tuple[Floats, ...]) -> dict[str, float]:
    """Blade elements that the roots of (11) and the loads of a point ask for, on average.

    A search is cut off after one evaluation, two, and so on, and the nodes left over are counted.
    """
    omega, speed, beta = batch
    flow = Flow(omega, speed * np.cos(beta), speed * np.sin(beta), None)
    ready = prepare(rotor.arrays, compiled=False)
    searched, loads = 0, 0

    def unfinished(most: int) -> tuple[int, int]:
        left: dict[int, tuple[int, int]] = {}

        def count(block: Block, solution: DiskSolution) -> None:
            own = np.maximum(block.azimuths // 2, 1)
            lost = np.isnan(np.asarray(solution.inflow))
            for point, nodes, elements in zip(
                block.points, (lost * own).sum(axis=0), lost.shape[0] * own, strict=True
            ):
                left[int(point)] = (int(nodes), int(elements))

        with mock.patch.object(disk, "MAX_STEPS", most):
            evaluate_flow(ready, accuracy("standard"), flow, solved=count)
        nodes, elements = zip(*left.values(), strict=True)
        return sum(nodes), sum(elements)

    for most in range(MOST_EVALUATIONS):
        left, loads = unfinished(most)
        searched += left
        if left == 0:
            break
    return {"roots": searched / omega.size, "loads": loads / omega.size}


def share_of_peak(precision: str, points_per_second: float, operations: float) -> dict[str, float]:
    """The device's peak, what the elements reach with ``operations`` per point, and its share."""
    peak, reached = peak_per_second(precision), operations * points_per_second
    return {"peak_per_second": peak, "reached_per_second": reached, "share": reached / peak}


def operations_per_point(rotor: Rotor, counted: int = COUNTED) -> dict[str, float]:
    """Elements and operations per point, at so many points of the mixed oblique batch."""
    elements = elements_per_point(rotor, tuple(a[:counted] for a in oblique(BATCH)))
    each = element_operations(rotor)
    total = elements["roots"] * each["slope"] + elements["loads"] * each["forces"]
    return {
        "elements_for_roots": elements["roots"],
        "elements_for_loads": elements["loads"],
        "operations_per_element_with_slope": each["slope"],
        "operations_per_element_for_loads": each["forces"],
        "operations_per_point": total,
    }


def main() -> None:
    """Measure, print, and write the results."""
    blade, section = propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")
    found: dict[str, Any] = {"machine": machine(), "device": jax.devices()[0].device_kind}
    found |= operations_per_point(Rotor(Model(blade, section)))
    for precision in PRECISIONS:
        rotor, batch = Rotor(Model(blade, section), precision=precision), oblique(BATCH)
        seconds = median_seconds(functools.partial(rotor.loads, *batch), 15)
        found[precision] = share_of_peak(precision, BATCH / seconds, found["operations_per_point"])
    for name, value in found.items():
        print(f"{name}: {value}")
    print(write_results("roofline.json", found))


if __name__ == "__main__":
    main()
