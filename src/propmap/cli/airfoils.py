"""``propmap airfoils``: the named parameter sets of the section law."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from propmap.cli.listing import ListByDefault
from propmap.cli.output import (
    Format,
    FormatOption,
    TextOutput,
    check_output,
    chosen_format,
    csv_text,
    emit,
    json_text,
    show,
)
from propmap.cli.rotor_options import constants
from propmap.model.airfoil import airfoil_names, parameter_set

if TYPE_CHECKING:
    from rich.console import Console

airfoils_app = typer.Typer(
    name="airfoils",
    cls=ListByDefault,
    help="Section laws: list them, or airfoils show NAME.",
    rich_markup_mode=None,
)


@airfoils_app.command("list")
def list_airfoils(format_: FormatOption = None, output: TextOutput = None) -> None:
    """List the parameter sets that come with propmap."""
    if output is not None:
        check_output(output)
    sets = [parameter_set(name) for name in airfoil_names()]
    rows = [asdict(one) for one in sets]
    chosen = chosen_format(format_, output)
    if chosen is Format.json:
        emit(json_text(rows), output)
        return
    if chosen is Format.csv:
        emit(csv_text(list(rows[0]), rows), output)
        return

    from rich.table import Table

    table = Table()
    table.add_column("name", no_wrap=True)
    for head in ("c_l1 [1/rad]", "c_l2", "c_d", "alpha_0 [deg]", "zero lift [deg]"):
        table.add_column(head, justify="right")
    table.add_column("source")
    for one in sets:
        angles = (f"{np.degrees(a):.1f}" for a in (one.alpha_0, one.zero_lift_angle))
        table.add_row(
            one.name, f"{one.c_l1:g}", f"{one.c_l2:g}", f"{one.c_d:g}", *angles, one.source
        )

    def draw(console: Console) -> None:
        console.print(table)

    show(output, draw)


@airfoils_app.command("show")
def show_airfoil(
    name: Annotated[str, typer.Argument(metavar="NAME|FILE", help="Parameter set or TOML file.")],
    output: TextOutput = None,
) -> None:
    """Print a parameter set as TOML, a template for one's own."""
    if output is not None:
        check_output(output, (".toml",))
    emit(constants(name).to_toml(), output)
