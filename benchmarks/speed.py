"""How fast: `make bench`, or `python -m benchmarks.speed`.  Writes results/speed.json.

Whole processes from nothing, as a user starts them, and calls in a running one.  Compare figures
within one run only: another run, or another machine, is another matter.
"""

from __future__ import annotations

import resource
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import propmap
from benchmarks.results_file import machine, write_results
from benchmarks.whole_process import python_process, whole_process
from propmap.dynamic_inflow import DynamicInflow
from propmap.flight.simulate import log_table
from propmap.model.airfoil import parameter_set
from propmap.model.model import Model
from propmap.rotor import Rotor
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
SINGLE = 200
"""Points that are asked for one by one."""

RPM = np.pi / 30.0

FIRST = (1, 10, 100, 1000)
"""Points of a process's first result."""

EXAMPLES = Path(__file__).parents[1] / "examples"
VEHICLE, FLOWN = EXAMPLES / "aircraft" / "delivery.toml", EXAMPLES / "px4" / "vehicle.toml"

README_TABLE = "--airfoil paper-apc --rpm 3000:9000 --speed 0:15 --beta 0:90 --tolerance 1%"

COMMANDS = {
    "propmap predict": "predict apc-8x6e --airfoil paper-apc --rpm 6000 --speed 10 --beta 60",
    "propmap trim, 30 speeds": f"trim {VEHICLE} --speed 0:20:30 -o trim.csv",
    "propmap fit tunnel": "fit tunnel apc-8x6e uiuc-8x6e -o fit.toml",
    "propmap table, README's": f"table apc-8x6e {README_TABLE} --force -o map.npz",
    "propmap choose, whole catalogue": f"choose {VEHICLE} --task cruise --speed 12",
    "propmap fit flight, two flights": "fit flight 0.csv 1.csv --vehicle flown.toml "
    "--method balance -o fit.toml",
    "propmap --help": "--help",
}
"""As a user types them."""

FIRST_RESULT = """
import numpy as np
import propmap
rotor = propmap.Rotor(propmap.catalogue_model("apc-8x6e"))
turn = np.linspace(0.0, 1.0, {count})
rotor.loads(300.0 + 600.0 * turn, 3.0 + 15.0 * turn, 0.2 + 1.2 * turn[::-1])
"""


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


def descent(count: int) -> tuple[Floats, Floats, Floats]:
    """Oblique and steep descent."""
    rng = np.random.default_rng(SEED + 3)
    rpm, speed = rng.uniform(3000.0, 10000.0, count), rng.uniform(0.0, 20.0, count)
    return rpm * RPM, speed, np.radians(rng.uniform(90.0, 180.0, count))


def median_seconds(call: Callable[[], Any], repeats: int) -> float:
    """Median time of ``call`` after one that does not count."""
    call()
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds)


def processes() -> dict[str, dict[str, float]]:
    """Wall and processor time of whole processes [s], medians of three."""
    found = {"import propmap": python_process(["-c", "import propmap"], 3)}
    for count in FIRST:
        code = FIRST_RESULT.format(count=count)
        found[f"first result, points: {count}"] = python_process(["-c", code], 3)
    for name, command in COMMANDS.items():
        with tempfile.TemporaryDirectory() as folder:
            if "flown.toml" in command:
                fly(Path(folder))
            found[name] = whole_process(command.split(), 3, Path(folder))
    return found


def fly(folder: Path) -> None:
    """Two flights of 60 s, and the vehicle file that reads them, into a ``folder``."""
    vehicle = FLOWN.read_text(encoding="utf-8").partition("[log]")[0] + log_table(4)
    (folder / "flown.toml").write_text(vehicle, encoding="utf-8")
    for seed in (0, 1):
        flight = f"simulate flight --vehicle flown.toml --speeds 1:8:8 --banked --seed {seed}"
        rest = f"--airfoil paper-apc --no-expectation -o {seed}.csv"
        whole_process([*flight.split(), *rest.split()], 1, folder)


def single_calls(rotor: Rotor) -> dict[str, dict[str, float]]:
    """Median and largest wall time of one point from Python [us], each point's least of five."""
    omega, speed, beta = oblique(SINGLE)
    angles = {"axial": 0.0 * beta, "oblique": beta, "edgewise": 0.0 * beta + 0.5 * np.pi}
    found = {}
    for name, at in angles.items():
        points = np.stack([omega, speed, at], axis=-1).tolist()
        least = np.full(SINGLE, np.inf)
        for _ in range(5):
            for k, point in enumerate(points):
                start = time.perf_counter()
                rotor.loads(*point)
                least[k] = min(least[k], time.perf_counter() - start)
        found[name] = {"median_us": 1e6 * float(np.median(least)), "most_us": 1e6 * least.max()}
    return found


def per_point(call: Callable[[], Any], points: int, repeats: int = 5) -> dict[str, float]:
    """Wall and processor time of a batch [us per point]: medians, after one that does not count."""
    call()
    wall, processor = [], []
    for _ in range(repeats):
        start, used = time.perf_counter(), time.process_time()
        call()
        wall.append(time.perf_counter() - start)
        processor.append(time.process_time() - used)
    return {
        "wall_us": 1e6 * statistics.median(wall) / points,
        "processor_us": 1e6 * statistics.median(processor) / points,
    }


