"""``propmap export VEHICLE.toml --to px4|ardupilot``: a vehicle's parameters for an autopilot."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from propmap.cli.aircraft_options import aircraft_of, vehicle_of
from propmap.cli.operating_points import parse_axis
from propmap.cli.rotor_options import AccuracyName, ModelName
from propmap.errors import InputError

AirfoilOption = Annotated[
    str | None,
    typer.Option(
        "--airfoil", metavar="NAME|FILE", help="For a vehicle: section law, as for predict."
    ),
]
TableOption = Annotated[
    Path | None,
    typer.Option("--table", metavar="FILE.npz", help="For a vehicle: loads from a map instead."),
]
SpeedOption = Annotated[
    str | None,
    typer.Option(
        "--speed",
        metavar="A:B:N",
        help="For px4 and ardupilot: level flights that drag is fitted to [m/s], else 1:15:8.",
    ),
]
ChargeOption = Annotated[
    float | None,
    typer.Option(
        "--charge", help="For px4 and ardupilot: state of charge of the thrust curve, else 1."
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
