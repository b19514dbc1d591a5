"""Sweeps and fits on a cluster of this machine: `make bench-cluster`.

Writes results/cluster.json: wall and processor time of one sweep with and without workers, whether
its results are the same, and memory; overheads of a task; efficiency by number of workers, measured
and simulated (``benchmarks.scheduler_simulation``); what a propeller of the catalogue and a design
of a study take.  With arguments, only those parts: sweep, scheduler, designs, catalogue; with
`some`, one in five of the catalogue.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import propmap
from benchmarks.results_file import RESULTS, machine, write_results
from benchmarks.scheduler_simulation import Costs, efficiency, simulate
from propmap.cluster.connection import connected
from propmap.cluster.dask_workers import DaskWorkers
from propmap.engine.compilation import compile_quickly, keep_compiled
from propmap.rotor import Rotor
from propmap.study.plan import Study
from propmap.study.run import loads_of_designs
from propmap.sweep.points import Grid, Part
from propmap.sweep.run import POINTS_PER_TASK, Sweep, loads_of_part, sweep_to_store
from propmap.tasks import InTurn

DATA = Path(__file__).parents[2] / "shared" / "data" / "uiuc" / "loads.csv"

SMALL, LARGE = (20, 50, 100), (100, 200, 100)
"""Rotational speeds, flight speeds and angles: 1e5 and 2e6 points."""

WORKERS = (1, 2, 4, 8)

SHORT_TASK = 2048
"""Operating points of the tasks that efficiencies are measured with: some tenths of a second, so
that what a task costs shows."""

TASKS = 48
EMPTY_TASKS = 300
WAIT = 0.05
"""Time of a task that does nothing but wait [s]: there workers do not share cores."""

MANY = (1, 2, 4, 8, 16, 100, 1000, 10_000)


def model(physics: str = "paper") -> propmap.Model:
    """An APC 8x6E by the paper's model, or by the recommended one."""
    return propmap.Model(
        propmap.propeller("apc-8x6e"),
        propmap.airfoil("paper-apc"),
        corrections=propmap.corrections_of(physics),
    )


def rotor() -> Rotor:
    """The rotor of the sweeps, by the paper's model: its tasks are short, and overheads show."""
    return Rotor(model())


def grid(shape: tuple[int, int, int]) -> Grid:
    """3000 to 8000 rpm, 0 to 20 m/s, climb to descent."""
    ends = (3000.0, 8000.0), (0.0, 20.0), (0.0, 180.0)
    return Grid(*(np.linspace(*pair, n) for pair, n in zip(ends, shape, strict=True)))


def one_sweep(shape: tuple[int, int, int], cluster: str, path: str) -> dict[str, Any]:
    """A whole sweep in this process and its workers: times [s] and peaks of memory [MB]."""
    compile_quickly()
    keep_compiled()
    start = time.perf_counter()
    with contextlib.ExitStack() as stack:
        workers = stack.enter_context(connected(cluster)) if cluster else InTurn()
        sweep_to_store(rotor(), grid(shape), Path(path), workers=workers)
        wall, peaks = time.perf_counter() - start, {}
        if isinstance(workers, DaskWorkers):
            peaks = workers.client.run(_usage)
    own = _usage()
    return {
        "wall_s": wall,
        "processor_s": own["processor_s"] + sum(one["processor_s"] for one in peaks.values()),
        "client_peak_MB": own["peak_MB"],
        "worker_peaks_MB": sorted(one["peak_MB"] for one in peaks.values()),
    }


def _usage() -> dict[str, float]:
    used = resource.getrusage(resource.RUSAGE_SELF)
    return {"peak_MB": used.ru_maxrss / 1024.0, "processor_s": used.ru_utime + used.ru_stime}


def sweeps() -> dict[str, Any]:
    """Both sizes, by this process and by two workers, each in a process of its own."""
    found: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, shape in (("1e5", SMALL), ("2e6", LARGE)):
            contents = []
            for who, cluster in (("one_process", ""), ("local_2", "local:2")):
                path = f"{folder}/{name}-{who}.zarr"
                command = [sys.executable, "-m", "benchmarks.cluster", "one", name, cluster, path]
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


