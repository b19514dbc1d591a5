"""``propmap trim``: an aircraft's steady states, its power curve and top speed."""

from __future__ import annotations

import math
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from propmap.cli.aircraft_options import (
    Charge,
    MaximumRpm,
    VehicleArgument,
    Wind,
    aircraft_of,
    digits,
    number_or_none,
    title,
)
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
    grid,
    json_text,
    show,
)
from propmap.cli.rotor_options import AccuracyName, Corrections, ModelOption
from propmap.errors import InputError

if TYPE_CHECKING:
    from rich.table import Table

    from propmap.aircraft.performance import NamedState, Performance
    from propmap.aircraft.steady import Aircraft, SteadyStates

SPEEDS = 21
"""Where --speed is A:B."""

NOTHING = 1e-4
"""Unbalanced moment over mass and radius [m/s^2] that is not worth a word."""


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
    airfoil: Annotated[
        str | None,
        typer.Option("--airfoil", metavar="NAME|FILE", help="As for `propmap predict`."),
    ] = None,
    table: Annotated[
        Path | None,
        typer.Option("--table", metavar="FILE.npz", help="Loads from `propmap table` instead."),
    ] = None,
    model: ModelOption = None,
    correction: Corrections = None,
    accuracy: Annotated[
        AccuracyName, typer.Option("--accuracy", help="Loads to 0.1 % or, slower, to 0.01 %.")
    ] = AccuracyName.standard,
    max_rpm: MaximumRpm = None,
    charge: Charge = 1.0,
    mission: Annotated[
        Path | None,
        typer.Option(
            "--mission",
            metavar="FILE.csv",
            help="Fly these legs instead: speed_mps, climb_mps, duration_s.",
        ),
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option("--picture", metavar="FILE", help="Power, pitch, rpm and thrust margin."),
    ] = None,
    format_: FormatOption = None,
    output: TextOutput = None,
) -> None:
    """Steady flight: attitude, rotor speeds, power and margins; range, endurance, top speed."""
    speeds = parse_axis("--speed", "speed", speed, SPEEDS)
    climbs = parse_axis("--climb", "climb", climb)
    if mission is not None and (picture is not None or bank or climbs.size > 1 or climbs[0] != 0.0):
        raise InputError(
            "--mission is given with --climb, --bank or --picture", "leave these out: legs say all"
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

    from propmap.vehicle.vehicle_toml import read_vehicle

    read = read_vehicle(vehicle).vehicle
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

        fly_and_show(craft, legs, form, output)
        return
    if bank and speeds[0] == 0.0:
        speeds = speeds[1:]
        typer.echo("note: a turn takes speed: 0 m/s is left out", err=True)
    flown = [craft.steady(speeds, each, math.radians(bank)) for each in climbs.tolist()]
    _say_moments(craft, flown)
    found = None
    if not bank and climbs.size == 1 and speeds.size > 1:
        from propmap.aircraft.performance import performance

        found = performance(craft, flown[0], climb=float(climbs[0]), wind=wind)
    command = shlex.join(["propmap", *context.obj])
    if netcdf and output is not None:
        from propmap.cli.trim_dataset import dataset
        from propmap.io.atomic_file import write_dataset

        write_dataset(dataset(craft, flown, command), output)
        typer.echo(f"wrote {output}", err=True)
    elif form is Format.table:
        show(output, title(craft), *(_table(states, found) for states in flown), *_told(found))
    else:
        _emit(craft, flown, found, form, output)
    if picture is not None:
        from propmap.report.power_curves import power_curves
        from propmap.report.style import save

        hover = craft.with_hover_model()
        still = [hover.steady(speeds, each, math.radians(bank)) for each in climbs.tolist()]
        save(power_curves(title(craft), flown, still, found), picture)
        typer.echo(f"wrote {picture}", err=True)


def _say_moments(craft: Aircraft, flown: list[SteadyStates]) -> None:
    """Say what rotors cannot balance: of a wing's flaps, or of a spin that is wrong."""
    left = np.concatenate([np.abs(states.moment) for states in flown])
    if not np.isfinite(left).any():
        return
    largest = np.nanmax(left, axis=0)
    if largest.max() > NOTHING * craft.vehicle.mass * craft.vehicle.propeller.radius:
        told = ", ".join(f"{name} {m:.2g}" for name, m in zip("xyz", largest, strict=True))
        typer.echo(
            f"note: the rotors cannot balance all moments; up to {told} N m about these axes are "
            "left to control surfaces (check position and spin, if there are none)",
            err=True,
        )


def _emit(
    craft: Aircraft,
    flown: list[SteadyStates],
    found: Performance | None,
    form: Format,
    output: Path | None,
) -> None:
    from propmap.aircraft.columns import rows

    listed = [row for states in flown for row in rows(states)]
    if found is not None:
        for row, time, way in zip(listed, found.endurance, found.distance, strict=True):
            row["endurance_s"], row["distance_m"] = number_or_none(time), number_or_none(way)
    if form is Format.csv:
        emit_rows(list(listed[0]), listed, form, output)
        return
    told: dict[str, Any] = {"vehicle": craft.vehicle.name, "states": listed}
    if found is not None:
        told["performance"] = {name: _plain(state) for name, _, state in _named(found)}
        told["performance"]["top_speed_limit"] = found.limit or None
    emit(json_text(told), output)


def _plain(state: NamedState | None) -> dict[str, float | None] | None:
    return None if state is None else {k: number_or_none(v) for k, v in vars(state).items()}


def _table(states: SteadyStates, found: Performance | None) -> Table:
    rpm = states.rotor_speed * 30.0 / math.pi
    heads = ["V [m/s]", "pitch [deg]", "roll [deg]", "rpm", "T [N]", "P shaft [W]"]
    columns: list[list[str]] = [
        [f"{v:.4g}" for v in states.speed],
        [digits(v) for v in np.degrees(states.pitch)],
        [digits(v) for v in np.degrees(states.roll)],
        [_span(each) for each in rpm],
        [digits(v) for v in states.thrust.sum(axis=1)],
        [digits(v) for v in states.shaft_power],
    ]
    if np.isfinite(states.electrical_power).any():
        heads += ["P electric [W]", "I motor [A]"]
        columns += [
            [digits(v) for v in states.electrical_power],
            [digits(v) for v in states.motor_current.max(axis=1)],
        ]
    if np.isfinite(states.throttle).any():
        heads.append("throttle [%]")
        columns.append([digits(v) for v in 100.0 * states.throttle.max(axis=1)])
    if found is not None and np.isfinite(found.endurance).any():
        heads += ["time [min]", "way [km]"]
        columns += [
            [digits(v) for v in found.endurance / 60.0],
            [digits(v) for v in found.distance / 1000.0],
        ]
    heads += ["thrust margin", "<status"]
    columns += [[digits(v) for v in states.thrust_margin], states.status.tolist()]
    climb, bank = float(states.climb[0]), math.degrees(float(states.bank[0]))
    title = f"climb {climb:g} m/s" if climb else (f"bank {bank:g} deg" if bank else "level flight")
    caption = "rpm: slowest to fastest rotor; thrust margin: T at the first limit over T needed"
    from propmap.aircraft.steady import STATUSES

    met = [status for status in STATUSES if status != "ok" and status in states.status]
    caption += "".join(f"\n{status}: {STATUSES[status]}" for status in met)
    return grid("|".join(heads), zip(*columns, strict=True), title, caption)


def _span(rpm: Any) -> str:
    if not np.isfinite(rpm).all():
        return "-"
    low, high = f"{rpm.min():.0f}", f"{rpm.max():.0f}"
    return low if low == high else f"{low}-{high}"


def _named(found: Performance) -> list[tuple[str, str, NamedState | None]]:
    return [
        ("hover", "hover", found.hover),
        ("least_power", "least power, longest time", found.least_power),
        ("best_range", "best range", found.best_range),
        ("fastest", "top speed", found.fastest),
    ]


def _told(found: Performance | None) -> list[str]:
    """Lines on the states that have a name."""
    if found is None:
        return []
    from propmap.aircraft.limits import LIMITS
    from propmap.aircraft.performance import FASTEST
    from propmap.aircraft.steady import STATUSES

    lines = []
    climbs = bool(found.states.climb[0])
    for name, label, state in _named(found):
        words = "straight up or down" if climbs and name == "hover" else label
        if state is None:
            if name == "fastest" and not found.limit:
                lines.append(f"{words}: above {FASTEST:g} m/s, no limit was met")
            else:
                lines.append(f"{words}: none; {STATUSES.get(found.limit, 'not found')}")
            margin = float(found.states.thrust_margin[0])
            if name == "hover" and found.states.speed[0] == 0.0 and margin < 1.0:
                lines[-1] += f"; thrust there is {margin:.2f} of what is needed"
            continue
        electric = math.isfinite(state.electrical_power)
        parts = [
            f"{state.speed:.3g} m/s",
            f"{state.power:.4g} W {'' if electric else 'shaft '}power",
        ]
        if name == "hover":
            parts = parts[1:]
        if name == "best_range":
            parts.append(f"{state.power / state.ground_speed:.3g} J/m")
        if name == "fastest":
            parts.append(f"limited by {LIMITS.get(found.limit) or STATUSES[found.limit]}")
        elif math.isfinite(state.endurance):
            parts.append(f"{state.endurance / 60.0:.3g} min")
            if name == "best_range":
                parts.append(f"{state.distance / 1000.0:.3g} km")
        lines.append(f"{words}: {', '.join(parts)}")
    return lines
