"""``propmap sweep`` and ``propmap study``: loads on a grid of operating points or of designs."""

from __future__ import annotations

import math
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any

import numpy as np
import typer
from rich.filesize import decimal
from typer import Argument, Option, echo

from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.errors import InputError
from propmap.io.csv import OperatingPoints, check_place, loads_csv, write_dataset
from propmap.results import STATUSES
from propmap.study.files import read_study
from propmap.sweep.points import Grid, column_of, parts_count
from propmap.sweep.run import (
    POINTS_PER_TASK,
    Evaluation,
    Filed,
    InMemory,
    Layout,
    Store,
    Sweep,
    begun,
)

# --- Runs into a Zarr store, new or resumed; the command prints size and time first --------------

ASK_ABOVE_BYTES = 1e9
ASK_ABOVE_SECONDS = 3600.0  # larger or longer runs need a confirmation or ``--yes``

Yes = Annotated[
    bool,
    Option("--yes", "-y", help="Do not ask before runs of more than one hour or 1 GB of output."),
]


def check_store(path: Path, *, force: bool) -> None:
    """Raise ``InputError`` if a store can be neither created nor resumed; ``force`` deletes it."""
    if check_place(path, str(path)):
        store = Store(path, begun(path)["run"])
        if force:
            with store.alone():
                shutil.rmtree(path)


def opened(path: Path, layout: Layout) -> Store:
    """Create or resume the store; raise ``InputError`` if it is complete or too large."""
    where = str(path)
    if not path.exists():
        free = shutil.disk_usage(path.parent).free
        if layout.bytes > free:
            found = f"the store needs up to {decimal(layout.bytes)}, but {decimal(free)} are free"
            raise InputError(found, "choose another disk or fewer points", where)
        return Store.create(path, layout)
    try:
        store = Store.resume(path, layout)
    except InputError:
        if (path / list(layout.quantities)[-1] / "c").exists():
            raise
        # The store of another run that stopped before its first task contains no results.
        shutil.rmtree(path)
        return opened(path, layout)
    done = store.done(layout)
    if done.all():
        raise InputError("the store is complete", "pass --force to compute it again", where)
    if done.any():
        echo(f"{path}: {int(done.sum())} of {done.size} tasks are done; resuming", err=True)
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
    """Print size and time of a run, ask before a large run unless ``yes`` is set, and run it with a
    progress bar; ``what`` names the points, such as "operating points"."""
    with opt.workers_of(cluster) as workers:
        seconds = evaluation.seconds_per_point(workers)
        points, parts = math.prod(layout.shape), parts_count(layout.shape, layout.chunk)
        needed = points * (1.0 - float(store.done(layout).mean())) * seconds / workers.count
        echo(
            f"{points} {what} in {parts} task{'s' * (parts > 1)}, up to {decimal(layout.bytes)}; "
            f"about {time_text(needed)} ({1e6 * seconds:.0f} us per point and worker)",
            err=True,
        )
        if not yes and (layout.bytes > ASK_ABOVE_BYTES or needed > ASK_ABOVE_SECONDS):
            if not sys.stdin.isatty():
                found = f"a run of {decimal(layout.bytes)} and {time_text(needed)} needs a "
                found += "confirmation"
                raise InputError(found, "pass --yes, or reduce the number of points")
            typer.confirm("start the run?", abort=True, err=True)
        with out.progress_bar("tasks") as update:
            evaluation.run(store, layout, workers, update)


