"""The pictures of figure 6."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from propmap.papers.gill_dandrea_2017.level_circles import ASSUMED, CASES, FORCE_ERROR, SetFlown
from propmap.papers.gill_dandrea_2017.paper import FASTEST, HOVER_FAILS
from propmap.report.style import COLOURS, HOVER, MARKERS, MEASURED, MODEL, new_figure, style
from propmap.vehicle.flight_log import GRAVITY

TITLES = {"paper-soft": "soft", "paper-stiff": "stiff"}
WEIGHT = ASSUMED.mass * GRAVITY
FACES = (COLOURS[0], "white")
"""Of the markers, full and hollow, told apart in print without colour."""

DASHED: dict[str, Any] = {"linestyle": HOVER["linestyle"], "linewidth": HOVER["linewidth"]}


def loads_figure(flown: dict[str, SetFlown]) -> Figure:
    """The paper's five panels, and a legend in the sixth."""
    with style():
        figure = new_figure(9.6, 6.2)
        axes = figure.subplots(2, 3, sharex=True).ravel()
        for k, one in enumerate(flown.values()):
            c, colour = one.circles[ASSUMED], COLOURS[k]
            lines = (
                (c.thrust, c.hover_thrust),
                (c.drag, 0.0 * c.drag),
                (1e3 * c.torque, 1e3 * c.hover_torque),
                (None, c.hover_error),
                (np.degrees(c.pitch), None),
            )
            for ax, (model, hover) in zip(axes, lines, strict=False):
                if model is not None:
                    ax.plot(c.speed, model, color=colour, **MODEL)
                if hover is not None:
                    ax.plot(c.speed, hover, color=colour, **DASHED)
            twin = one.twin
            axes[3].errorbar(
                twin.speed, twin.error, FORCE_ERROR * WEIGHT, color=colour, marker=MARKERS[k],
                linestyle="none", markersize=3.5, elinewidth=0.8, markerfacecolor=FACES[k],
            )  # fmt: skip
        labels = (
            "collective thrust ΣT [N]",
            "collective rotor drag ΣD [N]",
            "collective torque [mN m]",
            "vertical force error [N]",
            "pitch angle, nose down [deg]",
        )
        for ax, label in zip(axes, labels, strict=False):
            ax.set_ylabel(label)
            ax.margins(x=0.02)
        axes[3].axhline(0.0, color="0.6", linewidth=0.8)
        functions: Any = (lambda f: 100.0 * f / WEIGHT, lambda s: s * WEIGHT / 100.0)
        share = axes[3].secondary_yaxis("right", functions=functions)
        share.set_ylabel("share of the weight [%]")
        for ax in axes[2:5]:
            ax.set_xlabel("flight speed V [m/s]")
            ax.tick_params(labelbottom=True)
        axes[5].axis("off")
        axes[5].legend(handles=_legend(flown), loc="center", fontsize=9.0)
    return figure


def _legend(flown: dict[str, SetFlown]) -> list[Line2D]:
    handles = []
    for k, name in enumerate(flown):
        title = TITLES[name]
        handles += [
            Line2D([], [], color=COLOURS[k], label=f"{title}: this model", **MODEL),
            Line2D([], [], color=COLOURS[k], label=f"{title}: hover model", **DASHED),
            Line2D(
                [], [], color=COLOURS[k], marker=MARKERS[k],
                markerfacecolor=FACES[k], label=f"{title}: identified,\nsimulated flights",
                **(MEASURED | {"clip_on": True}),
            ),
        ]  # fmt: skip
    return handles


def cases_figure(flown: dict[str, SetFlown]) -> Figure:
    """The hover model's error in every case, a panel per set."""
    with style():
        figure = new_figure(9.2, 4.2)
        axes = figure.subplots(1, 2, sharey=True)
        for ax, (name, one) in zip(axes, flown.items(), strict=True):
            ax.axhline(0.0, color="0.6", linewidth=0.8)
            ax.axvline(HOVER_FAILS[name], color="0.3", linewidth=1.0, linestyle=":")
            order = sorted(CASES, key=lambda case: (case.mass, case.drag_area))
            for k, case in enumerate(order):
                found = one.circles[case]
                label = f"{case.mass:g} kg, {case.drag_area:g} m²"
                share = 100.0 * found.hover_error / (case.mass * GRAVITY)
                ax.plot(
                    found.speed, share, color=COLOURS[k], marker=MARKERS[k], markersize=3.5,
                    markevery=(2 + k, 6), label=label, **DASHED,
                )  # fmt: skip
            ax.set_title(f"{TITLES[name]} propeller", fontsize=9.0)
            ax.set_xlabel("flight speed V [m/s]")
            ax.set_xlim(0.0, FASTEST)
        axes[0].set_ylim(-35.0, 60.0)
        axes[0].set_ylabel("vertical force error\nof the hover model [% of the weight]")
        figure.legend(
            handles=axes[0].get_legend_handles_labels()[0],
            loc="outside lower center", ncols=len(CASES), handlelength=3.2, columnspacing=1.2,
        )  # fmt: skip
    return figure
