"""``propmap vehicle``: vehicle files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from typer import Argument

from propmap.cli import output as out

vehicle_app = typer.Typer(
    name="vehicle", help="Write a vehicle file: vehicle from-log LOG.", rich_markup_mode=None
)


@vehicle_app.callback()
def _group() -> None:
    pass


@vehicle_app.command("from-log")
def vehicle_from_log(
    log: Annotated[Path, Argument(metavar="LOG", help="ULog file of PX4.")],
    output: out.TextOutput = None,
    force: out.Force = False,
) -> None:
    """Draft a vehicle file from the parameters that a PX4 log holds.

    Rotors have the places, axes and spins of CA_ROTORn_*. What the log does not say is a comment
    that begins with MISSING, without which commands refuse the file.
    """
    if output is not None:
        out.check_output(output, (".toml",), keep_existing=not force)

    from propmap.vehicle.draft import draft_vehicle, missing_in

    with out.blamed_on(log):
        text = draft_vehicle(log)
    out.emit(text, output)
    out.note(f"fill in what the log does not say: {', '.join(missing_in(text))}")
