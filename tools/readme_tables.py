"""Write the table of README.md, and format other results for the documentation.

Usage: python tools/readme_tables.py [DEMO_FOLDER]

The script reads benchmarks/results/demo.json and replaces the text between the markers in
README.md.  With DEMO_FOLDER, the output folder of `make demo`, it first copies demo.json and the
picture from there.
"""

from __future__ import annotations

import json
import re
import shutil
import sys
from pathlib import Path
from typing import Any

from propmap.io.csv import replacing

ROOT = Path(__file__).resolve().parent.parent
README = ROOT / "README.md"
RESULTS = ROOT / "benchmarks" / "results"
PICTURE = ROOT / "docs" / "figures" / "apc-8x6e-loads.png"

MODELS = {"recommended": "recommended model", "paper": "paper's model", "hover": "hover model"}
"""Titles of the demo's models."""

HEADLINE = {
    "axial": {"thrust": "thrust", "torque": "torque"},
    "oblique": {"thrust": "thrust", "torque": "torque", "drag": "rotor drag"},
}
"""Loads that README.md lists for each data set of the demo, with their titles."""


def take_demo(folder: Path) -> None:
    """Copy the demo's results and picture from ``folder`` to where README.md uses them."""
    PICTURE.parent.mkdir(parents=True, exist_ok=True)
    for source, kept in (
        (folder / "demo.json", RESULTS / "demo.json"),
        (folder / "demo-loads.png", PICTURE),
    ):
        with replacing(kept) as part:
            shutil.copyfile(source, part)


def percent(share: float) -> str:
    """Format a fraction in percent with two significant digits."""
    return f"{100.0 * share:.2g}" if share >= 1e-6 else "<0.0001"


def fits(found: dict[str, Any]) -> str:
    """Tabulate fits to published data and their errors on all data sets."""
    rows = [
        "| fitted to | free | thrust | torque | rotor drag | roll moment |",
        "|---|---|---:|---:|---:|---:|",
    ]
    names = {
        "uiuc-8x6e": "UIUC",
        "gill-dandrea-2019-8x6e": "2019 polynomials",
        "gill-dandrea-2019-8x6e-fit": "2019 model",
    }
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
    """Tabulate numerical errors against both references in percent of the static load."""
    rows = [
        "| setting | against | points | thrust | rotor drag | torque | rolling moment |",
        "|---|---|---:|---:|---:|---:|---:|",
    ]
    for key, title in (
        ("against_reference", "independent reference"),
        ("against_fine", "`fine`"),
    ):
        for setting, bands in found[key].items():
            overall = bands[-1]
            cells = [
                f"{percent(overall[k]['percentile_95'])} / {percent(overall[k]['largest'])}"
                for k in ("thrust", "drag", "torque", "roll_moment")
            ]
            rows.append(f"| `{setting}` | {title} | {overall['points']} | {' | '.join(cells)} |")
    return "\n".join(rows)


def model_accuracy(found: dict[str, Any]) -> str:
    """Tabulate the errors of the models and add the notes of the demo."""
    words = [f"- {note}" for note in found["notes"]]
    return "\n".join([model_errors(found), "", "Notes of the same run:", "", *words])


def headline(found: dict[str, Any]) -> str:
    """Tabulate the relative rms errors for the loads in HEADLINE."""
    rows = [
        "| data | load | points | data spread | " + " | ".join(MODELS.values()) + " |",
        "|---|---|---:|---:|" + "---:|" * len(MODELS),
    ]
    for title, loads in HEADLINE.items():
        (group,) = (one for one in found["groups"] if one["title"] == title)
        for one in group["errors"]:
            if one["load"] in loads:
                shares = (one["models"][model]["relative_rms"] for model in MODELS)
                band = "" if one["band"] is None else _share(one["band"])
                cells = " | ".join(map(_share, shares))
                load = loads[one["load"]]
                rows.append(f"| {title} | {load} | {one['points']} | {band} | {cells} |")
    return "\n".join(rows)


def model_errors(found: dict[str, Any]) -> str:
    """Tabulate errors of the models and the difference between two forms of the data."""
    rows = [
        "| data | load | points | measured rms | data spread | "
        + " | ".join(f"{title}, rms" for title in MODELS.values())
        + " |",
        "|---|---|---:|---:|---:|" + "---:|" * len(MODELS),
    ]
    for group in found["groups"]:
        if group["title"] not in ("static", "axial", "oblique"):
            continue
        for one in group["errors"]:
            unit, load, band = one["unit"], one["load"].replace("_", " "), one["band"]
            cells = [f"{one['measured_rms']:.3g} {unit}", "" if band is None else _share(band)]
            for model in MODELS:
                errors = one["models"][model]
                share = errors["relative_rms"]
                relative = "" if share is None else f" ({_share(share)})"
                cells.append(f"{errors['rms']:.2g} {unit}{relative}")
            rows.append(f"| {group['title']} | {load} | {one['points']} | {' | '.join(cells)} |")
    return "\n".join(rows)


def _share(share: float) -> str:
    """Format a fraction in percent, with one decimal place below ten percent."""
    return f"{100.0 * share:.0f} %" if share >= 0.0995 else f"{100.0 * share:.1f} %"


def _stated(value: float | None, unit: str, digits: int, missing: str) -> str:
    return missing if value is None else f"{value:.{digits}f} {unit}"


