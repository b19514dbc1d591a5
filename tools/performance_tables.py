"""Tables of docs/performance.md, from options.json and peers.json of the results."""

from __future__ import annotations

from typing import Any


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


def mjx(found: dict[str, Any]) -> str:
    """What a step of many vehicles in MJX takes, and the rotors' share of it."""
    rows = {
        "step_of_mjx_alone": "step, without rotors",
        "step_on_hover_model": "step, hover model",
        "step_on_table": "step, table",
        "wrench_of_table": "force and moment alone, table",
        "wrench_of_table_and_gradient": "its vertical component and its gradient, table",
    }
    lines = ["| | ms | million vehicles per second |", "|---|---:|---:|"]
    for name, words in rows.items():
        rate = found["vehicles_per_second"][name] / 1e6
        lines.append(f"| {words} | {found['milliseconds'][name]:.1f} | {rate:.2f} |")
    return "\n".join(lines)
