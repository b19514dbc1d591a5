"""How fast: `make bench`, or `python -m benchmarks.speed`.  Writes results/speed.json.

Medians of repeats on this machine, after compilation unless said otherwise.  Compare figures
within one run only: another run, or another machine, is another matter.
"""

from __future__ import annotations

import resource
import statistics
import time
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

import propmap
from benchmarks.results_file import machine, write_results
from benchmarks.whole_process import whole_process
from propmap.engine.accuracy import accuracy
from propmap.engine.evaluation import prepare
from propmap.engine.gradients import load_gradients
from propmap.engine.programs import COMPILER_OPTIONS
from propmap.model.airfoil import parameter_set
from propmap.model.model import Model
from propmap.physics.velocities import AzimuthNodes, azimuth_nodes
from propmap.rotor import Rotor
from propmap.solve.problem import Case, annulus_problem, residual, residual_slope
from propmap.typing import Floats

FLOW, LAW = ("omega", "v_axial", "v_inplane"), ("c_l1", "c_l2", "c_d", "alpha_0", "zero_lift_angle")
GRADIENT = (*FLOW, *LAW)

BAND_LAW = ("c_l1", "c_d", "alpha_0", "zero_lift_angle", "c_d0", "reynolds_camber", "drag_angle")
BANDS = (*BAND_LAW, "chord_scale", "twist_offset")
"""What the uncertainty of a load is made of: the seven section constants of the catalogue, and the
blade's shape."""

GROWING = (1000, 10_000, 100_000, 1_000_000)
"""Operating points."""

SEED = 2017
BATCH = 4096
RPM = np.pi / 30.0

STATIONS, POINTS, AZIMUTHS = 48, 64, 16
"""Of the arrays of blade elements; 16 azimuths are 8 distinct ones."""

DESIGN_NOTES = {
    "XLA, azimuth as inner axis": 50.0,
    "XLA, batch as last axis": 11.0,
    "the same with derivative": 12.0,
    "hand-vectorised C": 3.1,
}
"""[ns] per blade element, from a prototype on another machine."""

PREDICT = ["predict", "apc-8x6e", "--airfoil", "paper-apc", "--format", "json"]
PREDICT += ["--rpm", "6000", "--speed", "10", "--beta", "60"]


def oblique(count: int) -> tuple[Floats, Floats, Floats]:
    """Mixed oblique points: omega [rad/s], speed [m/s], beta [rad], each (count,)."""
    rng = np.random.default_rng(SEED)
    rpm, speed = rng.uniform(3000.0, 10000.0, count), rng.uniform(3.0, 20.0, count)
    return rpm * RPM, speed, np.radians(rng.uniform(15.0, 85.0, count))


def envelope(count: int) -> tuple[Floats, Floats, Floats]:
    """The whole envelope; of every 16 points one hovers, one climbs and one flies edgewise."""
    rng = np.random.default_rng(SEED + 1)
    rpm, speed = rng.uniform(2000.0, 10000.0, count), rng.uniform(0.0, 20.0, count)
    beta = np.radians(rng.uniform(0.0, 90.0, count))
    speed[0::16], beta[1::16], beta[2::16] = 0.0, 0.0, 0.5 * np.pi
    return rpm * RPM, speed, beta


def axial(count: int, slowest: float, fastest: float) -> tuple[Floats, Floats, Floats]:
    """Points in climb."""
    rng = np.random.default_rng(SEED + 2)
    rpm, speed = rng.uniform(3000.0, 10000.0, count), rng.uniform(slowest, fastest, count)
    return rpm * RPM, speed, np.zeros(count)


def median_seconds(call: Callable[[], Any], repeats: int) -> float:
    """Median time of ``call`` after one that does not count."""
    call()
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds)


