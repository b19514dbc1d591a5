"""``propmap props``: the catalogue of propellers."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from propmap import catalogue
from propmap.catalogue.lookup import propeller
from propmap.cli.listing import ListByDefault
from propmap.cli.output import (
    PICTURES,
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
from propmap.cli.rotor_options import Blades, PropArgument, Radius

if TYPE_CHECKING:
    from rich.console import Console

    from propmap.model.propeller import Propeller

ENTRY = ("name", "title", "family", "blades", "diameter_m", "source")
OUTLINE_WIDTH = 72
"""Characters from the axis to the tip."""

props_app = typer.Typer(
    name="props",
    cls=ListByDefault,
    help="Propellers: props [TEXT] lists, props show NAME shows.",
    rich_markup_mode=None,
)


@props_app.command("list")
def list_props(
    words: Annotated[
        list[str] | None, typer.Argument(metavar="[TEXT]...", help="Words to search for.")
    ] = None,
    format_: FormatOption = None,
    output: TextOutput = None,
) -> None:
    """List the catalogue, or what in it matches all words."""
    if output is not None:
        check_output(output)
    text = " ".join(words or [])
    entries = catalogue.search(text)
    rows = [asdict(entry) for entry in entries]
    chosen = chosen_format(format_, output)
    if chosen is Format.json:
        emit(json_text(rows), output)
        return
    if chosen is Format.csv:
        emit(csv_text(ENTRY, rows), output)
        return

    from rich.table import Table

    table = Table()
    table.add_column("name", no_wrap=True)
    table.add_column("propeller")
    table.add_column("blades", justify="right")
    table.add_column("diameter [mm]", justify="right")
    for entry in entries:
        table.add_row(entry.name, entry.title, str(entry.blades), f"{1e3 * entry.diameter_m:.1f}")

    def draw(console: Console) -> None:
        if entries:
            console.print(table)
        found = f" with {text!r}" if text else ""
        console.print(f"{len(entries)} propellers{found}")

    show(output, draw)


@props_app.command("show")
def show_prop(
    prop: PropArgument,
    blades: Blades = None,
    radius: Radius = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE", help="Picture as well: .png, .svg, .pdf."),
    ] = None,
) -> None:
    """A propeller's stations, where they are from, and its outline."""
    if output is not None:
        check_output(output, PICTURES)
    blade = propeller(prop, blades, radius)
    show(None, lambda console: _print(console, blade))
    if output is not None:
        from propmap.report.planform import planform
        from propmap.report.style import save

        save(planform(blade), output)
        typer.echo(output)


def _print(console: Console, blade: Propeller) -> None:
    from rich.table import Table
    from rich.text import Text

    table = Table()
    for head in ("radius [m]", "r/R", "chord [mm]", "twist [deg]"):
        table.add_column(head, justify="right")
    for y, c, twist in zip(blade.station, blade.chord, blade.twist, strict=True):
        cells = (f"{y:.5f}", f"{y / blade.radius:.4f}", f"{1e3 * c:.3f}")
        table.add_row(*cells, f"{np.degrees(twist):.2f}")
    heading = f"{blade.name}: {blade.blades} blades, radius {blade.radius:.5g} m"
    console.print(Text(f"{heading}, loaded from {blade.root:.5g} m"))
    console.print(table)
    console.print(Text("\n".join(outline(blade)), no_wrap=True))
    console.print(Text(f"source: {blade.source or 'not given'}"))
    console.print(Text(f"citation: {blade.citation or 'not given'}"))


def outline(blade: Propeller) -> list[str]:
    """The blade about mid-chord in half-block characters, the axis at the left, to scale.

    A character is taken to be twice as high as wide, so a half block is as high as wide.
    """
    step = blade.radius / OUTLINE_WIDTH
    middles = (np.arange(OUTLINE_WIDTH) + 0.5) * step
    chord = np.interp(middles, blade.station, blade.chord, left=0.0)
    # A blade thinner than a half block is still drawn.
    chord = np.where(middles >= blade.station[0], np.maximum(chord, step), 0.0)
    rows = max(2, 2 * int(np.ceil(chord.max() / step / 2.0)))
    heights = (np.arange(rows) + 0.5 - 0.5 * rows) * step
    filled = np.abs(heights[:, None]) < 0.5 * chord
    marks = np.array([" ", "▀", "▄", "█"])
    lines = marks[filled[0::2].astype(int) + 2 * filled[1::2]]
    hub = rows // 4
    lines[hub, 0] = "┼"
    return ["".join(line).rstrip() for line in lines]
