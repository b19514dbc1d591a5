"""Figure 7, the APC 8x6E and an 8x4.5 in the tunnel, and what camber explains of it."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from propmap.fit.least_squares import rms
from propmap.loads import LOADS
from propmap.papers.gill_dandrea_2017.tunnel import (
    DIGITISED,
    HOVER_LABEL,
    OTHER_LABEL,
    Compared,
    LoadError,
    static_constants,
)
from propmap.papers.gill_dandrea_2017.tunnel_curves import (
    BETAS,
    OBLIQUE_OMEGA,
    Coefficients,
    ThrustCurve,
    measured_coefficients,
)
from propmap.report.html import (
    BAND,
    COLOURS,
    HOVER,
    MARKERS,
    MEASURED,
    MODEL,
    angle_keys,
    csv_of_columns,
    csv_of_rows,
    key,
    legend_below,
    marked,
    new_figure,
    number,
    style,
)
from propmap.typing import Floats
from propmap.units import RPM

SYMBOLS = {"thrust": "C_T", "power": "C_P"}


@style()
def axial_figure(one: Compared, curves: dict[str, Coefficients]) -> Figure:
    """C_T and C_P over J."""
    measured, still = measured_coefficients(one.data), one.data.speed == 0.0
    figure = new_figure(9.2, 4.2)
    axes = figure.subplots(1, 2)
    for ax, part, symbol in zip(axes, ("thrust", "power"), "TP", strict=True):
        values = getattr(measured, part)
        ax.plot(
            measured.advance, values, color="0.45", marker="o", linestyle="none", markersize=3.0,
            label="UIUC, measured", clip_on=False,
        )  # fmt: skip
        for k, (label, curve) in enumerate(curves.items()):
            y, every = getattr(curve, part), slice(3 + 4 * k, None, 14)
            ax.plot(curve.advance, y, color=COLOURS[k], label=label, **MODEL)
            ax.plot(curve.advance[every], y[every], linestyle="none", **_look(k))
        ax.axhline(float(values[still].mean()), label=HOVER_LABEL, **HOVER)
        ax.axhline(0.0, color="0.6", linewidth=0.8)
        ax.set_xlabel("advance ratio J = V/(nD) [-]")
        ax.set_ylabel(f"{part} coefficient $C_{symbol}$ [-]")
        ax.set_xlim(0.0, 1.1)
    handles = axes[0].get_legend_handles_labels()[0]
    for k, label in enumerate(curves):
        handles[1 + k] = key(label, **_look(k), **MODEL)
    legend_below(figure, handles)
    return figure


@style()
def oblique_figure(one: Compared, curves: tuple[Floats, dict[str, dict[str, Floats]]]) -> Figure:
    """Every load over speed; a column per parameter set, a colour per angle."""
    data, (speed, by_label) = one.data, curves
    hover = static_constants(data).loads(OBLIQUE_OMEGA)
    measured = {name: load for name, load in LOADS.items() if name in data.loads}
    mine = np.abs(data.omega - OBLIQUE_OMEGA) < 0.01 * OBLIQUE_OMEGA
    other = one.predicted[OTHER_LABEL]
    figure = new_figure(9.6, 2.3 * len(measured))
    axes = figure.subplots(len(measured), len(by_label), sharex=True, sharey="row")
    for column, (label, loads) in zip(axes.T, by_label.items(), strict=True):
        column[0].set_title(label, fontsize=9.0)
        for ax, name in zip(column, measured, strict=True):
            ax.axhline(float(hover[name]), **HOVER)
            for k, beta in enumerate(BETAS):
                at = mine & (np.abs(data.beta - beta) < np.radians(0.5))
                if name in other:
                    edges = (data.loads[name][at], other[name][at])
                    ax.fill_between(data.speed[at], *edges, color=COLOURS[k], **BAND)
                ax.plot(speed, loads[name][k], color=COLOURS[k], **MODEL)
                ax.plot(data.speed[at], data.loads[name][at], **marked(k), **MEASURED)
            ax.margins(x=0.02)
        column[-1].set_xlabel("speed V [m/s]")
    for ax, load in zip(axes[:, 0], measured.values(), strict=True):
        ax.set_ylabel(load.title)
    handles: list[Any] = [*angle_keys(BETAS, markersize=4.5, **MODEL), key(HOVER_LABEL, **HOVER)]
    handles.append(Patch(label="to the campaign's model", color="0.4", **BAND))
    legend_below(figure, handles)
    return figure


@style()
def multirotor_figure(one: Compared, curves: list[ThrustCurve]) -> Figure:
    """Thrust over rotational speed; a panel per parameter set, a colour per flow."""
    data, thrust = one.data, one.data.loads["thrust"]
    still = static_constants(data)
    labels = list(dict.fromkeys(curve.label for curve in curves))
    bar = DIGITISED * float(thrust.max())
    figure = new_figure(9.6, 4.2)
    axes = figure.subplots(1, len(labels), sharey=True)
    for ax, label in zip(axes, labels, strict=True):
        own = [curve for curve in curves if curve.label == label]
        for k, c in enumerate(own):
            at = (np.abs(data.speed - c.speed) < 0.01) & (np.abs(data.beta - c.beta) < 0.01)
            ax.plot(c.omega / RPM / 1e3, c.thrust, color=COLOURS[k], **MODEL)
            ax.errorbar(
                data.omega[at] / RPM / 1e3, thrust[at], bar, linestyle="none", markersize=4.0,
                elinewidth=0.8, **marked(k),
            )  # fmt: skip
        ax.plot(own[0].omega / RPM / 1e3, still.thrust(own[0].omega), **HOVER)
        ax.set_title(label, fontsize=9.0)
        ax.set_xlabel("rotational speed [1000/min]")
    axes[0].set_ylabel("thrust T [N]")
    handles = [key(_flow(c), markersize=4.5, **marked(k), **MODEL) for k, c in enumerate(own)]
    handles.append(key(HOVER_LABEL, **HOVER))
    legend_below(figure, handles, 6, columnspacing=1.2, handletextpad=0.5, fontsize=8.0)
    return figure


@style()
def camber_figure(one: Compared, curves: dict[str, Coefficients]) -> Figure:
    """Model less measured over J."""
    advance = measured_coefficients(one.data).advance
    figure = new_figure(9.2, 4.0)
    axes = figure.subplots(1, 2)
    for ax, (part, symbol) in zip(axes, SYMBOLS.items(), strict=True):
        ax.axhline(0.0, color="0.4", linewidth=0.8)
        for k, (label, curve) in enumerate(curves.items()):
            ax.plot(
                advance, coefficient_error(one, curve, part), linestyle="none", markersize=3.5,
                label=label, clip_on=False, **marked(k),
            )  # fmt: skip
        ax.set_xlabel("advance ratio J = V/(nD) [-]")
        ax.set_ylabel(f"model less measured ${symbol}$ [-]")
    legend_below(figure, axes[0].get_legend_handles_labels()[0])
    return figure


def coefficient_error(one: Compared, curve: Coefficients, part: str) -> Floats:
    """Model less measured thrust or power coefficient (n,)."""
    measured = measured_coefficients(one.data)
    model = np.interp(measured.advance, curve.advance, getattr(curve, part))
    return np.asarray(model - getattr(measured, part))


def rms_errors(one: Compared, curve: Coefficients) -> list[float]:
    """Root mean squares of the errors of the coefficients [-], in the order of ``SYMBOLS``."""
    return [rms(coefficient_error(one, curve, part)) for part in SYMBOLS]


def camber_sheet(one: Compared, curves: dict[str, Coefficients]) -> str:
    """The figure's numbers as CSV."""
    advance, thrust, power = measured_coefficients(one.data)
    columns = {"advance_ratio": advance, "measured_C_T": thrust, "measured_C_P": power}
    for label, curve in curves.items():
        for part, symbol in SYMBOLS.items():
            columns[f"{_slug(label)}_{symbol}_error"] = coefficient_error(one, curve, part)
    return csv_of_columns([columns])


