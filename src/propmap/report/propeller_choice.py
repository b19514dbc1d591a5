"""Hover power against top speed of the propellers that an aircraft may have."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from propmap.report.style import COLOURS, key, legend_below, new_figure, style

if TYPE_CHECKING:
    from propmap.aircraft.ranking import Judged

NAMED = 3
"""Of the ranking's best, so many are named beside those of the front."""


@style()
def propeller_choice(title: str, judged: Sequence[Judged], front: Sequence[int]) -> Figure:
    """A point for each feasible propeller; those that no other beats in both are joined.

    Parameters
    ----------
    title : str
        Of the picture.
    judged : sequence of Judged
        The ranking, best first.
    front : sequence of int
        Numbers of those that no other beats, by rising hover power.
    """
    figure = new_figure(8.6, 5.6)
    ax = figure.subplots()
    drawn = [k for k, one in enumerate(judged) if one.feasible and np.isfinite(one.top_speed)]
    power = [judged[k].hover_power for k in drawn]
    ax.plot(power, [judged[k].top_speed for k in drawn], "o", color=COLOURS[5], markersize=4.0)
    along = [judged[k].hover_power for k in front], [judged[k].top_speed for k in front]
    ax.plot(*along, "-o", color=COLOURS[1], markersize=5.0, linewidth=1.2)
    best = [k for k in range(min(NAMED, len(judged))) if k in drawn]
    for rank, k in enumerate(best, start=1):
        ax.plot(
            judged[k].hover_power, judged[k].top_speed, "s", color="black", fillstyle="none",
            markersize=9.0,
        )  # fmt: skip
        ax.annotate(
            f"{rank}", (judged[k].hover_power, judged[k].top_speed), xytext=(0, 6),
            textcoords="offset points", fontsize=8.0, ha="center", va="bottom",
        )  # fmt: skip
    for place, k in enumerate(front):
        up = place % 2 == 0
        ax.annotate(
            judged[k].candidate.name.removeprefix("uiuc-"),
            (judged[k].hover_power, judged[k].top_speed),
            xytext=(-7, 6) if up else (7, -8),
            textcoords="offset points",
            fontsize=7.5,
            ha="right" if up else "left",
            va="bottom" if up else "top",
        )
    ax.margins(0.12)
    ax.set_xlabel("power in hover [W]")
    ax.set_ylabel("top speed [m/s]")
    figure.suptitle(title)
    legend_below(
        figure,
        [
            key("feasible", color=COLOURS[5], marker="o", linestyle="none", markersize=4.0),
            key("no other is better in both", color=COLOURS[1], marker="o", markersize=5.0),
            key("best of the ranking", color="black", marker="s", linestyle="none",
                fillstyle="none", markersize=8.0),
        ],
    )  # fmt: skip
    return figure
