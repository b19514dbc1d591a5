"""What a scheduler's overhead costs, simulated event by event from measured times.

One dispatcher, the client and the scheduler together, hands out tasks one after the other, which
takes some milliseconds for each.  A worker has a queue of a few tasks, and an idle gap before each.
Tasks that run at a time share the cores: with more workers than cores each is slower.  Left out are
the network and the disk.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from propmap.cluster import AHEAD


@dataclass(frozen=True)
class Costs:
    """Overheads of a task [s]."""

    dispatch: float  # of client and scheduler, which do one task at a time
    gap: float  # of a worker between two tasks


def simulate(
    tasks: Sequence[float], workers: int, cores: float, costs: Costs, ahead: int = AHEAD
) -> float:
    """Simulate the time [s] from the first task handed out to the last one done.

    ``tasks`` are times of one core [s]; each worker runs one task at a time and has ``ahead`` under
    way at most; ``cores`` are those there are, or what others leave of them.
    """
    left = deque(tasks)
    queues: list[deque[float]] = [deque() for _ in range(workers)]
    busy = [False] * workers
    # The worker with the fewest tasks gets the next; entries that are out of date are skipped.
    load, order = [0] * workers, [(0, k) for k in range(workers)]
    events: list[tuple[float, int, str, int]] = []
    running: list[tuple[float, int, int]] = []
    number = itertools.count()
    now = progress = free_at = 0.0

    def at(time: float, kind: str, worker: int) -> None:
        heapq.heappush(events, (time, next(number), kind, worker))

    def hand_out() -> None:
        nonlocal free_at
        free_at = max(free_at, now) + costs.dispatch
        at(free_at, "sent", -1)

    def begin(worker: int) -> None:
        if queues[worker] and not busy[worker]:
            busy[worker] = True
            at(now + costs.gap, "begins", worker)

    for _ in range(min(ahead * workers, len(left))):
        hand_out()
    asked = min(ahead * workers, len(left))
    while events or running:
        # Running tasks progress alike, at one core each or what share there is.
        rate = min(1.0, cores / len(running)) if running else 1.0
        ends = now + (running[0][0] - progress) / rate if running else math.inf
        if events and events[0][0] <= ends:
            time, _, kind, worker = heapq.heappop(events)
            progress, now = progress + rate * (time - now), time
            if kind == "sent":
                while order[0][0] != load[order[0][1]]:
                    heapq.heappop(order)
                worker = heapq.heappop(order)[1]
                load[worker] += 1
                heapq.heappush(order, (load[worker], worker))
                queues[worker].append(left.popleft())
                begin(worker)
            else:
                work = queues[worker].popleft()
                heapq.heappush(running, (progress + work, next(number), worker))
        else:
            progress, now = running[0][0], ends
            _, _, worker = heapq.heappop(running)
            busy[worker] = False
            load[worker] -= 1
            heapq.heappush(order, (load[worker], worker))
            if asked < len(tasks):
                asked += 1
                hand_out()
            begin(worker)
    return now


def efficiency(
    task: float, workers: int, costs: Costs, tasks_each: int = 20, ahead: int = AHEAD
) -> float:
    """Share of the cores' time that goes into tasks of equal length [s], with a core per worker."""
    wall = simulate([task] * (tasks_each * workers), workers, workers, costs, ahead)
    return tasks_each * task / wall


TASKS = (2.0, 20.0, 200.0)
"""Lengths of tasks that a large job may be cut into [s]."""


def least_wall(work: float, workers: int, costs: Costs) -> tuple[float, float]:
    """Find the least time of a job of ``work`` [s of one core] and the length of its tasks [s].

    By what limits the simulation: the dispatcher hands out one task at a time, and workers, with a
    core each, do tasks in whole rounds.
    """

    def wall(task: float) -> float:
        count = math.ceil(work / task)
        each = task + costs.gap
        return max(count * costs.dispatch + each, math.ceil(count / workers) * each)

    return min((wall(task), task) for task in TASKS)
