"""How fast tables answer and are built: `make bench`; `make bench ONLY='table fine'` for 0.1 %.

The table is the one of the README: the APC 8x6E over 2000-10000 rpm, 0-20 m/s and all angles, at
0.5 %.  Beside it, in the same run, the full model and RotorPy's rotor model.  Times are processor
time, all cores together, and the least of several repeats, since others may be at work on the
machine; compare within one run.
Writes results/table.json, or results/fine_table.json.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import propmap
from benchmarks.c_header import c_nanoseconds
from benchmarks.results_file import machine, write_results
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.table import LoadTable, build_table
from propmap.typing import Floats

RPM = np.pi / 30.0
ENVELOPE = {
    "omega": (2000.0 * RPM, 10000.0 * RPM),
    "speed": (0.0, 20.0),
    "beta": (0.0, np.pi),
}
POINTS, SINGLE, BATCH = 100_000, 500, 4096

COLD = "from propmap.table import LoadTable; LoadTable.load({path!r}).loads(628.0, 12.0, 1.2)"


def least_seconds(
    call: Callable[[], Any], repeats: int, clock: Callable[[], float] = time.process_time
) -> float:
    """Least time of ``call``, after one that does not count."""
    call()
    seconds = []
    for _ in range(repeats):
        start = clock()
        call()
        seconds.append(clock() - start)
    return min(seconds)


def built(tolerance: float, accuracy: str) -> tuple[LoadTable, Rotor, dict[str, Any]]:
    """The table, its rotor, and what building it took."""
    rotor = Rotor(
        Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")), accuracy=accuracy
    )
    wall, processor = time.perf_counter(), time.process_time()
    table = build_table(
        rotor,
        omega=ENVELOPE["omega"],
        speed=ENVELOPE["speed"],
        beta=ENVELOPE["beta"],
        tolerance=tolerance,
    )
    figures = {
        "tolerance": tolerance,
        "accuracy": accuracy,
        "wall_s": time.perf_counter() - wall,
        "processor_s": time.process_time() - processor,
        "model_evaluations": table.info["model_evaluations"],
        "knots": [table.content.advance.size, table.content.beta.size],
        "file_MB": file_size(table) / 1e6,
        "certificate": table.certificate,
    }
    return table, rotor, figures


def file_size(table: LoadTable) -> int:
    """Bytes of the table's file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.npz"
        table.save(path)
        return path.stat().st_size


def random_points(count: int) -> tuple[Floats, Floats, Floats]:
    """omega [rad/s], speed [m/s], beta [rad] all over the envelope, (count,) each."""
    low, high = np.array(list(ENVELOPE.values())).T
    unit = np.random.default_rng(2017).random((count, 3))
    omega, speed, beta = (low + (high - low) * unit).T
    return omega, speed, beta


def query_microseconds(table: LoadTable) -> dict[str, float]:
    """Time per point [us] of queries from Python."""
    some = list(zip(*(x[:SINGLE].tolist() for x in random_points(POINTS)), strict=True))
    omega, speed, beta = random_points(POINTS)
    velocity = np.stack([speed * np.sin(beta), np.zeros(POINTS), speed * np.cos(beta)], axis=-1)
    vectors = list(zip(omega[:SINGLE].tolist(), velocity[:SINGLE], strict=True))
    thrust = np.asarray(table.loads(omega, speed, beta).thrust)
    wanted = list(zip(thrust.tolist(), speed.tolist(), beta.tolist(), strict=True))[:50]

    def each(call: Callable[..., Any], points: list[Any], repeats: int = 30) -> float:
        def loop() -> None:
            for point in points:
                call(*point)

        return 1e6 * least_seconds(loop, repeats) / len(points)

    return {
        "scalar": each(table.loads, some),
        "scalar_at_velocity": each(table.loads_at_velocity, vectors),
        "scalar_gradient": each(table.gradient_at_velocity, vectors),
        "scalar_inverse": each(lambda *p: table.omega_for("thrust", *p), wanted, 3),
        "array": 1e6 * least_seconds(lambda: table.loads(omega, speed, beta), 15) / POINTS,
    }


def model_microseconds(rotor: Rotor) -> dict[str, float]:
    """Time per point [us] of the full model, in a batch and alone."""
    batch = random_points(BATCH)
    one = tuple(float(x[0]) for x in batch)
    return {
        "array": 1e6 * least_seconds(lambda: rotor.loads(*batch), 3) / BATCH,
        "scalar": 1e6 * least_seconds(lambda: rotor.loads(*one), 20),
    }


