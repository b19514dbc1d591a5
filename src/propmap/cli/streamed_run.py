"""A run into a Zarr store: the store new or to go on with, its size and time told first."""

from __future__ import annotations

import math
import shutil
import sys
from pathlib import Path
from typing import Annotated

import typer

from propmap.errors import InputError
from propmap.sweep.points import parts_along
from propmap.sweep.run import Filed
from propmap.sweep.store import Layout, Store, begun

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


def announce(
    layout: Layout, store: Filed, seconds: float, workers: int, *, yes: bool, what: str
) -> None:
    """Say how large a run is and how long it takes, and ask where that is much.

    Parameters
    ----------
    layout, store : Layout, Filed
        Of the run.
    seconds : float
        That a worker takes for a point.
    workers : int
        How many there are.
    yes : bool
        Whether not to ask.
    what : str
        "operating points" or the like.
    """
    points = math.prod(layout.shape)
    parts = math.prod(parts_along(layout.shape, layout.chunk))
    left = points * (1.0 - float(store.done(layout).mean()))
    needed = left * seconds / workers
    typer.echo(
        f"{points} {what} in {parts} task{'s' * (parts > 1)}, up to {size_text(layout.bytes)}; "
        f"about {time_text(needed)} ({1e6 * seconds:.0f} us per point and worker)",
        err=True,
    )
    if yes or (layout.bytes <= ASK_ABOVE_BYTES and needed <= ASK_ABOVE_SECONDS):
        return
    if not sys.stdin.isatty():
        raise InputError(
            f"a run of {size_text(layout.bytes)} and {time_text(needed)} is not begun unasked",
            "pass --yes, or ask for fewer points",
        )
    typer.confirm("begin?", abort=True, err=True)


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
