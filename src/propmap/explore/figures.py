"""Figures as plain data for Plotly, in the reports' colours, labels and units."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propmap.loads import LOADS
from propmap.report.html import COLOURS

Figure = dict[str, Any]

GREY = "#777777"
MARKS = ("circle", "square", "triangle-up", "diamond", "triangle-down", "cross", "x")
"""Those of ``report.style.MARKERS``."""

STATUS_MARKS = {
    "multiple_roots": ("circle-open", COLOURS[4]),
    "windmill": ("triangle-up", COLOURS[2]),
    "coarse": ("diamond", COLOURS[3]),
    "vortex_ring": ("square", COLOURS[1]),
    "not_converged": ("x", "#CC0000"),
    "unresolved": ("diamond", COLOURS[1]),
    "clamped": ("square", COLOURS[3]),
    "no_value": ("x", "#CC0000"),
    "outside": ("x", GREY),
}
"""Mark and colour of points that are not "ok"."""


def array(values: ArrayLike) -> dict[str, Any] | list[Any]:
    """Numbers as Plotly takes them fastest."""
    found: NDArray[np.float64] = np.ascontiguousarray(values, np.float64)
    told = {"dtype": "f8", "bdata": base64.b64encode(found.tobytes()).decode()}
    if found.ndim > 1:
        told["shape"] = ", ".join(map(str, found.shape))
    return told


def line(
    x: ArrayLike, y: ArrayLike, name: str, colour: str, dash: str = "solid", **more: Any
) -> dict[str, Any]:
    """A curve."""
    return {
        "type": "scatter",
        "mode": "lines",
        "x": array(x),
        "y": array(y),
        "name": name,
        "line": {"color": colour, "width": 2, "dash": dash},
        **more,
    }


def band(x: ArrayLike, low: ArrayLike, high: ArrayLike, colour: str) -> dict[str, Any]:
    """What is shaded between two curves."""
    along, least, most = np.asarray(x), np.asarray(low), np.asarray(high)
    known = np.isfinite(least) & np.isfinite(most)
    along, least, most = along[known], least[known], most[known]
    r, g, b = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return {
        "type": "scatter",
        "mode": "lines",
        "x": array(np.concatenate([along, along[::-1]])),
        "y": array(np.concatenate([most, least[::-1]])),
        "fill": "toself",
        "fillcolor": f"rgba({r},{g},{b},0.22)",
        "line": {"width": 0},
        "hoverinfo": "skip",
        "showlegend": False,
    }


def points(
    x: ArrayLike, y: ArrayLike, name: str, colour: str, mark: str = "circle", **more: Any
) -> dict[str, Any]:
    """Single points."""
    return {
        "type": "scatter",
        "mode": "markers",
        "x": array(x),
        "y": array(y),
        "name": name,
        "marker": {"color": colour, "symbol": mark, "size": 7},
        **more,
    }


def figure(
    data: Sequence[dict[str, Any]],
    x: str,
    y: str,
    *,
    revision: str = "",
    shapes: Sequence[dict[str, Any]] = (),
    legend: bool = False,
    **layout: Any,
) -> Figure:
    """A figure with named axes; ``revision`` changes where a zoom is to be forgotten."""
    axis = {"gridcolor": "#dddddd", "zerolinecolor": "#bbbbbb", "automargin": False, "ticks": ""}
    own = {"x": layout.pop("xaxis", {}), "y": layout.pop("yaxis", {})}
    return {
        "data": list(data),
        "layout": {
            "xaxis": {**axis, "title": {"text": x, "standoff": 6}, **own["x"]},
            "yaxis": {**axis, "title": {"text": y, "standoff": 4}, **own["y"]},
            "margin": {"l": 62, "r": 12, "t": 12, "b": 44},
            "font": {"size": 12, "color": "#222222", "family": "system-ui, sans-serif"},
            "paper_bgcolor": "rgba(0,0,0,0)",
            "plot_bgcolor": "rgba(0,0,0,0)",
            "showlegend": legend,
            "legend": {"orientation": "h", "y": -0.22, "x": 0.0},
            "hovermode": "closest",
            "uirevision": revision,
            "shapes": list(shapes),
            **layout,
        },
    }


def span(*values: ArrayLike, zero: bool = False) -> dict[str, Any]:
    """A range of an axis that holds the finite ones of ``values``, with some room."""
    flat = np.concatenate([np.ravel(v) for v in values]) if values else np.zeros(1)
    flat = flat[np.isfinite(flat)]
    if zero or not flat.size:
        flat = np.append(flat, 0.0)
    low, high = float(flat.min()), float(flat.max())
    room = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
    return {"range": [low - room, high + room]}


def upright(x: float) -> dict[str, Any]:
    """A thin line at an operating point."""
    return {
        "type": "line",
        "xref": "x",
        "yref": "paper",
        "x0": x,
        "x1": x,
        "y0": 0,
        "y1": 1,
        "line": {"color": GREY, "width": 1, "dash": "dot"},
    }


TITLES = {**{name: load.title for name, load in LOADS.items()}, "power": "power P [W]"}
"""Of loads and the power, for axes."""

UNITS = {**{name: load.unit for name, load in LOADS.items()}, "power": "W"}

LABELS = {**{name: load.label for name, load in LOADS.items()}, "power": "power"}


def digits(value: float) -> str:
    """A number as it is told on the page."""
    return f"{value:.4g}" if np.isfinite(value) else "-"
