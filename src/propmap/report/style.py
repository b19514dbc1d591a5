"""One look for every figure, the pieces that many share, and how a figure is written."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from propmap.io.atomic_file import replacing
from propmap.loads import LOADS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RPM = 30.0 / np.pi
"""Revolutions per minute in 1 rad/s."""

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito's palette without its yellow, which does not print: told apart by readers
with any colour vision."""

MARKERS = ("o", "s", "^", "D", "v", "P", "X")
"""A marker goes with each colour, for print without colour."""

MODEL: dict[str, Any] = {"linestyle": "-", "linewidth": 1.6}
DASHED: dict[str, Any] = {"linestyle": (0, (5, 3)), "linewidth": 1.2}
HOVER: dict[str, Any] = {**DASHED, "color": "0.35"}
MEASURED: dict[str, Any] = {"linestyle": "none", "markersize": 4.5, "clip_on": False}
BAND: dict[str, Any] = {"alpha": 0.25, "linewidth": 0.0}

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
    """Draw in the package's style; the settings of the process stay.  Also a decorator."""
    with mpl.rc_context(_SETTINGS):
        yield


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of this size [inches] that lays itself out."""
    return Figure(figsize=(width, height), layout="constrained")


def load_panels(height: float, **shared: Any) -> tuple[Figure, Any]:
    """A figure with two panels in a row of this height [inches], and the axes (rows, 2)."""
    rows = -(-len(LOADS) // 2)
    figure = new_figure(8.6, height * rows)
    return figure, figure.subplots(rows, 2, squeeze=False, **shared)


def marked(k: int) -> dict[str, Any]:
    """Colour and marker number k."""
    return {"color": COLOURS[k], "marker": MARKERS[k]}


def key(label: str, **look: Any) -> Line2D:
    """A line of this look for a legend."""
    return Line2D([], [], label=label, **look)


def angle_keys(betas: Iterable[float], markersize: float = 0.0, **look: Any) -> list[Line2D]:
    """A line for a legend for each angle [rad], with a marker if that has a size."""
    return [
        key(
            f"β = {np.degrees(beta):.4g}°", color=COLOURS[k],
            **({"marker": MARKERS[k], "markersize": markersize} if markersize else {}), **look,
        )
        for k, beta in enumerate(betas)
    ]  # fmt: skip


def legend_below(figure: Figure, handles: Sequence[Any], columns: int = 0, **look: Any) -> None:
    """A legend under the panels, in one row unless ``columns`` is given."""
    ncols = columns or len(handles)
    figure.legend(handles=handles, loc="outside lower center", ncols=ncols, **look)


def legend_in_last(axes: Sequence[Axes], handles: Sequence[Any], label: str) -> None:
    """A legend in the last of 2 x 3 panels, and the label of the horizontal axis on the others."""
    for ax in axes[2:5]:
        ax.set_xlabel(label)
        ax.tick_params(labelbottom=True)
    axes[5].axis("off")
    axes[5].legend(handles=handles, loc="center", fontsize=9.0)


def share_of_weight(ax: Axes, weight: float) -> None:
    """A second scale, so that a force error can be read as a share of the weight [N]."""
    functions: Any = (lambda force: 100.0 * force / weight, lambda share: share * weight / 100.0)
    ax.secondary_yaxis("right", functions=functions).set_ylabel("share of the weight [%]")


def save(figure: Figure, path: Path) -> None:
    """Write a figure in the format of the file's ending, whole or not at all."""
    kind = path.suffix.lower().removeprefix(".")
    with style(), replacing(path) as part:
        figure.savefig(part, format=kind)


def as_svg(figure: Figure) -> bytes:
    """A figure for a page.

    Letters are outlines, so that it looks alike everywhere; it holds no date and no random names,
    so that the same figure gives the same bytes.
    """
    text = io.BytesIO()
    fixed: dict[Any, Any] = {"svg.fonttype": "path", "svg.hashsalt": "propmap"}
    with style(), mpl.rc_context(fixed):
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return text.getvalue()
