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
            time, ratio = (float(f"{x:.2g}") for x in (seconds[case] / 1e3, ratio))
            cells.append(f"{time:,g} ms, {ratio:,g} times propmap")
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


def accelerator(found: dict[str, Any]) -> str:
    """Tabulate the speed of tables and quadrotors in JAX, and the error of single precision."""
    place = found["machine"]
    # The last two columns were measured once, on an H100; see the page.
    rows = (
        ("loads", "points", "1100", "610"),
        ("loads_with_derivatives", "points with derivatives", "670", ""),
        ("steps", "steps of a quadrotor", "578", ""),
        ("steps_with_gradient", f"steps with the gradient through {found['steps']}", "184", ""),
    )
    lines = [
        f"Millions per second, for {found['points']:,} points and {found['vehicles']:,} quadrotors "
        f"({place['cpu']}, {place['cores']} cores, load {place['load_before']} at the start, JAX "
        f"{place['jax']}), and for 1,000,000 points and 262,144 quadrotors (H100).",
        "",
        f"| | {place['device']}, single | double | H100, single | double |",
        "|---|---:|---:|---:|---:|",
    ]
    for name, words, *once in rows:
        each = [found["per_second"][precision][name] for precision in ("single", "double")]
        cells = [f"{1e-6 * rate:.2g}" for rate in each]
        lines.append(f"| {words} | {' | '.join((*cells, *once))} |")
    lines += ["", "| load | single minus double precision, largest share of the static load |"]
    lines.append("|---|---:|")
    for name, apart in found["single_minus_double"].items():
        lines.append(f"| {name.replace('_', ' ')} | {apart:.1e} |")
    return "\n".join(lines)
