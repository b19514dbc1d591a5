"""``propmap demo``: the APC 8x6E against the measurements that come with propmap."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from propmap.errors import InputError

OutputFolder = Annotated[
    Path, typer.Option("--output", "-o", metavar="FOLDER", help="Where the files go.")
]


def demo(output: OutputFolder = Path("propmap-demo")) -> None:
    """Compare the recommended, the paper's and the hover model with measurements of an APC 8x6E."""
    if output.exists() and not output.is_dir():
        raise InputError("this is a file", "name a folder", str(output))
    output.mkdir(parents=True, exist_ok=True)

    from propmap.cli.demo_results import compute, notes, told, write_pictures, write_tables
    from propmap.cli.output import show

    results = compute()
    write_tables(results, output, notes(results))
    curves, disk = write_pictures(results, output)
    show(None, *told(results))
    for path in (output / "demo.csv", output / "demo.json", disk, curves):
        typer.echo(path)
