"""A response surface, with the designs that it was fitted to."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from propmap.report.style import new_figure, style

if TYPE_CHECKING:
    from propmap.study.response_surface import ResponseSurface
    from propmap.typing import Floats

GRID = 80
"""Values along each axis."""


@style()
def response_picture(
    title: str,
    label: str,
    surface: ResponseSurface,
    axes: tuple[str, str],
    labels: tuple[str, str],
    rows: dict[str, Floats],
    values: Floats,
) -> Figure:
    """Contours over two variables, the others at the middle of their ranges.

    Dots are all designs, wherever the others are.  Beside it what the surface says of each design,
    against what was computed.

    Parameters
    ----------
    title, label : str
        Of the picture, and of the quantity, with its unit.
    surface : ResponseSurface
        What is drawn.
    axes, labels : tuple of 2 str
        What varies across and up, and its words with units.
    rows : dict of str to ndarray, shape (n,)
        The designs.
    values : ndarray, shape (n,)
        The quantity, computed.
    """
    figure = new_figure(9.6, 4.6)
    ax, check = figure.subplots(1, 2, width_ratios=(1.35, 1.0))
    ends = [(rows[name].min(), rows[name].max()) for name in axes]
    across, up = np.meshgrid(*(np.linspace(*pair, GRID) for pair in ends))
    middle = surface.middle()
    if "blades" in middle:
        middle["blades"] = float(rows["blades"].min())
    at = {name: np.full(across.size, value) for name, value in middle.items()}
    at |= {axes[0]: across.ravel(), axes[1]: up.ravel()}
    found = surface(at).reshape(across.shape)
    filled = ax.contourf(across, up, found, 14, cmap="viridis")
    lines = ax.contour(across, up, found, filled.levels[::2], colors="white", linewidths=0.7)
    ax.clabel(lines, fontsize=7.5)
    figure.colorbar(filled, ax=ax, label=label)
    ax.plot(rows[axes[0]], rows[axes[1]], ".", color="black", markersize=2.5, alpha=0.6)
    ax.set_xlabel(labels[0])
    ax.set_ylabel(labels[1])
    rest = [f"{n.replace('_', ' ')} {v:.3g}" for n, v in middle.items() if n not in axes]
    told_rest = [f"surface at {', '.join(rest)}", "dots: designs, at any of these"] if rest else []
    ax.set_title("\n".join(told_rest), fontsize=8.0)
    told = surface(rows)
    check.plot(values, told, ".", markersize=3.5)
    line = [np.nanmin(values), np.nanmax(values)]
    check.plot(line, line, color="0.35", linewidth=0.9)
    check.set_xlabel(f"computed: {label}")
    check.set_ylabel("by the quadratic, fitted to them")
    spread = float(np.nanstd(values))
    unit = label[label.find("[") + 1 : -1]
    share = f", {100.0 * surface.left_out_rms / spread:.2g} % of the spread" if spread else ""
    check.set_title(
        f"rms error of designs left out: {surface.left_out_rms:.2g} {unit}{share}", fontsize=8.0
    )
    figure.suptitle(title)
    return figure
