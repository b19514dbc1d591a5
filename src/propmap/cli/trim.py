"""``propmap trim``: steady states, power curve, top speed and missions, as tables and files."""

from __future__ import annotations

import math
import shlex
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

import propmap
from propmap.aircraft.performance import columns
from propmap.aircraft.trim import STATUSES, Aircraft
from propmap.catalogue.identified import Identified, identified
from propmap.cli.aircraft_options import (
    Charge,
    MaximumRpm,
    NoWakes,
    VehicleArgument,
    Wind,
    aircraft_of,
    digits,
    number_or_none,
    title,
    vehicle_of,
)
from propmap.cli.options import (
    AccuracyName,
    AccuracyOption,
    AirfoilOption,
    Bands,
    Corrections,
    ModelOption,
    parse_axis,
    say_doubts,
    say_not_counted,
)
from propmap.cli.output import (
    Format,
    FormatOption,
    TextOutput,
    WideGrid,
    check_output,
    check_pictures,
    chosen_format,
    emit,
    emit_rows,
    grid,
    json_text,
    show,
)
from propmap.errors import InputError
from propmap.model.plausibility import point_warnings
from propmap.rotor import Rotor
from propmap.units import RPM

if TYPE_CHECKING:
    import xarray

    from propmap.aircraft.mission import Flown, Mission
    from propmap.aircraft.performance import NamedState, Performance
    from propmap.aircraft.sensitivity import StateChange
    from propmap.aircraft.trim import Aircraft, SteadyStates


# -------------------------------------------------------------------------------------------------
# ``propmap trim``: an aircraft's steady states, its power curve and top speed.

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


def _deviations(
    craft: Aircraft, flown: list[SteadyStates], *, bands: bool
) -> list[StateChange | None]:
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
    sure: list[StateChange | None],
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


# -------------------------------------------------------------------------------------------------
# Steady states as `propmap trim` shows them: tables, lines, and notes on what is odd.

SPARE = ("throttle [%]", "I motor [A]", "T [N]", "P shaft [W]", "way [km]", "roll [deg]", "rpm")
"""Columns that a narrow window goes without, the first first."""

LEVEL = 1e-4
"""Roll [rad] that is not worth a column."""

NOTHING = 1e-4
"""Unbalanced moment over mass and radius [m/s^2] that is not worth a word."""


def say_moments(craft: Aircraft, flown: list[SteadyStates]) -> None:
    """Say what moments the rotors of ``craft`` cannot balance in the states that are ``flown``.

    They are for a wing's flaps, or of a spin that is wrong.
    """
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


def say_beyond_data(craft: Aircraft, flown: list[SteadyStates], where: str = "") -> None:
    """Say what of the states ``flown`` is beyond the data of the constants or unlike propellers.

    ``craft`` is what flies, ``where`` says which states these are, if not all.
    """
    from propmap.rotor import Rotor

    if not isinstance(craft.loads, Rotor):
        return
    blade = craft.vehicle.propeller
    omega, hubs = (
        np.concatenate(each)
        for each in zip(*(craft.rotor_motion(states) for states in flown), strict=True)
    )
    if not omega.size:
        return
    speed = np.linalg.norm(hubs, axis=-1)
    along = np.einsum("nkj,kj->nk", hubs, craft.rotors.axis)
    beta = np.arccos(np.clip(np.divide(along, speed, out=along * 0.0, where=speed > 0.0), -1, 1))
    doubts = point_warnings(blade, omega, speed, beta)
    own = identified(blade.name, blade.blades)
    if own is not None and craft.loads.model.airfoil.name == own.airfoil.name:
        doubts = [*doubts, *_beyond(own, omega, speed, blade.diameter)]
    say_doubts([f"{where}{doubt}" for doubt in doubts])


def _beyond(own: Identified, omega: Any, speed: Any, diameter: float) -> list[str]:

    rpm, advance = (
        float(omega.max()) / RPM,
        float((2.0 * np.pi * speed / (omega * diameter)).max()),
    )
    parts = []
    if rpm > own.rpm_high:
        parts.append(f"{rpm:.0f} rpm where the data end at {own.rpm_high:.0f}")
    if advance > own.advance_high:
        parts.append(f"J = V/(n D) up to {advance:.2f} where they end at {own.advance_high:.2f}")
    return [f"beyond the data of the constants: {'; '.join(parts)}"] if parts else []


def say_fastest(craft: Aircraft, states: SteadyStates, found: Performance) -> None:
    """As ``say_beyond_data`` of a top speed that was ``found`` beyond the ``states`` asked for."""
    if found.fastest is not None and found.fastest.speed > states.speed[-1]:
        climb = states.climb[0]
        there = craft.steady(found.fastest.speed, climb, margin=False, near=states)
        say_beyond_data(craft, [there], "at the top speed, ")


def plain(state: NamedState | None) -> dict[str, float | None] | None:
    """A ``state`` with a name as plain data, None where there is none."""
    return None if state is None else {k: number_or_none(v) for k, v in vars(state).items()}