def time_text(seconds: float) -> str:
    """Return a time in seconds as text such as "3.5 h"."""
    for unit, length in (("years", 3.156e7), ("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * length:
            return f"{seconds / length:.3g} {unit}"
    return f"{seconds:.2g} s"


# --- ``propmap sweep``: loads on a grid of operating points, to NetCDF, CSV or Zarr --------------

CHUNK = 4096  # operating points per task in memory: some tenths of a second
MOST_POINTS = 10_000_000  # of a grid that is computed in memory
SOME = 30  # values of each axis that a sweep checks for plausibility


@opt.takes_choices
def sweep(
    choice: opt.RotorChoice,
    context: typer.Context,
    rpm: Annotated[
        str, Option(metavar="A:B:N", help=f"Rotational speeds in rpm, {opt.AXIS_HELP}.")
    ],
    speed: Annotated[str, Option(metavar="A:B:N", help=f"Airspeeds in m/s, {opt.AXIS_HELP}.")],
    beta: Annotated[
        str, Option(metavar="A:B:N", help=f"{opt.BETA_HELP} in degrees, {opt.AXIS_HELP}.")
    ],
    output: Annotated[
        Path,
        out.output_option(
            "Output file: NetCDF (.nc), CSV (.csv) or, for grids of any size, Zarr (.zarr). "
            "After an interruption, run the command again to complete the Zarr store."
        ),
    ],
    force: out.Force = False,
    bands: opt.Bands = True,
    std_by_source: opt.StdBySource = False,
    cluster: opt.Cluster = None,
    yes: Yes = False,
) -> None:
    """Compute the loads of a propeller on a grid of operating points."""
    opt.check_bands(bands, std_by_source)
    axes = (
        opt.parse_axis("--rpm", "rpm", rpm),
        opt.parse_axis("--speed", "speed", speed),
        opt.parse_axis("--beta", "beta", beta),
    )
    streamed = output.suffix.lower() == ".zarr"
    if streamed:
        check_store(output, force=force)
    else:
        out.check_output(output, (".nc", ".csv", ".zarr"), keep_existing=not force)
    count = math.prod(axis.size for axis in axes)
    if not streamed and count > MOST_POINTS:
        found = f"the grid has {count} points, more than the {MOST_POINTS} of a .nc or .csv file"
        raise InputError(found, "use the file extension .zarr")
    size = POINTS_PER_TASK if streamed else CHUNK
    made = Sweep(choice.rotor(), Grid(*axes), bands, std_by_source, size)
    few = [axis[np.unique(np.linspace(0, axis.size - 1, SOME).astype(int))] for axis in axes]
    opt.note_points(made.rotor.model, *OperatingPoints.grid(*few).si)
    layout = made.layout(opt.command_line(context))
    if any("_std" in name for name in layout.quantities):
        opt.note_not_counted(made.rotor.model)
    if streamed:
        kept = opened(output, layout)
        run_announced(made, kept, layout, cluster, yes=yes, what="operating points")
        echo(f"wrote {output}: {count} points")
        return
    store = InMemory(layout)
    with opt.workers_of(cluster) as workers, out.progress_bar("tasks") as update:
        made.run(store, layout, workers, update)
    if output.suffix.lower() == ".csv":
        values = {name: each.ravel() for name, each in store.values.items()}
        spread = {column_of(name): each for name, each in values.items() if "_std" in name}
        loads: Any = SimpleNamespace(**{**values, "status": np.array(STATUSES)[values["status"]]})
        out.write_text(loads_csv(OperatingPoints.grid(*axes), loads, spread), output)
    else:
        write_dataset(store.dataset(), output, new=not force)
    lost = int(np.sum(store.values["status"] == STATUSES.index("not_converged")))
    remark = f", {lost} not converged" if lost else ""
    echo(f"wrote {output}: {count} points{remark}")


# --- ``propmap study``: many designs derived from a propeller, at many operating points ----------

MOST_IN_MEMORY = 5_000_000  # operating points of a study that goes into a NetCDF file


def study(
    context: typer.Context,
    file: Annotated[
        Path,
        Argument(metavar="FILE.toml", help="Study file: varied quantities and operating points."),
    ],
    output: Annotated[
        Path,
        out.output_option(
            "Output file: NetCDF (.nc) or, for studies of any size, Zarr (.zarr). After "
            "an interruption, run the command again to complete the Zarr store."
        ),
    ],
    accuracy: opt.AccuracyOption = "standard",
    cluster: opt.Cluster = None,
    force: out.Force = False,
    yes: Yes = False,
) -> None:
    """Compute the loads of many variants of a propeller."""
    streamed = output.suffix.lower() == ".zarr"
    if streamed:
        check_store(output, force=force)
    else:
        out.check_output(output, (".nc", ".zarr"), keep_existing=not force)
    read = read_study(file)
    choice = opt.RotorChoice(read.propeller, airfoil=read.airfoil or None, accuracy=accuracy)
    with out.blamed_on(file):
        made = read.study(choice.rotor())
    layout = made.layout(opt.command_line(context))
    points = math.prod(made.shape)
    if not streamed and points > MOST_IN_MEMORY:
        fault = f"the study has {points} points, but a NetCDF file has at most {MOST_IN_MEMORY}"
        raise InputError(fault, "use the file extension .zarr")
    store = opened(output, layout) if streamed else InMemory(layout)
    run_announced(made, store, layout, cluster, yes=yes, what="points")
    if isinstance(store, InMemory):
        found = store.dataset()
        write_dataset(found, output, new=not force)
    else:
        import xarray

        found = xarray.open_dataset(output, engine="zarr", chunks=None)
    lost = int(np.isnan(found["thrust"]).sum())
    remark = f", {lost} without loads" if lost else ""
    echo(f"wrote {output}: {made.count} designs, {points} points{remark}")