def _empty(_: None, task: int) -> int:
    return task


def _wait(_: None, task: float) -> float:
    time.sleep(task)
    return task


def _timed_part(sweep: Sweep, part: Part) -> float:
    """Processor time of this process [s], which does one task at a time."""
    start = time.process_time()
    loads_of_part(sweep, part)
    return time.process_time() - start


def scheduler() -> dict[str, Any]:
    """Overheads of a task, and efficiency by workers: measured, and simulated with these."""
    compile_quickly()
    keep_compiled()
    cores = len(os.sched_getaffinity(0))
    sweep = Sweep(rotor(), grid(LARGE))
    rng = np.random.default_rng(1)
    some = [
        Part((), rng.uniform(3000.0, 8000.0, SHORT_TASK), *rest)
        for rest in zip(
            rng.uniform(0.0, 20.0, (TASKS, SHORT_TASK)),
            rng.uniform(0.0, 180.0, (TASKS, SHORT_TASK)),
            strict=True,
        )
    ]
    with connected("local:2") as workers:
        _seconds(workers, _empty, None, range(100))
        dispatch = _dispatch(workers)
    with connected("local:1") as workers:
        waits = [WAIT] * 40
        gap = _seconds(workers, _wait, None, waits) / len(waits) - WAIT
    costs = Costs(dispatch, max(gap, 0.0))
    rows: list[dict[str, float]] = []
    for count in WORKERS:
        with connected(f"local:{count}") as workers:
            list(workers.results(_timed_part, sweep, some[:1] * 3 * count))  # compiled
            before = _processor(workers)
            start = time.perf_counter()
            used = [seconds for _, seconds in workers.results(_timed_part, sweep, some)]
            wall = time.perf_counter() - start
            given = (_processor(workers) - before) / wall
            waiting = [WAIT] * (20 * count)
            each = [_dispatch(workers)]
            wait_wall = _seconds(workers, _wait, None, waiting)
            # Just before and after, for others on the machine slow it as they come and go.
            costs = Costs(float(np.mean([*each, _dispatch(workers)])), costs.gap)
        rows.append(
            {
                "workers": count,
                "task_s": float(np.mean(used)),
                "wall_s": wall,
                "simulated_s": simulate(used, count, cores, costs),
                "cores_had": given,
                # Others on the machine leave the workers less than its cores.
                "simulated_with_cores_had_s": simulate(used, count, min(given, cores), costs),
                "efficiency": sum(used) / (wall * min(count, cores)),
                "dispatch_s": costs.dispatch,
                "waiting_wall_s": wait_wall,
                "waiting_simulated_s": simulate(waiting, count, count, costs),
                "waiting_efficiency": 20 * WAIT / wait_wall,
            }
        )
        print(rows[-1], flush=True)
    # Of a machine that is not as busy as this one may have been.
    costs = Costs(min(dispatch, *(row["dispatch_s"] for row in rows)), costs.gap)
    beyond = {
        str(seconds): {str(n): efficiency(seconds, n, costs) for n in MANY}
        for seconds in (0.25, 2.0, 20.0)
    }
    return {
        "cores": cores,
        "dispatch_s": costs.dispatch,
        "gap_s": costs.gap,
        "points_per_task": SHORT_TASK,
        "rows": rows,
        "simulated_efficiency_by_task_s": beyond,
    }


def _seconds(workers: DaskWorkers, work: Any, common: Any, tasks: Any) -> float:
    start = time.perf_counter()
    for _ in workers.results(work, common, tasks):
        pass
    return time.perf_counter() - start


def _dispatch(workers: DaskWorkers) -> float:
    """What client and scheduler take for a task [s]."""
    return _seconds(workers, _empty, None, range(EMPTY_TASKS)) / EMPTY_TASKS


def _processor(workers: DaskWorkers) -> float:
    return sum(one["processor_s"] for one in workers.client.run(_usage).values())


