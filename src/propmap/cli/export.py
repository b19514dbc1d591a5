"""``propmap export``: a map in the form that another program reads."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from propmap.cli.aircraft_options import NoWakes
from propmap.cli.export_autopilot import (
    AirfoilOption,
    ChargeOption,
    SpeedOption,
    TableOption,
    export_vehicle,
    refuse_options,
)
from propmap.cli.export_wrench import export_wrench, is_vehicle
from propmap.cli.output import Force
from propmap.cli.plausibility import say_expected
from propmap.cli.rotor_options import (
    Corrections,
    ModelName,
    ModelOption,
    say_reynolds,
    with_physics,
)
from propmap.cli.table_report import building
from propmap.errors import InputError
from propmap.model.model import Model

if TYPE_CHECKING:
    from propmap.rotor import Rotor
    from propmap.table import LoadTable

TIP_SPEED = (20.0, 105.0)
SPEED = (0.0, 20.0)
BETA = (0.0, math.pi)
TOLERANCE = 0.005
"""Of the map that is built from a fit: tip speeds and speeds [m/s], angles [rad], share of the
static loads."""


def export(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="MAP|FIT|VEHICLE",
            help="Map (.npz), fit (.toml), any section law, or vehicle file.",
        ),
    ],
    to: Annotated[
        str,
        typer.Option(
            "--to",
            metavar="TARGET",
            help="c, multinomial, gazebo, rotorpy, jsbsim, npz, nc or csv; of a vehicle file c or "
            "rotorpy with --table, px4 or ardupilot.",
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
    from propmap.export import AUTOPILOTS, check_folder, check_target, export_table

    check_target(to)
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
        # What is wrong with a map is wrong with this file.
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
                raise InputError(f"{option} is given with a map, which has its own", "leave it out")
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
    """A map over an envelope that suits most multirotors."""
    from propmap.table import build_table

    radius = rotor.model.propeller.radius
    omega = (TIP_SPEED[0] / radius, TIP_SPEED[1] / radius)
    rpm = [30.0 / math.pi * w for w in omega]
    typer.echo(
        f"building a map of {rotor.model.propeller.name}, {rotor.model.law_title}, "
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
