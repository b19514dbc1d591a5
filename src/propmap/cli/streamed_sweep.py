"""``propmap sweep -o map.zarr``: a grid of any size, streamed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import typer

from propmap.cli.bands import say_not_counted
from propmap.cli.cluster_option import progress_bar, workers_of
from propmap.cli.plausibility import say_doubts_on_points
from propmap.cli.rotor_options import say_reynolds
from propmap.cli.streamed_run import announce, opened
from propmap.sweep.points import RPM, Grid, parts_along
from propmap.sweep.run import Sweep

if TYPE_CHECKING:
    from propmap.rotor import Rotor
    from propmap.typing import Floats

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
    with workers_of(cluster) as workers:
        seconds = sweep.seconds_per_point(workers)
        announce(layout, store, seconds, workers.count, yes=yes, what="operating points")
        total = int(np.prod(parts_along(layout.shape, layout.chunk)))
        with progress_bar("tasks") as tell:
            sweep.run(store, layout, workers, lambda done: tell(done, total))
    typer.echo(f"wrote {output}: {int(np.prod(layout.shape))} points")


def _say_doubts(rotor: Rotor, axes: tuple[Floats, Floats, Floats]) -> None:
    few = [axis[np.unique(np.linspace(0, axis.size - 1, SOME).astype(int))] for axis in axes]
    rpm, speed, beta = (values.ravel() for values in np.meshgrid(*few, indexing="ij"))
    points = rpm * RPM, speed, np.radians(beta)
    say_reynolds(rotor.model, *points)
    say_doubts_on_points(rotor.model, *points)
