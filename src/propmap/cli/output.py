"""Output of commands: path checks, formats, tables, files and notes."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from typer import Option, echo

from propmap.errors import InputError, require
from propmap.io.csv import check_place, csv_text, replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.console import Console, ConsoleOptions
    from rich.table import Table

PICTURES = (".png", ".svg", ".pdf")
EXTRA_OF = {**dict.fromkeys(PICTURES, "figures"), ".nc": "netcdf"}  # needed, by file extension


def output_option(help_: str, metavar: str = "FILE") -> Any:
    """Return the option ``--output``, ``-o`` with this help text."""
    return Option("--output", "-o", metavar=metavar, help=help_)


WIDTH_ELSEWHERE = 160  # characters per line in files and pipes: enough to truncate no cell

Format = Literal["table", "json", "csv"]
FormatOption = Annotated[
    Format | None,
    Option(
        "--format",
        help="Output format (default: from the extension of the output file, or table).",
    ),
]
TextOutput = Annotated[
    Path | None, output_option("Output file; overwritten if it exists (default: the terminal).")
]
PictureOutput = Annotated[Path, output_option("Picture file: .png, .svg or .pdf.")]
FolderOutput = Annotated[
    Path,
    output_option("Output folder: new, empty, or written earlier by this command.", "FOLDER"),
]
Force = Annotated[bool, Option("--force", help="Overwrite existing output.")]


def check_output(path: Path, endings: Sequence[str] = (), *, keep_existing: bool = False) -> None:
    """Raise ``InputError`` if the path has none of the ``endings``, cannot be written, or exists
    and ``keep_existing`` is set; commands call this before any work."""
    where = str(path)
    ending = path.suffix.lower()
    if endings and ending not in endings:
        found = f"the file extension is {path.suffix!r}"
        raise InputError(found, f"use {' or '.join(endings)}", where)
    if endings and ending in EXTRA_OF:
        require(EXTRA_OF[ending])
    if path.is_dir():
        raise InputError("this is a folder", "name a file inside it", where)
    if check_place(path, where) and keep_existing:
        raise InputError("the file exists", "pass --force to overwrite it", where)


def check_pictures(*paths: Path | None) -> None:
    """Check each given path like ``check_output``, for the extension of a picture."""
    for path in paths:
        if path is not None:
            check_output(path, PICTURES)


def chosen_format(wanted: Format | None, output: Path | None) -> Format:
    """Check the output file and return the format: ``wanted``, by the file extension, or table."""
    if output is not None:
        check_output(output)
    if wanted is None and output is not None:
        ending = output.suffix.lower()
        return "json" if ending == ".json" else "csv" if ending == ".csv" else "table"
    return wanted or "table"


def emit(text: str, output: Path | None) -> None:
    """Write text to the file, completely or not at all, or to standard output."""
    if output is None:
        echo(text, nl=False)
    else:
        write_text(text, output)
        echo(f"wrote {output}", err=True)


def emit_rows(
    columns: Sequence[str],
    rows: Sequence[Mapping[str, Any]],
    form: Format,
    output: Path | None,
    *,
    whole: Any = None,
) -> None:
    """Write rows as CSV or JSON; JSON contains ``whole``, if given, in place of the rows."""
    if form == "csv":
        emit(csv_text(columns, rows), output)
    else:
        emit(json_text(rows if whole is None else whole), output)


def write_text(text: str, output: Path) -> None:
    """Write text to the file, completely or not at all."""
    with replacing(output) as part:
        part.write_text(text, encoding="utf-8", newline="")


def save_picture(figure: Figure, output: Path) -> None:
    """Save a figure and print its path on standard error."""
    from propmap.report.html import save

    save(figure, output)
    echo(f"wrote {output}", err=True)


def note(*texts: str) -> None:
    """Print each text as a note on standard error."""
    for text in texts:
        echo(f"note: {text}", err=True)


@contextmanager
def blamed_on(file: Path) -> Iterator[None]:
    """Add this file to an ``InputError`` of the block, unless the error names a place itself."""
    try:
        yield
    except InputError as error:
        raise InputError(error.found, error.remedy, error.where or str(file)) from None


def digits(value: float, count: int = 4) -> str:
    """Return ``value`` with ``count`` significant digits, or a dash if it is not finite."""
    return f"{value + 0.0:.{count}g}" if math.isfinite(value) else "-"  # + 0.0: no -0


def percent(share: float, decimals: int) -> str:
    """Return a ``share`` in percent, or a dash if it is not finite."""
    return f"{100.0 * share:.{decimals}f} %" if math.isfinite(share) else "-"


def json_text(value: Any) -> str:
    """Return strict JSON, which has no NaN: callers pass None for a missing number."""
    return json.dumps(value, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def grid(heads: str, rows: Iterable[Sequence[str]], title: str = "", caption: str = "") -> Table:
    """Return a table of texts; ``heads`` are separated by "|", and "<" aligns a column left."""
    from rich.table import Table

    found = Table(
        title=title or None, caption=caption or None, title_justify="left", caption_justify="left"
    )
    for head in heads.split("|"):
        found.add_column(head.removeprefix("<"), justify="left" if head[:1] == "<" else "right")
    for row in rows:
        found.add_row(*row)
    return found


FRAME = 3  # characters of border and padding per column


@dataclass(frozen=True)
class WideGrid:
    """A ``grid`` that hides columns on a narrow terminal and names them in its caption."""

    heads: str
    rows: Sequence[Sequence[str]]
    title: str
    caption: str
    spare: tuple[str, ...]  # heads of the columns that may be hidden, in this order

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Table]:
        """Yield the table in the width of the terminal; rich calls this method."""
        heads = self.heads.split("|")
        # Heads may wrap at their spaces, cells may not.
        needed = [
            max(map(len, [*head.lstrip("<").split(), *cells, ""])) + FRAME
            for head, *cells in zip(heads, *self.rows, strict=True)
        ]
        left_out: list[str] = []
        for head in self.spare:
            if sum(needed) + 1 <= options.max_width:
                break
            if head in heads:
                k = heads.index(head)
                heads[k], needed[k] = "", 0
                left_out.append(head)
        kept = [k for k, width in enumerate(needed) if width]
        caption = self.caption
        if left_out:
            caption += f"\nhidden on this narrow terminal, see --format csv: {', '.join(left_out)}"
        rows = ([row[k] for k in kept] for row in self.rows)
        found = grid("|".join(heads[k] for k in kept), rows, self.title, caption)
        natural = [max(needed[k], len(heads[k].lstrip("<")) + FRAME) for k in kept]
        if sum(natural) + 1 > options.max_width:
            # Without fixed widths, rich narrows all columns equally and truncates cells.
            for column, k in zip(found.columns, kept, strict=True):
                column.width = needed[k] - FRAME
        yield found


def show(output: Path | None, *parts: object) -> None:
    """Print texts and tables to the terminal, or write them as plain text to a file or pipe."""
    from rich.console import Console

    # Without markup: "[deg]" in a heading is a unit, and file names may contain brackets.
    plain: dict[str, Any] = {"highlight": False, "markup": False, "emoji": False}
    text = io.StringIO()
    console = Console(**plain)
    if output is not None:
        console = Console(file=text, width=WIDTH_ELSEWHERE, **plain)
    elif not console.is_terminal:
        console = Console(width=WIDTH_ELSEWHERE, **plain)
    for part in parts:
        console.print(part)
    if output is not None:
        emit(text.getvalue(), output)


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[..., None]]:
    """Show a progress bar on a terminal; yield a function that sets done, total and text."""
    from rich import progress
    from rich.console import Console

    console = Console(stderr=True)
    columns = (
        progress.TextColumn("{task.description}"),
        progress.BarColumn(),
        progress.MofNCompleteColumn(),
        progress.TimeElapsedColumn(),
        progress.TextColumn("left:"),
        progress.TimeRemainingColumn(),
    )
    with progress.Progress(
        *columns, console=console, disable=not console.is_terminal, transient=True
    ) as bar:
        task = bar.add_task(what, total=None)

        def update(done: int, total: int | None = None, what: str = what) -> None:
            bar.update(task, completed=done, total=total, description=what)

        yield update