def batches(rotors: dict[str, Rotor]) -> dict[str, dict[str, float]]:
    """Each model over 4096 points of each kind."""
    kinds = {
        "oblique": oblique(BATCH),
        "envelope": envelope(BATCH),
        "axial, 10 m/s": axial(BATCH, 10.0, 10.0),
        "axial, 0-12 m/s": axial(BATCH, 0.0, 12.0),
        "descent": descent(BATCH),
    }
    return {
        f"{model}, {kind}": per_point(lambda r=rotor, p=points: r.loads(*p), BATCH)  # type: ignore[misc]
        for model, rotor in rotors.items()
        for kind, points in kinds.items()
    }


def gradients(rotors: dict[str, Rotor]) -> dict[str, dict[str, float]]:
    """The oblique batch with derivatives by eight parameters, and by all that bands need."""
    omega, speed, beta = oblique(BATCH)
    flow = (omega, speed * np.cos(beta), speed * np.sin(beta))
    named = {"eight derivatives": GRADIENT, "derivatives of bands": BANDS}
    return {
        f"{model}, {what}": per_point(
            lambda r=rotor, n=names: r.gradients(n, *flow),  # type: ignore[misc]
            BATCH,
        )
        for model, rotor in rotors.items()
        for what, names in named.items()
    }


def inflow_as_state(rotor: Rotor) -> dict[str, float]:
    """Return the number of values in an inflow state of a rotor, and times [us].

    They are the times of the steady wrench, of a step of the dynamic inflow, and of a call that
    returns both the wrench and the state after the step, for one rotor and for four.
    """
    inflow, flight = DynamicInflow(rotor), (600.0, [8.0, 0.0, 2.0])
    state = 0.9 * inflow.steady(*flight)
    four = DynamicInflow(rotor, spin=("ccw", "ccw", "cw", "cw"))
    states, speeds, velocities = (np.array([one] * 4) for one in (state, *flight))
    asked = {
        "wrench": lambda: rotor.wrench(*flight),
        "step": lambda: inflow.step(state, 0.002, *flight),
        "advance": lambda: inflow.advance(state, 0.002, *flight),
        "advance of four rotors": lambda: four.advance(states, 0.002, speeds, velocities),
    }
    times = {name: 1e6 * median_seconds(ask, 500) for name, ask in asked.items()}
    return {"states": inflow.size, **times}


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
    blade, law = propmap.propeller("apc-8x6e"), parameter_set("paper-apc")
    recommended = Model(blade, law, corrections=propmap.model_corrections("recommended"))
    rotors = {"paper": Rotor(Model(blade, law)), "recommended": Rotor(recommended)}
    fine, some = Rotor(rotors["paper"].model, accuracy="fine"), oblique(BATCH // 4)
    coarse = median_seconds(lambda: rotors["paper"].loads(*some), 3)
    return {
        "machine": place,
        "batch": BATCH,
        "processes": processes(),
        "single_call": single_calls(rotors["recommended"]),
        "batches": batches(rotors),
        "gradients": gradients(rotors),
        "inflow_as_state_us": {
            one.model.airfoil.name: inflow_as_state(one)
            for one in (Rotor(propmap.catalogue_model("apc-8x6e")), rotors["recommended"])
        },
        "fine_over_standard": median_seconds(lambda: fine.loads(*some), 3) / coarse,
        "growth": growth(rotors["paper"]),
    }


def main() -> None:
    """Measure, print, and write the results."""
    found = measure()
    where = found["machine"]
    console = Console()
    console.print(
        f"{where['cpu']}, {where['cores']} cores, load {where['load_before']}, "
        f"Python {where['python']}, core for {where['instructions']}"
    )
    cold = Table("whole process", "wall [s]", "processor [s]")
    for name, cost in found["processes"].items():
        cold.add_row(name, f"{cost['wall_s']:.2f}", f"{cost['processor_s']:.2f}")
    single = Table("one call, recommended", "median [us]", "most [us]")
    for name, cost in found["single_call"].items():
        single.add_row(name, f"{cost['median_us']:.0f}", f"{cost['most_us']:.0f}")
    warm = Table(f"batch of {BATCH}", "wall [us per point]", "processor [us per point]")
    for name, cost in (found["batches"] | found["gradients"]).items():
        warm.add_row(name, f"{cost['wall_us']:.1f}", f"{cost['processor_us']:.1f}")
    console.print(cold, single, warm)
    for law, (count, *costs) in ((k, v.values()) for k, v in found["inflow_as_state_us"].items()):
        names = ("wrench", "step", "advance", "advance of four rotors")
        times = ", ".join(f"{n} {one:.0f} us" for n, one in zip(names, costs, strict=True))
        console.print(f"dynamic inflow, {law}, {count} values per state: {times}")
    console.print(f"fine over standard: {found['fine_over_standard']:.1f}")
    for count, cost in found["growth"]["cpu_microseconds_per_point"].items():
        console.print(f"oblique batch of {count}: {cost:.1f} us of processor time per point")
    console.print(f"peak memory: {found['growth']['peak_megabytes']:.0f} MB")
    console.print(str(write_results("speed.json", found)))


if __name__ == "__main__":
    main()
