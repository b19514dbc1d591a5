"""``propmap export``: write tables, vehicles and propellers in the formats of other programs."""

from __future__ import annotations

import time
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
from typer import Argument, Option, echo

from propmap.catalogue.lookup import airfoil as section_law
from propmap.catalogue.lookup import propeller
from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.errors import InputError, quoted
from propmap.export import (
    AUTOPILOTS,
    EXPORTS,
    ROTOR_TARGETS,
    TARGETS,
    VEHICLE_TARGETS,
    find_export,
)
from propmap.fit.files import read_fit
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.units import RPM

if TYPE_CHECKING:
    from propmap.export.built_tables import Ranges
    from propmap.table import LoadTable

TABLES = (".npz", ".nc")  # extensions of table files


def _forms(source: str) -> str:
    """Return the targets of a ``source`` and their files as text for the help."""
    return ", ".join(f"{e.target} ({e.writes})" for e in EXPORTS if e.source == source)


def export(
    source: Annotated[
        str,
        Argument(
            metavar="TABLE|FIT|VEHICLE|PROP",
            help="Table (.npz), fit (.toml), section law, vehicle file (.toml), or propeller: "
            "catalogue name, designation or geometry file.",
        ),
    ],
    to: Annotated[
        str,
        Option(
            metavar="TARGET",
            help=f"Output format, by input. All inputs: {_forms('table')}. "
            f"Vehicle file: {_forms('vehicle')}, {_forms('autopilot')}. "
            f"Vehicle file of a pusher or tailsitter: {_forms('pusher')}. "
            f"Propeller or vehicle file: {_forms('rotor')}.",
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
        Path | None,
        Option(
            metavar="FILE.npz",
            help="For a vehicle: table of the rotor loads (default: the command builds a table for "
            "hover and level flight up to the top speed).",
        ),
    ] = None,
    joint: Annotated[
        str | None,
        Option(
            metavar="NAME",
            help="For gazebo: names of the rotor joints; {} stands for the number of the rotor, "
            "from 0 (default: rotor_{}_joint).",
        ),
    ] = None,
    link: Annotated[
        str | None,
        Option(metavar="NAME", help="For gazebo: names of the rotor links (default: rotor_{})."),
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

    For a fit, a propeller or a vehicle, the command builds the table if the format requires one.

    Except for cpp, the command also writes a README with the errors of the format.
    """
    from propmap.aircraft.assumptions import assumption_lines, assumptions
    from propmap.export import built_tables, export_rotor, export_table, export_vehicle
    from propmap.export.autopilot import SPEEDS, export_autopilot
    from propmap.export.files import check_folder
    from propmap.table import LoadTable

    path, names = Path(source), {"joint": joint, "link": link}
    patterns = {name: pattern for name, pattern in names.items() if pattern is not None}

    def refuse(**given: object) -> None:
        for name, value in given.items():
            if value is not None:
                option = f"--{name.replace('_', '-')}"
                fault = f"{option} does not apply to --to {to} of {quoted(source)}"
                raise InputError(fault, "leave it out")

    def write(loads: Rotor | LoadTable) -> list[Path]:
        if isinstance(loads, Rotor):
            return export_rotor(loads, to, output, replace=force)
        return export_table(loads, to, output, replace=force, **patterns)

    find_export(to)
    if to != "gazebo":
        refuse(**names)
    if to not in AUTOPILOTS:
        refuse(speed=speed, charge=charge)
    if path.suffix.lower() != ".toml" and to not in (*TARGETS, *ROTOR_TARGETS):
        fault = f"--to {to} needs a vehicle file"
        raise InputError(fault, "give VEHICLE.toml, see propmap trim", source)
    check_folder(output)
    for note in [] if force else output.glob(f"README-{to}.*"):
        raise InputError("the file exists", "pass --force to replace it", str(note))
    if _is_vehicle(path, to, table):
        refuse(prop=prop, table=table if to in ROTOR_TARGETS else None)
        speeds = SPEEDS if speed is None else opt.parse_axis("--speed", "speed", speed, len(SPEEDS))
        read, full = opt.vehicle_of(path, no_wakes=no_wakes), 1.0 if charge is None else charge
        craft = opt.aircraft_of(read, airfoil, table, model, correction, charge=full)
        with out.blamed_on(path):
            loads = craft.loads
            if isinstance(loads, Rotor) and to not in AUTOPILOTS:
                craft, loads = built_tables.with_mount_in_model(craft, loads)
                if to not in ROTOR_TARGETS:
                    loads = _built(loads, built_tables.ranges_of(craft))
            if to in AUTOPILOTS:
                paths = export_autopilot(craft, to, output, speeds=speeds, replace=force)
            elif to in VEHICLE_TARGETS and not isinstance(loads, Rotor):
                paths = export_vehicle(craft.vehicle, loads, to, output, replace=force, **patterns)
            else:
                out.note(f"--to {to} writes one rotor, without its position, axis and spin")
                paths = write(loads)
        out.note(*assumption_lines(assumptions(craft.vehicle, loads)))
        out.note(*craft.balance.allocation.notes)
    elif path.suffix.lower() in TABLES:
        find_export(to, "table")
        refuse(prop=prop, model=model, correction=correction or None, airfoil=airfoil)
        refuse(table=table, no_wakes=no_wakes or None)
        found = LoadTable.load(path)
        with out.blamed_on(path):
            paths = write(found)
    else:
        refuse(table=table, no_wakes=no_wakes or None)
        if prop is None and path.suffix.lower() != ".toml":
            rotor = opt.RotorChoice(source, airfoil, model=model, correction=correction).rotor()
        else:
            refuse(airfoil=airfoil)
            rotor = _rotor_of_law(path, prop, model, correction)
        ranges = built_tables.usual_ranges(rotor.model.propeller)
        paths = write(rotor if to in ROTOR_TARGETS else _built(rotor, ranges))
    for path in paths:
        echo(f"wrote {path}")


def _is_vehicle(path: Path, to: str, table: Path | None) -> bool:
    """Return whether the file is a vehicle file, because of other options or its keys."""
    if path.suffix.lower() != ".toml":
        return False
    if table is not None or to not in (*TARGETS, *ROTOR_TARGETS):
        return True
    try:
        return not {"rotors", "mass"}.isdisjoint(tomllib.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, RecursionError):
        return False


def _rotor_of_law(
    path: Path, prop: str | None, model: opt.ModelName | None, correction: list[str] | None
) -> Rotor:
    """Return the rotor of a fit, or of a section law with its propeller ``prop``."""
    law = opt.with_physics(section_law(path), model, correction)
    if prop is None:
        return Rotor(read_fit(path).model.with_airfoil(law))
    blade = propeller(prop)
    opt.note_reading(prop, blade)
    return Rotor(Model(blade, law))


def _built(rotor: Rotor, ranges: Ranges) -> LoadTable:
    """Return a table of a ``rotor``, and print notes on the range and the errors of the table."""
    from propmap.export import built_tables

    model, (omega, speed) = rotor.model, ranges
    least, most = (w / RPM for w in omega)
    echo(
        f"building a table of {model.propeller.name}, {model.law_title}, at {least:.0f} to "
        f"{most:.0f} rpm, {speed[0]:g} to {speed[1]:.3g} m/s, beta 0 to 180 deg, "
        f"{model.air.density:.4g} kg/m^3; for other values, use propmap table",
        err=True,
    )
    opt.note_reynolds(model, np.array(omega), np.array(speed), np.array(built_tables.BETA))
    start = time.perf_counter()
    with out.progress_bar("") as update:
        found = built_tables.built_table(rotor, ranges, lambda stage, n: update(n, what=stage))
    took, sure = time.perf_counter() - start, found.certificate
    worst, steep = max(sure["max_error"].values()), sure["unresolved_volume"]
    words = f"built the table in {took:.0f} s: errors at most {worst:.1%} of the static loads at "
    words += f"{sure['points']} points"
    words += f", except in {steep:.1%} of the range, where the loads are too steep" * (steep > 0.0)
    echo(words, err=True)
    return found
