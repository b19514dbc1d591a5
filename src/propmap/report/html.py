"""Reports: one HTML page from a template, each figure as SVG and its data as CSV.

A template contains the text of a page; the module of the same name computes its numbers.  All
templates extend ``layout.html.j2`` of this folder.
"""

from __future__ import annotations

import base64
import csv
import io
import math
import os
import re
import shutil
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import propmap
from propmap.errors import InputError
from propmap.io.csv import check_place, replacing
from propmap.loads import LOADS

if TYPE_CHECKING:  # the explorer needs only the colors of this module
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

MINUS, MISSING = "\N{MINUS SIGN}", "\N{EN DASH}"  # for negative and missing numbers
DIGITS = 6  # significant digits in CSV files: the accuracy of the loads
ZERO = 1e-9  # smaller numbers are rounding errors, which differ between machines: written as 0


@dataclass(frozen=True, eq=False)
class FigureRecord:
    """Data of a figure or table of a page, which are also written to a CSV file."""

    name: str  # name of its files without extension
    groups: Sequence[Mapping[str, Any]]  # columns by head, as "speed_mps"; one group per curve
    draw: Callable[[], Figure] | None = None  # None for a table without a figure
    cells: Sequence[Sequence[str]] = ()  # rows of the table on the page

    def csv(self) -> str:
        """Return the columns as CSV text, with the groups one below the other."""
        return csv_of_columns(self.groups)

    def figure(self) -> Figure:
        """Draw the figure in the style of the package."""
        assert self.draw is not None
        with style():
            return self.draw()


def columns_of(heads: str, rows: Iterable[Sequence[Any]]) -> list[dict[str, Any]]:
    """Return the columns of ``rows`` as the only group of a record; spaces separate ``heads``."""
    values = list(zip(*rows, strict=True)) or [()] * len(heads.split())
    return [dict(zip(heads.split(), values, strict=True))]


def record_files(
    template: str, records: Iterable[FigureRecord], **values: Any
) -> dict[str, str | bytes]:
    """Return all files of a report by name; ``cells`` of the template maps records to tables."""
    records = list(records)
    return report_files(
        template,
        {one.name: one.figure() for one in records if one.draw},
        {one.name: one.csv() for one in records},
        cells={one.name: one.cells for one in records},
        **values,
    )


def report_files(
    template: str,
    figures: Mapping[str, Figure],
    sheets: Mapping[str, str],
    folder: Path = Path(__file__).parents[1],
    **values: Any,
) -> dict[str, str | bytes]:
    """Return all files of a report by name: the page, an SVG per figure and a CSV per sheet.

    The page renders ``template``, from ``folder`` or the package, with ``values``.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    images = {name: as_svg(figure) for name, figure in figures.items()}
    inside = {name: base64.b64encode(image).decode("ascii") for name, image in images.items()}
    environment = Environment(
        loader=FileSystemLoader([folder, Path(__file__).parents[1]]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "number": number,
        "fixed": lambda value, digits=0: f"{value:.{digits}f}",
        "percent": percent,
        "sentence": sentence,
    }
    environment.globals |= {"columns": _columns, "version": propmap.__version__}
    html = environment.get_template(template).render(images=inside, **values)
    drawn = {f"{name}.svg": image for name, image in images.items()}
    return {PAGE: html, **drawn, **{f"{name}.csv": text for name, text in sheets.items()}}


def number(value: float | None, digits: int = 3) -> str:
    """Format a number with ``digits`` significant digits, without an exponent if it stays short."""
    if value is None or value != value:
        return MISSING
    text = f"{value:.{digits}g}"
    if "e" in text and 1e-5 < abs(value) < 1e7:
        rounded = float(text)
        text = f"{rounded:.0f}" if abs(value) >= 1.0 else f"{rounded:.{digits + 4}f}".rstrip("0")
    return text.replace("-", MINUS)


def percent(share: float) -> str:
    """Format a fraction in percent with two digits and a non-breaking space."""
    return f"{number(100.0 * share, 2)}\N{NO-BREAK SPACE}%"


def sentence(text: str) -> str:
    """Return a text with a capital first letter and a final period."""
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")


def csv_of_rows(heads: str, rows: Iterable[Sequence[Any]]) -> str:
    """Return rows as CSV text; spaces separate ``heads``, NaN and None become empty fields."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heads.split())
    writer.writerows([_field(value) for value in row] for row in rows)
    return text.getvalue()


