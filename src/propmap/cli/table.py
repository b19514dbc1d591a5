"""``propmap table``: build a certified table of a rotor's loads."""

from __future__ import annotations

import math
import shlex
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from propmap.cli.options import (
    Cluster,
    RotorChoice,
    parse_axis,
    say_doubts_on_points,
    say_reynolds,
    takes_rotor,
    workers_of,
)
from propmap.cli.output import Force, check_output, show
from propmap.cli.table_report import building, told
from propmap.errors import InputError, quoted
from propmap.units import RPM

if TYPE_CHECKING:
    from propmap.table import LoadTable


@takes_rotor
def table(
    choice: RotorChoice,
    context: typer.Context,
    rpm: Annotated[str, typer.Option("--rpm", metavar="A:B", help="Rotational speeds [1/min].")],
    speed: Annotated[str, typer.Option("--speed", metavar="A:B", help="Speeds [m/s].")],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE", help="Table (.npz) or NetCDF (.nc).")
    ],
    beta: Annotated[
        str, typer.Option("--beta", metavar="A:B", help="Angles [deg] within 0:180.")
    ] = "0:180",
    tolerance: Annotated[
        str, typer.Option("--tolerance", metavar="SHARE", help="Of the static loads: 0.5%.")
    ] = "0.5%",
    no_vortex_ring: Annotated[
        bool, typer.Option("--no-vortex-ring", help="NaN in the vortex ring state.")
    ] = False,
    force: Force = False,
    cluster: Cluster = None,
) -> None:
    """A look-up table of the loads, with its errors against the model certified."""
    ranges = (_range("rpm", rpm), _range("speed", speed), _range("beta", beta))
    share = _share("--tolerance", tolerance)
    check_output(output, (".npz", ".nc"), keep_existing=not force)

    from propmap.table.build import build_table, check_tolerance

    check_tolerance(share, choice.accuracy.value)
    rotor = choice.rotor()
    ends = np.meshgrid(*(np.array(pair) for pair in ranges), indexing="ij")
    corners = ends[0] * RPM, ends[1], np.radians(ends[2])
    say_reynolds(rotor.model, *corners)
    say_doubts_on_points(rotor.model, *corners)
    with workers_of(cluster) as workers, building() as progress:
        built = build_table(
            rotor,
            omega=(ranges[0][0] * RPM, ranges[0][1] * RPM),
            speed=ranges[1],
            beta=(math.radians(ranges[2][0]), math.radians(ranges[2][1])),
            tolerance=share,
            leave_out_vortex_ring=no_vortex_ring,
            progress=progress,
            workers=workers,
        )
    _save(built, output, shlex.join(["propmap", *context.obj]))
    show(None, *told(built))
    knots = f"{built.content.advance.size} x {built.content.beta.size}"
    size = output.stat().st_size / 1e6
    typer.echo(f"wrote {output}: {knots} knots, {size:.2f} MB")


def _share(option: str, text: str) -> float:
    """0.005 from "0.5%" or "0.005" of an ``option``."""
    try:
        value = float(text[:-1]) / 100.0 if text.endswith("%") else float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0.0):
        raise InputError(f"{option} {quoted(text)} is no share", "write 0.5% or 0.005")
    return value


def _range(quantity: str, text: str) -> tuple[float, float]:
    option = f"--{quantity}"
    if text.count(":") != 1:
        raise InputError(f"{option} {quoted(text)} is no range", "write A:B, from A to B")
    low, high = parse_axis(option, quantity, text, count=2).tolist()
    return low, high


def _save(built: LoadTable, output: Path, command: str) -> None:
    from propmap.table import LoadTable

    content = replace(built.content, info={**built.info, "command": command})
    filed = LoadTable(content)
    if output.suffix.lower() == ".nc":
        from propmap.table.files import write_netcdf

        write_netcdf(filed, output)
    else:
        filed.save(output)