def error_rows(errors: list[LoadError]) -> list[tuple[str, ...]]:
    """Load, model, errors and their shares, share of points within 9 %; of one data set."""
    above = ["", *(e.load for e in errors)]
    return [
        (
            "" if e.load == before else e.load.replace("_", " "),
            e.model,
            f"{number(e.rms, 2)} {e.unit}",
            f"{100 * e.rms_share:.0f}",
            f"{number(e.worst, 2)} {e.unit}",
            f"{100 * e.worst_share:.0f}",
            f"{100 * e.within_nine:.0f}",
        )
        for e, before in zip(errors, above, strict=False)
    ]


def sheets(
    tunnel: dict[str, str], found: dict[str, Compared], errors: list[LoadError]
) -> dict[str, str]:
    """The CSV files; ``tunnel`` names the file of each data set."""
    return {file: _rows(found[data]) for data, file in tunnel.items()} | {
        "figure-7-errors": csv_of_rows(
            "data_set load model points unit rms_error_in_unit worst_error_in_unit "
            "rms_over_rms_measured worst_over_largest_measured share_within_9_percent",
            [
                (e.data_set, e.load, e.model, e.points, e.unit, e.rms, e.worst, e.rms_share,
                 e.worst_share, e.within_nine)
                for e in errors
            ],
        )
    }  # fmt: skip


def _slug(label: str) -> str:
    """A label as part of the name of a column."""
    return label.lower().replace(",", "").replace(" ", "_")


def _rows(one: Compared) -> str:
    data = one.data
    columns: dict[str, Any] = {"rpm": data.omega / RPM, "speed_mps": data.speed}
    columns["beta_deg"] = np.degrees(data.beta)
    for load, truth in data.loads.items():
        columns[f"measured_{LOADS[load].column}"] = truth
        for model, values in one.predicted.items():
            if load in values:
                columns[f"{_slug(model)}_{LOADS[load].column}"] = values[load]
    return csv_of_columns([columns])


def _look(k: int) -> dict[str, Any]:
    """Of the points on axial line k."""
    return {"color": COLOURS[k], "marker": MARKERS[k + 1], "markersize": 5.0}


def _flow(curve: ThrustCurve) -> str:
    if curve.speed == 0.0:
        return "at rest"
    return f"{curve.speed:g} m/s, β = {np.degrees(curve.beta):.0f}°"
