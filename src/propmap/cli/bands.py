"""Columns and cells of how sure the loads are."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.loads import LOADS

if TYPE_CHECKING:
    from propmap.arrays.types import Floats
    from propmap.model.model import Model
    from propmap.results import Loads, LoadValues

Bands = Annotated[
    bool,
    typer.Option(
        "--bands/--no-bands",
        help="Standard deviations or bands of the loads, where the constants or the blade say "
        "how well they are known.",
    ),
]
StdBySource = Annotated[
    bool,
    typer.Option(
        "--std-by-source",
        help="Standard deviations by what they are from, too: parameters of the section law, "
        "geometry that was not measured, discrepancy of the model, another tunnel.",
    ),
]


def std_columns(loads: Loads, *, by_source: bool) -> dict[str, Floats]:
    """Standard deviations by their columns in files, "thrust_std_N" or "thrust_std_tunnel_N".

    Parameters
    ----------
    loads : Loads
        With deviations, else there are no columns.
    by_source : bool
        Whether there is a column for each source, too.
    """
    if not loads.std_by_source:
        return {}
    found = dict(_columns("std", loads.std))
    if by_source:
        for source, values in loads.std_by_source.items():
            found.update(_columns(f"std_{source}", values))
    return found


def say_not_counted(model: Model) -> None:
    """Name constants of which the data of a fit said nothing, on standard error."""
    known = model.uncertainty
    if known is not None and known.covariance.unknown:
        names = ", ".join(known.covariance.unknown)
        typer.echo(
            f"note: standard deviations do not count {names}, of which the data of the fit say "
            "nothing",
            err=True,
        )


def _columns(what: str, values: LoadValues) -> Iterator[tuple[str, Floats]]:
    for name, load in LOADS.items():
        yield load.column_of(what), getattr(values, name)
    yield f"power_{what}_W", values.power
