"""What the hover model would miss in a table's envelope."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from propmap.report.page import csv_of_columns, number
from propmap.report.style import COLOURS, DASHED, angle_keys, legend_below, new_figure, style
from propmap.report.table_page.loads import mark
from propmap.report.table_page.samples import OFF, TableSamples

LOADS = ("thrust", "torque")


@style()
def hover_figure(samples: TableSamples) -> Figure:
    """The hover model less the table in thrust and torque over speed, in the colours of angles."""
    look: dict[str, Any] = {**DASHED, "linewidth": 1.5}
    figure = new_figure(8.6, 3.8)
    for ax, load in zip(figure.subplots(1, 2), LOADS, strict=True):
        ax.axhline(0.0, color="0.4", linewidth=0.8)
        for k, one in enumerate(samples.curves):
            off = 100.0 * (samples.still[load] - one.loads[load]) / samples.still[load]
            ax.plot(samples.speed, off, color=COLOURS[k], **look)
            mark(ax, k, samples.speed, off)
        ax.set_ylabel(f"hover model less table, {load} [% of static]")
        ax.set_xlabel("flight speed V [m/s]")
        ax.margins(x=0.02)
    legend_below(figure, angle_keys([c.beta for c in samples.curves], markersize=4.0, **look))
    return figure


def judged(samples: TableSamples) -> dict[str, Any]:
    """The verdict: its level and word, the share of points off, the speed up to which it holds."""
    total = sum(one.points for one in samples.hover)
    off = sum(one.off[0] * one.points for one in samples.hover) / total
    good = [one for one in samples.hover if one.off[0] < OFF[0]]
    if len(good) == len(samples.hover):
        return {"level": "good", "word": "Yes, for thrust", "off": off}
    if good:
        speed = good[-1].speed[1]
        return {"level": "caution", "word": "Only in slow flight", "off": off, "speed": speed}
    return {"level": "bad", "word": "No", "off": off}


def error_rows(samples: TableSamples) -> list[tuple[str, ...]]:
    """Speed, errors of thrust, torque and drag, and shares of points off; a row per band."""
    return [
        (
            f"{number(one.speed[0], 2)} to {number(one.speed[1], 2)}",
            *(number(100.0 * value, 2) for value in one.rms),
            *(f"{100.0 * share:.0f}" for share in one.off),
        )
        for one in samples.hover
    ]


def hover_sheet(samples: TableSamples) -> str:
    """The figure's numbers as CSV."""
    return csv_of_columns(
        {"beta_deg": np.degrees(one.beta), "speed_mps": samples.speed, "rpm": samples.rpm}
        | {
            f"{load}_error_share": (samples.still[load] - one.loads[load]) / samples.still[load]
            for load in LOADS
        }
        for one in samples.curves
    )
