"""``propmap choose``: rank propellers for an aircraft, with the uncertainty of the ranking."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from pathlib import Path
from typing import Annotated, Any, Literal

from typer import Option

from propmap.aircraft import ranking
from propmap.aircraft.assumptions import assumption_lines, assumptions, without_body_drag
from propmap.aircraft.mission import Mission, read_mission
from propmap.aircraft.trim import STATUSES, UNLIMITED
from propmap.catalogue.lookup import airfoil as section_law
from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.errors import InputError, quoted
from propmap.io.csv import number_or_none
from propmap.model.corrections import as_text, model_corrections, split_mount
from propmap.tasks import InProcesses, Workers, cores
from propmap.units import INCH

SHOWN = {"J": ("Wh", 3600.0), "s": ("min", 60.0), "m": ("km", 1000.0)}
"""Units of scores in tables, and their size in the units of files."""
SURE = 0.95  # probability below which two adjacent propellers are reported as not separated


def choose(
    vehicle: opt.VehicleArgument,
    speed: Annotated[float | None, Option(help="Cruise airspeed in m/s for --task cruise.")] = None,
    task: Annotated[
        str,
        Option(
            metavar="hover|cruise|fast|FILE.csv",
            help="Flight to rank for: hover, cruise at --speed, flight at top speed (fast), or a "
            "mission (FILE.csv).",
        ),
    ] = "cruise",
    by: Annotated[
        Literal["energy", "time", "range"] | None,
        Option(help="For hover and cruise: rank by energy, time or range (default: energy)."),
    ] = None,
    diameter: Annotated[
        str | None, Option(metavar="A:B", help="Range of diameters in inches (default: all).")
    ] = None,
    blades: Annotated[int | None, Option(help="Number of blades (default: any).")] = None,
    propeller: Annotated[
        list[str] | None, Option(metavar="FILE", help="Rank this propeller too; may be repeated.")
    ] = None,
    airfoil: Annotated[
        str | None, Option(metavar="NAME|FILE", help="Section law of each --propeller.")
    ] = None,
    thrust_margin: Annotated[
        float, Option(help="Minimum ratio of maximum thrust to weight in hover.")
    ] = 1.5,
    top: Annotated[int, Option(min=1, help="Number of propellers to show and compare.")] = 10,
    all_: Annotated[bool, Option("--all", help="Also show unsuitable propellers.")] = False,
    model: opt.ModelOption = None,
    correction: opt.Corrections = None,
    max_rpm: opt.MaximumRpm = None,
    charge: opt.Charge = 1.0,
    no_wakes: opt.NoWakes = False,
    picture: Annotated[
        Path | None,
        Option(metavar="FILE", help="Picture of hover power and top speed: .png, .svg or .pdf."),
    ] = None,
    format_: out.FormatOption = None,
    output: out.TextOutput = None,
    cluster: opt.Cluster = None,
) -> None:
    """Rank the propellers of the catalogue for an aircraft and a task."""
    sizes = _diameters(diameter)
    largest = opt.checked_rpm(max_rpm)
    out.check_pictures(picture)
    form = out.chosen_format(format_, output)
    if airfoil is not None and not propeller:
        found = "--airfoil is given without --propeller"
        remedy = "leave it out: the catalogue has section constants for its propellers"
        raise InputError(found, remedy)

    read = opt.vehicle_of(vehicle, no_wakes=no_wakes).vehicle

    legs = _legs(task)
    name = "mission" if legs else task
    wanted = ranking.Task(name, speed, legs, thrust_margin, by or "")
    if by in ("time", "range") and read.powertrain.battery is None:
        raise InputError(f"--by {by}: the vehicle file has no [battery]", "add this table")
    law = section_law(airfoil) if airfoil else None
    own = [ranking.file_candidate(name, law) for name in propeller or ()]
    there = {one.name for one in own if law is None}
    others = ranking.catalogue_candidates(sizes, blades)
    candidates = [*own, *(one for one in others if one.name not in there)]
    installed = law is None or bool(split_mount(law.corrections or ())[1])
    corrections = model_corrections(model or "recommended", correction or (), installed=installed)
    rests_on = assumptions(read, None, [as_text(value) for value in corrections])
    judge = ranking.Ranking(read, wanted, corrections, maximum_rotor_speed=largest, charge=charge)
    craft = judge.aircraft(candidates[0])
    if not craft.limited and (wanted.name == "fast" or picture is not None):
        raise InputError("--task fast and --picture need a top speed", UNLIMITED)
    out.note(*craft.notes)
    with InProcesses(cores()) as here, opt.workers_of(cluster, here) as workers:
        judged = _judged(judge, candidates, top, workers)
    title = f"{read.name}, {read.mass:g} kg, {len(read.mounts)} rotors; "
    title += f"rho = {read.air.density:.4g} kg/m^3{without_body_drag(read)}"
    if form == "table":
        fit = [one for one in judged if one.feasible]
        shown = fit if all_ else fit[:top]
        ranked = [_table(wanted, shown, without_body_drag(read))] if shown else []
        lines = assumption_lines(rests_on)
        out.show(output, title, *lines, *ranked, *_remarks(judged, top, all_=all_))
    else:
        rows = _rows(wanted, judged)
        whole = {"vehicle": read.name, "assumptions": rests_on, "propellers": rows}
        out.emit_rows(list(rows[0]), rows, form, output, whole=whole)
        if form == "csv":
            out.note(*assumption_lines(rests_on))
    if picture is not None:
        from propmap.report.pictures import propeller_choice

        out.save_picture(propeller_choice(title, judged, ranking.pareto(judged).tolist()), picture)


def _diameters(text: str | None) -> tuple[float, float]:
    if text is None:
        return 0.0, math.inf
    try:
        parts = [float(part) for part in text.split(":")]
    except ValueError:
        parts = []
    if len(parts) == 1:
        parts *= 2
    if len(parts) != 2 or not 0.0 < parts[0] <= parts[1] < math.inf:
        remedy = "write A:B in inches, such as 9:10"
        raise InputError(f"--diameter {quoted(text)} is not a range", remedy)
    return parts[0] * INCH, parts[1] * INCH


def _legs(task: str) -> Mission | None:
    """Return the mission that ``--task`` names, or None for another task."""
    if task != "mission" and task in ranking.MEASURES:
        return None
    if not task.lower().endswith(".csv"):
        known = ", ".join(name for name in ranking.MEASURES if name != "mission")
        found = f"--task {quoted(task)} is not known"
        raise InputError(found, f"choose from {known}, or name a mission file (.csv)")
    return read_mission(task)


def _judged(
    judge: ranking.Ranking, candidates: list[ranking.Candidate], top: int, workers: Workers
) -> list[ranking.Judged]:
    """Rank the candidates, and add standard deviations to the first ``top`` of them."""
    count = itertools.count(1)
    with out.progress_bar("propellers") as update:
        found = judge.judged(candidates, lambda: update(next(count), len(candidates)), workers)
    first = [one for one in found if one.feasible][:top]
    again = itertools.count(1)
    with out.progress_bar("uncertainty") as update:
        closer = judge.with_deviations(first, lambda: update(next(again), len(first)), workers)
    return [*closer, *found[len(closer) :]]


# --- Output of a ranking: table, remarks and rows for files --------------------------------------


def _table(task: ranking.Task, judged: list[ranking.Judged], caution: str) -> out.WideGrid:
    unit, size = SHOWN.get(task.unit, (task.unit, 1.0))
    times = any(math.isfinite(one.hover_time) for one in judged)
    cruise = "" if task.speed is None else f"{task.speed:g} m/s"
    rows = []
    for k, one in enumerate(judged):
        nearer = ranking.beats(one, judged[k + 1]) if k + 1 < len(judged) else math.nan
        cells = {
            "": str(k + 1),
            "<propeller": one.candidate.name,
            unit: out.digits(one.score / size),
            "+-": out.digits(one.deviation / size, 2),
            "beats next": out.percent(nearer, 0),
            "1 beats it": out.percent(ranking.beats(judged[0], one) if k else math.nan, 0),
            "hover [W]": out.digits(one.hover_power),
        }
        if times:
            cells["hover [min]"] = out.digits(one.hover_time / 60.0, 3)
        if cruise:
            cells[f"{cruise} [W]"] = out.digits(one.cruise_power)
            if times:
                cells[f"{cruise} [min]"] = out.digits(one.cruise_time / 60.0, 3)
        cells["margin"], cells["top [m/s]"] = (
            out.digits(value, 3) for value in (one.thrust_margin, one.top_speed)
        )
        cells["<constants"] = "good" if one.candidate.verdict == "good" else "doubtful"
        rows.append(cells)
    caption = (
        "+-: one standard deviation, from the section constants alone; beats next: probability "
        "that a propeller is better than the next one; 1 beats it: probability that the first "
        "propeller is better than this one; margin: maximum thrust divided by the weight, "
        "in hover; doubtful constants: see --format csv for the reason"
    )
    spare = ("hover [min]", f"{cruise} [min]", "margin", "top [m/s]", "1 beats it", f"{cruise} [W]")
    title = f"ranked by {task.words} [{unit}]{caution}"
    body = [list(cells.values()) for cells in rows]
    return out.WideGrid("|".join(rows[0]), body, title, caption, spare)


def _remarks(judged: list[ranking.Judged], top: int, *, all_: bool) -> list[Any]:
    """Return remarks on pairs that the uncertainty does not separate and on unsuitable ones."""
    fit = [one for one in judged if one.feasible]
    rest = [one for one in judged if not one.feasible]
    remarks: list[Any] = []
    close = [
        f"{k + 1} and {k + 2}"
        for k, (a, b) in enumerate(itertools.pairwise(fit[:top]))
        if ranking.beats(a, b) < SURE
    ]
    if close:
        remarks.append(
            f"adjacent pairs not separated with {SURE:.0%} probability: {', '.join(close)}"
        )
    level = [k + 2 for k, one in enumerate(fit[1:top]) if ranking.beats(fit[0], one) < SURE]
    if level:
        remarks.append(f"not separated from the first: {', '.join(map(str, level))}")
    limits = Counter(one.limit for one in fit[:top] if one.limit in STATUSES)
    if limits:
        words = (f"{STATUSES[name].removeprefix('beyond ')} ({n})" for name, n in limits.items())
        remarks.append(f"limit of the top speed (number of propellers): {', '.join(words)}")
    if len(fit) > top and not all_:
        remarks.append(f"{len(fit) - top} more are suitable: see --all or --format csv")
    if not fit:
        remarks.append("no propeller is suitable; the reasons are below, best candidate first")
    if rest and (all_ or not fit):
        rows = [(one.candidate.name, one.why_not) for one in rest]
        remarks.append(out.grid("<propeller|<reason", rows, f"{len(rest)} unsuitable propellers"))
    elif rest:
        remarks.append(f"{len(rest)} are unsuitable: --all shows the reasons")
    return remarks


def _rows(task: ranking.Task, judged: list[ranking.Judged]) -> list[dict[str, Any]]:
    """Return the ranking as rows for files, with None for NaN."""
    name = f"{task.ranked_by}_{task.unit.replace('/', '_per_')}"
    rows = []
    for k, one in enumerate(judged):
        following = judged[k + 1] if k + 1 < len(judged) else None
        sure = ranking.beats(one, following) if following is not None else math.nan
        numbers = {
            "diameter_m": one.candidate.propeller.diameter,
            name: one.score,
            "standard_deviation": one.deviation,
            "probability_beats_next": sure,
            "probability_first_beats": ranking.beats(judged[0], one) if k else math.nan,
            "hover_power_W": one.hover_power,
            "cruise_power_W": one.cruise_power,
            "hover_time_s": one.hover_time,
            "cruise_time_s": one.cruise_time,
            "thrust_margin": one.thrust_margin,
            "top_speed_mps": one.top_speed,
        }
        rows.append(
            {"propeller": one.candidate.name, "blades": one.candidate.propeller.blades}
            | {key: number_or_none(value) for key, value in numbers.items()}
            | {"feasible": one.feasible, "top_speed_limit": one.limit, "why_not": one.why_not}
            | {"constants": one.candidate.verdict}
        )
    return rows