def csv_of_columns(groups: Iterable[Mapping[str, Any]]) -> str:
    """Return groups of columns as CSV text; the columns of each group are broadcast."""
    heads = ""
    rows: list[Sequence[Any]] = []
    for group in groups:
        heads = " ".join(group)
        columns = np.broadcast_arrays(*(np.asarray(v, dtype=object) for v in group.values()))
        rows += zip(*(column.ravel().tolist() for column in columns), strict=True)
    return csv_of_rows(heads, rows)


def _field(value: Any) -> Any:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if not isinstance(value, float):
        return value
    return f"{0.0 if abs(value) < ZERO else value:.{DIGITS}g}"


def _columns(heads: str, rows: Iterable[Sequence[Any]]) -> list[tuple[str, str, bool, list[str]]]:
    """Split a table with ``heads`` such as "load | rms error [N]" into columns: name, unit, whether
    all cells are numbers, and cells with three digits."""

    def is_number(text: str) -> bool:
        bare = re.sub(f"[{MINUS}{MISSING}% ]", "", text)
        return bare == "" or bare.replace(".", "", 1).isdigit()

    columns = []
    for head, *values in zip(heads.split("|"), *rows, strict=True):
        name, _, unit = head.strip().removesuffix("]").partition(" [")
        cells = [str(v) if isinstance(v, (str, int)) else number(v) for v in values]
        columns.append((name, unit, bool(unit) or all(map(is_number, cells)), cells))
    return columns


# --- The folder of a report, which is written completely or not at all ---------------------------

PAGE = "index.html"


def file_names(figures: Collection[str], tables: Collection[str]) -> frozenset[str]:
    """Return the file names of a report: the page, SVG and CSV per figure, CSV per other table."""
    pairs = {f"{name}{ending}" for name in figures for ending in (".svg", ".csv")}
    return frozenset({PAGE, *pairs, *(f"{name}.csv" for name in tables)})


MOST_LOADS = 6  # loads fitted in flight: three forces and three moments

REPORT_FILES = file_names(
    [f"fit-{name}" for name in ("coverage", "errors", "loads", "parameters", "check", "measured")]
    + [f"fit-residuals-{k}" for k in range(1, MOST_LOADS + 1)]
    + [f"table-{name}" for name in ("cells", "loads", "maps")],
    ["fit-correlations", "table-certificate"],
)  # all files that ``propmap report`` can write

TERMS_FILES = file_names(["fit-terms"], ["fit-terms-values", "fit-terms-worth"])
"""All files that ``propmap fit terms`` can write."""


def check_folder(folder: Path, names: Collection[str]) -> None:
    """Raise ``InputError`` unless the folder is new or contains only files in ``names``."""
    where = str(folder)
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise InputError("this is not a folder", "give the path of a folder", where)
    held = folder.iterdir() if check_place(folder.absolute(), where) else ()
    others = sorted(p.name for p in held if p.name not in names or p.is_dir())
    if others:
        found = f"the folder contains {others[0]!r}, which this command does not write"
        raise InputError(found, "choose a new or an empty folder", where)


def write_folder(
    folder: Path, files: Mapping[str, str | bytes], names: Collection[str] = ()
) -> None:
    """Write ``files`` to a new folder, or replace a folder that contains only these and ``names``.

    A temporary folder is renamed when it is complete, so an error leaves the old folder unchanged.
    """
    check_folder(folder, {*files, *names})
    place = folder.absolute()
    part, old = (
        place.with_name(f".{place.name[:100]}.{os.getpid()}.{ending}") for ending in ("part", "old")
    )
    try:
        part.mkdir()
        for name, content in files.items():
            data = content.encode("utf-8") if isinstance(content, str) else content
            (part / name).write_bytes(data)
        if folder.exists():
            folder.rename(old)
        try:
            part.rename(folder)
        except BaseException:
            if old.exists():
                old.rename(folder)
            raise
    finally:
        for beside in (part, old):
            shutil.rmtree(beside, ignore_errors=True)


