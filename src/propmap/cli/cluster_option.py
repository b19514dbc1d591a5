"""``--cluster``: who does the work, and how far it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Annotated

import typer

from propmap.errors import InputError
from propmap.tasks import InTurn, Workers

Cluster = Annotated[
    str | None,
    typer.Option(
        "--cluster",
        metavar="local[:N]|tcp://HOST:PORT",
        help="Work on N processes of this machine, by default one per core, or on the workers of a "
        "Dask scheduler. Results are the same.",
    ),
]


@contextmanager
def workers_of(cluster: str | None, otherwise: Workers | None = None) -> Iterator[Workers]:
    """The workers that ``--cluster`` asks for; without it ``otherwise``, by default this process.

    A line on standard error says how many, and where their dashboard is.
    """
    if cluster is None:
        yield otherwise or InTurn()
        return
    from propmap.cluster.workers import connected

    with connected(cluster) as workers:
        typer.echo(
            f"{workers.count} worker threads, dashboard at {workers.client.dashboard_link}",
            err=True,
        )
        yield workers


def workers_of_bootstrap(cluster: str | None, bootstrap: int) -> AbstractContextManager[Workers]:
    """The same for a fit, of which only the refits of ``bootstrap`` are independent tasks."""
    if cluster is not None and not bootstrap:
        raise InputError(
            "--cluster spreads the refits of --bootstrap, of which there are none",
            "give --bootstrap 200, or leave --cluster out",
        )
    return workers_of(cluster)


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on a terminal, told how much is done and of how much; with what is left."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left:"),
        TimeRemainingColumn(),
    )
    with Progress(
        *columns, console=console, disable=not console.is_terminal, transient=True
    ) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
