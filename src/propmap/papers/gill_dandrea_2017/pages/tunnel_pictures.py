"""The pictures of figure 7."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from propmap.papers.gill_dandrea_2017.tunnel import (
    DIGITISED,
    HOVER_LABEL,
    Compared,
    static_constants,
)
from propmap.papers.gill_dandrea_2017.tunnel_curves import (
    BETAS,
    OBLIQUE_OMEGA,
    AxialCurve,
    ObliqueCurves,
    ThrustCurve,
    coefficients,
)
from propmap.report.load_curves import PANELS
from propmap.report.style import COLOURS, HOVER, MARKERS, MEASURED, MODEL, new_figure, style

RPM = 30.0 / np.pi


def axial_figure(one: Compared, curves: list[AxialCurve]) -> Figure:
    """C_T and C_P over J."""
    advance, thrust, power = coefficients(one.data)
    still = one.data.speed == 0.0
    with style():
        figure = new_figure(9.2, 4.2)
        axes = figure.subplots(1, 2)
        panels = (
            ("thrust coefficient $C_T$ [-]", thrust, "thrust_coefficient"),
            ("power coefficient $C_P$ [-]", power, "power_coefficient"),
        )
        for ax, (label, values, field) in zip(axes, panels, strict=True):
            ax.plot(
                advance, values, color="0.45", marker="o", linestyle="none", markersize=3.0,
                label="UIUC, measured", clip_on=False,
            )  # fmt: skip
            for k, curve in enumerate(curves):
                y = getattr(curve, field)
                ax.plot(curve.advance, y, color=COLOURS[k], label=curve.label, **MODEL)
                ax.plot(
                    curve.advance[3 + 4 * k :: 14], y[3 + 4 * k :: 14], color=COLOURS[k],
                    linestyle="none", marker=MARKERS[k + 1], markersize=5.0,
                )  # fmt: skip
            ax.axhline(float(values[still].mean()), label=HOVER_LABEL, **HOVER)
            ax.axhline(0.0, color="0.6", linewidth=0.8)
            ax.set_xlabel("advance ratio J = V/(nD) [-]")
            ax.set_ylabel(label)
            ax.set_xlim(0.0, 1.1)
        handles, labels = axes[0].get_legend_handles_labels()
        for k in range(len(curves)):
            handles[1 + k] = Line2D(
                [], [], color=COLOURS[k], marker=MARKERS[k + 1], markersize=5.0, **MODEL
            )
        figure.legend(handles, labels, loc="outside lower center", ncols=5)
    return figure


def oblique_figure(one: Compared, curves: list[ObliqueCurves]) -> Figure:
    """Every load over speed; a column per parameter set, a colour per angle."""
    data = one.data
    still = static_constants(data).loads(OBLIQUE_OMEGA)
    panels = [(load, label) for load, label in PANELS if load in one.measured]
    mine = np.abs(data.omega - OBLIQUE_OMEGA) < 0.01 * OBLIQUE_OMEGA
    with style():
        figure = new_figure(8.6, 2.55 * len(panels))
        axes = figure.subplots(len(panels), 2, sharex=True, sharey="row")
        for column, curve in enumerate(curves):
            axes[0, column].set_title(curve.label, fontsize=9.0)
            for ax, (load, label) in zip(axes[:, column], panels, strict=True):
                ax.axhline(float(still[load]), **HOVER)
                for k, beta in enumerate(BETAS):
                    at = mine & (np.abs(data.beta - beta) < np.radians(0.5))
                    ax.plot(curve.speed, curve.loads[load][k], color=COLOURS[k], **MODEL)
                    ax.plot(
                        data.speed[at], one.measured[load][at], color=COLOURS[k],
                        marker=MARKERS[k], **MEASURED,
                    )  # fmt: skip
                if column == 0:
                    ax.set_ylabel(label)
                ax.margins(x=0.02)
            axes[-1, column].set_xlabel("speed V [m/s]")
        handles = [
            Line2D(
                [], [], color=COLOURS[k], marker=MARKERS[k], markersize=4.5,
                label=f"β = {np.degrees(beta):.0f}°", **MODEL,
            )
            for k, beta in enumerate(BETAS)
        ]  # fmt: skip
        handles.append(Line2D([], [], label=HOVER_LABEL, **HOVER))
        figure.legend(handles=handles, loc="outside lower center", ncols=5)
    return figure


def multirotor_figure(one: Compared, curves: list[ThrustCurve]) -> Figure:
    """Thrust over rotational speed; a panel per parameter set, a colour per flow."""
    data, thrust = one.data, one.measured["thrust"]
    still = static_constants(data)
    labels = list(dict.fromkeys(curve.label for curve in curves))
    bar = DIGITISED * float(thrust.max())
    with style():
        figure = new_figure(9.6, 4.2)
        axes = figure.subplots(1, len(labels), sharey=True)
        for ax, label in zip(axes, labels, strict=True):
            own = [curve for curve in curves if curve.label == label]
            for k, c in enumerate(own):
                at = (np.abs(data.speed - c.speed) < 0.01) & (np.abs(data.beta - c.beta) < 0.01)
                ax.plot(c.omega * RPM / 1e3, c.thrust, color=COLOURS[k], **MODEL)
                ax.errorbar(
                    data.omega[at] * RPM / 1e3, thrust[at], bar, color=COLOURS[k],
                    marker=MARKERS[k], linestyle="none", markersize=4.0, elinewidth=0.8,
                )  # fmt: skip
            ax.plot(own[0].omega * RPM / 1e3, still.thrust(own[0].omega), **HOVER)
            ax.set_title(label, fontsize=9.0)
            ax.set_xlabel("rotational speed [1000/min]")
        axes[0].set_ylabel("thrust T [N]")
        handles = [
            Line2D(
                [], [], color=COLOURS[k], marker=MARKERS[k], markersize=4.5, label=_flow(c), **MODEL
            )
            for k, c in enumerate(own)
        ]
        handles.append(Line2D([], [], label=HOVER_LABEL, **HOVER))
        figure.legend(
            handles=handles,
            loc="outside lower center",
            ncols=6,
            columnspacing=1.2,
            handletextpad=0.5,
            fontsize=8.0,
        )
    return figure


def _flow(curve: ThrustCurve) -> str:
    if curve.speed == 0.0:
        return "at rest"
    return f"{curve.speed:g} m/s, β = {np.degrees(curve.beta):.0f}°"
