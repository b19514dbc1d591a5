"""Write the generated parts of the documentation: tables of results and the command reference.

Usage: python -m tools.docs_pages FOLDER

The documentation build calls ``write``.  All numbers come from benchmarks/results/, except the
table of effects on rotor drag, which comes from the model.  The commands themselves provide the
command reference.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

from propmap.catalogue.identified import all_identified
from propmap.export import EXPORTS
from propmap.io.csv import replacing
from tools import (
    aircraft_tables,
    flight_tables,
    lifting_line_tables,
    performance_tables,
    readme_tables,
    scale_tables,
    simulator_tables,
)
from tools.catalogue.verdict import summary
from tools.drag_effects import drag_effects
from tools.drag_effects import table as drag_effects_table

RESULTS = Path(__file__).resolve().parent.parent / "benchmarks" / "results"
LOADS = {
    "thrust": "thrust",
    "torque": "torque",
    "drag": "rotor drag",
    "roll_moment": "roll moment",
    "pitch_moment": "pitch moment",
}

LEFT_OUT = {
    "own": "its own constants",
    "own_run": "its own constants without the run at its middle rpm: errors of this run",
    "own_fastest": "its own constants without the run at its highest rpm: errors of this run",
    "family": "constants of its family; its blade is known",
    "other_blade_of_family": "constants of family members with other blades; its blade is known",
    "population": "constants of all propellers; its blade is known",
    "maker": "constants of its family; its blade from the maker's file",
    "family_blade": "mean blade and constants of its family",
    "population_blade": "mean blade and constants of all propellers",
    "family_static": "constants of its family, after a static test: errors of moving rows",
    "population_static": "constants of all propellers, after a static test: errors of moving rows",
    "family_label": "mean blade and constants of its family; its blade was never measured",
    "siblings_label": "mean blade of all, constants of its family; no family blade was measured",
    "population_label": "mean blade and constants of all propellers; no family blade was measured",
}


def write(folder: Path) -> None:
    """Write all generated parts into ``folder`` as Markdown."""
    found = {
        name: json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
        for name in (
            "accelerator",
            "after_static",
            "aircraft",
            "choice",
            "coaxial",
            "cluster",
            "convergence",
            "cross_check",
            "demo",
            "fine_table",
            "flight_held_out",
            "flight_steps",
            "flight_twins",
            "identification",
            "interference",
            "left_out",
            "lifting_line",
            "lifting_line_causes",
            "mjx",
            "options",
            "peers",
            "sim",
            "speed",
            "table",
            "throttle",
            "wind",
        )
    }
    parts = {
        "numerical-accuracy": readme_tables.numerical_accuracy(found["convergence"]),
        "model-accuracy": readme_tables.model_accuracy(found["demo"]),
        "fits": readme_tables.fits(found["identification"]),
        "building-tables": readme_tables.building(found["table"], found["fine_table"]),
        "speed": readme_tables.speed(found["speed"]),
        "table-speed": readme_tables.tables(found["table"]),
        "twins": twins(found["identification"]),
        "coverage": coverage(found["identification"]),
        "flight-twins": flight_twins(found["flight_twins"]),
        "by-angle": by_angle(found["demo"]),
        "flight-terms": flight_tables.terms(found["flight_steps"]),
        "flight-terms-recorded": flight_tables.terms_as_recorded(found["flight_steps"]),
        "flight-unseen-forces": flight_tables.unseen_forces(found["flight_held_out"]),
        "flight-unseen-moments": flight_tables.unseen_moments(found["flight_held_out"]),
        "flight-responses": flight_tables.responses(found["flight_held_out"]),
        "flight-throttle": flight_tables.throttle(found["throttle"]),
        "throttle-without": flight_tables.throttle_without(found["throttle"]),
        "throttle-twins": flight_tables.throttle_twins(found["throttle"]),
        **{f"wind-{name}": flight_tables.wind(rows) for name, rows in found["wind"].items()},
        "wakes-cost": flight_tables.wakes_cost(found["interference"]),
        "wakes-coaxial": flight_tables.coaxial(found["coaxial"]),
        "measured-power": aircraft_tables.measured_power(found["aircraft"]["power"]),
        "aircraft-times": aircraft_tables.times(found["aircraft"]),
        "aircraft-study": aircraft_tables.study(found["aircraft"]["study"]),
        "aircraft-transition": aircraft_tables.transition(found["aircraft"]["transition"]),
        "choice-cost": choice_cost(found["choice"]),
        "choice-measured": choice_measured(found["choice"]),
        "choice-table": choice_table(found["choice"]),
        "lifting-line-checks": lifting_line_tables.known_answers(found["lifting_line"]),
        "lifting-line-convergence": lifting_line_tables.convergence(found["lifting_line"]),
        "lifting-line-four": lifting_line_tables.four_points(found["lifting_line"]),
        "lifting-line-causes": lifting_line_tables.causes(found["lifting_line_causes"]),
        "lifting-line-variation": lifting_line_tables.variation(found["lifting_line"]),
        "lifting-line-everywhere": lifting_line_tables.everywhere(found["lifting_line"]),
        "mjx": performance_tables.mjx(found["mjx"]),
        "performance-accelerator": performance_tables.accelerator(found["accelerator"]),
        "performance-options": performance_tables.options(found["options"]),
        "performance-peers": performance_tables.peers(found["peers"]),
        "drag-effects": drag_effects_table(drag_effects()),
        "identified": identified(),
        "after-static": after_static(found["after_static"]),
        "left-out": left_out(found["left_out"]),
        "left-out-makers": left_out_makers(found["left_out"]["makers"]),
        "other-tunnel": other_tunnel(found["demo"]),
        "scale-sweep": scale_tables.sweep(found["cluster"]),
        "scale-overhead": scale_tables.overhead(found["cluster"]),
        "scale-workers": scale_tables.workers(found["cluster"]),
        "scale-beyond": scale_tables.beyond(found["cluster"]),
        "scale-cost": scale_tables.cost(
            found["cluster"], found["fine_table"], len(all_identified())
        ),
        "scale-catalogue": scale_tables.catalogue(found["cluster"]),
        "simulators-agreement": simulator_tables.agreement(found["cross_check"]),
        "simulators-convergence": simulator_tables.convergence(found["cross_check"]),
        "simulators-elsewhere": simulator_tables.elsewhere(found["cross_check"]),
        "simulators-energy": simulator_tables.energy(found["cross_check"]),
        "simulators-models": simulator_tables.models(found["cross_check"]),
        "sim-steps": sim_steps(found["sim"]),
        "exports": exports(),
        "cli": command_reference(),
    }
    for name, text in parts.items():
        # A no-break space keeps the per cent sign on the line of its number.
        kept = re.sub(r"(?<=\d) %", "\u00a0%", text)
        with replacing(folder / f"{name}.md") as part:
            part.write_text(kept + "\n", encoding="utf-8")


def twins(found: dict[str, Any]) -> str:
    """Return the table of noise-free twin experiments: errors of the fitted parameters."""
    rows = [
        "| truth | largest residual | c_l1 | c_l2 | c_d | alpha_0 | starts that end near it |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    for name, twin in found["noise_free"].items():
        errors = twin["relative_errors"]
        cells = [f"{abs(errors[n]):.0e}" for n in ("c_l1", "c_l2", "c_d", "alpha_0")]
        residual = f"{twin['largest_residual_share_of_weight']:.0e} of the weight"
        cells.append(f"{twin['starts_within_1e-3_of_the_truth']} of {twin['starts']}")
        rows.append(f"| `{name}` | {residual} | {' | '.join(cells)} |")
    return "\n".join(rows)


def coverage(found: dict[str, Any]) -> str:
    """Return the table of how often the 95 % intervals contain the truth."""
    rows = [
        "| twin | parameter set | parameter | called identified, of 200 "
        "| truth inside, of the identified | truth inside, of all |",
        "|---|---|---|---:|---:|---:|",
    ]
    for name, twins in found["coverage"].items():
        for twin, parameters in twins.items():
            for parameter, case in parameters.items():
                shares = [case["of_these_truth_inside"], case["of_all_truth_inside"]]
                inside = ["-" if s is None else f"{100.0 * s:.1f} %" for s in shares]
                cells = (twin, f"`{name}`", parameter, case["called_identified"], *inside)
                rows.append(f"| {' | '.join(str(cell) for cell in cells)} |")
    return "\n".join(rows)


def flight_twins(found: dict[str, Any]) -> str:
    """Return the same table for fits of whole flights."""
    rows = [
        f"| parameter | truth | unit | called identified, of {found['repetitions']} "
        "| truth inside, of the identified | of all | if rows were independent | median width "
        "| error without noise |",
        "|---|---:|---|---:|---:|---:|---:|---:|---:|",
    ]
    for name, case in found["coverage"].items():
        shares = (
            case["of_these_truth_inside"],
            case["of_all_truth_inside"],
            case["if_rows_were_independent"],
        )
        exact = found["noise_free"][name]
        cells = (
            f"`{name}`",
            f"{exact['truth']:.3g}",
            case["unit"],
            case["called_identified"],
            *("-" if share is None else f"{100.0 * share:.0f} %" for share in shares),
            f"{case['median_width']:.2g}",
            f"{100.0 * abs(exact['relative_error']):.1g} %",
        )
        rows.append(f"| {' | '.join(str(cell) for cell in cells)} |")
    return "\n".join(rows)


def by_angle(found: dict[str, Any]) -> str:
    """Return the errors of three models on the oblique data, by angle beta."""
    groups = [g for g in found["groups"] if g["title"].startswith("oblique ")]
    loads = [one["load"] for one in groups[0]["errors"]]
    names = " | ".join(LOADS[load] for load in loads)
    rows = [f"| β [deg] | points | {names} |", "|---:|---:|" + "---:|" * len(loads)]
    for group in groups:
        cells = []
        for one in group["errors"]:
            shares = [one["models"][model]["relative_rms"] for model in readme_tables.MODELS]
            cells.append(" / ".join("-" if s is None else f"{100.0 * s:.0f} %" for s in shares))
        points = group["errors"][0]["points"]
        rows.append(f"| {group['beta_deg']:g} | {points} | {' | '.join(cells)} |")
    return "\n".join(rows)


def choice_cost(found: dict[str, Any]) -> str:
    """Return the cost of each representation and its difference from the full model."""
    rows = [
        "| | one point [µs] | in a batch [µs per point] | thrust | rotor drag | torque "
        "| roll moment |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    for way in found["ways"]:
        costs = [way[f"microseconds_{how}"] for how in ("single", "batch")]
        lost = way["model_error"]
        shares = [
            "-" if lost is None else f"{100.0 * lost[load]:.2g} %"
            for load in ("thrust", "drag", "torque", "roll_moment")
        ]
        cells = [f"{cost:.2g}" if cost < 100.0 else f"{cost:.0f}" for cost in costs] + shares
        rows.append(f"| {way['name']} | {' | '.join(cells)} |")
    in_c = found["table"]["microseconds_in_c"]
    if in_c is not None:
        same = " | ".join(rows[4].split(" | ")[3:])
        rows.insert(5, f"| table, C header | {in_c:.2g} | {in_c:.2g} | {same}")
    return "\n".join(rows)


def choice_measured(found: dict[str, Any]) -> str:
    """Return the errors of each representation on fitted and on held-out measurements."""
    order = ("thrust", "torque", "drag", "roll_moment")
    names = " | ".join(LOADS[load] for load in order)
    rows = [f"| | {names} |", "|---|" + "---:|" * len(order)]
    for title, group in (("ways", "fitted to these data"), ("unseen", "fitted to UIUC's data")):
        for way in found[title]:
            cells = [percent(way["measured"][load]) for load in order]
            rows.append(f"| {way['name']}, {group} | {' | '.join(cells)} |")
    return "\n".join(rows)


def percent(share: float) -> str:
    """Return a percentage: an integer from 10 %, two significant digits below."""
    return f"{100.0 * share:.0f} %" if share >= 0.1 else f"{100.0 * share:.2g} %"


def choice_table(found: dict[str, Any]) -> str:
    """Return a sentence on the range, build time and size of the table."""
    table, place = found["table"], found["machine"]
    rpm = [9.549296585513721 * w for w in found["envelope"]["omega"]]
    return (
        f"The table of this comparison covers {rpm[0]:.0f} to {rpm[1]:.0f} rpm, "
        f"{found['envelope']['speed'][0]:g} to {found['envelope']['speed'][1]:g} m/s and β from 0 "
        f"to 90° with a tolerance of {100.0 * table['tolerance']:g} % of the static loads; it "
        f"took {table['build_seconds']:.0f} s to build and certify, and its size is "
        f"{table['bytes'] / 1e3:.0f} kB. Times: {place['cpu']}, {place['cores']} cores, Python "
        f"{place['python']}, minimum of many runs; load of the machine at the start: "
        f"{place['load_before']}."
    )


def after_static(found: dict[str, Any]) -> str:
    """Return the errors in axial flight before and after a fit to static rows."""
    lines = [
        f"| {found['propellers']} propellers | thrust, median error | torque, median error | "
        "rows in the 95 % band, thrust | torque |",
        "|---|---|---|---|---|",
    ]
    for when in ("before", "after"):
        cells = [*found[when]["error"], *found[when]["held"]]
        lines.append(f"| {when} | " + " | ".join(f"{100.0 * v:.1f} %" for v in cells) + " |")
    return "\n".join(lines) + "\n"


def other_tunnel(found: dict[str, Any]) -> str:
    """Return the errors of the catalogue prediction of the 8x6E on another tunnel's data."""
    rows = [
        "| load | inside the 95 % band | mean error, standard deviations | rms error |",
        "|---|---:|---:|---:|",
    ]
    for one in found["by_name"]:
        rows.append(
            f"| {LOADS[one['load']]} | {one['inside']:.0%} | {one['z_score']:+.1f} | "
            f"{one['relative_rms']:.0%} |"
        )
    return "\n".join(rows)


