"""``propmap table`` and ``propmap show``: build a certified table of loads, and describe one."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from typer import Argument, Option, echo

from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.errors import InputError, quoted
from propmap.units import RPM

if TYPE_CHECKING:
    from propmap.table import LoadTable


@opt.takes_choices
def table(
    choice: opt.RotorChoice,
    context: typer.Context,
    rpm: Annotated[
        str, Option(metavar="A:B", help="Range of rotational speeds in rpm; negative: backward.")
    ],
    speed: Annotated[str, Option(metavar="A:B", help="Range of airspeeds in m/s.")],
    output: Annotated[Path, out.output_option("Output file: table (.npz) or NetCDF (.nc).")],
    beta: Annotated[
        str, Option(metavar="A:B", help=f"{opt.BETA_HELP} in degrees: range within 0:180.")
    ] = "0:180",
    tolerance: Annotated[
        str,
        Option(
            metavar="SHARE",
            help="Largest permitted error relative to the static loads, as 0.5% or 0.005.",
        ),
    ] = "0.5%",
    no_vortex_ring: Annotated[
        bool, Option("--no-vortex-ring", help="Store NaN for points in the vortex ring state.")
    ] = False,
    force: out.Force = False,
    cluster: opt.Cluster = None,
) -> None:
    """Build a table of propeller loads with certified error bounds."""
    ranges = []
    for name, text in (("rpm", rpm), ("speed", speed), ("beta", beta)):
        if text.count(":") != 1:
            raise InputError(f"--{name} {quoted(text)} is not a range", "write A:B, from A to B")
        ranges.append(opt.parse_axis(f"--{name}", name, text, count=2))
    share = _share("--tolerance", tolerance)
    out.check_output(output, (".npz", ".nc"), keep_existing=not force)

    from propmap.table import LoadTable
    from propmap.table.build import build_table, check_tolerance

    check_tolerance(share, choice.accuracy)
    rotor = choice.rotor()
    omega, speeds, betas = ranges[0] * RPM, ranges[1], np.radians(ranges[2])
    opt.note_points(rotor.model, *np.meshgrid(omega, speeds, betas, indexing="ij"))
    with opt.workers_of(cluster) as workers, out.progress_bar("") as update:
        built = build_table(
            rotor,
            omega=(omega[0], omega[1]),
            speed=(speeds[0], speeds[1]),
            beta=(betas[0], betas[1]),
            tolerance=share,
            leave_out_vortex_ring=no_vortex_ring,
            progress=lambda stage, done: update(done, what=stage),
            workers=workers,
        )
    content = replace(built.content, info={**built.info, "command": opt.command_line(context)})
    if output.suffix.lower() == ".nc":
        LoadTable(content).to_netcdf(output)
    else:
        LoadTable(content).save(output)
    out.show(None, *certificate_of(built))
    knots = f"{built.content.advance.size} x {built.content.beta.size}"
    size = output.stat().st_size / 1e6
    echo(f"wrote {output}: {knots} knots, {size:.2f} MB")


def _share(option: str, text: str) -> float:
    """Read 0.005 from "0.5%" or "0.005"; messages name the ``option``."""
    try:
        value = float(text[:-1]) / 100.0 if text.endswith("%") else float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0.0):
        raise InputError(f"{option} {quoted(text)} is not a fraction", "write 0.5% or 0.005")
    return value


def show_table(
    source: Annotated[Path, Argument(metavar="TABLE", help="Table of loads (.npz).")],
    format_: out.FormatOption = None,
    output: out.TextOutput = None,
) -> None:
    """Show the origin, the range and the errors of a table."""
    chosen = out.chosen_format(format_, output)
    if chosen == "csv":
        raise InputError("--format csv: the description has no columns", "use --format json")

    from propmap.export.files import origin
    from propmap.table import LoadTable

    found = LoadTable.load(source)
    if chosen == "json":
        out.emit(out.json_text({"envelope": found.envelope, **found.info}), output)
    else:
        out.show(output, *origin(found), *certificate_of(found))


def certificate_of(found: LoadTable) -> Iterator[object]:
    """Yield the errors of the table against the model and, if known, the model's uncertainty."""
    from propmap.table.certificate import PLACE, TITLES, claims, largest_at, parameter_claims

    errors = found.certificate
    if not errors:
        yield "not certified: the errors of the table against the model are unknown"
        return
    columns = {
        "max": errors["max_error"],
        "rms": errors["rms_error"],
        "max unresolved": errors["unresolved_max_error"],
    }
    parameters = found.info.get("parameter_uncertainty")
    if parameters:
        columns["parameters, median"] = parameters["median"]
        columns["parameters, 95 %"] = parameters["percentile_95"]
    places = largest_at(errors)
    heads = [*columns, *(f"at [{unit}]" for unit in PLACE.values())]
    rows = []
    for name, title in TITLES.items():
        shares = (f"{100.0 * by_load[name]:.3f} %" for by_load in columns.values())
        rows.append((title, *shares, *(f"{value:.4g}" for value in places[name] or ())))
    yield out.grid("|".join(["<error / static load", *heads]), rows, "Certificate")
    yield from claims(errors)
    yield from parameter_claims(parameters) if parameters else ()
