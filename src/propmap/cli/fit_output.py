"""Where fits go, the same for all commands of ``propmap fit``: a file, a picture, the screen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.cli.output import check_output, check_pictures, show, write_text

if TYPE_CHECKING:
    from propmap.fit.fit import Fitted
    from propmap.fit.least_squares import FlightErrors
    from propmap.model.model import Model

Output = Annotated[
    Path, typer.Option("--output", "-o", metavar="FIT.toml", help="Where the fit is written.")
]
Picture = Annotated[
    Path | None, typer.Option("--picture", metavar="FILE", help="Picture of the fit.")
]


def check_outputs(output: Path | None, *pictures: Path | None) -> None:
    """Raise ``InputError`` where a fit or its pictures cannot be written."""
    if output is not None:
        check_output(output, (".toml",))
    check_pictures(*pictures)


def finish(
    fitted: Fitted,
    found: Model,
    remarks: Sequence[str],
    text: str,
    output: Path | None,
    flights: Mapping[str, Mapping[str, FlightErrors]] | None = None,
) -> None:
    """Write the ``text`` of a fit file and show the fit, by flight where ``flights`` has that."""
    from propmap.cli.fit_report import told

    if output is not None:
        write_text(text, output)
    show(None, *told(fitted, found.correction_texts, remarks, flights or {}))
    if output is not None:
        typer.echo(f"wrote {output}", err=True)
