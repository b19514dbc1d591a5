"""What does not agree, first: camber."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from propmap.arrays.types import Floats
from propmap.papers.gill_dandrea_2017.pages.figure_7 import slug
from propmap.papers.gill_dandrea_2017.tunnel import Compared
from propmap.papers.gill_dandrea_2017.tunnel_curves import Coefficients, measured_coefficients
from propmap.report.page import csv_of_columns
from propmap.report.style import legend_below, marked, new_figure, style

SYMBOLS = {"thrust": "C_T", "power": "C_P"}


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


def camber_sheet(one: Compared, curves: dict[str, Coefficients]) -> str:
    """The figure's numbers as CSV."""
    advance, thrust, power = measured_coefficients(one.data)
    columns = {"advance_ratio": advance, "measured_C_T": thrust, "measured_C_P": power}
    for label, curve in curves.items():
        for part, symbol in SYMBOLS.items():
            columns[f"{slug(label)}_{symbol}_error"] = coefficient_error(one, curve, part)
    return csv_of_columns(columns)
