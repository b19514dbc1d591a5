"""``propmap trim``: an aircraft's steady states, its power curve and top speed."""

from __future__ import annotations

import math
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from propmap.cli.aircraft_options import (
    Charge,
    MaximumRpm,
    NoWakes,
    VehicleArgument,
    Wind,
    aircraft_of,
    number_or_none,
    title,
    vehicle_of,
)
from propmap.cli.bands import Bands, say_not_counted
from propmap.cli.operating_points import parse_axis
from propmap.cli.output import (
    Format,
    FormatOption,
    TextOutput,
    check_output,
    check_pictures,
    chosen_format,
    emit,
    emit_rows,
    json_text,
    show,
)
from propmap.cli.rotor_options import (
    AccuracyName,
    AccuracyOption,
    AirfoilOption,
    Corrections,
    ModelOption,
)
from propmap.cli.trim_words import (
    named,
    plain,
    say_beyond_data,
    say_fastest,
    say_moments,
    table_of,
    told,
)
from propmap.errors import InputError

if TYPE_CHECKING:
    from propmap.aircraft.performance import Performance
    from propmap.aircraft.sensitivity import Spread
    from propmap.aircraft.trim import Aircraft, SteadyStates

SPEEDS = 21
"""Where --speed is A:B."""


def trim(
    context: typer.Context,
    vehicle: VehicleArgument,
    speed: Annotated[
        str, typer.Option("--speed", metavar="A:B:N", help="Horizontal speeds [m/s], or a list.")
    ] = "0:20",
    climb: Annotated[
        str, typer.Option("--climb", metavar="A:B:N", help="Climb rates [m/s], or a list.")
    ] = "0",
    bank: Annotated[
        float, typer.Option("--bank", help="Of a coordinated level turn [deg], right positive.")
    ] = 0.0,
    wind: Wind = 0.0,
    airfoil: AirfoilOption = None,
    table: Annotated[
        Path | None,
        typer.Option("--table", metavar="FILE.npz", help="Loads from `propmap table` instead."),
    ] = None,
    model: ModelOption = None,
    correction: Corrections = None,
    accuracy: AccuracyOption = AccuracyName.standard,
    max_rpm: MaximumRpm = None,
    charge: Charge = 1.0,
    no_wakes: NoWakes = False,
    mission: Annotated[
        Path | None,
        typer.Option(
            "--mission",
            metavar="FILE.csv",
            help="Fly these legs instead: speed_mps, climb_mps, duration_s.",
        ),
    ] = None,
    bands: Bands = True,
    picture: Annotated[
        Path | None,
        typer.Option(
            "--picture", metavar="FILE", help="Power, pitch, rpm and margin; a mission over time."
        ),
    ] = None,
    format_: FormatOption = None,
    output: TextOutput = None,
) -> None:
    """Steady flight: attitude, rotor speeds, power and margins; range, endurance, top speed."""
    speeds = parse_axis("--speed", "speed", speed, SPEEDS)
    climbs = parse_axis("--climb", "climb", climb)
    if mission is not None and (bank or climbs.size > 1 or climbs[0] != 0.0):
        raise InputError(
            "--mission is given with --climb or --bank", "leave these out: legs say all"
        )
    if not math.isfinite(bank):
        raise InputError(f"--bank is {bank}", "give degrees")
    check_pictures(picture)
    netcdf = output is not None and output.suffix.lower() == ".nc"
    if netcdf and output is not None:
        check_output(output)
        if format_ is not None or mission is not None:
            raise InputError("the output is NetCDF", "leave --format and --mission out")
    form = chosen_format(format_, None if netcdf else output)

    read = vehicle_of(vehicle, no_wakes=no_wakes)
    legs = None
    if mission is not None:
        from propmap.aircraft.mission import read_mission

        legs = read_mission(mission)
    craft = aircraft_of(
        read,
        airfoil=airfoil,
        table=table,
        model=model,
        correction=correction,
        accuracy=accuracy,
        maximum_rpm=max_rpm,
        charge=charge,
    )
    if legs is not None:
        from propmap.cli.mission_table import fly_and_show

        fly_and_show(craft, legs, form, output, picture)
        return
    if bank and speeds[0] == 0.0:
        speeds = speeds[1:]
        typer.echo("note: a turn takes speed: 0 m/s is left out", err=True)
    flown = [craft.steady(speeds, each, math.radians(bank)) for each in climbs.tolist()]
    say_moments(craft, flown)
    say_beyond_data(craft, flown)
    found = None
    if not bank and climbs.size == 1 and speeds.size > 1:
        from propmap.aircraft.performance import performance

        found = performance(craft, flown[0], climb=float(climbs[0]), wind=wind, bands=bands)
        say_fastest(craft, flown[0], found)
    sure = _deviations(craft, flown, bands=bands)
    command = shlex.join(["propmap", *context.obj])
    if netcdf and output is not None:
        from propmap.cli.trim_dataset import dataset
        from propmap.io.csv import write_dataset

        write_dataset(dataset(craft, flown, sure, command), output)
        typer.echo(f"wrote {output}", err=True)
    elif form is Format.table:
        tables = (table_of(*both, found) for both in zip(flown, sure, strict=True))
        show(output, title(craft), *tables, *told(found))
    else:
        _emit(craft, flown, sure, found, form, output)
    if picture is not None:
        from propmap.report.html import save
        from propmap.report.pictures import power_curves

        hover = craft.with_hover_model()
        still = [hover.steady(speeds, each, math.radians(bank)) for each in climbs.tolist()]
        save(power_curves(title(craft), flown, still, found, sure), picture)
        typer.echo(f"wrote {picture}", err=True)


def _deviations(craft: Aircraft, flown: list[SteadyStates], *, bands: bool) -> list[Spread | None]:
    """Standard deviations of the states, None where they are not asked for or not known."""
    if not bands:
        return [None] * len(flown)
    from propmap.aircraft.sensitivity import spread
    from propmap.rotor import Rotor

    if isinstance(craft.loads, Rotor):
        say_not_counted(craft.loads.model)
    return [spread(craft, states) for states in flown]


def _emit(
    craft: Aircraft,
    flown: list[SteadyStates],
    sure: list[Spread | None],
    found: Performance | None,
    form: Format,
    output: Path | None,
) -> None:
    from propmap.aircraft.performance import rows

    listed = [row for both in zip(flown, sure, strict=True) for row in rows(*both)]
    if found is not None:
        for row, time, way in zip(listed, found.endurance, found.distance, strict=True):
            row["endurance_s"], row["distance_m"] = number_or_none(time), number_or_none(way)
    if form is Format.csv:
        emit_rows(list(listed[0]), listed, form, output)
        return
    whole: dict[str, Any] = {"vehicle": craft.vehicle.name, "states": listed}
    if found is not None:
        whole["performance"] = {name: plain(state) for name, _, state in named(found)}
        whole["performance"]["top_speed_limit"] = found.limit or None
    emit(json_text(whole), output)
