"""What is printed of a table: progress while it is built, and its certificate."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from propmap.cli.output import grid
from propmap.report.words import PLACE, TITLES, claims, largest_at, parameter_claims

if TYPE_CHECKING:
    from propmap.table import LoadTable
    from propmap.table.build import Progress


@contextmanager
def building() -> Iterator[Progress]:
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


def told(table: LoadTable) -> Iterator[object]:
    """How far the table is from the model, and the model's own uncertainty if it is known."""
    found = table.certificate
    if not found:
        yield "not certified: how far the table is from the model is not known"
        return
    columns = {
        "max": found["max_error"],
        "rms": found["rms_error"],
        "max unresolved": found["unresolved_max_error"],
    }
    parameters = table.info.get("parameter_uncertainty")
    if parameters:
        columns |= {
            "parameters, median": parameters["median"],
            "parameters, 95 %": parameters["percentile_95"],
        }
    places = largest_at(found)
    heads = [*columns, *(f"at [{unit}]" for unit in PLACE.values() if places)]
    rows = [
        (
            title,
            *(f"{100.0 * by_load[name]:.3f} %" for by_load in columns.values()),
            *(f"{value:.4g}" for value in places.get(name) or ()),
        )
        for name, title in TITLES.items()
    ]
    yield grid("|".join(["<error, share of static", *heads]), rows, "Certificate")
    yield from claims(found)
    yield from parameter_claims(parameters) if parameters else ()
