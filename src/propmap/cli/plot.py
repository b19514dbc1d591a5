"""``propmap plot``: pictures of loads, of a blade and of the disk."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from propmap.catalogue.lookup import propeller
from propmap.cli.options import (
    Bands,
    Blades,
    PropArgument,
    Radius,
    RootCutout,
    RotorChoice,
    parse_axis,
    say_doubts,
    say_doubts_on_points,
    say_expected,
    say_reynolds,
    single_point,
    takes_rotor,
)
from propmap.cli.output import PICTURES, PictureOutput, check_output, check_pictures, write_text
from propmap.errors import InputError
from propmap.io.csv import LOAD_COLUMNS, disk_csv, read_points
from propmap.model.plausibility import blade_warnings
from propmap.units import RPM

if TYPE_CHECKING:
    from propmap.report.pictures import MeasuredLoads

SPEEDS_PER_CURVE = 61

SAME_RPM = 0.01
"""Measured rows within this share of the picture's rpm are drawn."""

plot_app = typer.Typer(
    name="plot", help="Pictures: loads against speed, a blade, the disk.", rich_markup_mode=None
)


@plot_app.command("map")
@takes_rotor
def plot_map(
    choice: RotorChoice,
    rpm: Annotated[float, typer.Option("--rpm", help="Rotational speed [1/min].")],
    output: PictureOutput,
    speed: Annotated[
        str, typer.Option("--speed", metavar="A:B", help="Range of flight speeds [m/s].")
    ] = "0:20",
    beta: Annotated[
        str, typer.Option("--beta", metavar="B,B,...", help="Angles, a curve each [deg].")
    ] = "0,30,60,90",
    measured: Annotated[
        Path | None,
        typer.Option("--measured", metavar="FILE.csv", help="Points to draw, such as thrust_N."),
    ] = None,
    bands: Bands = True,
) -> None:
    """All loads against flight speed, the hover model dashed."""
    omega = float(single_point(rpm, 0.0, 0.0).rpm[0]) * RPM
    speeds = parse_axis("--speed", "speed", speed, SPEEDS_PER_CURVE)
    betas = np.radians(parse_axis("--beta", "beta", beta))
    check_pictures(output)
    points = None if measured is None else _measured(measured, rpm)
    rotor = choice.rotor()
    points_drawn = np.array(omega), speeds[:, None], betas
    say_reynolds(rotor.model, *points_drawn)
    say_doubts_on_points(rotor.model, *points_drawn)

    from propmap.report.html import save
    from propmap.report.pictures import load_curves

    band = rotor if bands else None
    save(load_curves(rotor, omega, speeds, betas.tolist(), points, band=band), output)
    typer.echo(output)


@plot_app.command("planform")
def plot_planform(
    prop: PropArgument,
    output: PictureOutput,
    blades: Blades = None,
    radius: Radius = None,
    root_cutout: RootCutout = None,
) -> None:
    """A blade's outline, chord and twist."""
    check_pictures(output)
    blade = propeller(prop, blades, radius, root_cutout)
    say_expected(prop)
    say_doubts(blade_warnings(blade))

    from propmap.report.html import save
    from propmap.report.pictures import planform

    save(planform(blade), output)
    typer.echo(output)


@plot_app.command("disk")
@takes_rotor
def plot_disk(
    choice: RotorChoice,
    rpm: Annotated[float, typer.Option("--rpm", help="Rotational speed [1/min].")],
    speed: Annotated[float, typer.Option("--speed", help="Flight speed [m/s].")],
    beta: Annotated[float, typer.Option("--beta", help="Velocity to axis [deg].")],
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="Picture: .png, .svg or .pdf; field: .csv.",
        ),
    ],
) -> None:
    """The angle of attack over the disk, with stall and reverse flow outlined."""
    point = single_point(rpm, speed, beta)
    check_output(output, (*PICTURES, ".csv"))
    rotor = choice.rotor()
    say_reynolds(rotor.model, *point.si)
    say_doubts_on_points(rotor.model, *point.si)

    flow = (float(point.rpm[0]) * RPM, speed, float(np.radians(beta)))
    if output.suffix.lower() == ".csv":
        write_text(disk_csv(rotor, *flow), output)
        typer.echo(output)
        return

    from propmap.report.html import save
    from propmap.report.pictures import disk_picture

    save(disk_picture(rotor, *flow), output)
    typer.echo(output)


def _measured(path: Path, rpm: float) -> MeasuredLoads:
    points, columns = read_points(path, LOAD_COLUMNS)
    if not columns:
        raise InputError(
            "there is no column of loads", f"name one of {', '.join(LOAD_COLUMNS)}", str(path)
        )
    mine = np.abs(points.rpm - rpm) <= SAME_RPM * rpm
    if not mine.any():
        near = points.rpm[np.argmin(np.abs(points.rpm - rpm))]
        raise InputError(f"no row is within 1 % of {rpm:g} rpm", f"try --rpm {near:g}", str(path))
    loads = {LOAD_COLUMNS[name]: values[mine] for name, values in columns.items()}

    from propmap.report.pictures import MeasuredLoads

    beta = np.radians(points.beta_deg[mine])
    return MeasuredLoads(path.stem, points.speed_mps[mine], beta, loads)
