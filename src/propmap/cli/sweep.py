"""``propmap sweep``: loads over a grid of operating points, to NetCDF, CSV or Zarr."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.cli.bands import Bands, StdBySource, say_not_counted
from propmap.cli.cluster_option import Cluster
from propmap.cli.operating_points import parse_axis
from propmap.cli.output import Force, check_output, write_text
from propmap.cli.plausibility import say_doubts_on_points
from propmap.cli.rotor_options import RotorChoice, say_reynolds, takes_rotor
from propmap.cli.streamed_run import Yes, check_store
from propmap.errors import InputError
from propmap.io.csv import OperatingPoints, loads_csv, std_columns

if TYPE_CHECKING:
    from propmap.results import Loads
    from propmap.rotor import Rotor

CHUNK = 4096
"""Operating points per step of the progress bar: some tenths of a second."""

MOST_POINTS = 10_000_000


@takes_rotor
def sweep(
    choice: RotorChoice,
    context: typer.Context,
    rpm: Annotated[str, typer.Option("--rpm", metavar="A:B:N", help="Or 6000, or 4000,6000.")],
    speed: Annotated[str, typer.Option("--speed", metavar="A:B:N", help="Speeds [m/s].")],
    beta: Annotated[str, typer.Option("--beta", metavar="A:B:N", help="Angles [deg].")],
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="NetCDF (.nc) or CSV (.csv); or Zarr (.zarr), for grids of any size: it is "
            "written as it is computed, and a run that was stopped goes on.",
        ),
    ],
    force: Force = False,
    bands: Bands = True,
    std_by_source: StdBySource = False,
    cluster: Cluster = None,
    yes: Yes = False,
) -> None:
    """Loads over a grid of rotational speeds, flight speeds and angles."""
    axes = (
        parse_axis("--rpm", "rpm", rpm),
        parse_axis("--speed", "speed", speed),
        parse_axis("--beta", "beta", beta),
    )
    count = axes[0].size * axes[1].size * axes[2].size
    command = shlex.join(["propmap", *context.obj])
    if output.suffix.lower() == ".zarr":
        check_store(output, force=force)
        from propmap.cli.streamed_sweep import streamed_sweep

        streamed_sweep(
            choice.rotor(),
            axes,
            output,
            command,
            bands=bands,
            by_source=std_by_source,
            cluster=cluster,
            yes=yes,
        )
        return
    if cluster is not None:
        raise InputError(
            f"--cluster with {output.name}: only a Zarr store is written by many workers",
            "end the file's name with .zarr",
        )
    if count > MOST_POINTS:
        raise InputError(
            f"the grid has {count} points, more than the {MOST_POINTS} of such a file",
            "end the file's name with .zarr",
        )
    check_output(output, (".nc", ".csv", ".zarr"), keep_existing=not force)
    rotor = choice.rotor()
    points = OperatingPoints.grid(*axes)
    say_reynolds(rotor.model, *points.si)
    say_doubts_on_points(rotor.model, *points.si)
    loads = _compute(rotor, points, bands=bands)
    spread = std_columns(loads, by_source=std_by_source) if bands else {}
    if spread:
        say_not_counted(rotor.model)
    if output.suffix.lower() == ".nc":
        from propmap.cli.sweep_dataset import dataset
        from propmap.io.csv import write_dataset

        found = dataset(rotor, axes, loads, command, bands=bands, by_source=std_by_source)
        write_dataset(found, output)
    else:
        write_text(loads_csv(points, loads, spread), output)
    lost = int((loads.status == "not_converged").sum())
    remark = f", {lost} of them not converged" if lost else ""
    typer.echo(f"wrote {output}: {count} points{remark}")


def _compute(rotor: Rotor, points: OperatingPoints, *, bands: bool) -> Loads:
    from rich.console import Console
    from rich.progress import Progress

    from propmap.results import joined

    console = Console(stderr=True)
    parts = []
    with Progress(console=console, disable=not console.is_terminal, transient=True) as progress:
        task = progress.add_task("operating points", total=points.count)
        for start in range(0, points.count, CHUNK):
            part = points.part(start, CHUNK)
            found = part.loads(rotor)
            if bands:
                _ = found.std_by_source  # now, while the bar tells of the progress
            parts.append(found)
            progress.advance(task, part.count)
    return joined(parts)
