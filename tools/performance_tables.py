"""Tables of docs/performance.md, from phases.json, options.json and peers.json of the results."""

from __future__ import annotations

from typing import Any


def jobs(found: dict[str, Any]) -> str:
    """How the mixed oblique batch is sorted, and what each job costs."""
    place = found["machine"]
    rows = [
        f"{place['cpu']}, one core, large blocks, after compilation; "
        f"{found['nodes_per_point']:.0f} nodes and {found['one_core_us']:.0f} µs per point on "
        "average.",
        "",
        "| radial nodes | azimuths | share of the points | nodes per point | µs per point |",
        "|---|---:|---:|---:|---:|",
    ]
    for job in found["jobs"]:
        nodes = "+".join(str(count) for count in job["panels"])
        share = 100.0 * job["share"]
        rows.append(
            f"| {nodes} | {job['azimuths']} | {share:.1f} % | {job['nodes']} "
            f"| {job['microseconds']:.1f} |"
        )
    return "\n".join(rows)


def following(found: dict[str, Any]) -> str:
    """Phases of points that follow stall."""
    rows = ["| azimuths | survey | folds | roots | loads |", "|---:|---:|---:|---:|---:|"]
    for split in found["following"]:
        cells = (f"{split[phase]:.1f} µs" for phase in ("survey", "folds", "roots", "loads"))
        rows.append(f"| {split['azimuths']} | {' | '.join(cells)} |")
    return "\n".join(rows)


def options(found: dict[str, Any]) -> str:
    """What corrections and section tables cost beside the paper's model."""
    place = found["machine"]
    rows = [
        f"{place['cpu']}, {found['points']} oblique points of the APC 8x6E with `paper-apc`, and "
        "with tables sampled from it; processor time.",
        "",
        "| model | µs per point | beside the paper's |",
        "|---|---:|---:|",
    ]
    for row in found["rows"]:
        cells = (row["model"], f"{row['microseconds']:.0f}", f"{row['ratio']:.2f}")
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows)


def peers(found: dict[str, Any]) -> str:
    """Times beside CCBlade, at two bounds on the error."""
    place, model = found["machine"], found["package"]["model"]
    rows = [
        f"{place['cpu']}, {place['cores']} cores, load {place['load_before']} at the start; WISDEM "
        f"{found['versions']['wisdem']}, propmap {place['propmap']}.  APC 8x6E, `paper-apc`, "
        "6000 rpm.",
        "",
        "| case | one call | in a batch, per point | numerical error | CCBlade at our error "
        "| CCBlade at 0.1 % |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for case in ("hover", "axial", "60 deg", "85 deg", "mixed"):
        single = f"{model['single_us'][case]:.0f} µs" if case in model["single_us"] else ""
        batch, error = model["batch_us"][case], 100.0 * model["error"][case]
        cells = [single, f"{batch:.0f} µs", f"{error:.2g} %"]
        for bound in ("measured", "promised"):
            seconds = found["ccblade"][bound]["single_us"]
            if case not in seconds:
                cells.append("not answered")
                continue
            ratio = found["ccblade_over_package"][bound][f"model_batch, {case}"]
            cells.append(f"{seconds[case] / 1e3:.3g} ms, {ratio:.0f} times a point of the batch")
        rows.append(f"| {case} | {' | '.join(cells)} |")
    return "\n".join(rows)