def table_of(states: SteadyStates, sure: StateChange | None, found: Performance | None) -> WideGrid:
    """States in a table.

    Parameters
    ----------
    states : SteadyStates
        At one climb rate and bank.
    sure : StateChange, optional
        Their standard deviations.
    found : Performance, optional
        With their times and distances.
    """
    rpm = states.rotor_speed / RPM
    heads, columns = ["V [m/s]", "pitch [deg]"], [[f"{v:.4g}" for v in states.speed]]
    columns.append([digits(v) for v in np.degrees(states.pitch)])
    if np.nanmax(np.abs(np.nan_to_num(states.roll))) > LEVEL:
        heads.append("roll [deg]")
        columns.append([digits(v) for v in np.degrees(states.roll)])
    heads += ["rpm", "T [N]", "P shaft [W]"]
    columns += [
        [_span(each) for each in rpm],
        [digits(v) for v in states.thrust.sum(axis=1)],
        [digits(v) for v in states.shaft_power],
    ]
    electric = bool(np.isfinite(states.electrical_power).any())
    deviations = [] if sure is None else [[_rough(v) for v in sure.power]]
    if deviations and not electric:
        heads.append("+- [W]")
        columns += deviations
    if electric:
        heads += ["P electric [W]", *(["+- [W]"] if deviations else []), "I motor [A]"]
        columns += [
            [digits(v) for v in states.electrical_power],
            *deviations,
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
    if deviations:
        caption += "\n+-: one standard deviation of the power, from those of the rotors' loads"
    from propmap.aircraft.trim import STATUSES

    met = [status for status in STATUSES if status != "ok" and status in states.status]
    caption += "".join(f"\n{status}: {STATUSES[status]}" for status in met)
    return WideGrid("|".join(heads), list(zip(*columns, strict=True)), title, caption, SPARE)


def _rough(std: float) -> str:
    # Two digits, without an exponent.
    return f"{float(f'{std:.2g}'):g}" if math.isfinite(std) else "-"


def _give_or_take(std: float) -> str:
    return f" +- {_rough(std)}" if math.isfinite(std) else ""


def _span(rpm: Any) -> str:
    if not np.isfinite(rpm).all():
        return "-"
    low, high = f"{rpm.min():.0f}", f"{rpm.max():.0f}"
    return low if low == high else f"{low}-{high}"


def named(found: Performance) -> list[tuple[str, str, NamedState | None]]:
    """Key, words and state of each that was ``found``."""
    return [
        ("hover", "hover", found.hover),
        ("least_power", "least power, longest time", found.least_power),
        ("best_range", "best range", found.best_range),
        ("fastest", "top speed", found.fastest),
    ]


def told(found: Performance | None) -> list[str]:
    """Lines on the states that have a name."""
    if found is None:
        return []
    from propmap.aircraft.performance import FASTEST
    from propmap.aircraft.trim import LIMITS, STATUSES

    lines = []
    climbs = bool(found.states.climb[0])
    for name, label, state in named(found):
        words = "straight up or down" if climbs and name == "hover" else label
        if state is None:
            if name == "fastest" and not found.limit:
                lines.append(f"{words}: above {FASTEST:g} m/s, no limit was met")
            else:
                why = found.at_rest if name == "hover" else found.limit
                lines.append(f"{words}: none; {STATUSES.get(why, 'not found')}")
            margin = float(found.states.thrust_margin[0])
            if name == "hover" and found.states.speed[0] == 0.0 and margin < 1.0:
                lines[-1] += f"; it cannot lift off, thrust is {margin:.2f} of the weight"
            continue
        kind = "" if math.isfinite(state.electrical_power) else "shaft "
        parts = [
            f"{state.speed:.3g}{_give_or_take(state.speed_std)} m/s",
            f"{state.power:.4g}{_give_or_take(state.power_std)} W {kind}power",
        ]
        if name == "hover":
            parts = parts[1:]
        if name == "best_range":
            parts.append(f"{state.power / state.ground_speed:.3g} J/m")
        if name == "fastest":
            parts.append(f"limited by {LIMITS.get(found.limit) or STATUSES[found.limit]}")
        elif math.isfinite(state.endurance):
            time, std = state.endurance / 60.0, state.endurance_std / 60.0
            parts.append(f"{time:.3g}{_give_or_take(std)} min")
            if name == "best_range":
                way, std = state.distance / 1000.0, abs(state.ground_speed) * std * 0.06
                parts.append(f"{way:.3g}{_give_or_take(std)} km")
        lines.append(f"{words}: {', '.join(parts)}")
    return lines


# -------------------------------------------------------------------------------------------------
# Steady states as an xarray dataset over climb rate and speed.

AXES = ("climb_mps", "speed_mps")


def dataset(
    craft: Aircraft, flown: list[SteadyStates], sure: list[StateChange | None], command: str
) -> xarray.Dataset:
    """States at the same n speeds for each of several climb rates, with provenance.

    ``sure`` are their standard deviations.
    """
    import xarray

    parts = [columns(*both) for both in zip(flown, sure, strict=True)]
    speed, climb = parts[0]["speed_mps"], parts[0]["climb_mps"]
    rates = np.array([states.climb[0] for states in flown])
    coordinates = {
        "climb_mps": ("climb_mps", rates, {"units": climb.unit, "long_name": climb.meaning}),
        "speed_mps": ("speed_mps", speed.values, {"units": speed.unit, "long_name": speed.meaning}),
        "rotor": ("rotor", np.arange(1, len(craft.vehicle.mounts) + 1)),
    }
    variables = {}
    for name, column in parts[0].items():
        if name in AXES or any(name not in part for part in parts):
            continue
        dims = (*AXES, "rotor") if column.values.ndim == 2 else AXES
        values = np.stack([part[name].values for part in parts])
        variables[name] = (dims, values, {"units": column.unit, "long_name": column.meaning})
    found = xarray.Dataset(variables, coordinates, _provenance(craft, command))
    names = list(STATUSES)
    codes = [[names.index(status) for status in states.status.tolist()] for states in flown]
    flags = {
        "long_name": "whether the state was found within the limits",
        "flag_values": np.arange(len(names), dtype=np.uint8),
        "flag_meanings": " ".join(names),
    }
    found["status"] = (AXES, np.array(codes, np.uint8), flags)
    return found


def _provenance(craft: Aircraft, command: str) -> dict[str, str | float]:
    vehicle, loads = craft.vehicle, craft.loads
    told: dict[str, str | float] = {
        "title": f"Steady flight of {vehicle.name}",
        "propmap_version": propmap.__version__,
        "mass_kg": vehicle.mass,
        "propeller": vehicle.propeller.name,
        "geometry_sha256": vehicle.propeller.fingerprint(),
        "air_density_kg_m3": vehicle.air.density,
        "command": command,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    if isinstance(loads, Rotor):
        told |= {"section_law": loads.model.law_title, "model_sha256": loads.model.fingerprint()}
    return told


# -------------------------------------------------------------------------------------------------
# A mission as `propmap trim` shows it: energy and state of charge, leg by leg and over time.


def fly_and_show(
    craft: Aircraft, legs: Mission, form: Format, output: Path | None, picture: Path | None
) -> None:
    """Fly the ``legs`` with the aircraft ``craft``.

    Rows in this ``form`` go to ``output``, and where it is wanted a ``picture`` of all over time.
    """
    from propmap.aircraft.mission import fly

    flown = fly(craft, legs)
    columns = {
        "time_s": flown.course.time[:, -1],
        "speed_mps": legs.speed,
        "climb_mps": legs.climb,
        "duration_s": legs.duration,
        "pitch_deg": np.degrees(flown.states.pitch),
        "power_W": flown.states.power,
        "energy_J": flown.energy,
        "charge": flown.charge,
        "voltage_V": flown.course.voltage[:, -1],
    }
    if form is Format.table:
        _show_table(craft, legs, flown, columns, output)
    else:
        names = [*columns, "status"]
        values = zip(*(v.tolist() for v in columns.values()), flown.status.tolist(), strict=True)
        listed = [
            dict(zip(names, [*(number_or_none(v) for v in row[:-1]), row[-1]], strict=True))
            for row in values
        ]
        if form is Format.csv:
            emit_rows(names, listed, form, output)
        else:
            whole = {"vehicle": craft.vehicle.name, "legs": listed, "over_time": _over_time(flown)}
            emit(json_text(whole), output)
    if picture is not None:
        from propmap.report.html import save
        from propmap.report.pictures import mission_course

        save(mission_course(title(craft), legs, flown), picture)
        typer.echo(f"wrote {picture}", err=True)


def _over_time(flown: Flown) -> dict[str, list[float | None]]:
    named = {"time_s": "time", "charge": "charge", "voltage_V": "voltage"}
    return {
        key: [number_or_none(v) for v in getattr(flown.course, name).ravel().tolist()]
        for key, name in named.items()
    }


def _show_table(
    craft: Aircraft, legs: Mission, flown: Flown, columns: dict[str, Any], output: Path | None
) -> None:
    cells = [[digits(v) for v in values] for values in columns.values()]
    heads = "until [s]|V [m/s]|climb [m/s]|time [s]|pitch [deg]|P [W]|energy [J]|charge|U [V]"
    body = grid(
        f"{heads}|<status",
        zip(*cells, flown.status.tolist(), strict=True),
        f"mission {legs.source}",
        "charge, U: state of charge (1 when full) and the battery's voltage at the end of the leg",
    )
    lost = ~flown.lasted
    told = f"{np.sum(flown.energy) / 3600.0:.4g} Wh in {legs.duration.sum() / 60.0:.4g} min"
    if lost.any():
        leg = int(np.argmax(lost))
        told = f"leg {leg + 1} cannot be flown to its end: {flown.status_in_words(leg)}"
    show(output, title(craft), body, told)
