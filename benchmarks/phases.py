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
from propmap.engine import evaluation
from propmap.engine.accuracy import accuracy
from propmap.engine.batch import large_block, nodes_of_each
from propmap.engine.lanes import in_lanes
from propmap.engine.plan import Job, Outlook, may_leave_islands, plan
from propmap.engine.programs import AZIMUTHS_TOGETHER, OBLIQUE_OPTIONS
from propmap.physics.velocities import AzimuthNodes
from propmap.rotor import Rotor
from propmap.solve.disk import solve_disk
from propmap.solve.folds import find_folds
from propmap.solve.problem import Case, annulus_problem
from propmap.solve.rotor_loads import disk_loads
from propmap.solve.split import hump_crossings

REPEATS = 9
BLOCKS = 5
"""At most so many of a job's, from one end to the other: they are sorted by climb, and with it goes
what they cost."""

OPTIONS: Any = OBLIQUE_OPTIONS

FOLLOWING = (12, 18, 18)
"""Radial nodes on the panels of a point that follows stall outside descent."""


Block = tuple[Any, tuple[Any, ...], AzimuthNodes]
"""The rotor's theory, omega, v_axial and v_inplane of the points, and their azimuth nodes."""


def microseconds(blocks: list[Block], *calls: Callable[[Block], Any]) -> list[float]:
    """Time of each call per point [us], the mean over the blocks of each one's least.

    By turns, lest a slow moment of the machine strike one of them.
    """
    least = np.full((len(calls), len(blocks)), np.inf)
    for j, block in enumerate(blocks):
        for turn in range(REPEATS + 1):
            for i, call in enumerate(calls):
                start = time.perf_counter()
                jax.tree.map(np.asarray, call(block))
                if turn:  # the first compiles
                    least[i, j] = min(least[i, j], time.perf_counter() - start)
    points = blocks[0][1][0].size
    return [float(mean) for mean in 1e6 * least.mean(axis=1) / points]


def jobs_of_the_batch(rotor: Rotor) -> tuple[list[Job], tuple[np.ndarray, ...]]:
    """The jobs into which the batch is sorted, and its omega, v_axial and v_inplane.

    The points of each job here have one number of azimuth nodes, to be told apart.
    """
    omega, speed, beta = oblique(BATCH)
    flow = (omega, speed * np.cos(beta), speed * np.sin(beta))
    ready = evaluation.prepare(rotor.arrays)
    stalls = ready.forecast.may_stall(*flow)
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


def blocks_of(rotor: Rotor, job: Job, flow: tuple[np.ndarray, ...]) -> list[Block]:
    """Some blocks of a job."""
    size = large_block(job)
    last = max(job.points.size - size, 0)
    count = min(BLOCKS, -(-job.points.size // size))
    starts = np.linspace(0, last, count).astype(int)
    return [block(rotor, job, np.resize(job.points[i : i + size], size), flow) for i in starts]


def block(rotor: Rotor, job: Job, which: np.ndarray, flow: tuple[np.ndarray, ...]) -> Block:
    """The block of these points of the job."""
    omega, v_axial, v_inplane = (jnp.asarray(a[which]) for a in flow)
    azimuths = np.resize(job.azimuths, which.size)
    return rotor.arrays, (omega, v_axial, v_inplane), nodes_of_each(azimuths, job.most_azimuths)


def in_groups(phase: Callable[..., Any], *panels: tuple[int, ...]) -> Callable[..., Any]:
    """The phase compiled as the whole is, for a few points at a time; of a block, and of arrays
    that the phase takes beside."""

    def some(theory: Any, each: Any) -> Any:
        (omega, v_axial, v_inplane), azimuth, *beside = each
        case = Case(theory, omega, v_axial, v_inplane, None)
        return phase(case, azimuth, *beside, *panels)

    @functools.partial(jax.jit, compiler_options=OPTIONS)
    def program(theory: Any, *each: Any) -> Any:
        return in_lanes(some, theory, each, jnp.asarray(each[0][0].size), AZIMUTHS_TOGETHER)

    return lambda block, *beside: program(*block, *beside)


def phases_of(blocks: list[Block], programs: dict[str, Callable[..., Any]]) -> dict[str, float]:
    """What each phase costs where stall is followed, and all of them [us]."""
    near = {id(block): programs["survey"](block)[0] for block in blocks}
    first, second, third, every = microseconds(
        blocks,
        programs["survey"],
        lambda block: programs["folds"](block, near[id(block)]),
        programs["roots"],
        programs["all"],
    )
    return {
        "survey": first,
        "folds": second,
        "roots": third - first - second,
        "loads": every - third,
        "all": every,
    }


def whole(case: Case, azimuth: AzimuthNodes, panels: tuple[int, ...]) -> Any:
    """All of it."""
    return disk_loads(case, panels, azimuth)


def survey(case: Case, azimuth: AzimuthNodes) -> Any:
    """The look along the blade for where the hump passes zero."""
    blade, edges = case.rotor.blade, len(FOLLOWING) - 1
    problem_at = functools.partial(annulus_problem, case)
    return hump_crossings(problem_at, blade.root, blade.tip, edges, azimuth)


def folds(case: Case, azimuth: AzimuthNodes, near: Any) -> Any:
    """The search for the folds from there."""
    blade = case.rotor.blade
    problem_at = functools.partial(annulus_problem, case)
    return find_folds(near, problem_at, blade.root, blade.tip, azimuth)


def inflow(case: Case, azimuth: AzimuthNodes, panels: tuple[int, ...]) -> Any:
    """Survey, folds and the roots of (11)."""
    return solve_disk(case, panels, azimuth)[0]


def main() -> None:
    """Measure, print and write."""
    found: dict[str, Any] = {"machine": machine(), "batch": BATCH}
    rotor = propmap.Rotor(
        propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"))
    )
    table = Table("panels", "azimuths", "share %", "nodes", "us per point", "of the batch, us")
    parts = Table("azimuths", "survey", "folds", "roots", "loads", "all [us]", title="following")
    with jax.enable_x64(True):
        jobs, flow = jobs_of_the_batch(rotor)
        programs = {"survey": in_groups(survey), "folds": in_groups(folds)}
        programs |= {"roots": in_groups(inflow, FOLLOWING), "all": in_groups(whole, FOLLOWING)}
        rows: list[dict[str, Any]] = []
        phases: list[dict[str, Any]] = []
        for job in jobs:
            blocks = blocks_of(rotor, job, flow)
            if job.panels == FOLLOWING:
                split = phases_of(blocks, programs)
                each = split.pop("all")
            else:
                (each,) = microseconds(blocks, in_groups(whole, job.panels))
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
            if job.panels == FOLLOWING:
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
