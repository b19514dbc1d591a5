"""``propmap show``: what a table holds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from propmap.cli.output import (
    Format,
    FormatOption,
    TextOutput,
    chosen_format,
    emit,
    json_text,
    show,
)
from propmap.errors import InputError


def show_table(
    source: Annotated[Path, typer.Argument(metavar="TABLE", help="Table (.npz).")],
    format_: FormatOption = None,
    output: TextOutput = None,
) -> None:
    """Where a table comes from, its envelope, and its certificate."""
    chosen = chosen_format(format_, output)
    if chosen is Format.csv:
        raise InputError("what a table holds has no columns", "use --format json")

    from propmap.cli.table_report import told
    from propmap.export.files import origin
    from propmap.table import LoadTable

    table = LoadTable.load(source)
    if chosen is Format.json:
        emit(json_text({"envelope": table.envelope, **table.info}), output)
    else:
        show(output, *origin(table), *told(table))
