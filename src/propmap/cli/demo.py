"""``propmap demo``: the APC 8x6E against the measurements that come with propmap."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from propmap.cli.demo_results import Results

OutputFolder = Annotated[
    Path, typer.Option("--output", "-o", metavar="FOLDER", help="Where the files go.")
]


def demo(output: OutputFolder = Path("propmap-demo")) -> None:
    """Compare the model, and the hover model, with measurements of the APC 8x6E."""
    if output.exists() and not output.is_dir():
        raise InputError("this is a file", "name a folder", str(output))
    output.mkdir(parents=True, exist_ok=True)

    from propmap.cli.demo_results import compute, write_pictures, write_tables
    from propmap.cli.output import show
    from propmap.engine.compilation import keep_compiled

    keep_compiled()
    results = compute()
    write_tables(results, output)
    curves, disk = write_pictures(results, output)

    def draw(console: Console) -> None:
        _print(console, results)
        for path in (output / "demo.csv", output / "demo.json", disk, curves):
            console.print(str(path), soft_wrap=True)

    show(None, draw)


def _print(console: Console, results: Results) -> None:
    from rich.table import Table

    rotor = results.rotor
    console.print(
        f"{rotor.model.propeller.name}, airfoil {rotor.model.airfoil.name}, against "
        "UIUC (static, axial) and Gill & D'Andrea 2019 (oblique, their fit)"
    )
    table = Table(
        caption="errors: predicted less measured; rel.: rms error over the rms of the measured "
        "load; hover model: constants from this rotor at V = 0",
        caption_justify="left",
    )
    table.add_column("data set", no_wrap=True)
    table.add_column("load", no_wrap=True)
    heads = ["points", "measured rms", "rms", "rel. [%]", "worst"]
    for head in [*heads, "hover rms", "rel. [%]", "worst", "unit"]:
        table.add_column(head, justify="right")
    for group in results.groups:
        for i, one in enumerate(group.errors):
            table.add_row(
                group.title if i == 0 else "",
                one.load.replace("_", " "),
                str(one.points),
                f"{one.measured_rms:.3g}",
                f"{one.model.rms:.3g}",
                _percent(one.model.relative_rms),
                f"{one.model.worst:.3g}",
                f"{one.hover.rms:.3g}",
                _percent(one.hover.relative_rms),
                f"{one.hover.worst:.3g}",
                one.unit,
                end_section=i == len(group.errors) - 1,
            )
    console.print(table)
    console.print(_by_angle(results))
    for line in results.notes():
        console.print(f"- {line}")
    times = " and ".join(
        f"{1e6 * timing.seconds_per_point:.0f} microseconds per point with {timing.points} at once"
        for timing in results.timings
    )
    console.print(f"{times}, on this machine ({results.cores} cores), after the first call")


def _by_angle(results: Results) -> object:
    from rich.table import Table

    table = Table(
        title="oblique, by angle: rms error over the rms of the measured load [%], "
        "this model / hover model",
        title_justify="left",
    )
    table.add_column("beta [deg]", justify="right")
    for one in results.by_angle[0].errors:
        table.add_column(one.load.replace("_", " "), justify="right")
    table.add_column("points", justify="right")
    for group in results.by_angle:
        pairs = [
            f"{_percent(one.model.relative_rms)} / {_percent(one.hover.relative_rms)}"
            for one in group.errors
        ]
        table.add_row(f"{group.beta_deg:g}", *pairs, str(group.errors[0].points))
    return table


def _percent(share: float | None) -> str:
    return "-" if share is None else f"{100.0 * share:.1f}"
