"""Write the figures of README.md from the files that the commands produced.

Usage: python tools/readme_tables.py [DEMO_FOLDER]

Reads benchmarks/results/convergence.json, speed.json and demo.json; with DEMO_FOLDER, where
`propmap demo` wrote, takes demo.json and the picture from there first.  The text between the
markers is replaced; the same files give the same README.
"""

from __future__ import annotations

import json
import re
import shutil
import sys
from pathlib import Path
from typing import Any

from propmap.atomic_file import replacing

ROOT = Path(__file__).resolve().parent.parent
README = ROOT / "README.md"
RESULTS = ROOT / "benchmarks" / "results"
PICTURE = ROOT / "docs" / "figures" / "apc-8x6e-loads.png"


def take_demo(folder: Path) -> None:
    """Keep the demo's figures and its picture."""
    PICTURE.parent.mkdir(parents=True, exist_ok=True)
    for source, kept in (
        (folder / "demo.json", RESULTS / "demo.json"),
        (folder / "demo-loads.png", PICTURE),
    ):
        with replacing(kept) as part:
            shutil.copyfile(source, part)


def percent(share: float) -> str:
    """A share in per cent, to two figures."""
    return f"{100.0 * share:.2g}" if share >= 1e-6 else "<0.0001"


def fits(found: dict[str, Any]) -> str:
    """Fits to published data, checked on all of it."""
    rows = [
        "| fitted to | free | thrust | torque | rotor drag | roll moment |",
        "|---|---|---:|---:|---:|---:|",
    ]
    names = {"uiuc-8x6e": "UIUC", "gill-dandrea-2019-8x6e-fit": "oblique"}
    loads = ("thrust_N", "torque_Nm", "drag_N", "roll_moment_Nm")
    for case in found["published"]:
        cells = []
        for load in loads:
            parts = [
                f"{names[data]} {100.0 * errors[load]['relative_rms']:.1f} %"
                for data, errors in case["errors"].items()
                if load in errors
            ]
            cells.append(", ".join(parts))
        free = ", ".join(f"`{name}` {value:.3g}" for name, value in case["parameters"].items())
        to = f"{names[case['data']]}: {', '.join(case['loads']).replace('_', ' ')}"
        rows.append(f"| {to} | {free} | {' | '.join(cells)} |")
    return "\n".join(rows)


def numerical_accuracy(found: dict[str, Any]) -> str:
    """Settings against both references, in per cent of the static load."""
    rows = [
        "| setting | against | points | thrust | rotor drag | torque |",
        "|---|---|---:|---:|---:|---:|",
    ]
    for key, title in (
        ("against_reference", "independent reference"),
        ("against_twice_fine", "twice the nodes of `fine`"),
    ):
        for setting, bands in found[key].items():
            overall = bands[-1]
            cells = [
                f"{percent(overall[k]['percentile_95'])} / {percent(overall[k]['largest'])}"
                for k in ("thrust", "drag", "torque")
            ]
            rows.append(f"| `{setting}` | {title} | {overall['points']} | {' | '.join(cells)} |")
    return "\n".join(rows)


def model_accuracy(found: dict[str, Any]) -> str:
    """Model and hover model against measurements."""
    rows = [
        "| data | load | points | measured rms | this model, rms | hover model, rms |",
        "|---|---|---:|---:|---:|---:|",
    ]
    for group in found["groups"]:
        if group["title"] not in ("static", "axial", "oblique"):
            continue
        for one in group["errors"]:
            unit, load = one["unit"], one["load"].replace("_", " ")
            cells = [f"{one['measured_rms']:.3g} {unit}"]
            for model in (one["model"], one["hover"]):
                share = model["relative_rms"]
                relative = "" if share is None else f" ({100.0 * share:.0f} %)"
                cells.append(f"{model['rms']:.2g} {unit}{relative}")
            rows.append(f"| {group['title']} | {load} | {one['points']} | {' | '.join(cells)} |")
    rows += ["", "In words, from the same run:", ""]
    rows += [f"- {note}" for note in found["notes"]]
    return "\n".join(rows)


def speed(found: dict[str, Any]) -> str:
    """Times, with the machine they come from."""
    place, point = found["machine"], found["microseconds_per_point"]
    single, process, ratio = found["single_call_ms"], found["process"], found["ratios"]
    cost = found["ns_per_element"]
    rows = [
        f"{place['cpu']}, {place['cores']} cores, Python {place['python']}, "
        f"JAX {place['jax']}; medians; the machine's load was {place['load_before']} at the start.",
        "",
        "| what | time |",
        "|---|---:|",
        f"| {found['batch']} oblique points at once | {point['oblique']:.0f} µs per point |",
        f"| {found['batch']} points of the whole envelope | {point['envelope']:.0f} µs per point |",
        f"| one call, oblique | {single['oblique']:.2g} ms |",
        f"| one call, hover | {single['hover']:.2g} ms |",
        f"| one blade element | {cost['residual']:.0f} ns |",
        f"| one blade element with derivative | {cost['residual_slope']:.0f} ns |",
        f"| `propmap predict`, first ever | {process['empty_cache_s']:.1f} s |",
        f"| `propmap predict`, from then on | {process['warm_cache_s']:.1f} s |",
        f"| `fine` over `standard` | {ratio['fine_over_standard']:.1f} times |",
    ]
    return "\n".join(rows)


def replaced(text: str, name: str, table: str) -> str:
    """``text`` with what stands between the markers of ``name`` exchanged."""
    pattern = re.compile(rf"(<!-- {name} -->\n).*?(<!-- /{name} -->)", re.DOTALL)
    new, count = pattern.subn(lambda found: f"{found[1]}{table}\n{found[2]}", text)
    if count != 1:
        raise ValueError(f"README.md has {count} places for {name!r}: it must have one")
    return new


def with_tables(text: str) -> str:
    """The README's ``text`` with the tables that the results give."""
    for name, source, make in (
        ("numerical accuracy", "convergence.json", numerical_accuracy),
        ("model accuracy", "demo.json", model_accuracy),
        ("fits", "identification.json", fits),
        ("speed", "speed.json", speed),
    ):
        found = json.loads((RESULTS / source).read_text(encoding="utf-8"))
        text = replaced(text, name, make(found))
    return text


def main(arguments: list[str]) -> None:
    """Take the demo's files if a folder is given, then write the tables."""
    if arguments:
        take_demo(Path(arguments[0]))
    text = with_tables(README.read_text(encoding="utf-8"))
    with replacing(README) as part:
        part.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
