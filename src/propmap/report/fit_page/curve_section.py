"""The load curves of a fit on the page."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.fit.fit_record import FitRecord
from propmap.fit.tunnel import TunnelData
from propmap.loads import LOADS
from propmap.report.fit_page.curves import RPM, Curve, Curves
from propmap.report.fit_page.parameter_draws import held
from propmap.report.load_curves import PANELS
from propmap.report.page import Section, Text
from propmap.report.part import Part, files_of, picture
from propmap.report.sheet import csv_of_rows
from propmap.report.style import COLOURS, HOVER, MEASURED, MODEL, new_figure, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NEAR = np.radians(2.5)
"""Of a curve's angle, within which measured points are drawn with it."""

DATA: dict[str, Any] = {"color": "0.92", "linewidth": 0.0}
BAND: dict[str, Any] = {"color": COLOURS[5], "alpha": 0.55, "linewidth": 0.0}


def curve_section(fit: FitRecord, curves: Curves, measured: TunnelData | None) -> Part:
    """Figure, what its bands are, and its numbers."""
    points = (
        ""
        if measured is None
        else " Points: the data given with --data, brought to this rotational speed at their own "
        "advance ratio (loads with Ω², speeds with Ω)."
    )
    shown = picture(
        curve_figure(curves, _seen(fit), measured),
        "fit-loads",
        f"Loads of the fitted propeller at {curves.omega * RPM:.0f} rpm. Solid: this model, "
        "dotted in the vortex ring state. Dashed: hover model. Grey: speeds that the data cover "
        "at this angle, for the loads that they tell of; elsewhere the curve is extrapolation."
        f"{points}",
        "Thrust, rotor drag, torque and rolling moment against speed, a column for each angle.",
    )
    section = Section("loads", "Loads over speed", (shown, Text(_band(fit, curves))))
    return Part(section, files_of(shown) | {"fit-loads.csv": _csv(curves)})


def curve_figure(
    curves: Curves, seen: Collection[str], measured: TunnelData | None = None
) -> Figure:
    """A row per load, a column per angle.

    seen : loads that the data tell of, where their range is shaded.
    measured : points to draw, if any.
    """
    count = len(curves.curves)
    with style():
        figure = new_figure(max(2.35 * count + 0.6, 8.6), 2.15 * len(PANELS))
        axes = figure.subplots(len(PANELS), count, sharex=True, sharey="row", squeeze=False)
        for row, (load, label) in zip(axes, PANELS, strict=True):
            row[0].set_ylabel(label)
            for ax, one in zip(row, curves.curves, strict=True):
                _panel(ax, curves, one, load, shaded=load in seen)
                if measured is not None:
                    _points(ax, curves, one, load, measured)
        for ax, one in zip(axes[0], curves.curves, strict=True):
            data = "" if one.covered else ", no data"
            ax.set_title(f"β = {np.degrees(one.beta):.0f}°{data}", fontsize=9.0)
        for ax in axes[-1]:
            ax.set_xlabel("flight speed V [m/s]")
            ax.set_xlim(0.0, curves.speed[-1])
        figure.legend(handles=_legend(curves, measured), loc="outside lower center", ncols=5)
    return figure


def _panel(ax: Axes, curves: Curves, one: Curve, load: str, *, shaded: bool) -> None:
    if shaded and one.covered is not None:
        ax.axvspan(*one.covered, **DATA)
    if one.low is not None and one.high is not None:
        ax.fill_between(curves.speed, one.low[load], one.high[load], **BAND)
    ax.plot(curves.speed, one.hover[load], **HOVER)
    ax.plot(curves.speed, _where(one.loads[load], one.valid), color=COLOURS[0], **MODEL)
    if not one.valid.all():
        ring = {**MODEL, "linestyle": ":"}
        ax.plot(curves.speed, _where(one.loads[load], ~one.valid), color=COLOURS[0], **ring)


def _seen(fit: FitRecord) -> Collection[str]:
    """Loads that the data tell of: in flight, those that make the forces."""
    if fit.kind == "tunnel":
        return [one.name for one in fit.loads]
    return ("thrust",) if fit.kind == "level flight" else ("thrust", "drag")


def _where(values: Floats, mask: NDArray[np.bool_]) -> Floats:
    return np.where(mask, values, np.nan)


def _points(ax: Axes, curves: Curves, one: Curve, load: str, data: TunnelData) -> None:
    if load not in data.loads:
        return
    ratio = curves.omega / np.maximum(data.omega, 1e-9)
    mine = (np.abs(data.folded_beta - one.beta) < NEAR) | (data.speed == 0.0)
    mine &= (data.omega > 0.0) & (data.speed * ratio <= curves.speed[-1])
    ax.plot(
        (data.speed * ratio)[mine], (data.loads[load] * ratio**2)[mine], color=COLOURS[1],
        marker="o", **{**MEASURED, "markersize": 2.6},
    )  # fmt: skip


def _legend(curves: Curves, measured: TunnelData | None) -> list[Line2D | Patch]:
    handles: list[Line2D | Patch] = [
        Line2D([], [], color=COLOURS[0], label="this model", **MODEL),
        Line2D([], [], label="hover model", **HOVER),
        Patch(label="covered by the data", **DATA),
    ]
    if curves.draws:
        handles.insert(1, Patch(label="95 % by the parameters", **BAND))
    if measured is not None:
        points = {**MEASURED, "markersize": 4.0}
        handles.append(Line2D([], [], color=COLOURS[1], marker="o", label="measured", **points))
    return handles


def _band(fit: FitRecord, curves: Curves) -> str:
    if not curves.draws:
        return (
            "No band is drawn: the data leave the parameters so open, or so hard at their bounds, "
            "that almost no draw from the fit's covariance is within the bounds."
        )
    told = (
        f"Blue bands: the middle 95 % of {curves.draws} curves. For each, parameters are drawn "
        "from the fit's covariance and kept only if all are within their bounds; the loads follow "
        "them linearly, by their derivatives at the fit. A band tells what the "
        "scatter of the data leaves open; it does not hold errors of the theory itself, for which "
        "see the errors above."
    )
    names = held(fit)
    if names:
        told += (
            f" The data say nothing of {', '.join(names)}, held at the start in every draw: where "
            "there were no data the band is too narrow."
        )
    return told


def _csv(curves: Curves) -> str:
    columns = [load.column for load in LOADS.values()]
    ends = [
        f"{name}_{end}_{column.rpartition('_')[2]}"
        for name, column in zip(LOADS, columns, strict=True)
        for end in ("low_95", "high_95")
    ]
    heads = (
        "beta_deg", "speed_mps", "rpm", "advance_ratio", "covered", "momentum_theory_holds",
        *columns, *ends, *(f"hover_{column}" for column in columns),
    )  # fmt: skip
    rows = []
    for one in curves.curves:
        for k, speed in enumerate(curves.speed.tolist()):
            low, high = one.covered or (1.0, 0.0)
            band = [
                float(side[load][k]) if side else None
                for load in LOADS
                for side in (one.low, one.high)
            ]
            rows.append(
                (
                    float(np.degrees(one.beta)), speed, curves.omega * RPM,
                    speed / (curves.omega * curves.radius), int(low <= speed <= high),
                    int(one.valid[k]), *(float(one.loads[load][k]) for load in LOADS), *band,
                    *(float(one.hover[load][k]) for load in LOADS),
                )
            )  # fmt: skip
    return csv_of_rows(heads, rows)
