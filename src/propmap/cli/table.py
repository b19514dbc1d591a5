"""``propmap table``: build a certified table of a rotor's loads."""

from __future__ import annotations

import math
import shlex
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from propmap.cli.operating_points import RPM, parse_axis
from propmap.cli.output import check_output, show
from propmap.cli.rotor_options import RotorChoice, takes_rotor
from propmap.errors import InputError, quoted

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.console import Console

    from propmap.table import LoadTable
    from propmap.table.model import Progress

TITLES = {
    "thrust": "thrust / static thrust",
    "drag": "drag / static thrust",
    "torque": "torque / static torque",
    "roll_moment": "roll moment / (static thrust R)",
}


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
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
) -> None:
    """A look-up table of the loads, with its errors against the model certified."""
    ranges = (_range("rpm", rpm), _range("speed", speed), _range("beta", beta))
    share = parse_share("--tolerance", tolerance)
    check_output(output, (".npz", ".nc"), keep_existing=not force)

    from propmap.table.build import build_table, check_tolerance

    check_tolerance(share, choice.accuracy.value)
    rotor = choice.rotor()
    with _progress() as progress:
        built = build_table(
            rotor,
            omega=(ranges[0][0] * RPM, ranges[0][1] * RPM),
            speed=ranges[1],
            beta=(math.radians(ranges[2][0]), math.radians(ranges[2][1])),
            tolerance=share,
            leave_out_vortex_ring=no_vortex_ring,
            progress=progress,
        )
    _save(built, output, shlex.join(["propmap", *context.obj]))
    show(None, lambda console: _certificate(console, built))
    knots = f"{built.content.advance.size} x {built.content.beta.size}"
    size = output.stat().st_size / 1e6
    typer.echo(f"wrote {output}: {knots} knots, {size:.2f} MB")


def parse_share(option: str, text: str) -> float:
    """0.005 from "0.5%" or "0.005"; option : its name in messages."""
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
        from propmap.table.netcdf import write_netcdf

        write_netcdf(filed, output)
    else:
        filed.save(output)


@contextmanager
def _progress() -> Iterator[Progress]:
    """A line that says what is being done; how much there will be, refinement decides."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    columns: list[Any] = [
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed} operating points"),
        TimeElapsedColumn(),
    ]
    with Progress(
        *columns, console=console, disable=not console.is_terminal, transient=True
    ) as bar:
        task = bar.add_task("", total=None)
        yield lambda stage, done: bar.update(task, description=stage, completed=done)


def _certificate(console: Console, built: LoadTable) -> None:
    from rich.table import Table

    found = built.certificate
    rows = Table("error, share of static", "max", "rms", "max unresolved", title="Certificate")
    for column in rows.columns[1:]:
        column.justify = "right"
    for name, title in TITLES.items():
        figures = (found["max_error"], found["rms_error"], found["unresolved_max_error"])
        rows.add_row(title, *(f"{100.0 * by_load[name]:.3f} %" for by_load in figures))
    console.print(rows)
    points = found["points"]
    console.print(
        f"tolerance {found['tolerance']:.2%} holds on {points} points that the table was not "
        f"built from; of these {found['unresolved']} ({found['unresolved'] / points:.2%}) are "
        f"marked unresolved, {found['vortex_ring']} vortex ring, {found['no_value']} without loads"
    )
