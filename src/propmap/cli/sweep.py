"""``propmap sweep``: loads over a grid of points, to NetCDF or CSV, or streamed to Zarr."""

from __future__ import annotations

import math
import shlex
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from propmap.cli.options import (
    Bands,
    Cluster,
    RotorChoice,
    StdBySource,
    parse_axis,
    progress_bar,
    say_doubts_on_points,
    say_not_counted,
    say_reynolds,
    takes_rotor,
    workers_of,
)
from propmap.cli.output import Force, check_output, write_text
from propmap.errors import InputError
from propmap.io.csv import OperatingPoints, loads_csv, std_columns
from propmap.sweep.points import RPM, Grid, parts_count, quantities
from propmap.sweep.run import Evaluation, Sweep
from propmap.sweep.store import Filed, Layout, Store, begun

if TYPE_CHECKING:
    from propmap.results import Loads
    from propmap.rotor import Rotor
    from propmap.typing import Floats


# -------------------------------------------------------------------------------------------------
# A run into a Zarr store: the store new or to go on with, its size and time told first.

ASK_ABOVE_BYTES = 1e9
ASK_ABOVE_SECONDS = 3600.0
"""Size and time from which on a run is not begun without ``--yes``."""

Yes = Annotated[
    bool,
    typer.Option("--yes", "-y", help="Do not ask before a run of over 1 GB or one hour (.zarr)."),
]


def check_store(path: Path, *, force: bool) -> None:
    """Refuse a folder that a store cannot be made in, or ``force``d away, before any work.

    Raises ``InputError`` where there is something else than a store of propmap's.
    """
    if not path.parent.is_dir():
        raise InputError(
            f"there is no folder {str(path.parent)!r}", "make it or choose another", str(path)
        )
    if path.exists():
        begun(path)
        if force:
            shutil.rmtree(path)


def opened(path: Path, layout: Layout) -> Store:
    """The store, new or to go on with; ``InputError`` where it is complete or the disk too small.

    What a run that was stopped has done is kept, and a line says so.
    """
    where = str(path)
    if not path.exists():
        free = shutil.disk_usage(path.parent).free
        if layout.bytes > free:
            raise InputError(
                f"this takes up to {size_text(layout.bytes)}, and {size_text(free)} are free",
                "choose another disk or fewer points",
                where,
            )
        return Store.create(path, layout)
    try:
        store = Store.resume(path, layout)
    except InputError:
        if (path / list(layout.quantities)[-1] / "c").exists():
            raise
        # Another run that was refused or stopped before its first task: nothing is lost.
        shutil.rmtree(path)
        return opened(path, layout)
    done = store.done(layout)
    if done.all():
        raise InputError("the store is there and complete", "pass --force to begin anew", where)
    if done.any():
        typer.echo(f"{path}: {int(done.sum())} of {done.size} tasks are done; going on", err=True)
    return store


def run_announced(
    evaluation: Evaluation,
    store: Filed,
    layout: Layout,
    cluster: str | None,
    *,
    yes: bool,
    what: str,
) -> None:
    """Run, with a progress bar, after saying how large that is and how long it takes.

    Asks first where that is much, unless ``yes``; ``what`` is "operating points" or the like.
    """
    with workers_of(cluster) as workers:
        seconds = evaluation.seconds_per_point(workers)
        points, parts = math.prod(layout.shape), parts_count(layout.shape, layout.chunk)
        needed = points * (1.0 - float(store.done(layout).mean())) * seconds / workers.count
        typer.echo(
            f"{points} {what} in {parts} task{'s' * (parts > 1)}, up to {size_text(layout.bytes)}; "
            f"about {time_text(needed)} ({1e6 * seconds:.0f} us per point and worker)",
            err=True,
        )
        if not yes and (layout.bytes > ASK_ABOVE_BYTES or needed > ASK_ABOVE_SECONDS):
            if not sys.stdin.isatty():
                raise InputError(
                    f"a run of {size_text(layout.bytes)} and {time_text(needed)} is not begun "
                    "unasked",
                    "pass --yes, or ask for fewer points",
                )
            typer.confirm("begin?", abort=True, err=True)
        with progress_bar("tasks") as tell:
            evaluation.run(store, layout, workers, tell)


