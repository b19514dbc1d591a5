"""What is printed of a table: progress while it is built, and its certificate."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

    from propmap.table import LoadTable
    from propmap.table.model import Progress

TITLES = {
    "thrust": "thrust / static thrust",
    "drag": "drag / static thrust",
    "torque": "torque / static torque",
    "roll_moment": "roll moment / (static thrust R)",
}


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


def draw_certificate(console: Console, table: LoadTable) -> None:
    """Print how far the table is from the model, and the model's own uncertainty if it is known."""
    from rich.table import Table

    found = table.certificate
    if not found:
        console.print("not certified: how far the table is from the model is not known")
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
    rows = Table("error, share of static", title="Certificate")
    for title in columns:
        rows.add_column(title, justify="right")
    for name, title in TITLES.items():
        rows.add_row(title, *(f"{100.0 * by_load[name]:.3f} %" for by_load in columns.values()))
    console.print(rows)
    console.print("\n".join([*_claims(found), *(_of_parameters(parameters) if parameters else ())]))


def _claims(found: dict[str, Any]) -> Iterator[str]:
    told = f"tolerance {found['tolerance']:.2%} holds on {found['points']} points that the table "
    yield told + "was not built from" + (", unresolved cells apart" if _cells(found) else "")
    if _cells(found):
        worst = max(found["unresolved_max_error"].values())
        yield (
            f"unresolved: {_cells(found)} cells, {found['unresolved_volume']:.2%} of the envelope, "
            f"where the model's loads jump; there errors reach {worst:.2%} on "
            f"{found['unresolved_points']} points"
        )
    yield (
        f"of the {found['points']} points, {found['vortex_ring']} are vortex ring and "
        f"{found['no_value']} without loads"
    )


def _cells(found: dict[str, Any]) -> int:
    return int(found["unresolved_cells"])


def _of_parameters(found: dict[str, Any]) -> Iterator[str]:
    yield (
        "parameters: standard deviation of the loads by the fit's covariance of "
        f"{', '.join(found['parameters'])}, on {found['points']} points"
    )
    if found["not_counted"]:
        yield f"not counted, the fit's data say nothing of them: {', '.join(found['not_counted'])}"
