"""One look for every picture, and how it is written."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from propmap.io.atomic_file import replacing

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito's palette without its yellow, which does not print: told apart by readers
with any colour vision."""

MARKERS = ("o", "s", "^", "D", "v", "P", "X")
"""A marker goes with each colour, for print without colour."""

MODEL: dict[str, Any] = {"linestyle": "-", "linewidth": 1.6}
HOVER: dict[str, Any] = {"linestyle": (0, (5, 3)), "linewidth": 1.2, "color": "0.35"}
MEASURED: dict[str, Any] = {"linestyle": "none", "markersize": 4.5, "clip_on": False}

_SETTINGS: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.grid": True,
    "grid.color": "0.88",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "figure.dpi": 150.0,
    "savefig.facecolor": "white",
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
}


@contextmanager
def style() -> Iterator[None]:
    """Draw in the package's style, without touching the settings of the process."""
    with mpl.rc_context(_SETTINGS):
        yield


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of this size [inches] that lays itself out."""
    return Figure(figsize=(width, height), layout="constrained")


def save(figure: Figure, path: Path) -> None:
    """Write a picture in the format of the file's ending, whole or not at all."""
    kind = path.suffix.lower().removeprefix(".")
    with style(), replacing(path) as part:
        figure.savefig(part, format=kind)


def as_svg(figure: Figure) -> bytes:
    """A picture for a page: letters as outlines, so that it looks alike everywhere, and without
    date and random names, so that the same figure gives the same bytes."""
    text = io.BytesIO()
    fixed: dict[Any, Any] = {"svg.fonttype": "path", "svg.hashsalt": "propmap"}
    with style(), mpl.rc_context(fixed):
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return text.getvalue()
