"""``propmap export``: a table, a vehicle or its parameters in the form that other programs read."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from propmap.cli.aircraft_options import NoWakes, aircraft_of, vehicle_of
from propmap.cli.options import (
    AccuracyName,
    Corrections,
    ModelName,
    ModelOption,
    parse_axis,
    say_expected,
    say_reynolds,
    with_physics,
)
from propmap.cli.output import Force
from propmap.cli.table_report import building
from propmap.errors import InputError
from propmap.export import AUTOPILOTS, EXPORTS, VEHICLE_TARGETS, find_export
from propmap.model.model import Model
from propmap.units import RPM

if TYPE_CHECKING:
    from propmap.rotor import Rotor
    from propmap.table import LoadTable


# -------------------------------------------------------------------------------------------------
# ``propmap export``: a table in the form that another program reads.

TIP_SPEED = (20.0, 105.0)
SPEED = (0.0, 20.0)
BETA = (0.0, math.pi)
TOLERANCE = 0.005
"""Of the table that is built from a fit: tip speeds and speeds [m/s], angles [rad], share of the
static loads."""


def _forms(source: str) -> str:
    """List the targets of a ``source`` and what is written for them, for the help."""
    return "; ".join(f"{e.target}: {e.writes}" for e in EXPORTS if e.source == source)


def export(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="TABLE|FIT|VEHICLE",
            help="Table (.npz), fit (.toml), any section law, or vehicle file.",
        ),
    ],
    to: Annotated[
        str,
        typer.Option(
            "--to",
            metavar="TARGET",
            help=f"{_forms('table')}. Of a vehicle file and --table: {_forms('vehicle')}. "
            f"Of a vehicle file: {_forms('autopilot')}.",
        ),
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder; made if need be.")
    ],
    prop: Annotated[
        str | None,
        typer.Option("--prop", metavar="PROP", help="For a section law: name or geometry file."),
    ] = None,
    model: ModelOption = None,
    correction: Corrections = None,
    airfoil: AirfoilOption = None,
    table: TableOption = None,
    speed: SpeedOption = None,
    charge: ChargeOption = None,
    no_wakes: NoWakes = False,
    force: Force = False,
) -> None:
    """Files for simulators, flight code and autopilots, with a note of the errors they make."""
    from propmap.export import export_table
    from propmap.export.files import check_folder

    find_export(to)
    if to in AUTOPILOTS:
        refuse_options(to, prop=prop)
        export_vehicle(
            source,
            to,
            output,
            airfoil=airfoil,
            table=table,
            model=model,
            correction=correction,
            speed=speed,
            charge=charge,
            no_wakes=no_wakes,
            replace=force,
        )
        return
    if is_vehicle(source):
        given = {"prop": prop, "model": model, "correction": correction or None}
        refuse_options(to, **given, airfoil=airfoil, speed=speed, charge=charge)
        export_wrench(source, to, output, table=table, no_wakes=no_wakes, replace=force)
        return
    refuse_options(
        to, airfoil=airfoil, table=table, speed=speed, charge=charge, no_wakes=no_wakes or None
    )
    check_folder(output)
    built = _table(source, prop, model, correction)
    try:
        paths = export_table(built, to, output, replace=force)
    except InputError as error:
        # What is wrong with a table is wrong with this file.
        raise InputError(error.found, error.remedy, error.where or str(source)) from None
    for path in paths:
        typer.echo(f"wrote {path}")


def _table(
    source: Path, prop: str | None, physics: ModelName | None, corrections: list[str] | None
) -> LoadTable:
    if source.suffix.lower() in (".npz", ".nc") or (prop is None and source.suffix != ".toml"):
        from propmap.table import LoadTable

        for option, given in (
            ("--prop", prop),
            ("--model", physics),
            ("--correction", corrections),
        ):
            if given:
                found = f"{option} is given with a table, which has its own"
                raise InputError(found, "leave it out")
        return LoadTable.load(source)
    from propmap.catalogue.lookup import airfoil, propeller
    from propmap.fit.files import is_fit, read_fit
    from propmap.rotor import Rotor

    if prop is not None:
        say_expected(prop)
    law = with_physics(airfoil(source), physics, corrections)
    fit = read_fit(source) if prop is None or is_fit(source) else None
    model = (
        fit.model.with_airfoil(law) if fit and prop is None else Model(propeller(prop or ""), law)
    )
    return _built(Rotor(model))


def _built(rotor: Rotor) -> LoadTable:
    """A table over an envelope that suits most multirotors."""
    from propmap.table import build_table

    radius = rotor.model.propeller.radius
    omega = (TIP_SPEED[0] / radius, TIP_SPEED[1] / radius)
    rpm = [w / RPM for w in omega]
    typer.echo(
        f"building a table of {rotor.model.propeller.name}, {rotor.model.law_title}, "
        f"at {rpm[0]:.0f} to {rpm[1]:.0f} rpm, {SPEED[0]:g} to {SPEED[1]:g} m/s, "
        "beta 0 to 180 deg, which takes minutes; "
        "for another range, build it with propmap table",
        err=True,
    )
    say_reynolds(rotor.model, np.array(omega), np.array(SPEED), np.array(BETA))
    with building() as progress:
        return build_table(
            rotor,
            omega=omega,
            speed=SPEED,
            beta=BETA,
            tolerance=TOLERANCE,
            progress=progress,
        )


# -------------------------------------------------------------------------------------------------
# ``propmap export VEHICLE.toml --table TABLE.npz --to c|rotorpy``: force and moment on a vehicle.


def is_vehicle(path: Path) -> bool:
    """Whether the file at ``path`` is a vehicle's: TOML with a table ``[[rotors]]``."""
    import tomllib

    if path.suffix.lower() != ".toml":
        return False
    try:
        return "rotors" in tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False


