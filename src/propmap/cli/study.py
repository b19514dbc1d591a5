"""``propmap study``: many designs made from a propeller, at many operating points."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from propmap.cli.options import AccuracyName, AccuracyOption, Cluster, RotorChoice
from propmap.cli.output import Force, check_output, check_pictures, show
from propmap.cli.sweep import Yes, check_store, opened, run_announced
from propmap.errors import InputError

if TYPE_CHECKING:
    import xarray

    from propmap.study.files import StudyFile, Surface
    from propmap.study.run import Study

MOST_IN_MEMORY = 5_000_000
"""Operating points of a study that goes into a NetCDF file."""


def study(
    context: typer.Context,
    file: Annotated[Path, typer.Argument(metavar="FILE.toml", help="What varies, and where.")],
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="NetCDF (.nc); or Zarr (.zarr), for studies of any size: a run that was stopped "
            "goes on.",
        ),
    ],
    picture: Annotated[
        Path | None,
        typer.Option("--picture", metavar="FILE", help="Response surface: .png, .svg or .pdf."),
    ] = None,
    accuracy: AccuracyOption = AccuracyName.standard,
    cluster: Cluster = None,
    force: Force = False,
    yes: Yes = False,
) -> None:
    """Loads of designs that differ in geometry and operating point, with a response surface."""
    streamed = output.suffix.lower() == ".zarr"
    if streamed:
        check_store(output, force=force)
    else:
        check_output(output, (".nc", ".zarr"), keep_existing=not force)
    check_pictures(picture)

    from propmap.study.files import read_study
    from propmap.sweep.store import InMemory

    read = read_study(file)
    if picture is not None and read.surface is None:
        raise InputError("--picture needs two quantities that vary", "vary another", str(file))
    choice = RotorChoice(read.propeller, airfoil=read.airfoil or None, accuracy=accuracy)
    try:
        made = read.study(choice.rotor())
    except InputError as error:
        raise InputError(error.found, error.remedy, str(file)) from None
    layout = made.layout(shlex.join(["propmap", *context.obj]))
    points = int(np.prod(made.shape))
    if not streamed and points > MOST_IN_MEMORY:
        raise InputError(
            f"the study has {points} points, more than the {MOST_IN_MEMORY} of a NetCDF file",
            "end the file's name with .zarr",
        )
    store = opened(output, layout) if streamed else InMemory(layout)
    run_announced(made, store, layout, cluster, yes=yes, what="points")
    if isinstance(store, InMemory):
        from propmap.io.csv import write_dataset

        found = store.dataset()
        write_dataset(found, output)
    else:
        import xarray

        found = xarray.open_dataset(output, engine="zarr", chunks=None)
    lost = int(np.isnan(found["thrust"]).sum())
    remark = f", {lost} of them without loads" if lost else ""
    typer.echo(f"wrote {output}: {made.count} designs, {points} points{remark}")
    if read.surface is not None:
        _surface(read, read.surface, made, found, picture)


def _surface(
    read: StudyFile, asked: Surface, made: Study, found: xarray.Dataset, picture: Path | None
) -> None:
    """Fit the surface, say how good it is, and draw it."""
    from propmap.study.files import response_surface
    from propmap.study.run import VARIABLES
    from propmap.sweep.points import AXES, TEXTS

    at: dict[str, Any] = {}
    told = []
    for dim, (name, unit, _) in AXES.items():
        if name in made.axes:
            values = made.axes[name]
            index = int(np.argmin(np.abs(values - asked.at.get(name, values[0]))))
            at[dim] = index
            value, word = f"{values[index]:g}", name.partition("_")[0]
            told.append(f"{value} rpm" if word == "rpm" else f"{word} {value} {unit}")
    values = found[asked.quantity].isel(at).values
    surface = response_surface(made.rows, values)
    unit, _ = TEXTS[asked.quantity]
    show(
        None,
        f"{asked.quantity} at {', '.join(told) or 'the points of the designs'}: "
        f"{np.nanmin(values):.4g} to {np.nanmax(values):.4g} {unit}; a quadratic of "
        f"{', '.join(surface.names)} predicts designs left out to {surface.left_out_rms:.2g} "
        f"{unit} rms",
    )
    if picture is None:
        return
    from propmap.report.html import save
    from propmap.report.pictures import response_picture

    labels = tuple(
        f"{name.replace('_', ' ')} [{VARIABLES[name][0]}]" for name in (asked.across, asked.up)
    )
    title = f"{read.title}: {', '.join(told)}" if told else read.title
    figure = response_picture(
        title,
        f"{asked.quantity.replace('_', ' ')} [{unit}]",
        surface,
        (asked.across, asked.up),
        (labels[0], labels[1]),
        made.rows,
        values,
    )
    save(figure, picture)
    typer.echo(f"wrote {picture}", err=True)
