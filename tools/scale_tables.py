"""Tables of docs/scale.md, from benchmarks/results/cluster.json."""

from __future__ import annotations

from typing import Any

from benchmarks.scheduler_simulation import Costs, least_wall

CORES = (100, 1000, 10_000)

TIMES = (("years", 3.156e7), ("days", 86400.0), ("h", 3600.0), ("min", 60.0), ("s", 1.0))
SIZES = (("PB", 1e15), ("TB", 1e12), ("GB", 1e9), ("MB", 1e6))


def sweep(found: dict[str, Any]) -> str:
    """Tabulate wall time, processor time and memory of sweeps with 1e5 and 2e6 points."""
    part = found["sweep"]
    rows = [
        _machine(part),
        "",
        "| | wall time | processor time | peak memory, client | peak memory, workers |",
        "|---|---:|---:|---:|---:|",
    ]
    for size, words in (("1e5", "100,000 points"), ("2e6", "2,000,000 points")):
        for who, said in (("one_process", "one process"), ("local_2", "`local:2`")):
            one = part[f"{size}_{who}"]
            peaks = ", ".join(f"{peak:.0f} MB" for peak in one["worker_peaks_MB"]) or "-"
            rows.append(
                f"| {words}, {said} | {one['wall_s']:.0f} s | {one['processor_s']:.0f} s "
                f"| {one['client_peak_MB']:.0f} MB | {peaks} |"
            )
    same = "bit-identical" if part["2e6_same_bits"] and part["1e5_same_bits"] else "NOT the same"
    return "\n".join(
        [
            *rows,
            "",
            f"Results are {same}. For 2,000,000 points two workers take "
            f"{part['ratio_of_wall_s']:.2f} times the wall time of one process on all cores, and "
            f"{part['ratio_of_processor_s']:.2f} times its processor time. Storage: "
            f"{part['2e6_bytes_per_point']:.0f} bytes per point, in {part['2e6_files']} files.",
        ]
    )


def overhead(found: dict[str, Any]) -> str:
    """Tabulate the time of a task, a point and a design."""
    part, each = found["scheduler"], found["designs"]
    return "\n".join(
        [
            "| | time |",
            "|---|---:|",
            f"| client and scheduler, per task | {1e3 * part['dispatch_s']:.1f} ms |",
            f"| gap of a worker between two tasks | {1e3 * part['gap_s']:.1f} ms |",
            f"| one point on one core, `standard` | {1e6 * each['point_standard_s']:.0f} µs "
            f"({1.0 / each['point_standard_s']:,.0f} points per second and core) |",
            f"| one point on one core, `fine` | {1e6 * each['point_fine_s']:.0f} µs |",
            f"| one design of a study, {each['design_points']} points | "
            f"{1e3 * each['design_s']:.0f} ms |",
        ]
    )


