"""``propmap choose``: which propeller suits an aircraft."""

from __future__ import annotations

import itertools
import math
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from propmap.cli.aircraft_options import (
    Charge,
    MaximumRpm,
    NoWakes,
    VehicleArgument,
    checked_rpm,
    say_missing,
    vehicle_of,
)
from propmap.cli.output import (
    Format,
    FormatOption,
    TextOutput,
    check_pictures,
    chosen_format,
    emit_rows,
    grid,
    show,
)
from propmap.cli.rotor_options import Corrections, ModelName, ModelOption
from propmap.errors import InputError, quoted

if TYPE_CHECKING:
    from rich.table import Table

    from propmap.aircraft.candidates import Candidate
    from propmap.aircraft.ranking import Judged, Ranking
    from propmap.aircraft.task import Task

INCH = 0.0254


class TaskName(StrEnum):
    """What the propellers are ranked by, but for a mission."""

    hover = "hover"
    cruise = "cruise"
    fast = "fast"


UNITS = {
    "hover": ("W", 1.0),
    "cruise": ("J/m", 1.0),
    "fast": ("m/s", 1.0),
    "mission": ("Wh", 3600.0),
}


def choose(
    vehicle: VehicleArgument,
    speed: Annotated[float, typer.Option("--speed", help="Cruise speed [m/s].")],
    task: Annotated[
        TaskName, typer.Option("--task", help="Ranked by hover power, energy per metre, top speed.")
    ] = TaskName.cruise,
    mission: Annotated[
        Path | None,
        typer.Option("--mission", metavar="FILE.csv", help="Ranked by the energy of this instead."),
    ] = None,
    diameter: Annotated[
        str | None, typer.Option("--diameter", metavar="A:B", help="Of the propellers [in].")
    ] = None,
    blades: Annotated[int | None, typer.Option("--blades", help="How many they have.")] = None,
    propeller: Annotated[
        list[str] | None,
        typer.Option("--propeller", metavar="FILE", help="Another one; may be repeated."),
    ] = None,
    airfoil: Annotated[
        str | None,
        typer.Option("--airfoil", metavar="NAME|FILE", help="Section law of those of --propeller."),
    ] = None,
    thrust_margin: Annotated[
        float, typer.Option("--thrust-margin", help="That hover must leave, 2 for twice.")
    ] = 1.5,
    top: Annotated[
        int, typer.Option("--top", min=1, help="How many are shown, and compared closely.")
    ] = 10,
    all_: Annotated[
        bool, typer.Option("--all", help="Show those that do not fit as well.")
    ] = False,
    model: ModelOption = None,
    correction: Corrections = None,
    max_rpm: MaximumRpm = None,
    charge: Charge = 1.0,
    no_wakes: NoWakes = False,
    picture: Annotated[
        Path | None, typer.Option("--picture", metavar="FILE", help="Hover power and top speed.")
    ] = None,
    format_: FormatOption = None,
    output: TextOutput = None,
) -> None:
    """Rank the propellers of the catalogue on an aircraft, those that fit first."""
    sizes = _diameters(diameter)
    largest = checked_rpm(max_rpm)
    check_pictures(picture)
    form = chosen_format(format_, output)
    if airfoil is not None and not propeller:
        raise InputError(
            "--airfoil is given without --propeller",
            "leave it out: propellers of the catalogue have their own constants",
        )

    read = vehicle_of(vehicle, no_wakes=no_wakes)

    from propmap.aircraft.candidates import catalogue_candidates, file_candidate
    from propmap.aircraft.ranking import Ranking
    from propmap.aircraft.task import Task
    from propmap.catalogue.lookup import airfoil as section_law
    from propmap.engine.compilation import keep_compiled
    from propmap.model.corrections import corrections_of

    wanted = Task(
        "mission" if mission else task.value, speed, _legs(mission), thrust_margin=thrust_margin
    )
    law = section_law(airfoil) if airfoil else None
    candidates = [
        *(file_candidate(name, law) for name in propeller or ()),
        *catalogue_candidates(sizes, blades),
    ]
    corrections = tuple(corrections_of(model or ModelName.recommended, correction or ()))
    say_missing(read)
    keep_compiled()
    ranking = Ranking(read, wanted, corrections, maximum_rotor_speed=largest, charge=charge)
    judged = _judged(ranking, candidates, top)
    title = (
        f"{read.name}, {read.mass:g} kg, {len(read.mounts)} rotors; "
        f"rho = {read.air.density:.4g} kg/m^3"
    )
    if form is Format.table:
        fit = [one for one in judged if one.feasible]
        shown = fit if all_ else fit[:top]
        show(output, title, _table(wanted, shown), *_told(judged, top, all_=all_))
    else:
        rows = _rows(wanted, judged)
        emit_rows(list(rows[0]), rows, form, output)
    if picture is not None:
        from propmap.aircraft.ranking_comparison import pareto
        from propmap.report.propeller_choice import propeller_choice
        from propmap.report.style import save

        save(propeller_choice(title, judged, pareto(judged).tolist()), picture)
        typer.echo(f"wrote {picture}", err=True)


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
        raise InputError(f"--diameter {quoted(text)} is no range", "write A:B in inches, as 9:10")
    return parts[0] * INCH, parts[1] * INCH