def element_nanoseconds(rotor: Rotor) -> dict[str, float]:
    """Time per blade element [ns] of the residual of (11), without and with derivative."""
    blade = rotor.arrays.blade
    omega, speed, beta = oblique(POINTS)
    rng = np.random.default_rng(SEED)
    share = np.sort(rng.uniform(0.02, 0.98, (STATIONS, POINTS)), axis=0)
    radius = blade.root + (blade.station[-1] - blade.root) * share
    elements = STATIONS * POINTS * (AZIMUTHS // 2)
    cost = {}
    with jax.enable_x64(True):
        axial, inplane = jnp.asarray(speed * np.cos(beta)), jnp.asarray(speed * np.sin(beta))
        no = jnp.zeros(POINTS)
        case = Case(rotor.arrays, jnp.asarray(omega), axial, inplane, v_hover=no)
        problem = jax.jit(annulus_problem)(case, jnp.asarray(radius))
        v_i = jnp.full((STATIONS, POINTS), 4.0)
        turn = azimuth_nodes(AZIMUTHS)
        nodes = AzimuthNodes(jnp.asarray(turn.sines), jnp.asarray(AZIMUTHS // 2))
        for name, function in (("residual", residual), ("residual_slope", residual_slope)):
            options: Any = COMPILER_OPTIONS
            program: Callable[..., Any] = jax.jit(function, compiler_options=options)

            def call(program: Callable[..., Any] = program) -> None:
                for found in jax.tree.leaves(program(problem, v_i, nodes)):
                    found.block_until_ready()

            cost[name] = 1e9 * median_seconds(call, 200) / elements
    return cost


def gradient_microseconds(
    rotor: Rotor, batch: tuple[Floats, Floats, Floats], names: tuple[str, ...]
) -> dict[str, float]:
    """Loads with their derivatives by ``names``, and the same without [us] per point."""
    omega, speed, beta = batch
    flow = (omega, speed * np.cos(beta), speed * np.sin(beta))
    ready, setting = prepare(rotor.arrays), accuracy("standard")
    plain, with_slopes = [], []
    for kept in (False, True, True, True, True, True):
        start = time.perf_counter()
        rotor.loads(*batch)
        middle = time.perf_counter()
        load_gradients(ready, setting, names, *flow)
        if kept:
            plain.append(middle - start)
            with_slopes.append(time.perf_counter() - middle)
    both = [1e6 * statistics.median(seconds) / omega.size for seconds in (plain, with_slopes)]
    return {"plain": both[0], "with_gradient": both[1], "ratio": both[1] / both[0]}


def growth(rotor: Rotor) -> dict[str, Any]:
    """Processor time per point, all cores together, of batches of a thousand to a million points,
    in turn lest a slow minute strike one size, and the memory that they take."""
    before = resident_megabytes()
    batches = {count: oblique(count) for count in GROWING}
    costs: dict[int, list[float]] = {count: [] for count in GROWING}
    for turn in range(4):
        for count, batch in batches.items():
            calls = max(1, GROWING[1] // count) if turn else 1
            if count == GROWING[-1] and turn != 2:
                continue
            start = time.process_time()
            for _ in range(calls):
                rotor.loads(*batch)
            if turn:
                costs[count].append(1e6 * (time.process_time() - start) / (calls * count))
    per_point = {str(count): statistics.median(cost) for count, cost in costs.items()}
    return {
        "cpu_microseconds_per_point": per_point,
        "most_over_least": max(per_point.values()) / min(per_point.values()),
        "peak_megabytes": resident_megabytes(),
        "peak_megabytes_before": before,
    }


def resident_megabytes() -> float:
    """Most memory that this process has held so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def measure() -> dict[str, Any]:
    """All figures."""
    place = machine()
    blade, section = propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")
    rotor, fine = Rotor(Model(blade, section)), Rotor(Model(blade, section), accuracy="fine")
    terms = parameter_set("paper-apc").with_parameters(reynolds_camber=-0.02, drag_angle=0.025)
    of_catalogue = Rotor(Model(blade, terms))
    omega = 6000.0 * RPM
    batches = {
        "oblique": oblique(BATCH),
        "envelope": envelope(BATCH),
        "axial, 10 m/s": axial(BATCH, 10.0, 10.0),
        "axial, 0-12 m/s": axial(BATCH, 0.0, 12.0),
    }
    per_point = {
        name: 1e6 * median_seconds(lambda b=batch: rotor.loads(*b), 5) / BATCH  # type: ignore[misc]
        for name, batch in batches.items()
    }
    flight = (omega, 10.0, np.radians(60.0))
    single = {
        "oblique": 1e3 * median_seconds(lambda: rotor.loads(*flight), 30),
        "hover": 1e3 * median_seconds(lambda: rotor.loads(omega, 0.0, 0.0), 30),
    }
    some = oblique(BATCH // 4)
    coarse = median_seconds(lambda: rotor.loads(*some), 3)
    ratios = {
        "single_call_over_batch_point": 1e3 * single["oblique"] / per_point["oblique"],
        "fine_over_standard": median_seconds(lambda: fine.loads(*some), 3) / coarse,
    }
    return {
        "machine": place,
        "batch": BATCH,
        "microseconds_per_point": per_point,
        "single_call_ms": single,
        "ns_per_element": element_nanoseconds(rotor),
        "design_notes_ns_per_element_on_another_machine": DESIGN_NOTES,
        "process": whole_process(PREDICT, 3),
        "ratios": ratios,
        "gradient": gradient_microseconds(rotor, batches["oblique"], GRADIENT),
        "bands": gradient_microseconds(of_catalogue, batches["oblique"], BANDS),
        "growth": growth(rotor),
    }


def main() -> None:
    """Measure, print, and write the results."""
    found = measure()
    where = found["machine"]
    print(
        f"{where['cpu']}, {where['cores']} cores, load {where['load_before']}, "
        f"Python {where['python']}, JAX {where['jax']}"
    )
    for name, value in found["microseconds_per_point"].items():
        print(f"batch of {BATCH}, {name}: {value:.1f} us per point")
    for name, value in found["single_call_ms"].items():
        print(f"single warm call, {name}: {value:.2f} ms")
    for name, value in found["ns_per_element"].items():
        print(f"blade element, {name}: {value:.1f} ns")
    for name, value in DESIGN_NOTES.items():
        print(f"  prototype on another machine, {name}: {value:g} ns")
    for name, value in found["process"].items():
        print(f"propmap predict, whole process, {name}: {value:.2f}")
    for name, value in found["ratios"].items():
        print(f"{name}: {value:.1f}")
    for name, value in found["gradient"].items():
        print(f"gradient by {len(GRADIENT)} parameters, {name}: {value:.1f}")
    for name, value in found["bands"].items():
        print(f"bands by {len(BANDS)} parameters, {name}: {value:.1f}")
    for count, value in found["growth"]["cpu_microseconds_per_point"].items():
        print(f"oblique batch of {count}: {value:.1f} us of processor time per point")
    print(f"peak memory: {found['growth']['peak_megabytes']:.0f} MB")
    print(write_results("speed.json", found))


if __name__ == "__main__":
    main()
