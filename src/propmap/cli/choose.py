"""``propmap choose``: which propeller suits an aircraft."""

from __future__ import annotations

import math
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
from propmap.cli.choose_words import rows_of, table_of, told_of
from propmap.cli.cluster_option import Cluster, workers_of
from propmap.cli.output import (
    Format,
    FormatOption,
    TextOutput,
    check_pictures,
    chosen_format,
    emit_rows,
    show,
)
from propmap.cli.rotor_options import Corrections, ModelName, ModelOption
from propmap.errors import InputError, quoted
from propmap.tasks import InProcesses, Workers

if TYPE_CHECKING:
    from propmap.aircraft.mission import Mission
    from propmap.aircraft.ranking import Candidate, Judged, Ranking

INCH = 0.0254


class Measure(StrEnum):
    """What a task may be ranked by."""

    energy = "energy"
    time = "time"
    range = "range"


def choose(
    vehicle: VehicleArgument,
    speed: Annotated[
        float | None, typer.Option("--speed", help="Cruise speed [m/s], needed to cruise.")
    ] = None,
    task: Annotated[
        str,
        typer.Option(
            "--task",
            metavar="hover|cruise|fast|FILE.csv",
            help="Ranked by hover power, energy per metre, top speed, a mission's energy.",
        ),
    ] = "cruise",
    by: Annotated[
        Measure | None,
        typer.Option("--by", help="Hover or cruise ranked by this instead of energy."),
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
    cluster: Cluster = None,
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

    from propmap.aircraft.ranking import Ranking, Task, catalogue_candidates, file_candidate
    from propmap.catalogue.lookup import airfoil as section_law
    from propmap.model.corrections import corrections_of
    from propmap.tasks import cores

    legs = _legs(task)
    name = "mission" if legs else task
    wanted = Task(name, speed, legs, thrust_margin, by.value if by else "")
    if by in (Measure.time, Measure.range) and read.powertrain.battery is None:
        raise InputError(f"--by {by.value}: the vehicle file has no [battery]", "add it")
    law = section_law(airfoil) if airfoil else None
    own = [file_candidate(name, law) for name in propeller or ()]
    there = {one.name for one in own if law is None}
    others = catalogue_candidates(sizes, blades)
    candidates = [*own, *(one for one in others if one.name not in there)]
    corrections = tuple(corrections_of(model or ModelName.recommended, correction or ()))
    say_missing(read)
    ranking = Ranking(read, wanted, corrections, maximum_rotor_speed=largest, charge=charge)
    with InProcesses(cores()) as here, workers_of(cluster, here) as workers:
        judged = _judged(ranking, candidates, top, workers)
    title = (
        f"{read.name}, {read.mass:g} kg, {len(read.mounts)} rotors; "
        f"rho = {read.air.density:.4g} kg/m^3"
    )
    if form is Format.table:
        fit = [one for one in judged if one.feasible]
        shown = fit if all_ else fit[:top]
        ranked = [table_of(wanted, shown)] if shown else []
        show(output, title, *ranked, *told_of(judged, top, all_=all_))
    else:
        rows = rows_of(wanted, judged)
        emit_rows(list(rows[0]), rows, form, output)
    if picture is not None:
        from propmap.aircraft.ranking import pareto
        from propmap.report.html import save
        from propmap.report.pictures import propeller_choice

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


def _legs(task: str) -> Mission | None:
    """The mission that ``--task`` names, None for another task."""
    from propmap.aircraft.mission import read_mission
    from propmap.aircraft.ranking import MEASURES

    if task != "mission" and task in MEASURES:
        return None
    if not task.lower().endswith(".csv"):
        known = ", ".join(name for name in MEASURES if name != "mission")
        raise InputError(
            f"--task {quoted(task)} is not known", f"choose from {known}, or name a mission's .csv"
        )
    return read_mission(task)


def _judged(
    ranking: Ranking, candidates: list[Candidate], top: int, workers: Workers
) -> list[Judged]:
    """The ranking, with deviations of the first ``top``."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, disable=not console.is_terminal, transient=True) as progress:
        step = progress.add_task("propellers", total=len(candidates))
        found = ranking.judged(candidates, lambda: progress.advance(step), workers)
        first = [one for one in found if one.feasible][:top]
        step = progress.add_task("uncertainty", total=len(first))
        closer = ranking.with_deviations(first, lambda: progress.advance(step), workers)
    return [*closer, *found[len(closer) :]]
