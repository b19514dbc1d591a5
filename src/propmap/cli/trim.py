"""``propmap trim``: steady flight, power curve, top speed and missions of an aircraft."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer
from typer import Option, echo

import propmap
from propmap.aircraft import performance
from propmap.aircraft.assumptions import assumption_lines, assumptions, without_body_drag
from propmap.aircraft.mission import Mission, fly, read_mission
from propmap.aircraft.sensitivity import StateChange, spread
from propmap.aircraft.trim import LIMITS, STATUSES, Aircraft, SteadyStates
from propmap.catalogue.identified import identified_with_name
from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.errors import InputError
from propmap.io.csv import number_or_none, numbers_of, write_dataset
from propmap.model.plausibility import point_warnings
from propmap.rotor import Rotor
from propmap.units import RPM

if TYPE_CHECKING:
    import xarray


SPEEDS = 21  # number of values of --speed A:B


def trim(
    context: typer.Context,
    vehicle: opt.VehicleArgument,
    speed: Annotated[
        str, Option(metavar="A:B:N", help=f"Horizontal airspeeds in m/s, {opt.AXIS_HELP}.")
    ] = "0:20",
    climb: Annotated[
        str, Option(metavar="A:B:N", help=f"Climb rates in m/s, {opt.AXIS_HELP}.")
    ] = "0",
    bank: Annotated[
        float, Option(help="Bank angle of a coordinated level turn in degrees, right positive.")
    ] = 0.0,
    wind: Annotated[float, Option(help="Headwind in m/s; affects only range and distances.")] = 0.0,
    airfoil: opt.AirfoilOption = None,
    table: Annotated[
        Path | None,
        Option(metavar="FILE.npz", help="Load table; replaces the rotor model."),
    ] = None,
    model: opt.ModelOption = None,
    correction: opt.Corrections = None,
    accuracy: opt.AccuracyOption = "standard",
    max_rpm: opt.MaximumRpm = None,
    charge: opt.Charge = 1.0,
    no_wakes: opt.NoWakes = False,
    mission: Annotated[
        Path | None,
        Option(
            metavar="FILE.csv", help="Mission to fly: columns speed_mps, climb_mps, duration_s."
        ),
    ] = None,
    bands: opt.Bands = True,
    picture: Annotated[
        Path | None,
        Option(metavar="FILE", help="Picture of power curve or mission: .png, .svg or .pdf."),
    ] = None,
    format_: out.FormatOption = None,
    output: out.TextOutput = None,
) -> None:
    """Find the power, range, endurance and top speed of an aircraft.

    With -o FILE.nc, the command writes NetCDF.
    """
    speeds = opt.parse_axis("--speed", "speed", speed, SPEEDS)
    climbs = opt.parse_axis("--climb", "climb", climb)
    if mission is not None and (bank or climbs.size > 1 or climbs[0] != 0.0):
        fault = "--mission is given with --climb or --bank"
        raise InputError(fault, "leave these out: the legs define the flight")
    if not math.isfinite(bank):
        raise InputError(f"--bank is {bank}", "give an angle in degrees")
    out.check_pictures(picture)
    netcdf = output if output is not None and output.suffix.lower() == ".nc" else None
    if netcdf is not None:
        out.check_output(netcdf, (".nc",))
        if format_ is not None or mission is not None:
            fault = "--format or --mission is given with a NetCDF file"
            raise InputError(fault, "leave it out, or write another file")
    form = out.chosen_format(format_, None if netcdf else output)

    read = opt.vehicle_of(vehicle, no_wakes=no_wakes)
    legs = read_mission(mission) if mission is not None else None
    craft = opt.aircraft_of(read, airfoil, table, model, correction, accuracy, max_rpm, charge)
    rests_on, allocation = assumptions(craft.vehicle, craft.loads), craft.balance.allocation
    out.note(*craft.notes)
    if form == "csv":
        out.note(*assumption_lines(rests_on))
    if legs is not None:
        _fly(craft, legs, rests_on, form, output, picture)
        return
    if bank and speeds[0] == 0.0:
        speeds = speeds[1:]
        if not speeds.size:
            raise InputError("--bank is given with --speed 0", "give speeds above 0 for a turn")
        out.note("a turn needs airspeed: 0 m/s is omitted")

    def steady(craft: Aircraft) -> list[SteadyStates]:
        return [craft.steady(speeds, each, math.radians(bank)) for each in climbs.tolist()]

    flown = steady(craft)
    _note_moments(craft, flown)
    _note_beyond_data(craft, flown)
    found = None
    if not bank and climbs.size == 1 and speeds.size > 1:
        found = performance.performance(
            craft, flown[0], climb=float(climbs[0]), wind=wind, bands=bands
        )
        if found.fastest is not None and found.fastest.speed > speeds[-1]:
            top = craft.steady(found.fastest.speed, climbs[0], margin=False, near=flown[0])
            _note_beyond_data(craft, [top], "at the top speed, ")
    sure: list[StateChange | None] = [None] * len(flown)
    if bands:
        if isinstance(craft.loads, Rotor):
            opt.note_not_counted(craft.loads.model)
        sure = [spread(craft, states) for states in flown]
    if netcdf is not None:
        data = _dataset(craft, flown, sure, opt.command_line(context))
        write_dataset(data.assign_attrs({f"assumed_{k}": v for k, v in rests_on.items()}), netcdf)
        echo(f"wrote {netcdf}", err=True)
    elif form == "table":
        tables = (_table(*both, found) for both in zip(flown, sure, strict=True))
        lines = assumption_lines(rests_on)
        out.show(output, _title(craft), *lines, *tables, *_named_lines(craft, found))
    else:
        listed = [row for both in zip(flown, sure, strict=True) for row in performance.rows(*both)]
        if found is not None:
            for row, time, way in zip(listed, found.endurance, found.distance, strict=True):
                row["endurance_s"] = number_or_none(time)
                row["distance_m"] = number_or_none(way)
        whole: dict[str, Any] = {"vehicle": craft.vehicle.name, "assumptions": rests_on}
        whole["control"] = {
            "rank": len(allocation.commanded),
            "condition": number_or_none(allocation.condition),
            "yaw_over_roll": number_or_none(allocation.yaw_over_roll),
            "notes": allocation.notes,
        }
        whole["states"] = listed
        if found is not None:
            whole["performance"] = {name: plain(state) for name, _, state in found.named}
            whole["performance"]["top_speed_limit"] = found.limit or None
        out.emit_rows(list(listed[0]), listed, form, output, whole=whole)
    if picture is not None:
        from propmap.report.pictures import power_curves

        still = steady(craft.with_hover_model())
        out.save_picture(power_curves(_title(craft), flown, still, found, sure), picture)


# --- Output of steady states: tables, lines, and notes on implausible values ---------------------

# Columns that a narrow terminal hides, in this order.
SPARE = ("throttle [%]", "I motor [A]", "T [N]", "P shaft [W]", "range [km]", "roll [deg]", "rpm")
LEVEL = 1e-4  # roll below which the table has no column for it [rad]
NOTHING = 1e-4  # unbalanced moment over mass and radius below which there is no note [m/s^2]


def _note_moments(craft: Aircraft, flown: list[SteadyStates]) -> None:
    """Note moments that the rotors do not balance."""
    left = np.concatenate([np.abs(states.moment) for states in flown])
    largest = np.nan_to_num(left).max(axis=0)
    least = NOTHING * craft.vehicle.mass * craft.vehicle.propeller.radius
    parts = [
        f"{m:.2g} N m about {axis}" for m, axis in zip(largest, "xyz", strict=True) if m > least
    ]
    if parts:
        out.note(f"in these states, control surfaces must supply up to {', '.join(parts)}")


def _note_beyond_data(craft: Aircraft, flown: list[SteadyStates], where: str = "") -> None:
    """Note states that are implausible or beyond the data of the section constants; each note
    begins with ``where``."""
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
    warnings = point_warnings(blade, omega, speed, beta)
    own = identified_with_name(craft.loads.model.airfoil.name, blade.blades)
    if own is not None:
        rpm = float(omega.max()) / RPM
        advance = float((2.0 * np.pi * speed / (omega * blade.diameter)).max())
        parts = []
        if rpm > own.rpm_high:
            parts.append(f"{rpm:.0f} rpm (data up to {own.rpm_high:.0f})")
        if advance > own.advance_high:
            parts.append(f"J = V/(n D) of {advance:.2f} (data up to {own.advance_high:.2f})")
        if parts:
            beyond = f"the section constants are extrapolated to {' and '.join(parts)}"
            warnings = [*warnings, beyond]
    out.note(*(f"{where}{warning}" for warning in warnings))


def plain(state: performance.NamedState | None) -> dict[str, float | None] | None:
    """Return the fields of a state for JSON, or None without a state."""
    return None if state is None else {k: number_or_none(v) for k, v in vars(state).items()}


def _title(craft: Aircraft) -> str:
    vehicle = craft.vehicle
    return (
        f"{vehicle.name}, {vehicle.mass:g} kg, {len(vehicle.mounts)} x {vehicle.propeller.name}"
        f"; rho = {vehicle.air.density:.4g} kg/m^3{without_body_drag(vehicle)}"
    )


def _digits(value: float) -> str:
    """Return the text of a table cell, a dash for NaN."""
    if not math.isfinite(value):
        return "-"
    return "0" if abs(value) < 5e-4 else f"{value:.4g}"


def _table(
    states: SteadyStates, sure: StateChange | None, found: performance.Performance | None
) -> out.WideGrid:
    """Return a table of states at one climb rate and bank."""

    def cells(values: Any) -> list[str]:
        return [_digits(value) for value in values]

    columns = {"V [m/s]": [f"{v:.4g}" for v in states.speed]}
    columns["pitch [deg]"] = cells(np.degrees(states.pitch))
    if np.nanmax(np.abs(np.nan_to_num(states.roll))) > LEVEL:
        columns["roll [deg]"] = cells(np.degrees(states.roll))
    columns |= {
        "rpm": [_span(each) for each in states.rotor_speed / RPM],
        "T [N]": cells(states.thrust.sum(axis=1)),
        "P shaft [W]": cells(states.shaft_power),
    }
    deviations = {} if sure is None else {"+- [W]": [_rough(v) for v in sure.power]}
    if np.isfinite(states.electrical_power).any():
        columns |= {"P electric [W]": cells(states.electrical_power), **deviations}
        columns["I motor [A]"] = cells(states.motor_current.max(axis=1))
    else:
        columns |= deviations
    if np.isfinite(states.throttle).any():
        columns["throttle [%]"] = cells(100.0 * states.throttle.max(axis=1))
    if found is not None and np.isfinite(found.endurance).any():
        columns["time [min]"] = cells(found.endurance / 60.0)
        columns["range [km]"] = cells(found.distance / 1000.0)
    columns |= {"thrust margin": cells(states.thrust_margin), "<status": states.status.tolist()}
    climb, bank = float(states.climb[0]), math.degrees(float(states.bank[0]))
    title = f"climb {climb:g} m/s" if climb else (f"bank {bank:g} deg" if bank else "level flight")
    caption = "rpm: slowest to fastest rotor; thrust margin: maximum T / required T"
    if deviations:
        caption += "\n+-: one standard deviation of the power, from the errors of the rotor loads"
    met = [status for status in STATUSES if status != "ok" and status in states.status]
    caption += "".join(f"\n{status}: {STATUSES[status]}" for status in met)
    rows = list(zip(*columns.values(), strict=True))
    return out.WideGrid("|".join(columns), rows, title, caption, SPARE)


def _rough(std: float) -> str:
    """Return a number with two digits and without an exponent."""
    return f"{float(f'{std:.2g}'):g}" if math.isfinite(std) else "-"


def _give_or_take(std: float) -> str:
    return f" +- {_rough(std)}" if math.isfinite(std) else ""


def _span(rpm: Any) -> str:
    if not np.isfinite(rpm).all():
        return "-"
    low, high = f"{rpm.min():.0f}", f"{rpm.max():.0f}"
    return low if low == high else f"{low}{'-' if rpm.min() > 0.0 else ' to '}{high}"


def _named_lines(craft: Aircraft, found: performance.Performance | None) -> list[str]:
    if found is None:
        return []
    lines = []
    climbs = bool(found.states.climb[0])
    for name, label, state in found.named:
        words = "straight up or down" if climbs and name == "hover" else label
        if state is None:
            if name == "fastest" and found.limit in ("", performance.UNKNOWN):
                above = f"above {performance.FASTEST:g} m/s, no limit was met"
                lines.append(f"{words}: {found.limit or above}")
            elif name in ("least_power", "best_range") and (
                found.states.found.any() and found.states.speed[-1] > found.wind
            ):
                lines.append(f"{words}: unknown, above the highest computed speed")
            else:
                why = found.at_rest if name == "hover" else found.limit
                lines.append(f"{words}: none; {STATUSES.get(why, 'not found')}")
            margin = float(found.states.thrust_margin[0])
            if name == "hover" and found.states.speed[0] == 0.0 and margin < 1.0:
                lines[-1] += f"; too heavy to lift off, thrust is {margin:.2f} of the weight"
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
            limit = LIMITS.get(found.limit)
            parts.append(f"limited by {limit}" if limit else f"limit: {STATUSES[found.limit]}")
        elif math.isfinite(state.endurance):
            time, std = state.endurance / 60.0, state.endurance_std / 60.0
            parts.append(f"{time:.3g}{_give_or_take(std)} min")
            if name == "best_range":
                way, std = state.distance / 1000.0, abs(state.ground_speed) * std * 0.06
                parts.append(f"{way:.3g}{_give_or_take(std)} km")
        caution = without_body_drag(craft.vehicle) if name != "hover" else ""
        lines.append(f"{words}: {', '.join(parts)}{caution}")
    return lines


AXES = ("climb_mps", "speed_mps")


def _dataset(
    craft: Aircraft, flown: list[SteadyStates], sure: list[StateChange | None], command: str
) -> xarray.Dataset:
    """Return a dataset of states at the same airspeeds for each climb rate, with provenance."""
    import xarray

    parts = [performance.columns(*both) for both in zip(flown, sure, strict=True)]
    speed, climb = parts[0]["speed_mps"], parts[0]["climb_mps"]
    rates = np.array([states.climb[0] for states in flown])
    coordinates: dict[str, Any] = {
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
    vehicle, blade = craft.vehicle, craft.vehicle.propeller
    provenance: dict[str, str | float] = {
        "title": f"Steady flight of {vehicle.name}",
        "propmap_version": propmap.__version__,
        "mass_kg": vehicle.mass,
        "propeller": blade.name,
        "geometry_sha256": blade.fingerprint(),
        "air_density_kg_m3": vehicle.air.density,
        "command": command,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    if isinstance(craft.loads, Rotor):
        model = craft.loads.model
        provenance |= {"section_law": model.law_title, "model_sha256": model.fingerprint()}
    found = xarray.Dataset(variables, coordinates, provenance)
    names = list(STATUSES)
    codes = [[names.index(status) for status in states.status.tolist()] for states in flown]
    flags = {
        "long_name": "status of the steady state",
        "flag_values": np.arange(len(names), dtype=np.uint8),
        "flag_meanings": " ".join(names),
    }
    found["status"] = (AXES, np.array(codes, np.uint8), flags)
    return found


# --- Output of a mission: energy and state of charge, by leg and over time -----------------------


def _fly(
    craft: Aircraft,
    legs: Mission,
    rests_on: dict[str, str],
    form: out.Format,
    output: Path | None,
    picture: Path | None,
) -> None:
    """Fly a mission, print or write it by leg, and draw it over time."""
    flown = fly(craft, legs)
    course = flown.course
    columns = {
        "time_s": course.time[:, -1],
        "speed_mps": legs.speed,
        "climb_mps": legs.climb,
        "duration_s": legs.duration,
        "pitch_deg": np.degrees(flown.states.pitch),
        "power_W": flown.states.power,
        "energy_J": flown.energy,
        "charge": flown.charge,
        "voltage_V": course.voltage[:, -1],
    }
    status = flown.status.tolist()
    if form == "table":
        heads = "until [s]|V [m/s]|climb [m/s]|time [s]|pitch [deg]|P [W]|energy [J]|charge|U [V]"
        body = out.grid(
            f"{heads}|<status",
            zip(*([_digits(v) for v in each] for each in columns.values()), status, strict=True),
            f"mission {legs.source}",
            "charge, U: state of charge (1 is full) and voltage of the battery at the end of the "
            "leg",
        )
        lost = ~flown.lasted
        outcome = f"{np.sum(flown.energy) / 3600.0:.4g} Wh in {legs.duration.sum() / 60.0:.4g} min"
        if lost.any():
            leg = int(np.argmax(lost))
            outcome = f"leg {leg + 1} cannot be flown to its end: {flown.status_in_words(leg)}"
        out.show(output, _title(craft), *assumption_lines(rests_on), body, outcome)
    else:
        numbers = map(numbers_of, columns.values())
        names = [*columns, "status"]
        listed = [dict(zip(names, row, strict=True)) for row in zip(*numbers, status, strict=True)]
        shown = {"time_s": course.time, "charge": course.charge, "voltage_V": course.voltage}
        over_time = {name: numbers_of(each) for name, each in shown.items()}
        whole: dict[str, Any] = {"vehicle": craft.vehicle.name, "assumptions": rests_on}
        whole |= {"legs": listed, "over_time": over_time}
        out.emit_rows(names, listed, form, output, whole=whole)
    if picture is not None:
        from propmap.report.pictures import mission_course

        out.save_picture(mission_course(_title(craft), legs, flown), picture)
