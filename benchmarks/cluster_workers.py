"""Overheads of a task, and efficiency by number of workers: measured, and simulated with these."""

from __future__ import annotations

import os
import time
from typing import Any

import numpy as np

from benchmarks.cluster_rotor import LARGE, grid, rotor, usage
from benchmarks.scheduler_simulation import Costs, efficiency, simulate
from propmap.cluster import DaskWorkers, connected
from propmap.io.csv import OperatingPoints
from propmap.sweep.run import Sweep

WORKERS = (1, 2, 4, 8)

SHORT_TASK = 2048
"""Operating points of the tasks that efficiencies are measured with: some tenths of a second, so
that what a task costs shows."""

TASKS = 48
EMPTY_TASKS = 300
WAIT = 0.05
"""Time of a task that does nothing but wait [s]: there workers do not share cores."""

MANY = (1, 2, 4, 8, 16, 100, 1000, 10_000)


def _empty(_: None, task: int) -> int:
    return task


def _wait(_: None, task: float) -> float:
    time.sleep(task)
    return task


def _timed_part(sweep: Sweep, part: OperatingPoints) -> float:
    """Processor time of this process [s], which does one task at a time."""
    start = time.process_time()
    sweep.values(part)
    return time.process_time() - start


def scheduler() -> dict[str, Any]:
    """Overheads of a task, and efficiency by workers: measured, and simulated with these."""
    cores = len(os.sched_getaffinity(0))
    sweep = Sweep(rotor(), grid(LARGE))
    rng = np.random.default_rng(1)
    some = [
        OperatingPoints(rng.uniform(3000.0, 8000.0, SHORT_TASK), *rest)
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
    # This machine may have been busier than another.
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
    return sum(one["processor_s"] for one in workers.client.run(usage).values())
