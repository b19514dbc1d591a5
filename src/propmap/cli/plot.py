"""``propmap plot`` and ``propmap explore``: pictures of loads, blade and disk, and a web page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from typer import Argument, Option, echo

from propmap.catalogue.lookup import looks_like_path
from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.errors import InputError
from propmap.io.csv import disk_csv
from propmap.units import RPM

if TYPE_CHECKING:
    from propmap.fit.tunnel import TunnelData
    from propmap.rotor import Rotor

SPEEDS_PER_CURVE = 61
SAME_RPM = 0.01  # relative difference from the rpm of the picture up to which rows are drawn
PORT = 8765

plot_app = typer.Typer(
    name="plot", help="Draw the loads, blade or disk of a propeller.", rich_markup_mode=None
)


@plot_app.command("map")
@opt.takes_choices
def plot_map(
    choice: opt.RotorChoice,
    rpm: Annotated[float, Option(help="Rotational speed in rpm.")],
    output: out.PictureOutput,
    speed: Annotated[str, Option(metavar="A:B", help="Range of airspeeds in m/s.")] = "0:20",
    beta: Annotated[
        str, Option(metavar="B,B,...", help=f"{opt.BETA_HELP} in degrees, one curve each.")
    ] = "0,30,60,90",
    measured: Annotated[
        Path | None,
        Option(
            metavar="FILE.csv",
            help="Measured points: columns rpm, speed_mps, beta_deg and loads such as thrust_N.",
        ),
    ] = None,
    bands: opt.Bands = True,
) -> None:
    """Draw the loads of a propeller over airspeed.

    Dashed lines show the hover model: thrust and torque proportional to rpm squared.
    """
    point = opt.single_point(rpm, 0.0, 0.0)
    omega = float(point.si[0][0])
    speeds = opt.parse_axis("--speed", "speed", speed, SPEEDS_PER_CURVE)
    betas = np.radians(opt.parse_axis("--beta", "beta", beta))
    out.check_pictures(output)
    rotor = choice.rotor()
    points = None if measured is None else _measured(measured, rpm, rotor)
    opt.note_points(rotor.model, np.array(omega), speeds[:, None], betas)

    from propmap.report.pictures import load_curves

    band = rotor if bands else None
    out.save_picture(load_curves(rotor, omega, speeds, betas.tolist(), points, band=band), output)


@plot_app.command("planform")
def plot_planform(
    prop: opt.PropArgument,
    output: out.PictureOutput,
    blades: opt.Blades = None,
    radius: opt.Radius = None,
    root_cutout: opt.RootCutout = None,
) -> None:
    """Draw the outline, chord and twist of a blade."""
    out.check_pictures(output)
    blade = opt.propeller_noted(prop, blades, radius, root_cutout)

    from propmap.report.pictures import planform

    out.save_picture(planform(blade), output)


@plot_app.command("disk")
@opt.takes_choices
def plot_disk(
    choice: opt.RotorChoice,
    rpm: Annotated[float, Option(help="Rotational speed in rpm.")],
    speed: Annotated[float, Option(help="Airspeed in m/s.")],
    beta: Annotated[float, Option(help=f"{opt.BETA_HELP} in degrees.")],
    output: Annotated[
        Path, out.output_option("Picture (.png, .svg or .pdf) or values on the disk (.csv).")
    ],
) -> None:
    """Draw the angle of attack over the disk of a propeller.

    The picture outlines stall and reverse flow.
    """
    point = opt.single_point(rpm, speed, beta)
    out.check_output(output, (*out.PICTURES, ".csv"))
    rotor = choice.rotor()
    opt.note_points(rotor.model, *point.si)
    omega, v, angle = (float(values[0]) for values in point.si)
    if output.suffix.lower() == ".csv":
        out.emit(disk_csv(rotor, omega, v, angle), output)
        return

    from propmap.report.pictures import disk_picture

    out.save_picture(disk_picture(rotor, omega, v, angle), output)


def _measured(path: Path, rpm: float, rotor: Rotor) -> TunnelData:
    from propmap.fit.tunnel import measured_loads

    found = measured_loads(path)(rotor.model.propeller, rotor.model.air)
    out.note(*found.remarks)
    given = found.omega / RPM
    mine = np.abs(given - rpm) <= SAME_RPM * rpm
    if not mine.any():
        near = given[np.argmin(np.abs(given - rpm))]
        raise InputError(f"no row is within 1 % of {rpm:g} rpm", f"try --rpm {near:g}", str(path))
    return found.picked(mine)


def explore(
    subject: Annotated[
        str | None,
        Argument(
            metavar="[PROP|FIT.toml|TABLE.npz|VEHICLE.toml]",
            help="Propeller (catalogue name, designation or file), fit, parameter set, table, "
            "vehicle file, or measured loads (.csv).",
            show_default=False,
        ),
    ] = None,
    port: Annotated[
        int | None, Option(min=0, max=65535, help=f"Port (default: {PORT} or the next free one).")
    ] = None,
    browser: Annotated[
        bool, Option("--browser/--no-browser", help="Open the page in a browser.")
    ] = True,
    host: Annotated[
        str, Option(help="Address of the server; the default serves this computer only.")
    ] = "127.0.0.1",
) -> None:
    """Explore the loads of a propeller interactively in the browser."""
    from propmap.explore.app import Application, guard, is_loopback, listen, names_of, serve
    from propmap.explore.session import Session, Shelf, read_path
    from propmap.explore.views import VIEWS

    shelf, first = Shelf(), Session()
    if subject is not None and looks_like_path(subject):
        given = read_path(Path(subject))
        first = first.with_file(given, shelf.put(given))
    elif subject is not None:
        first = Session(prop=subject)
    first.model  # noqa: B018 - reports a bad input before the server starts
    app = Application(first, VIEWS, shelf)
    guard(app.dash.server, names_of(host))
    server = listen(app.dash.server, host, port, PORT)
    if not is_loopback(host):
        who = f"anyone who can reach {host} can use this server: it has no password"
        echo(f"propmap: warning: {who}", err=True)
    serve(server, echo, browser=browser, host=host)
