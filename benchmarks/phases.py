"""Where the time of a load evaluation goes: `make bench-phases`.  Writes results/phases.json.

The mixed oblique batch of `benchmarks.speed`, one core.  How its points are sorted into jobs, what
each job costs, and for points that follow stall what each phase of the theory costs: the survey of
the hump along the blade, the search for the folds, the roots, and the loads.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from rich.console import Console
from rich.table import Table

import propmap
from benchmarks.results_file import machine, write_results
from benchmarks.speed import BATCH, oblique
from propmap import evaluation
from propmap.blocks import large_block, nodes_of_each
from propmap.programs import COMPILER_OPTIONS
from propmap.rotor import Rotor
from propmap.schedule import Job, Outlook, accuracy, may_leave_islands, may_stall, plan
from propmap.theory.disk_inflow import Case, question, solve_disk
from propmap.theory.loads import disk_loads
from propmap.theory.stall_folds import find_folds
from propmap.theory.stall_split import hump_crossings
from propmap.theory.velocities import AzimuthNodes, azimuth_nodes

REPEATS = 9
OPTIONS: Any = COMPILER_OPTIONS

FOLLOWING = (12, 18, 18)
"""Radial nodes on the panels of a point that follows stall outside descent."""


def least_microseconds(call: Callable[[], Any], points: int) -> float:
    """Least time of ``call`` per each of its ``points`` [us], after one that does not count."""
    jax.tree.map(np.asarray, call())
    seconds = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        jax.tree.map(np.asarray, call())
        seconds.append(time.perf_counter() - start)
    return min(seconds) / points * 1e6


def jobs_of_the_batch(rotor: Rotor) -> tuple[list[Job], tuple[np.ndarray, ...]]:
    """The jobs into which the batch is sorted, and its omega, v_axial and v_inplane.

    The points of each job here have one number of azimuth nodes, to be told apart.
    """
    omega, speed, beta = oblique(BATCH)
    flow = (omega, speed * np.cos(beta), speed * np.sin(beta))
    ready = evaluation.prepare(rotor.theory)
    stalls = may_stall(*ready.forecast, *flow)
    outlook = Outlook(
        evaluation.advance_ratio(ready, omega, flow[2]),
        evaluation.advance_ratio(ready, omega, flow[1]),
        stalls,
        may_leave_islands(flow[1], np.zeros_like(omega)),
    )
    jobs = [
        Job(job.points[mine], job.panels, job.azimuths[mine], job.most_azimuths)
        for job in plan(accuracy("standard"), outlook, np.arange(BATCH))
        for mine in (job.azimuths == count for count in np.unique(job.azimuths))
    ]
    return jobs, flow


def block(rotor: Rotor, job: Job, flow: tuple[np.ndarray, ...]) -> tuple[Case, AzimuthNodes]:
    """One block of a job: its case and azimuth nodes."""
    which = np.resize(job.points, large_block(job))
    ready = evaluation.prepare(rotor.theory)
    still = np.zeros(which.size)
    blade, section, medium = ready.on_device
    omega, v_axial, v_inplane = (jnp.asarray(a[which]) for a in flow)
    case = Case(blade, section, medium, omega, v_axial, v_inplane, jnp.asarray(still))
    nodes = (
        azimuth_nodes(1)
        if job.azimuths[0] == 1
        else nodes_of_each(np.resize(job.azimuths, which.size), job.most_azimuths)
    )
    return case, nodes


@functools.partial(jax.jit, compiler_options=OPTIONS, static_argnums=1)
def whole(case: Case, panels: tuple[int, ...], azimuth: AzimuthNodes) -> Any:
    """All of it."""
    return disk_loads(*case[:6], jnp.zeros_like(case.omega), panels, azimuth)


@functools.partial(jax.jit, compiler_options=OPTIONS)
def survey(case: Case, azimuth: AzimuthNodes) -> Any:
    """The look along the blade for where the hump passes zero."""
    ask = functools.partial(question, case)
    return hump_crossings(ask, case.blade.root, case.blade.tip, len(FOLLOWING) - 1, azimuth)


@functools.partial(jax.jit, compiler_options=OPTIONS)
def folds(case: Case, near: Any, azimuth: AzimuthNodes) -> Any:
    """The search for the folds from there."""
    ask = functools.partial(question, case)
    return find_folds(near, ask, case.blade.root, case.blade.tip, azimuth)


@functools.partial(jax.jit, compiler_options=OPTIONS, static_argnums=1)
def inflow(case: Case, panels: tuple[int, ...], azimuth: AzimuthNodes) -> Any:
    """Survey, folds and the roots of (11)."""
    return solve_disk(case, panels, azimuth)[0]


def main() -> None:
    """Measure, print and write."""
    found: dict[str, Any] = {"machine": machine(), "batch": BATCH}
    rotor = propmap.Rotor(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"))
    table = Table("panels", "azimuths", "share %", "nodes", "us per point", "of the batch, us")
    parts = Table("azimuths", "survey", "folds", "roots", "loads", "all [us]", title="following")
    with jax.enable_x64(True):
        jobs, flow = jobs_of_the_batch(rotor)
        rows: list[dict[str, Any]] = []
        phases: list[dict[str, Any]] = []
        for job in jobs:
            case, nodes = block(rotor, job, flow)
            run = functools.partial(whole, case, job.panels, nodes)
            size = large_block(job)
            each = least_microseconds(run, size)
            azimuths = int(job.azimuths[0])
            count = sum(job.panels) * max(azimuths // 2, 1)
            share = job.points.size / BATCH
            rows.append(
                {
                    "panels": list(job.panels),
                    "azimuths": azimuths,
                    "share": share,
                    "nodes": count,
                    "microseconds": each,
                }
            )
            table.add_row(
                "+".join(map(str, job.panels)),
                str(azimuths),
                f"{100 * share:.1f}",
                str(count),
                f"{each:.1f}",
                f"{share * each:.1f}",
            )
            if job.panels != FOLLOWING:
                continue
            near, _ = survey(case, nodes)
            first = least_microseconds(functools.partial(survey, case, nodes), size)
            second = least_microseconds(functools.partial(folds, case, near, nodes), size)
            third = least_microseconds(functools.partial(inflow, case, job.panels, nodes), size)
            split: dict[str, float] = {
                "survey": first,
                "folds": second,
                "roots": max(third - first - second, 0.0),
                "loads": max(each - third, 0.0),
            }
            phases.append({"azimuths": azimuths, **split})
            cells = [f"{value:.1f}" for value in (*split.values(), each)]
            parts.add_row(str(azimuths), *cells)
    found |= {"jobs": rows, "following": phases}
    found["one_core_us"] = sum(row["share"] * row["microseconds"] for row in rows)
    found["nodes_per_point"] = sum(row["share"] * row["nodes"] for row in rows)
    console = Console()
    console.print(table, parts)
    nodes, cost = found["nodes_per_point"], found["one_core_us"]
    console.print(f"{nodes:.0f} nodes and {cost:.1f} us per point, one core")
    console.print(f"written: {write_results('phases.json', found)}")


if __name__ == "__main__":
    main()
