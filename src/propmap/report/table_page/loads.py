"""Loads of a table as curves over speed and as maps over speed and angle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from propmap.loads import LOADS
from propmap.report.page import csv_of_columns
from propmap.report.style import (
    COLOURS,
    HOVER,
    MODEL,
    angle_keys,
    key,
    legend_below,
    load_panels,
    marked,
    style,
)
from propmap.report.table_page.samples import TableSamples
from propmap.table.interpolation import STATUSES, UNRESOLVED, VORTEX_RING
from propmap.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NAMES = np.array(STATUSES)


@style()
def curve_figure(samples: TableSamples) -> Figure:
    """A panel per load, a colour per angle."""
    figure, axes = load_panels(3.3, sharex=True)
    for ax, load in zip(axes.ravel(), LOADS.values(), strict=True):
        if np.isfinite(samples.still["thrust"]):
            ax.axhline(samples.still[load.name], **HOVER)
        for k, one in enumerate(samples.curves):
            ring, values = one.code == VORTEX_RING, one.loads[load.name]
            solid, dotted = np.where(ring, np.nan, values), np.where(ring, values, np.nan)
            ax.plot(samples.speed, solid, color=COLOURS[k], **MODEL)
            ax.plot(samples.speed, dotted, color=COLOURS[k], linestyle=":", linewidth=1.1)
            mark(ax, k, samples.speed, values)
        ax.set_ylabel(load.title)
        ax.margins(x=0.02)
    for ax in axes[-1]:
        ax.set_xlabel("flight speed V [m/s]")
    keys = angle_keys([c.beta for c in samples.curves], markersize=4.0, **MODEL)
    legend_below(figure, [*keys, key("hover model", **HOVER)])
    return figure


def mark(ax: Axes, k: int, speed: Floats, values: Floats) -> None:
    """Some markers on curve k: the curves of axial flow lie on each other."""
    every = slice(6 + 3 * k, None, 24)
    ax.plot(speed[every], values[every], markersize=4.0, linestyle="none", **marked(k))


@style()
def map_figure(samples: TableSamples) -> Figure:
    """A panel per load: filled contours, the vortex ring hatched, what is unresolved black."""
    speed, beta = samples.speed, np.degrees(samples.beta)
    ring, loose = (np.where(samples.code == code, 1.0, 0.0).T for code in (VORTEX_RING, UNRESOLVED))
    figure, axes = load_panels(3.4, sharex=True, sharey=True)
    for ax, load in zip(axes.ravel(), LOADS.values(), strict=True):
        values = samples.maps[load.name].T
        ax.grid(visible=False)
        if np.isfinite(values).any():
            filled = ax.contourf(speed, beta, values, 12, cmap="viridis")
            figure.colorbar(filled, ax=ax, label=load.title)
        if ring.any():
            ax.contourf(speed, beta, ring, [0.5, 1.5], colors="none", hatches=["//"])
            ax.contour(speed, beta, ring, [0.5], colors="white", linewidths=0.8)
        if loose.any():
            ax.contourf(speed, beta, loose, [0.5, 1.5], colors="black")
    for ax in axes[-1]:
        ax.set_xlabel("flight speed V [m/s]")
    for ax in axes[:, 0]:
        ax.set_ylabel("angle β [deg]")
    return figure


def curve_sheet(samples: TableSamples) -> str:
    """The curves as CSV, the hover model's loads beside them."""
    return csv_of_columns(
        {
            "beta_deg": np.degrees(one.beta),
            "speed_mps": samples.speed,
            "rpm": samples.rpm,
            "status": NAMES[one.code],
            **{load.column: one.loads[name] for name, load in LOADS.items()},
            **{f"hover_{load.column}": samples.still[name] for name, load in LOADS.items()},
        }
        for one in samples.curves
    )


def map_sheet(samples: TableSamples) -> str:
    """The maps as CSV."""
    return csv_of_columns(
        [
            {
                "speed_mps": samples.speed[:, None],
                "beta_deg": np.degrees(samples.beta),
                "rpm": samples.rpm,
                "status": NAMES[samples.code],
                **{load.column: samples.maps[name] for name, load in LOADS.items()},
            }
        ]
    )
