"""``propmap study``: many designs made from a propeller, at many operating points."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from propmap.cli.options import (
    AccuracyName,
    AccuracyOption,
    Cluster,
    RotorChoice,
    progress_bar,
    workers_of,
)
from propmap.cli.output import Force, check_output, check_pictures, show
from propmap.cli.sweep import Yes, announce, check_store, opened
from propmap.errors import InputError

if TYPE_CHECKING:
    import xarray

    from propmap.study.files import StudyFile, Surface
    from propmap.study.run import InMemory, Study
    from propmap.sweep.store import Layout, Store
    from propmap.tasks import Workers

MOST_IN_MEMORY = 5_000_000
"""Operating points of a study that goes into a NetCDF file."""

SAMPLE = 4
"""Designs by which the time of a study is foretold."""


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
    from propmap.study.run import InMemory, run_study, study_layout

    read = read_study(file)
    if picture is not None and read.surface is None:
        raise InputError("--picture needs two quantities that vary", "vary another", str(file))
    choice = RotorChoice(read.propeller, airfoil=read.airfoil or None, accuracy=accuracy)
    try:
        made = read.study(choice.rotor())
    except InputError as error:
        raise InputError(error.found, error.remedy, str(file)) from None
    layout = study_layout(made, shlex.join(["propmap", *context.obj]))
    points = int(np.prod(made.shape))
    if not streamed and points > MOST_IN_MEMORY:
        raise InputError(
            f"the study has {points} points, more than the {MOST_IN_MEMORY} of a NetCDF file",
            "end the file's name with .zarr",
        )
    store = opened(output, layout) if streamed else InMemory(layout)
    with workers_of(cluster) as workers:
        _announce(made, layout, store, workers, yes=yes)
        total = store.done(layout).size
        with progress_bar("tasks") as tell:
            run_study(made, store, layout, workers, lambda done: tell(done, total))
    found = _dataset(store, output)
    if not streamed:
        from propmap.io.csv import write_dataset

        write_dataset(found, output)
    lost = int(np.isnan(found["thrust"]).sum())
    remark = f", {lost} of them without loads" if lost else ""
    typer.echo(f"wrote {output}: {made.count} designs, {points} points{remark}")
    if read.surface is not None:
        _surface(read, read.surface, made, found, picture)


def _announce(
    made: Study, layout: Layout, store: Store | InMemory, workers: Workers, *, yes: bool
) -> None:
    from propmap.study.run import Designs, loads_of_designs
    from propmap.sweep.run import seconds

    some = np.unique(np.linspace(0, made.count - 1, SAMPLE).astype(int))
    rows = {name: values[some] for name, values in made.rows.items()}
    sample = Designs(rows, {name: np.asarray(v) for name, v in made.axes.items()})
    each = seconds(workers, loads_of_designs, made, sample) / (some.size * np.prod(made.shape[1:]))
    announce(layout, store, each, workers.count, yes=yes, what="points")


def _dataset(store: Store | InMemory, output: Path) -> xarray.Dataset:
    from propmap.study.run import InMemory

    if isinstance(store, InMemory):
        return store.dataset()
    import xarray

    return xarray.open_dataset(output, engine="zarr", chunks=None)


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
        f"{', '.join(surface.names)} foretells designs left out to {surface.left_out_rms:.2g} "
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
