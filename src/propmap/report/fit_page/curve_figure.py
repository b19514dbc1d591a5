"""The figure of a fit's load curves."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from propmap.fit.tunnel import TunnelData
from propmap.loads import LOADS
from propmap.report.fit_page.curves import Curve, Curves
from propmap.report.style import (
    COLOURS,
    HOVER,
    MEASURED,
    MODEL,
    key,
    legend_below,
    new_figure,
    style,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NEAR = np.radians(2.5)
"""Of a curve's angle, within which measured points are drawn with it."""

DATA: dict[str, Any] = {"color": "0.92", "linewidth": 0.0}
BAND: dict[str, Any] = {"color": COLOURS[5], "alpha": 0.55, "linewidth": 0.0}
POINTS: dict[str, Any] = {**MEASURED, "color": COLOURS[1], "marker": "o"}


@style()
def curve_figure(curves: Curves, seen: Collection[str], measured: TunnelData | None) -> Figure:
    """A row per load, a column per angle.

    Parameters
    ----------
    curves : Curves
        What is drawn.
    seen : collection of str
        Loads that the data tell of; the speeds of the data are shaded.
    measured : TunnelData or None
        Points to draw.
    """
    count = len(curves.curves)
    figure = new_figure(max(2.35 * count + 0.6, 8.6), 2.15 * len(LOADS))
    axes = figure.subplots(len(LOADS), count, sharex=True, sharey="row", squeeze=False)
    for row, (name, load) in zip(axes, LOADS.items(), strict=True):
        row[0].set_ylabel(load.title)
        for ax, one in zip(row, curves.curves, strict=True):
            if name in seen and one.covered is not None:
                ax.axvspan(*one.covered, **DATA)
            if one.low is not None and one.high is not None:
                ax.fill_between(curves.speed, one.low[name], one.high[name], **BAND)
            ax.plot(curves.speed, np.full_like(curves.speed, curves.hover[name]), **HOVER)
            look = {**MODEL, "color": COLOURS[0]}
            ax.plot(curves.speed, np.where(one.valid, one.loads[name], np.nan), **look)
            if not one.valid.all():
                ring = np.where(one.valid, np.nan, one.loads[name])
                ax.plot(curves.speed, ring, **{**look, "linestyle": ":"})
            if measured is not None and name in measured.loads:
                _points(ax, curves, one, name, measured)
    for ax, one in zip(axes[0], curves.curves, strict=True):
        data = "" if one.covered else ", no data"
        ax.set_title(f"β = {np.degrees(one.beta):.0f}°{data}", fontsize=9.0)
    for ax in axes[-1]:
        ax.set_xlabel("flight speed V [m/s]")
        ax.set_xlim(0.0, curves.speed[-1])
    handles = [
        key("this model", color=COLOURS[0], **MODEL),
        *([Patch(label="95 % by the parameters", **BAND)] if curves.draws else []),
        key("hover model", **HOVER),
        Patch(label="covered by the data", **DATA),
        *([key("measured", **{**POINTS, "markersize": 4.0})] if measured is not None else []),
    ]
    legend_below(figure, handles, columns=5)
    return figure


def _points(ax: Axes, curves: Curves, one: Curve, load: str, data: TunnelData) -> None:
    """Points near the curve's angle, at the advance ratio that they were measured at."""
    ratio = curves.omega / np.maximum(data.omega, 1e-9)
    mine = (np.abs(data.folded_beta - one.beta) < NEAR) | (data.speed == 0.0)
    mine &= (data.omega > 0.0) & (data.speed * ratio <= curves.speed[-1])
    loads = data.loads[load] * ratio**2
    ax.plot((data.speed * ratio)[mine], loads[mine], **{**POINTS, "markersize": 2.6})