# --- Style and shared parts of the figures, and their output -------------------------------------

# Okabe and Ito's palette, which color-blind readers can distinguish, without the yellow, which is
# invisible in print.  Each color has a marker for prints without color.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")

MODEL: dict[str, Any] = {"linestyle": "-", "linewidth": 1.6}
DASHED: dict[str, Any] = {"linestyle": (0, (5, 3)), "linewidth": 1.2}
HOVER: dict[str, Any] = {**DASHED, "color": "0.35"}
MEASURED: dict[str, Any] = {"linestyle": "none", "markersize": 4.5, "clip_on": False}
BAND: dict[str, Any] = {"alpha": 0.25, "linewidth": 0.0}


@contextmanager
def style(settings: Any = None) -> Iterator[None]:
    """Apply the style of the package, then ``settings``, in a block or a decorated function."""
    from matplotlib import rc_context

    with rc_context(settings, fname=Path(__file__).with_name("propmap.mplstyle")):
        yield


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of this size [inches] with automatic layout."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def load_panels(height: float, **shared: Any) -> tuple[Figure, Any]:
    """Return a figure with a panel per load, and axes (rows, 2); rows have this height [inches]."""
    rows = -(-len(LOADS) // 2)
    figure = new_figure(8.6, height * rows)
    return figure, figure.subplots(rows, 2, squeeze=False, **shared)


def marked(k: int) -> dict[str, Any]:
    """Return color and marker number ``k``."""
    return {"color": COLORS[k], "marker": MARKERS[k]}


def key(label: str, **look: Any) -> Line2D:
    """Return a line with this style for a legend."""
    from matplotlib.lines import Line2D

    return Line2D([], [], label=label, **look)


def angle_keys(betas: Iterable[float], markersize: float = 0.0, **look: Any) -> list[Line2D]:
    """Return a legend line for each angle [rad], with a marker unless ``markersize`` is 0."""
    return [
        key(
            f"β = {np.degrees(beta):.4g}°", color=COLORS[k],
            **({"marker": MARKERS[k], "markersize": markersize} if markersize else {}), **look,
        )
        for k, beta in enumerate(betas)
    ]  # fmt: skip


def legend_below(figure: Figure, handles: Sequence[Any], columns: int = 0, **look: Any) -> None:
    """Add a legend below the panels, in one row unless ``columns`` is given."""
    ncols = columns or len(handles)
    figure.legend(handles=handles, loc="outside lower center", ncols=ncols, **look)


def legend_in_last(axes: Sequence[Axes], handles: Sequence[Any], label: str) -> None:
    """Use the last of 2 x 3 panels for a legend; label the x axes at the bottom of each column."""
    for ax in axes[2:5]:
        ax.set_xlabel(label)
        ax.tick_params(labelbottom=True)
    axes[5].axis("off")
    axes[5].legend(handles=handles, loc="center", fontsize=9.0)


def share_of_weight(ax: Axes, weight: float) -> None:
    """Add a second y axis that shows forces as a fraction of the ``weight`` [N]."""
    functions: Any = (lambda force: 100.0 * force / weight, lambda share: share * weight / 100.0)
    ax.secondary_yaxis("right", functions=functions).set_ylabel("fraction of the weight [%]")


def save(figure: Figure, path: Path) -> None:
    """Write a figure in the format of the file extension, completely or not at all."""
    kind = path.suffix.lower().removeprefix(".")
    with style(), replacing(path) as part:
        figure.savefig(part, format=kind)


def as_svg(figure: Figure) -> bytes:
    """Return a figure as SVG with outlined text, without date and random names.

    The figure looks the same on all machines, and equal figures give equal bytes.
    """
    text = io.BytesIO()
    with style({"svg.fonttype": "path", "svg.hashsalt": "propmap"}):
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return text.getvalue()