def left_out(found: dict[str, Any]) -> str:
    """Return the errors of propellers that are predicted from the other propellers."""
    rows = [
        "| predicted from | propellers | C_T: median, 90th percentile | C_P: median, 90th "
        "percentile | inside the 95 % band at rest: C_T, C_P | moving: C_T, C_P | half width: C_T, "
        "C_P | score: C_T, C_P |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for name, told in LEFT_OUT.items():
        one = found[name]
        cells = [
            f"{100.0 * half:.1f} %, {100.0 * most:.1f} %"
            for half, most in zip(one["median"], one["nine_in_ten"], strict=True)
        ]
        cells += [
            "-" if None in one[key] else ", ".join(f"{100.0 * share:.1f} %" for share in one[key])
            for key in ("at_rest", "moving")
        ]
        cells.append(", ".join(f"{100.0 * half:.0f} %" for half in one["half_width"]))
        cells.append(", ".join(f"{score:.2f}" for score in one["score"]))
        rows.append(f"| {told} | {one['propellers']} | {' | '.join(cells)} |")
    return "\n".join(rows)


def left_out_makers(found: dict[str, Any]) -> str:
    """Compare mean blades with blades from makers' files, by series."""
    rows = [
        "| series | propellers | mean blade: C_T, C_P | blade from the maker's file: C_T, C_P |",
        "|---|---:|---:|---:|",
    ]
    for name, one in found.items():
        cells = [
            ", ".join(
                f"{100.0 * half:.1f} % ({100.0 * rms:.1f} %)"
                for half, rms in zip(one[group], one[f"{group}_rms"], strict=True)
            )
            for group in ("mean", "maker")
        ]
        rows.append(f"| {name} | {one['propellers']} | {' | '.join(cells)} |")
    return "\n".join(rows)


def identified() -> str:
    """Return the errors of the bundled constants, and the propellers with the largest errors."""
    found = summary(all_identified())
    rows = [
        f"Root mean square errors over all rows of {found.propellers} propellers with a measured "
        "blade, from "
        "`python -m tools.catalogue`:",
        "",
        "| | median | 90th percentile |",
        "|---|---:|---:|",
        *(
            f"| {name} | {median:.4f} | {tail:.4f} |"
            for name, (median, tail) in (("C_T", found.thrust), ("C_P", found.power))
        ),
        "",
        "Propellers with the largest errors:",
        "",
        "| propeller | C_T | C_P | verdict |",
        "|---|---:|---:|---|",
        *(
            f"| {one.tested} | {one.thrust_rms:.4f} | {one.power_rms:.4f} | {one.verdict} |"
            for one in found.worst
        ),
    ]
    return "\n".join(rows)


def sim_steps(found: dict[str, Any]) -> str:
    """Return the time of a MuJoCo step for each source of the forces."""
    place, steps = found["machine"], found["step_us"]
    bare, *others = steps.items()
    rows = [
        f"| source of the forces | step [µs] | added to {bare[0]} [µs] |",
        "|---|---:|---:|",
        *(
            f"| {name} | {cost:.1f} | {round(cost - bare[1], 1) + 0.0:.1f} |"
            for name, cost in others
        ),
        "",
        f"On {place['cpu']} with {place['cores']} cores, load {place['load_before']}, MuJoCo "
        f"{found['mujoco']}.",
    ]
    return "\n".join(rows)


def exports() -> str:
    """Return the table of exports from their registry: files, kept and lost terms."""
    rows = ["| target | writes | keeps | loses |", "|---|---|---|---|"]
    kinds = {"table": "", "rotor": " of a propeller", "pusher": " of a pusher or tailsitter"}
    for e in EXPORTS:
        kind = kinds.get(e.source, " of a vehicle")
        rows.append(f"| `{e.target}`{kind} | {e.writes} | {e.keeps} | {e.loses} |")
    return "\n".join(rows)


def command_reference() -> str:
    """Return the reference of all commands, from typer."""
    command = [sys.executable, "-m", "typer", "propmap.cli.app", "utils", "docs"]
    done = subprocess.run(
        [*command, "--name", "propmap"], capture_output=True, text=True, check=True
    )
    # typer truncates the descriptions in its lists; each command has its own section below.
    text = re.sub(r"\*\*Commands\*\*:\n\n(?:\* .*\n)+\n?", "", done.stdout)
    return text.replace("# `propmap`\n", "# Commands\n", 1).strip()


if __name__ == "__main__":
    write(Path(sys.argv[1]))
