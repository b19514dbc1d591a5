"""Tables of docs/performance.md, from options.json and peers.json of the results."""

from __future__ import annotations

from typing import Any


def options(found: dict[str, Any]) -> str:
    """Tabulate the cost of corrections and section tables relative to the paper's model."""
    place = found["machine"]
    rows = [
        f"Processor time for {found['points']} oblique points of the APC 8x6E with the section law "
        f"`paper-apc`, or with tables sampled from this law; {place['cpu']}.",
        "",
        "| model | µs per point | relative to `paper` |",
        "|---|---:|---:|",
    ]
    for row in found["rows"]:
        cells = (row["model"], f"{row['microseconds']:.0f}", f"{row['ratio']:.2f}")
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows)


def peers(found: dict[str, Any]) -> str:
    """Tabulate times of propmap and of CCBlade at two bounds on CCBlade's error."""
    place, model = found["machine"], found["package"]["model"]
    rows = [
        f"{place['cpu']}, {place['cores']} cores, load {place['load_before']} at the start; WISDEM "
        f"{found['versions']['wisdem']}, propmap {place['propmap']}.  APC 8x6E, `paper-apc`, "
        "6000 rpm.",
        "",
        "| case | one call | per point in a batch | numerical error | CCBlade at propmap's error "
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
                cells.append("not solved")
                continue
            ratio = found["ccblade_over_package"][bound][f"model_batch, {case}"]
            cells.append(f"{seconds[case] / 1e3:.3g} ms, {ratio:.0f} times propmap in a batch")
        rows.append(f"| {case} | {' | '.join(cells)} |")
    return "\n".join(rows)


def mjx(found: dict[str, Any]) -> str:
    """Tabulate the time of a step of many vehicles in MJX, with and without rotors."""
    rows = {
        "step_of_mjx_alone": "step, without rotors",
        "step_on_hover_model": "step, hover model",
        "step_on_table": "step, table",
        "wrench_of_table": "force and moment alone, table",
        "wrench_of_table_and_gradient": "vertical force and its gradient alone, table",
    }
    lines = ["| | ms | million vehicles per second |", "|---|---:|---:|"]
    for name, words in rows.items():
        rate = found["vehicles_per_second"][name] / 1e6
        lines.append(f"| {words} | {found['milliseconds'][name]:.1f} | {rate:.2f} |")
    return "\n".join(lines)
