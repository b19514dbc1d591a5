"""Loads of a table as curves over speed and as maps over speed and angle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from propmap.baselines.hover import HoverModel
from propmap.loads import LOADS
from propmap.report.load_curves import PANELS, ROWS
from propmap.report.page import Section
from propmap.report.part import Part, files_of, picture
from propmap.report.sheet import csv_of_rows
from propmap.report.style import COLOURS, HOVER, MARKERS, MODEL, new_figure, style
from propmap.report.table_page.samples import RPM, TableSamples
from propmap.table.lookup import STATUSES, UNRESOLVED, VORTEX_RING

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def load_section(samples: TableSamples) -> Part:
    """Curves and maps at the middle rotational speed."""
    rpm = f"{samples.omega * RPM:.0f} rpm, the geometric middle of the envelope"
    curves = picture(
        curve_figure(samples),
        "table-loads",
        f"Loads of the table at {rpm}. Thin dotted: vortex ring state. Dashed: hover model with "
        "the table's loads at rest.",
        "Thrust, rotor drag, torque and rolling moment against speed for several angles.",
    )
    maps = picture(
        map_figure(samples),
        "table-maps",
        f"The same over speed and angle at {rpm}. Hatched, in white outline: vortex ring state. "
        "Black: unresolved.",
        "Maps of the loads over speed and angle.",
    )
    section = Section("loads", "Loads", (curves, maps))
    files = files_of(curves, maps) | {
        "table-loads.csv": _curves_csv(samples),
        "table-maps.csv": _maps_csv(samples),
    }
    return Part(section, files)


def hover_loads(samples: TableSamples) -> dict[str, float]:
    """The hover model's loads at the curves' rotational speed; NaN where there are none."""
    hover = HoverModel(samples.k_thrust, samples.k_torque, samples.omega)
    return {name: float(value) for name, value in hover.loads(samples.omega).items()}


def curve_figure(samples: TableSamples) -> Figure:
    """A panel per load, a colour per angle."""
    hover = hover_loads(samples)
    with style():
        figure = new_figure(8.6, 3.3 * ROWS)
        axes = figure.subplots(ROWS, 2, sharex=True).ravel()
        for ax, (load, label) in zip(axes, PANELS, strict=True):
            if np.isfinite(samples.k_thrust):
                ax.axhline(hover[load], **HOVER)
            for k, one in enumerate(samples.curves):
                ring = one.code == VORTEX_RING
                values = one.loads[load]
                # The curves of axial flow lie on each other: markers tell them apart.
                every = slice(6 + 3 * k, None, 24)
                ax.plot(
                    samples.speed, np.where(ring, np.nan, values), color=COLOURS[k], **MODEL
                )  # fmt: skip
                ax.plot(
                    samples.speed, np.where(ring, values, np.nan), color=COLOURS[k],
                    linestyle=":", linewidth=1.1,
                )  # fmt: skip
                ax.plot(
                    samples.speed[every], values[every], color=COLOURS[k], marker=MARKERS[k],
                    markersize=4.0, linestyle="none",
                )  # fmt: skip
            ax.set_ylabel(label)
            ax.margins(x=0.02)
        for ax in axes[-2:]:
            ax.set_xlabel("flight speed V [m/s]")
        handles = [
            Line2D(
                [], [], color=COLOURS[k], marker=MARKERS[k], markersize=4.0,
                label=f"β = {np.degrees(one.beta):.0f}°", **MODEL,
            )
            for k, one in enumerate(samples.curves)
        ]  # fmt: skip
        handles.append(Line2D([], [], label="hover model", **HOVER))
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return figure


def map_figure(samples: TableSamples) -> Figure:
    """A panel per load, filled contours."""
    degrees = np.degrees(samples.beta)
    with style():
        figure = new_figure(8.6, 3.4 * ROWS)
        axes = figure.subplots(ROWS, 2, sharex=True, sharey=True)
        for ax, (load, label) in zip(axes.ravel(), PANELS, strict=True):
            values = samples.maps[load].T
            ax.grid(visible=False)
            if np.isfinite(values).any():
                filled = ax.contourf(samples.speed, degrees, values, 12, cmap="viridis")
                figure.colorbar(filled, ax=ax, label=label)
            _marks(ax, samples, degrees)
        for ax in axes[-1]:
            ax.set_xlabel("flight speed V [m/s]")
        for ax in axes[:, 0]:
            ax.set_ylabel("angle β [deg]")
    return figure


def _marks(ax: Axes, samples: TableSamples, degrees: NDArray[np.float64]) -> None:
    ring, loose = (np.where(samples.code == code, 1.0, 0.0).T for code in (VORTEX_RING, UNRESOLVED))
    if ring.any():
        ax.contourf(samples.speed, degrees, ring, [0.5, 1.5], colors="none", hatches=["//"])
        ax.contour(samples.speed, degrees, ring, [0.5], colors="white", linewidths=0.8)
    if loose.any():
        ax.contourf(samples.speed, degrees, loose, [0.5, 1.5], colors="black")


def _curves_csv(samples: TableSamples) -> str:
    hover = hover_loads(samples)
    columns = [load.column for load in LOADS.values()]
    heads = (
        "beta_deg", "speed_mps", "rpm", "status", *columns, *(f"hover_{name}" for name in columns),
    )  # fmt: skip
    rows = [
        (
            float(np.degrees(one.beta)), speed, samples.omega * RPM, STATUSES[int(one.code[k])],
            *(float(one.loads[n][k]) for n in LOADS), *(float(hover[n]) for n in LOADS),
        )
        for one in samples.curves
        for k, speed in enumerate(samples.speed.tolist())
    ]  # fmt: skip
    return csv_of_rows(heads, rows)


def _maps_csv(samples: TableSamples) -> str:
    heads = ("speed_mps", "beta_deg", "rpm", "status", *(load.column for load in LOADS.values()))
    degrees = np.degrees(samples.beta).tolist()
    rows = [
        (
            speed, beta, samples.omega * RPM, STATUSES[int(samples.code[i, j])],
            *(float(samples.maps[n][i, j]) for n in LOADS),
        )
        for i, speed in enumerate(samples.speed.tolist())
        for j, beta in enumerate(degrees)
    ]  # fmt: skip
    return csv_of_rows(heads, rows)