def export_wrench(
    source: Path, to: str, output: Path, *, table: Path | None, no_wakes: bool, replace: bool
) -> None:
    """Write force and moment on the vehicle file ``source`` for the target ``to``."""
    from propmap.export import export_vehicle
    from propmap.export.files import check_folder
    from propmap.table import LoadTable

    if to not in VEHICLE_TARGETS:
        raise InputError(
            f"this is a vehicle file, and {to} is written of a table alone",
            f"give the table, or --to {', '.join((*VEHICLE_TARGETS, *AUTOPILOTS))}",
            str(source),
        )
    if table is None:
        raise InputError(
            "this is a vehicle file, and the loads of its rotors are not given",
            "build a table with propmap table and give it as --table TABLE.npz",
            str(source),
        )
    check_folder(output)
    vehicle, loads = vehicle_of(source, no_wakes=no_wakes), LoadTable.load(table)
    try:
        paths = export_vehicle(vehicle, loads, to, output, replace=replace)
    except InputError as error:
        raise InputError(error.found, error.remedy, error.where or str(source)) from None
    for path in paths:
        typer.echo(f"wrote {path}")


# -------------------------------------------------------------------------------------------------
# ``propmap export VEHICLE.toml --to px4|ardupilot``: a vehicle's parameters for an autopilot.

AirfoilOption = Annotated[
    str | None,
    typer.Option(
        "--airfoil", metavar="NAME|FILE", help="For a vehicle: section law, as for predict."
    ),
]
TableOption = Annotated[
    Path | None,
    typer.Option("--table", metavar="FILE.npz", help="For a vehicle: loads from a table instead."),
]
SpeedOption = Annotated[
    str | None,
    typer.Option(
        "--speed",
        metavar="A:B:N",
        help=f"For {' and '.join(AUTOPILOTS)}: level flights that drag is fitted to [m/s], "
        "else 1:15:8.",
    ),
]
ChargeOption = Annotated[
    float | None,
    typer.Option(
        "--charge",
        help=f"For {' and '.join(AUTOPILOTS)}: state of charge of the thrust curve, else 1.",
    ),
]


def export_vehicle(
    source: Path,
    to: str,
    output: Path,
    *,
    airfoil: str | None,
    table: Path | None,
    model: ModelName | None,
    correction: list[str] | None,
    speed: str | None,
    charge: float | None,
    no_wakes: bool,
    replace: bool,
) -> None:
    """Write the parameters of the vehicle file ``source`` for the autopilot ``to``."""
    import numpy as np

    from propmap.export.autopilot import SPEEDS, export_autopilot
    from propmap.export.files import check_folder
    from propmap.export.inplane_drag import missing_drag

    check_folder(output)
    if source.suffix.lower() != ".toml":
        raise InputError(
            f"{to} takes a vehicle file", "give VEHICLE.toml, see propmap trim", str(source)
        )
    speeds = SPEEDS if speed is None else parse_axis("--speed", "speed", speed, len(SPEEDS))
    craft = aircraft_of(
        vehicle_of(source, no_wakes=no_wakes),
        airfoil=airfoil,
        table=table,
        model=model,
        correction=correction,
        accuracy=AccuracyName.standard,
        maximum_rpm=None,
        charge=1.0 if charge is None else charge,
    )
    try:
        paths = export_autopilot(craft, to, output, speeds=np.asarray(speeds), replace=replace)
    except InputError as error:
        raise InputError(error.found, error.remedy, error.where or str(source)) from None
    for words in missing_drag(craft):
        typer.echo(f"note: {words}", err=True)
    for path in paths:
        typer.echo(f"wrote {path}")


def refuse_options(to: str, **given: object) -> None:
    """Raise ``InputError`` for an option, by its name, that the target ``to`` does not have."""
    for name, value in given.items():
        if value is not None:
            option = name.replace("_", "-")
            raise InputError(f"--{option} is given with --to {to}, which has none", "leave it out")