def rotorpy_microseconds(table: LoadTable) -> float | None:
    """Time per rotor [us] of RotorPy's model, with this table's parameters; None without it."""
    try:
        from rotorpy.vehicles.multirotor import Multirotor
    except ModuleNotFoundError:
        return None
    from propmap.export.files import sample
    from propmap.export.simple_models import fit_rotor

    fitted = fit_rotor(table, sample(table))
    corners = ((1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0))
    arms = {f"r{k}": np.array([0.15 * x, 0.15 * y, 0.0]) for k, (x, y) in enumerate(corners, 1)}
    frame = {"mass": 1.0, "num_rotors": 4, "rotor_pos": arms, "tau_m": 0.02}
    frame |= {"rotor_directions": np.array([1, -1, 1, -1])}
    frame |= dict.fromkeys(("Ixx", "Iyy", "Izz"), 4e-3)
    frame |= dict.fromkeys(("Ixy", "Ixz", "Iyz", "c_Dx", "c_Dy", "c_Dz", "k_flap"), 0.0)
    frame |= {"rotor_speed_min": 0.0, "rotor_speed_max": ENVELOPE["omega"][1]}
    rotor = {name: getattr(fitted, name) for name in ("k_eta", "k_m", "k_d", "k_z", "k_h")}
    vehicle = Multirotor(frame | rotor)
    rates, speeds, velocity = np.zeros(3), np.full(4, 600.0), np.array([3.0, 1.0, 0.5])

    def loop() -> None:
        for _ in range(SINGLE):
            vehicle.compute_body_wrench(rates, speeds, velocity)

    return 1e6 * least_seconds(loop, 30) / SINGLE / 4


def cold_seconds(table: LoadTable) -> dict[str, float]:
    """A process that imports the package, loads the table and asks it once [s]."""
    with tempfile.TemporaryDirectory() as folder:
        path = f"{folder}/map.npz"
        table.save(path)
        command = [sys.executable, "-c", COLD.format(path=path)]

        def run() -> None:
            subprocess.run(command, check=True)

        return {
            "wall": least_seconds(run, 15, time.perf_counter),
            "processor": least_seconds(run, 5, _children_seconds),
        }


def _children_seconds() -> float:
    used = os.times()
    return used.children_user + used.children_system


def measure() -> dict[str, Any]:
    """All figures of the table at 0.5 %."""
    place = machine()
    table, rotor, building = built(0.005, "standard")
    query, model = query_microseconds(table), model_microseconds(rotor)
    rotorpy = rotorpy_microseconds(table)
    c = {
        name: c_nanoseconds(table, single=single)
        for name, single in (("double", False), ("float", True))
    }
    return {
        "machine": place,
        "building": building,
        "query_us": query,
        "c_ns": c,
        "cold_process_s": cold_seconds(table),
        "model_us": model,
        "rotorpy_us_per_rotor": rotorpy,
        "ratios": {
            "model_over_table_array": model["array"] / query["array"],
            "model_over_table_scalar": model["scalar"] / query["scalar"],
            "model_array_over_c_double": 1e3 * model["array"] / c["double"]
            if c["double"]
            else None,
            "table_scalar_over_rotorpy": query["scalar"] / rotorpy if rotorpy else None,
        },
    }


def show_building(figures: dict[str, Any]) -> None:
    """Print what building took."""
    told = figures["certificate"]
    print(
        f"table at {figures['tolerance']:.1%}: {figures['wall_s']:.0f} s, processor "
        f"{figures['processor_s']:.0f} s, {figures['model_evaluations']} operating points, "
        f"{figures['knots'][0]} x {figures['knots'][1]} knots, {figures['file_MB']:.2f} MB"
    )
    print(
        f"largest error {max(told['max_error'].values()):.3%}; unresolved "
        f"{told['unresolved_volume']:.2%}, there at most "
        f"{max(told['unresolved_max_error'].values()):.2%}"
    )


def show(found: dict[str, Any]) -> None:
    """Print the figures of queries."""
    for name, value in found["query_us"].items():
        print(f"table, {name}: {value:.2f} us per point")
    for name, value in found["c_ns"].items():
        print(f"C header, {name}: " + (f"{value:.0f} ns per point" if value else "no gcc"))
    for name, value in found["cold_process_s"].items():
        print(f"cold process, one query, {name}: {value:.2f} s")
    for name, value in found["model_us"].items():
        print(f"full model, {name}: {value:.1f} us per point")
    rotorpy = found["rotorpy_us_per_rotor"]
    print("RotorPy's rotor: " + (f"{rotorpy:.2f} us" if rotorpy else "not installed"))
    for name, value in found["ratios"].items():
        print(f"{name}: " + (f"{value:.1f}" if value else "not measured"))


def main() -> None:
    """Measure, print and write; with "fine", build the table at 0.1 % and nothing else."""
    if "fine" in sys.argv[1:]:
        place = machine()
        figures = built(0.001, "fine")[2]
        show_building(figures)
        print(write_results("fine_table.json", {"machine": place, "building": figures}))
        return
    found = measure()
    show_building(found["building"])
    show(found)
    print(write_results("table.json", found))


if __name__ == "__main__":
    main()
