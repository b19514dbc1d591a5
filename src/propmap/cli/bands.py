"""Columns and cells of how sure the loads are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from propmap.model.model import Model

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