def speed(found: dict[str, Any]) -> str:
    """Tabulate times of whole processes and of calls, with their machine."""
    place, growth = found["machine"], found["growth"]["cpu_microseconds_per_point"]
    rows = [
        f"Medians on {place['cpu']}, {place['cores']} cores, Python {place['python']}, core built "
        f"for {place['instructions']} instructions; the machine's load was "
        f"{place['load_before']} at the start.",
        "",
        "| whole process | wall time | processor time |",
        "|---|---:|---:|",
        *(
            f"| {name} | {cost['wall_s']:.2f} s | {cost['processor_s']:.2f} s |"
            for name, cost in found["processes"].items()
        ),
        "",
        "| one call from Python, recommended model | median | maximum |",
        "|---|---:|---:|",
        *(
            f"| {name} | {cost['median_us']:.0f} µs | {cost['most_us']:.0f} µs |"
            for name, cost in found["single_call"].items()
        ),
        "",
        f"| batch of {found['batch']} points | wall time per point | processor time per point |",
        "|---|---:|---:|",
        *(
            f"| {name} | {cost['wall_us']:.1f} µs | {cost['processor_us']:.1f} µs |"
            for name, cost in (found["batches"] | found["gradients"]).items()
        ),
        "",
        "| constants of the APC 8x6E | values per inflow state | wrench, steady inflow "
        "| wrench and step of the dynamic inflow, one rotor | wrench and step, four rotors |",
        "|---|---:|---:|---:|---:|",
        *(
            f"| {law} | {one['states']} | {one['wrench']:.0f} µs | {one['advance']:.0f} µs "
            f"| {one['advance of four rotors']:.0f} µs |"
            for law, one in found["inflow_as_state_us"].items()
        ),
        "",
        f"- `fine` takes {found['fine_over_standard']:.1f} times as long as `standard`.",
        f"- Processor time per oblique point: {growth['1000']:.0f} µs for a thousand points, "
        f"{growth['1000000']:.0f} µs for a million.",
        f"- Peak memory for a million points: {found['growth']['peak_megabytes'] / 1e3:.1f} GB.",
    ]
    return "\n".join(rows)


def tables(found: dict[str, Any]) -> str:
    """Tabulate times of a table, the model and RotorPy's rotor, with their machine."""
    place, query, c = found["machine"], found["query_us"], found["c_ns"]
    model, rotorpy = found["model_us"], found["rotorpy_us_per_rotor"]

    rows = [
        "Processor time of all cores, minimum of several repeats. Machine: "
        f"{place['cpu']}, {place['cores']} cores, Python {place['python']}, NumPy "
        f"{place['numpy']}, load {place['load_before']} at the start.",
        "",
        "| operation | time |",
        "|---|---:|",
        f"| table, one point | {query['scalar']:.1f} µs |",
        f"| table, one velocity vector | {query['scalar_at_velocity']:.1f} µs |",
        f"| table, 100 000 points in one call | {query['array']:.2f} µs per point |",
        f"| table, gradient of all loads, one point | {query['scalar_gradient']:.0f} µs |",
        f"| table, Ω for a thrust | {query['scalar_inverse'] / 1e3:.1f} ms |",
        f"| C header, `double` | {_stated(c['double'], 'ns', 0, 'no gcc')} |",
        f"| C header, `float` | {_stated(c['float'], 'ns', 0, 'no gcc')} |",
        "| full model, 4096 points of that table, half in descent "
        f"| {model['array']:.0f} µs per point |",
        f"| full model, one of these points, in descent | {model['scalar']:.0f} µs |",
        f"| RotorPy's rotor model, per rotor | {_stated(rotorpy, 'µs', 1, 'not installed')} |",
        "| process that imports propmap, loads the table and evaluates one point | "
        f"{found['cold_process_s']['processor']:.2f} s |",
    ]
    return "\n".join(rows)


def building(found: dict[str, Any], fine: dict[str, Any]) -> str:
    """Tabulate the building cost and the certified errors of two tables."""
    rows = [
        "| tolerance | processor time | model evaluations | knots | file | largest error | "
        "unresolved part of the envelope | largest error there |",
        "|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for one in (found["building"], fine["building"]):
        told = one["certificate"]
        rows.append(
            f"| {one['tolerance']:.1%} | {one['processor_s']:.0f} s | {one['model_evaluations']} | "
            f"{one['knots'][0]} x {one['knots'][1]} | {one['file_MB']:.1f} MB | "
            f"{max(told['max_error'].values()):.2%} | {told['unresolved_volume']:.2%} | "
            f"{max(told['unresolved_max_error'].values()):.1%} |"
        )
    return "\n".join(rows)


def replaced(text: str, name: str, table: str) -> str:
    """Return ``text`` with ``table`` between the markers of ``name``."""
    pattern = re.compile(rf"(<!-- {name} -->\n).*?(<!-- /{name} -->)", re.DOTALL)
    new, count = pattern.subn(lambda found: f"{found[1]}{table}\n{found[2]}", text)
    if count != 1:
        raise ValueError(f"README.md contains {count} pairs of markers for {name!r}, expected one")
    return new


def with_tables(text: str) -> str:
    """Return the ``text`` of README.md with the table from the results."""
    demo = json.loads((RESULTS / "demo.json").read_text(encoding="utf-8"))
    return replaced(text, "model accuracy", headline(demo))


def main(arguments: list[str]) -> None:
    """Copy the demo's files if a folder is given, then write the table of README.md."""
    if arguments:
        take_demo(Path(arguments[0]))
    text = with_tables(README.read_text(encoding="utf-8"))
    with replacing(README) as part:
        part.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