def size_text(size: float) -> str:
    """A size in bytes as "1.3 GB"."""
    units = ("B", "kB", "MB", "GB", "TB", "PB")
    power = min(int(math.log10(max(size, 1.0))) // 3, len(units) - 1)
    return f"{size / 1000.0**power:.3g} {units[power]}"


def time_text(seconds: float) -> str:
    """A time as "3.5 h"."""
    for unit, length in (("years", 3.156e7), ("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * length:
            return f"{seconds / length:.3g} {unit}"
    return f"{seconds:.2g} s"


# -------------------------------------------------------------------------------------------------
# ``propmap sweep -o map.zarr``: a grid of any size, streamed.

SOME = 30
"""Values of each axis at which operating points are looked at for what is odd about them."""


def streamed_sweep(
    rotor: Rotor,
    axes: tuple[Floats, Floats, Floats],
    output: Path,
    command: str,
    *,
    bands: bool,
    by_source: bool,
    cluster: str | None,
    yes: bool,
) -> None:
    """Run or go on with a sweep over ``axes`` [1/min], [m/s], [degree] into a store."""
    grid = Grid(*axes)
    _say_doubts(rotor, axes)
    sweep = Sweep(rotor, grid, bands, by_source)
    layout = sweep.layout(command)
    if any("_std" in name for name in layout.quantities):
        say_not_counted(rotor.model)
    store = opened(output, layout)
    run_announced(sweep, store, layout, cluster, yes=yes, what="operating points")
    typer.echo(f"wrote {output}: {math.prod(layout.shape)} points")


def _say_doubts(rotor: Rotor, axes: tuple[Floats, Floats, Floats]) -> None:
    few = [axis[np.unique(np.linspace(0, axis.size - 1, SOME).astype(int))] for axis in axes]
    rpm, speed, beta = (values.ravel() for values in np.meshgrid(*few, indexing="ij"))
    points = rpm * RPM, speed, np.radians(beta)
    say_reynolds(rotor.model, *points)
    say_doubts_on_points(rotor.model, *points)


# -------------------------------------------------------------------------------------------------
# ``propmap sweep``: loads over a grid of operating points, to NetCDF, CSV or Zarr.

CHUNK = 4096
"""Operating points per step of the progress bar, at most: some tenths of a second."""

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
    evaluation = Sweep(rotor, Grid(*axes), bands, std_by_source, CHUNK)
    loads = _compute(evaluation)
    spread = std_columns(loads, by_source=std_by_source) if bands else {}
    if spread:
        say_not_counted(rotor.model)
    if output.suffix.lower() == ".nc":
        from propmap.io.csv import write_dataset

        values = quantities(loads, bands=bands, by_source=std_by_source)
        write_dataset(evaluation.layout(command).dataset(values), output)
    else:
        write_text(loads_csv(points, loads, spread), output)
    lost = int((loads.status == "not_converged").sum())
    remark = f", {lost} of them not converged" if lost else ""
    typer.echo(f"wrote {output}: {count} points{remark}")


def _compute(evaluation: Sweep) -> Loads:
    """Loads (n,) of all points in memory, with a progress bar."""
    from rich.console import Console
    from rich.progress import Progress

    from propmap.results import joined

    console = Console(stderr=True)
    parts = []
    with Progress(console=console, disable=not console.is_terminal, transient=True) as progress:
        task = progress.add_task("operating points", total=math.prod(evaluation.shape))
        for found in evaluation.in_turn():
            if evaluation.bands:
                _ = found.std_by_source  # now, while the bar tells of the progress
            parts.append(found)
            progress.advance(task, found.status.size)
    return joined(parts)
