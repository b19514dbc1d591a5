"""Output of commands: checked paths, formats, tables, text to a file or the terminal, notes."""

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
EXTRA_OF = {**dict.fromkeys(PICTURES, "figures"), ".nc": "netcdf"}  # that writes such files


def output_option(help_: str, metavar: str = "FILE") -> Any:
    """Make the option ``--output``, ``-o`` of a command with this help."""
    return Option("--output", "-o", metavar=metavar, help=help_)


WIDTH_ELSEWHERE = 160  # columns of a table that does not go to a terminal, so that nothing is cut

Format = Literal["table", "json", "csv"]
FormatOption = Annotated[
    Format | None,
    Option("--format", help="Form of the output; by default as the file's ending says."),
]
TextOutput = Annotated[Path | None, output_option("Write to this file, replacing it.")]
PictureOutput = Annotated[Path, output_option("Write this picture: .png, .svg or .pdf.")]
FolderOutput = Annotated[
    Path, output_option("Folder for the page: new, empty, or written by this command.", "FOLDER")
]
Force = Annotated[bool, Option("--force", help="Replace what exists.")]


def check_output(path: Path, endings: Sequence[str] = (), *, keep_existing: bool = False) -> None:
    """Raise ``InputError`` before any work if no file with one of the ``endings``, if any, can be
    written at the path, or one is there and ``keep_existing``."""
    where = str(path)
    ending = path.suffix.lower()
    if endings and ending not in endings:
        found = f"the file's ending is {path.suffix!r}"
        raise InputError(found, f"use {' or '.join(endings)}", where)
    if endings and ending in EXTRA_OF:
        require(EXTRA_OF[ending])
    if path.is_dir():
        raise InputError("this is a folder", "name a file inside it", where)
    if check_place(path, where) and keep_existing:
        raise InputError("the file exists", "pass --force to replace it", where)


def check_pictures(*paths: Path | None) -> None:
    """Check each path that is given as ``check_output`` does, for the ending of a picture."""
    for path in paths:
        if path is not None:
            check_output(path, PICTURES)


def chosen_format(wanted: Format | None, output: Path | None) -> Format:
    """Check the file and return the format: as asked for, by the file's ending, or a table."""
    if output is not None:
        check_output(output)
    if wanted is None and output is not None:
        ending = output.suffix.lower()
        return "json" if ending == ".json" else "csv" if ending == ".csv" else "table"
    return wanted or "table"


def emit(text: str, output: Path | None) -> None:
    """Write text to the file, whole or not at all, or to standard output."""
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
    """Write rows as CSV, or them or a ``whole`` that holds them as JSON."""
    if form == "csv":
        emit(csv_text(columns, rows), output)
    else:
        emit(json_text(rows if whole is None else whole), output)


def write_text(text: str, output: Path) -> None:
    """Write text to the file, whole or not at all."""
    with replacing(output) as part:
        part.write_text(text, encoding="utf-8", newline="")


def save_picture(figure: Figure, output: Path) -> None:
    """Save a figure and say so on standard error."""
    from propmap.report.html import save

    save(figure, output)
    echo(f"wrote {output}", err=True)


def note(*texts: str) -> None:
    """Print each text as a note on standard error."""
    for text in texts:
        echo(f"note: {text}", err=True)


@contextmanager
def blamed_on(file: Path) -> Iterator[None]:
    """Let an ``InputError`` from within name this file, unless it names a place itself."""
    try:
        yield
    except InputError as error:
        raise InputError(error.found, error.remedy, error.where or str(file)) from None


def digits(value: float, count: int = 4) -> str:
    """Write so many significant digits, a dash for what is not finite."""
    return f"{value:.{count}g}" if math.isfinite(value) else "-"


def json_text(value: Any) -> str:
    """Format strict JSON, which has no NaN: callers put None where there is no number."""
    return json.dumps(value, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def grid(heads: str, rows: Iterable[Sequence[str]], title: str = "", caption: str = "") -> Table:
    """Make a table of texts; heads are separated by bars, those of words begin with "<"."""
    from rich.table import Table

    found = Table(
        title=title or None, caption=caption or None, title_justify="left", caption_justify="left"
    )
    for head in heads.split("|"):
        found.add_column(head.removeprefix("<"), justify="left" if head[:1] == "<" else "right")
    for row in rows:
        found.add_row(*row)
    return found


FRAME = 3  # characters that a column takes beside its cells


@dataclass(frozen=True)
class WideGrid:
    """A ``grid`` that leaves out columns where a terminal is too narrow, and says which."""

    heads: str
    rows: Sequence[Sequence[str]]
    title: str
    caption: str
    spare: tuple[str, ...]  # heads of the columns to leave out, the first first

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Table]:
        """Draw the table as wide as the terminal is, which rich calls for."""
        heads = self.heads.split("|")
        # Heads may be broken at their spaces, cells not.
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
            caption += f"\nleft out for want of width, and in --format csv: {', '.join(left_out)}"
        rows = ([row[k] for k in kept] for row in self.rows)
        found = grid("|".join(heads[k] for k in kept), rows, self.title, caption)
        natural = [max(needed[k], len(heads[k].lstrip("<")) + FRAME) for k in kept]
        if sum(natural) + 1 > options.max_width:
            # Rich would narrow all columns alike, and cut cells off.
            for column, k in zip(found.columns, kept, strict=True):
                column.width = needed[k] - FRAME
        yield found


def show(output: Path | None, *parts: object) -> None:
    """Print texts and tables to the terminal, or as plain text to the file or a pipe."""
    from rich.console import Console

    # Without markup: "[deg]" in a heading is a unit and a file's name may hold brackets.
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
    """Show a progress bar on a terminal, and give the function that sets done, total and words."""
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
