"""The cells of a table: certified, vortex ring, unresolved, or without a value."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from propmap.report.page import csv_of_rows
from propmap.report.style import COLOURS, RPM, legend_below, new_figure, style
from propmap.table.interpolation import NO_VALUE, OK, STATUSES, UNRESOLVED, VORTEX_RING, cell_codes
from propmap.table.query import LoadTable

KINDS = {
    OK: ("certified", "#e8eef2"),
    VORTEX_RING: ("vortex ring: certified, but the theory is not valid there", COLOURS[5]),
    UNRESOLVED: ("unresolved: the loads jump", COLOURS[1]),
    NO_VALUE: ("no value", "0.55"),
}


@style()
def cell_figure(table: LoadTable) -> Figure:
    """Every cell over advance ratio and angle, in the colour of its status."""
    content, (rank, codes) = table.content, cell_ranks(table)
    (w0, w1), (_, fastest), _ = table.envelope.values()
    figure = new_figure(8.6, 5.0)
    ax = figure.subplots()
    ax.grid(visible=False)
    ax.pcolormesh(
        content.advance, np.degrees(content.beta), rank.T, vmin=-0.5, vmax=len(KINDS) - 0.5,
        cmap=ListedColormap([colour for _, colour in KINDS.values()]), shading="flat",
        rasterized=True,
    )  # fmt: skip
    for omega in (w0, float(np.sqrt(w0 * w1)), w1):
        limit = fastest / (omega * content.radius)
        ax.axvline(limit, color="0.2", linewidth=1.0, linestyle="-.")
        ax.annotate(
            f"{omega * RPM:.0f} rpm", (limit, 1.0), (-3, -4), xycoords=("data", "axes fraction"),
            textcoords="offset points", rotation=90.0, ha="right", va="top", fontsize=8.0,
        )  # fmt: skip
    ax.set_xlim(content.advance[0], content.advance[-1])
    ax.set_xlabel("advance ratio V/(ΩR) [-]")
    ax.set_ylabel("angle β [deg]")
    low, high = np.degrees(content.beta[[0, -1]])
    if high - low > 60.0:
        ax.set_yticks(np.arange(30 * np.ceil(low / 30.0), high + 1.0, 30.0))
    handles = [
        Patch(facecolor=colour, edgecolor="0.5", linewidth=0.5, label=label)
        for code, (label, colour) in KINDS.items()
        if (codes == code).any()
    ]
    legend_below(figure, handles, columns=2)
    return figure


def cell_sheet(table: LoadTable) -> str:
    """The cells that are not certified, as CSV."""
    content, codes = table.content, _codes(table)
    advance, beta = content.advance.tolist(), np.degrees(content.beta).tolist()
    return csv_of_rows(
        "advance_from advance_to beta_from_deg beta_to_deg status",
        [
            (advance[i], advance[i + 1], beta[j], beta[j + 1], STATUSES[codes[i, j]])
            for i, j in np.argwhere(codes != OK).tolist()
        ],
    )


def cell_ranks(table: LoadTable) -> tuple[np.ndarray, np.ndarray]:
    """Of each cell (n - 1, m - 1) of a ``table``: its place in ``KINDS``, and its status."""
    codes = _codes(table)
    return np.searchsorted(list(KINDS), codes), codes


def _codes(table: LoadTable) -> np.ndarray:
    """Statuses of the cells (n - 1, m - 1), ``NO_VALUE`` where a corner has none."""
    lost: Any = np.isnan(table.content.coefficients).any(axis=(0, 1))
    corners = lost[:-1, :-1] | lost[1:, :-1] | lost[:-1, 1:] | lost[1:, 1:]
    return np.where(corners, np.uint8(NO_VALUE), cell_codes(table.content))