def _legs(path: Path | None) -> Any:
    if path is None:
        return None
    from propmap.aircraft.mission import read_mission

    return read_mission(path)


def _judged(ranking: Ranking, candidates: list[Candidate], top: int) -> list[Judged]:
    """The ranking, with deviations of the first ``top``."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, disable=not console.is_terminal, transient=True) as progress:
        step = progress.add_task("propellers", total=len(candidates))
        found = ranking.judged(candidates, lambda: progress.advance(step))
        first = [one for one in found if one.feasible][:top]
        step = progress.add_task("uncertainty", total=len(first))
        closer = ranking.with_deviations(first, lambda: progress.advance(step))
    return [*closer, *found[len(closer) :]]


def _table(task: Task, judged: list[Judged]) -> Table:
    from propmap.aircraft.ranking_comparison import beats
    from propmap.aircraft.task import TASKS

    unit, size = UNITS[task.name]
    times = any(math.isfinite(one.hover_time) for one in judged)
    heads = ["", "<propeller", unit, "+-", "beats next", "hover [W]", f"{task.speed:g} m/s [W]"]
    heads += ["hover [min]", f"{task.speed:g} m/s [min]"] if times else []
    heads += ["margin", "top [m/s]", "<constants"]
    rows = []
    for k, one in enumerate(judged):
        sure = beats(one, judged[k + 1]) if k + 1 < len(judged) else math.nan
        cells = [
            str(k + 1),
            one.candidate.name,
            _digits(one.score / size),
            _digits(one.deviation / size),
            f"{100.0 * sure:.0f} %" if math.isfinite(sure) else "-",
            _digits(one.hover_power),
            _digits(one.cruise_power),
        ]
        if times:
            cells += [_digits(one.hover_time / 60.0, 3), _digits(one.cruise_time / 60.0, 3)]
        cells += [_digits(one.thrust_margin, 3), _digits(one.top_speed, 3)]
        cells.append("good" if one.candidate.verdict == "good" else "doubtful")
        rows.append(cells)
    title = f"ranked by {TASKS[task.name]}" if task.name != "mission" else "ranked by energy [Wh]"
    caption = (
        "+-: one standard deviation, from that of the constants alone; beats next: probability of "
        "being better than the next, from the same; margin: thrust at the first limit over weight, "
        "in hover; doubtful constants: why, by --format csv"
    )
    return grid("|".join(heads), rows, title, caption)


def _told(judged: list[Judged], top: int, *, all_: bool) -> list[Any]:
    """What the uncertainty does not separate, and why the rest do not fit."""
    from propmap.aircraft.ranking_comparison import beats

    fit = [one for one in judged if one.feasible]
    rest = [one for one in judged if not one.feasible]
    told: list[Any] = []
    close = [
        f"{k + 1} and {k + 2}"
        for k, (a, b) in enumerate(itertools.pairwise(fit[:top]))
        if beats(a, b) < SURE
    ]
    if close:
        told.append(f"not separated to {SURE:.0%}: {', '.join(close)}")
    if len(fit) > top and not all_:
        told.append(f"{len(fit) - top} more fit: all are shown by --all, or --format csv")
    if not fit:
        told.append("no propeller fits; the closest reasons are below")
    if rest and (all_ or not fit):
        rows = [(one.candidate.name, one.why_not) for one in rest]
        told.append(grid("<propeller|<why not", rows, f"{len(rest)} that do not fit"))
    elif rest:
        told.append(f"{len(rest)} do not fit: why is shown by --all")
    return told


SURE = 0.95
"""Probability below which neighbours are said not to be separated."""


def _rows(task: Task, judged: list[Judged]) -> list[dict[str, Any]]:
    from propmap.aircraft.ranking_comparison import beats

    unit, _ = UNITS[task.name]
    name = "energy_J" if task.name == "mission" else f"score_{unit.replace('/', '_per_')}"
    rows = []
    for k, one in enumerate(judged):
        following = judged[k + 1] if k + 1 < len(judged) else None
        sure = beats(one, following) if following is not None else math.nan
        numbers = {
            "diameter_m": one.candidate.propeller.diameter,
            name: one.score,
            "standard_deviation": one.deviation,
            "probability_beats_next": sure,
            "hover_power_W": one.hover_power,
            "cruise_power_W": one.cruise_power,
            "hover_time_s": one.hover_time,
            "cruise_time_s": one.cruise_time,
            "thrust_margin": one.thrust_margin,
            "top_speed_mps": one.top_speed,
        }
        rows.append(
            {"propeller": one.candidate.name, "blades": one.candidate.propeller.blades}
            | {key: value if math.isfinite(value) else None for key, value in numbers.items()}
            | {"feasible": one.feasible, "top_speed_limit": one.limit, "why_not": one.why_not}
            | {"constants": one.candidate.verdict}
        )
    return rows


def _digits(value: float, digits: int = 4) -> str:
    return f"{value:.{digits}g}" if math.isfinite(value) else "-"