def designs() -> dict[str, Any]:
    """Processor time of a core [s]: per point of a task, and per design of a study."""
    compile_quickly()
    keep_compiled()
    from propmap.engine.batch import on_cores

    found: dict[str, Any] = {}
    whole = grid(LARGE)
    with on_cores(1):
        for accuracy in ("standard", "fine"):
            sweep = Sweep(Rotor(model("recommended"), accuracy=accuracy), whole)
            rng = np.random.default_rng(2)
            size = POINTS_PER_TASK if accuracy == "standard" else 4096
            part = Part(
                (),
                rng.uniform(3000.0, 8000.0, size),
                rng.uniform(0.0, 20.0, size),
                rng.uniform(0.0, 180.0, size),
            )
            found[f"point_{accuracy}_s"] = (
                _least(lambda s=sweep, p=part: loads_of_part(s, p)) / size
            )
        axes = {
            "rpm": np.linspace(3000.0, 8000.0, 4),
            "speed_mps": np.linspace(0.0, 20.0, 5),
            "beta_deg": np.linspace(0.0, 180.0, 5),
        }
        varied = {"diameter": np.array([0.18, 0.24]), "pitch": np.array([0.1, 0.18])}
        study = Study(Rotor(model("recommended")), varied, axes, 64)
        some = study.part((0, 0, 0, 0), (16, 4, 5, 5))
        found["design_points"] = 100
        found["design_s"] = _least(lambda: loads_of_designs(study, some)) / 16
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


def catalogue(every: int = 1) -> dict[str, Any]:
    """`propmap fit catalogue` as a whole process, by itself and on two workers.

    ``every`` is the distance of the propellers taken, 1 for all.
    """
    found: dict[str, Any] = {}
    files = []
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder) / "loads.csv"
        head, *rows = DATA.read_text(encoding="utf-8").splitlines()
        names = list(dict.fromkeys(row.partition(",")[0] for row in rows))[::every]
        kept = [row for row in rows if row.partition(",")[0] in names]
        data.write_text("\n".join([head, *kept]) + "\n", encoding="utf-8")
        for who, cluster in (("one_process", []), ("local_2", ["--cluster", "local:2"])):
            output = Path(folder) / who / "identified.csv"
            output.parent.mkdir()
            command = [sys.executable, "-m", "propmap", "fit", "catalogue", str(data)]
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            start = time.perf_counter()
            subprocess.run([*command, "-o", str(output), *cluster], check=True, capture_output=True)
            wall = time.perf_counter() - start
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            found[who] = {"wall_s": wall, "processor_s": after.ru_utime - before.ru_utime}
            files.append(
                [(output.with_name(n)).read_bytes() for n in (output.name, "population.toml")]
            )
            found["propellers"] = files[-1][0].count(b"\n") - 1
    found["same_bytes"] = files[0] == files[1]
    found["speed_up"] = found["one_process"]["wall_s"] / found["local_2"]["wall_s"]
    return found


PARTS = {"sweep": sweeps, "scheduler": scheduler, "designs": designs, "catalogue": catalogue}

SOME = 5
"""With the argument `some`, one propeller in so many stands for the catalogue."""


def main(wanted: list[str]) -> None:
    """Measure the parts ``wanted``, all if none is named, and keep the others' results."""
    path = RESULTS / "cluster.json"
    some = "some" in wanted
    for name in [name for name in wanted if name != "some"] or PARTS:
        if name == "catalogue" and not DATA.exists():
            print("the UIUC database is not at hand: no catalogue")
            continue
        told = {"machine": machine()}
        told |= catalogue(SOME) if some and name == "catalogue" else PARTS[name]()
        print(name, json.dumps(told), flush=True)
        found = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        print(f"wrote {write_results(path.name, found | {name: told})}")


if __name__ == "__main__":
    if sys.argv[1:2] == ["one"]:
        _, _, points, where, store = sys.argv
        print(json.dumps(one_sweep(SMALL if points == "1e5" else LARGE, where, store)))
    else:
        main(sys.argv[1:])
