"""``propmap demo``: the APC 8x6E against the measurements that come with propmap."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.errors import InputError

if TYPE_CHECKING:
    from propmap.cli.demo_results import Results
    from propmap.report.comparison import ErrorFigures

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
    show(None, *_told(results))
    for path in (output / "demo.csv", output / "demo.json", disk, curves):
        typer.echo(path)


def _told(results: Results) -> Iterator[object]:
    """Texts and tables on the results."""
    from propmap.cli.output import grid

    model = results.rotor.model
    yield (
        f"{model.propeller.name}, airfoil {model.law_title}, against UIUC (static, axial) and "
        "Gill & D'Andrea 2019 (oblique, their fit)"
    )
    rows = [
        (
            group.title if i == 0 else "",
            one.load.replace("_", " "),
            str(one.points),
            f"{one.measured_rms:.3g}",
            *_figures(one.model),
            *_figures(one.hover),
            one.unit,
        )
        for group in results.groups
        for i, one in enumerate(group.errors)
    ]
    yield grid(
        "<data set|<load|points|measured rms|rms|rel. [%]|worst|hover rms|rel. [%]|worst|<unit",
        rows,
        caption="errors: predicted less measured; rel.: rms error over the rms of the measured "
        "load; hover model: constants from this rotor at V = 0",
    )
    loads = [one.load.replace("_", " ") for one in results.by_angle[0].errors]
    rows_by_angle = [
        (
            f"{group.beta_deg:g}",
            *(
                f"{_percent(one.model.relative_rms)} / {_percent(one.hover.relative_rms)}"
                for one in group.errors
            ),
            str(group.errors[0].points),
        )
        for group in results.by_angle
    ]
    yield grid(
        "|".join(["beta [deg]", *loads, "points"]),
        rows_by_angle,
        "oblique, by angle: rms error over the rms of the measured load [%], this model / hover "
        "model",
    )
    yield from (f"- {line}" for line in results.notes())
    times = " and ".join(
        f"{1e6 * timing.seconds_per_point:.0f} microseconds per point with {timing.points} at once"
        for timing in results.timings
    )
    yield f"{times}, on this machine ({results.cores} cores), after the first call"


def _figures(errors: ErrorFigures) -> tuple[str, str, str]:
    return f"{errors.rms:.3g}", _percent(errors.relative_rms), f"{errors.worst:.3g}"


def _percent(share: float | None) -> str:
    return "-" if share is None else f"{100.0 * share:.1f}"
