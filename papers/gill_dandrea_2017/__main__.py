"""``propmap reproduce``: the paper's results, computed again."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def reproduce(
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FOLDER", help="New, empty, or written by this command."
        ),
    ] = Path("propmap-reproduce"),
) -> None:
    """The paper's tables and figures from public data, and what does not agree: one page.

    Takes about two minutes on two cores.  FOLDER gets index.html with all figures inside, and
    every figure and table as SVG and CSV; the files are there all at once or not at all.
    """
    from propmap.papers.gill_dandrea_2017 import FILES
    from propmap.report.html import PAGE, check_folder, write_folder

    check_folder(output, FILES)

    from propmap.papers.gill_dandrea_2017.numbers import compute
    from propmap.papers.gill_dandrea_2017.pages.page import pages

    typer.echo("computing: about two minutes, less from the second time on", err=True)
    files = pages(compute())
    write_folder(output, files)
    typer.echo(f"wrote {output / PAGE} and {len(files) - 1} files beside it")
