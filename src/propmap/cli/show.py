"""``propmap show``: what a table holds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.cli.output import (
    Format,
    FormatOption,
    TextOutput,
    check_output,
    chosen_format,
    emit,
    json_text,
    show,
)
from propmap.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console


def show_table(
    source: Annotated[Path, typer.Argument(metavar="MAP", help="Table (.npz).")],
    format_: FormatOption = None,
    output: TextOutput = None,
) -> None:
    """Where a table comes from, its envelope, and its certificate."""
    if output is not None:
        check_output(output)
    chosen = chosen_format(format_, output)
    if chosen is Format.csv:
        raise InputError("what a table holds has no columns", "use --format json")

    from propmap.cli.table_report import draw_certificate
    from propmap.export.provenance import origin
    from propmap.table import LoadTable

    table = LoadTable.load(source)
    if chosen is Format.json:
        emit(json_text({"envelope": table.envelope, **table.info}), output)
        return
    lines = "\n".join(origin(table))

    def draw(console: Console) -> None:
        console.print(lines)
        draw_certificate(console, table)

    show(output, draw)