def workers(found: dict[str, Any]) -> str:
    """Tabulate measured and simulated times for each number of workers."""
    part = found["scheduler"]
    rows = [
        f"| workers | {part['points_per_task']} points per task: wall time | simulated "
        "| efficiency | cores received | simulated with these cores | sleeping tasks: wall time "
        "| simulated |",
        "|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for one in part["rows"]:
        had = one["simulated_with_cores_had_s"]
        rows.append(
            f"| {one['workers']} | {one['wall_s']:.2f} s | {one['simulated_s']:.2f} s "
            f"({_off(one['simulated_s'], one['wall_s'])}) | {100.0 * one['efficiency']:.0f} % "
            f"| {one['cores_had']:.2f} | {had:.2f} s ({_off(had, one['wall_s'])}) "
            f"| {one['waiting_wall_s']:.2f} s | {one['waiting_simulated_s']:.2f} s "
            f"({_off(one['waiting_simulated_s'], one['waiting_wall_s'])}) |"
        )
    told = (
        f"The machine has {part['cores']} cores. Other processes used part of them; the fifth "
        "column lists the number of cores that the workers received. The third column is simulated "
        "with all cores, the sixth with the received cores. " + _machine(part)
    )
    return "\n".join([*rows, "", told])


def beyond(found: dict[str, Any]) -> str:
    """Tabulate the simulated efficiency by number of workers and task length."""
    shares = found["scheduler"]["simulated_efficiency_by_task_s"]
    counts = list(next(iter(shares.values())))
    rows = [
        f"| task length / workers | {' | '.join(f'{int(n):,}' for n in counts)} |",
        f"|---:|{'---:|' * len(counts)}",
    ]
    for task, row in shares.items():
        cells = " | ".join(f"{100.0 * row[n]:.3g} %" for n in counts)
        rows.append(f"| {float(task):g} s | {cells} |")
    return "\n".join(rows)


def cost(found: dict[str, Any], table: dict[str, Any], propellers: int) -> str:
    """Tabulate work, wall time and storage of three large jobs."""
    each, part = found["designs"], found["scheduler"]
    costs = Costs(part["dispatch_s"], part["gap_s"])
    size = found["sweep"]["2e6_bytes_per_point"]
    evaluations = propellers * table["building"]["model_evaluations"]
    jobs = (
        (f"(a) tables of {propellers} propellers", evaluations * each["point_fine_s"],
         1e6 * propellers * table["building"]["file_MB"]),
        ("(b) 1e6 designs", 1e6 * each["design_s"], 1e6 * each["design_points"] * size),
        ("(c) 1e12 points", 1e12 * each["point_standard_s"], 1e12 * size),
    )  # fmt: skip
    heads = " | ".join(f"{n:,} cores" for n in CORES)
    rows = [
        f"| | work on one core | {heads} | storage |",
        f"|---|---:|{'---:|' * len(CORES)}---:|",
    ]
    for words, work, stored in jobs:
        least = [least_wall(work, n, costs) for n in CORES]
        cells = " | ".join(f"{_sized(wall, TIMES)} ({task:g})" for wall, task in least)
        rows.append(f"| {words} | {_sized(work, TIMES)} | {cells} | {_sized(stored, SIZES)} |")
    return "\n".join(rows)


def catalogue(found: dict[str, Any]) -> str:
    """Tabulate times to identify the whole catalogue with one process and with two workers."""
    part = found["catalogue"]
    same = "byte-identical" if part["same_bytes"] else "NOT the same"
    rows = [
        f"`python -m tools.catalogue` for {part['propellers']} propellers with data:",
        "",
        "| | wall time | processor time |",
        "|---|---:|---:|",
    ]
    for who, said in (
        ("one_core", "one process on one core"),
        ("one_process", "one process on all cores"),
        ("local_2", "`local:2`"),
    ):
        one = part[who]
        rows.append(f"| {said} | {one['wall_s']:.0f} s | {one['processor_s']:.0f} s |")
    told = (
        f"Two workers take {1.0 / part['speed_up_over_one_core']:.2f} times the wall time of one "
        f"core and {1.0 / part['speed_up_over_one_process']:.2f} times the wall time of one "
        f"process on all cores. The files are {same}. {_machine(part)}"
    )
    return "\n".join([*rows, "", told])


def _off(simulated: float, measured: float) -> str:
    return f"{100.0 * (simulated / measured - 1.0):+.0f} %"


def _sized(value: float, units: tuple[tuple[str, float], ...]) -> str:
    """Format ``value`` in the largest unit in which it is at least 2."""
    for unit, size in units:
        if value >= 2.0 * size:
            return f"{value / size:.3g} {unit}"
    unit, size = units[-1]
    return f"{value / size:.2g} {unit}"


def _machine(part: dict[str, Any]) -> str:
    place = part["machine"]
    return (
        f"Machine: {place['cpu']}, {place['cores']} cores, Python {place['python']}, load "
        f"{place['load_before']} before the start."
    )
