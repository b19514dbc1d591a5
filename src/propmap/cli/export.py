"""``propmap export``: write tables, vehicles and propellers in the formats of other programs."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
from typer import Argument, Option, echo

from propmap.catalogue.lookup import airfoil as section_law
from propmap.catalogue.lookup import propeller
from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.errors import InputError
from propmap.export import (
    AUTOPILOTS,
    EXPORTS,
    ROTOR_TARGETS,
    TARGETS,
    VEHICLE_TARGETS,
    find_export,
)
from propmap.fit.files import is_fit, read_fit
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.units import RPM

if TYPE_CHECKING:
    from propmap.table import LoadTable

# The table that is built from a fit: tip speeds and airspeeds [m/s], angles [rad], and the
# largest error as a fraction of the static loads.
TIP_SPEED = (20.0, 105.0)
SPEED = (0.0, 20.0)
BETA = (0.0, math.pi)
TOLERANCE = 0.005

TABLES = (".npz", ".nc")  # extensions of table files


def _forms(source: str) -> str:
    """Return the targets of a ``source`` and their files as text for the help."""
    return ", ".join(f"{e.target} ({e.writes})" for e in EXPORTS if e.source == source)


def export(
    source: Annotated[
        Path,
        Argument(
            metavar="TABLE|FIT|VEHICLE|PROP",
            help="Table (.npz), fit (.toml), section law, vehicle file, or propeller.",
        ),
    ],
    to: Annotated[
        str,
        Option(
            metavar="TARGET",
            help=f"Output format, by input. Table, fit or section law: {_forms('table')}. "
            f"Vehicle file with --table: {_forms('vehicle')}. "
            f"Vehicle file: {_forms('autopilot')}. "
            f"Vehicle file of a pusher or tailsitter: {_forms('pusher')}. "
            f"Propeller: {_forms('rotor')}.",
        ),
    ],
    output: Annotated[Path, out.output_option("Output folder; created if it is missing.", "DIR")],
    prop: Annotated[
        str | None,
        Option(metavar="PROP", help="For a section law: propeller by name, designation or file."),
    ] = None,
    model: opt.ModelOption = None,
    correction: opt.Corrections = None,
    airfoil: Annotated[
        str | None,
        Option(
            metavar="NAME|FILE",
            help="For a vehicle or propeller: section law, as for predict.",
        ),
    ] = None,
    table: Annotated[
        Path | None, Option(metavar="FILE.npz", help="For a vehicle: table of the rotor loads.")
    ] = None,
    speed: Annotated[
        str | None,
        Option(
            metavar="A:B:N",
            help="For px4 and ardupilot: airspeeds in m/s of the simulated level flights from "
            "which the drag parameters are fitted (default: 1:15:8).",
        ),
    ] = None,
    charge: Annotated[
        float | None,
        Option(help="For px4 and ardupilot: state of charge for the thrust curve (default: 1)."),
    ] = None,
    no_wakes: opt.NoWakes = False,
    force: out.Force = False,
) -> None:
    """Export rotor loads to simulators, flight code and autopilots.

    For approximate formats, the output folder also receives a README with the approximation errors.
    """
    from propmap.aircraft.assumptions import assumption_lines, assumptions
    from propmap.export import export_rotor, export_table, export_vehicle
    from propmap.export.files import check_folder
    from propmap.table import LoadTable

    def refuse(**given: object) -> None:
        for name, value in given.items():
            if value is not None:
                option = f"--{name.replace('_', '-')}"
                fault = f"{option} does not apply to --to {to}"
                raise InputError(fault, "leave it out")

    find_export(to)
    if to in AUTOPILOTS:
        from propmap.export.autopilot import SPEEDS, export_autopilot

        refuse(prop=prop)
        check_folder(output)
        if source.suffix.lower() != ".toml":
            fault = f"--to {to} needs a vehicle file"
            raise InputError(fault, "give VEHICLE.toml, see propmap trim", str(source))
        speeds = SPEEDS if speed is None else opt.parse_axis("--speed", "speed", speed, len(SPEEDS))
        read, full = opt.vehicle_of(source, no_wakes=no_wakes), 1.0 if charge is None else charge
        craft = opt.aircraft_of(read, airfoil, table, model, correction, charge=full)
        with out.blamed_on(source):
            paths = export_autopilot(craft, to, output, speeds=np.asarray(speeds), replace=force)
        out.note(*assumption_lines(assumptions(craft.vehicle, craft.loads)))
        out.note(*craft.balance.allocation.notes)
    elif to in ROTOR_TARGETS:
        refuse(prop=prop, table=table, speed=speed, charge=charge, no_wakes=no_wakes or None)
        if source.suffix.lower() in TABLES or _is_vehicle(source):
            find_export(to, "table" if source.suffix.lower() in TABLES else "vehicle")
        check_folder(output)
        asked = opt.RotorChoice(str(source), airfoil=airfoil, model=model, correction=correction)
        paths = export_rotor(asked.rotor(), to, output, replace=force)
    elif _is_vehicle(source) or _meant_as_vehicle(source, to, table):
        refuse(prop=prop, model=model, correction=correction or None)
        refuse(airfoil=airfoil, speed=speed, charge=charge)
        if to not in VEHICLE_TARGETS:
            fault = f"this is a vehicle file, but --to {to} needs a table"
            remedy = f"give the table, or --to {', '.join(VEHICLE_TARGETS)}, px4 or ardupilot"
            raise InputError(fault, remedy, str(source))
        vehicle = opt.vehicle_of(source, no_wakes=no_wakes)
        if table is None:
            fault = "this is a vehicle file, but the loads of its rotors are missing"
            remedy = "build a table with propmap table and give it as --table FILE.npz"
            raise InputError(fault, remedy, str(source))
        check_folder(output)
        loads = LoadTable.load(table)
        with out.blamed_on(source):
            paths = export_vehicle(vehicle, loads, to, output, replace=force)
        out.note(*assumption_lines(assumptions(vehicle, loads)))
    else:
        find_export(to, "table")
        refuse(airfoil=airfoil, table=table, speed=speed, charge=charge, no_wakes=no_wakes or None)
        check_folder(output)
        found = _table_of(source, prop, model, correction)
        with out.blamed_on(source):
            paths = export_table(found, to, output, replace=force)
    for path in paths:
        echo(f"wrote {path}")


def _is_vehicle(path: Path) -> bool:
    """Return whether the file is a vehicle file: TOML with a table ``[[rotors]]``."""
    if path.suffix.lower() != ".toml":
        return False
    try:
        return "rotors" in tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return False


def _meant_as_vehicle(source: Path, to: str, table: Path | None) -> bool:
    """Return whether a file that cannot be read must be a vehicle file, because ``to`` and
    ``table`` allow no other source."""
    if source.suffix.lower() in TABLES or to not in VEHICLE_TARGETS:
        return False
    return table is not None or to not in TARGETS


def _table_of(
    source: Path, prop: str | None, physics: opt.ModelName | None, corrections: list[str] | None
) -> LoadTable:
    """Load a table, or build one from a section law for the range of most multirotors."""
    from propmap.table import LoadTable, build_table

    if source.suffix.lower() in TABLES or (prop is None and source.suffix != ".toml"):
        given = {"--prop": prop, "--model": physics, "--correction": corrections}
        for option, value in given.items():
            if value:
                found = f"{option} is given, but the table already contains it"
                raise InputError(found, "leave it out")
        return LoadTable.load(source)

    law = opt.with_physics(section_law(source), physics, corrections)
    fit = read_fit(source) if prop is None or is_fit(source) else None
    model = (
        fit.model.with_airfoil(law) if fit and prop is None else Model(propeller(prop or ""), law)
    )
    blade = model.propeller
    if prop is not None:
        opt.note_reading(prop, blade)
    omega = (TIP_SPEED[0] / blade.radius, TIP_SPEED[1] / blade.radius)
    rpm = [w / RPM for w in omega]
    echo(
        f"building a table of {blade.name}, {model.law_title}, "
        f"at {rpm[0]:.0f} to {rpm[1]:.0f} rpm, {SPEED[0]:g} to {SPEED[1]:g} m/s, "
        "beta 0 to 180 deg (takes minutes); for another range, use propmap table",
        err=True,
    )
    opt.note_reynolds(model, np.array(omega), np.array(SPEED), np.array(BETA))
    with out.progress_bar("") as update:
        return build_table(
            Rotor(model),
            omega=omega,
            speed=SPEED,
            beta=BETA,
            tolerance=TOLERANCE,
            progress=lambda stage, done: update(done, what=stage),
        )
