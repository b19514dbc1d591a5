"""The fitted parameters: values, intervals, verdicts, and correlations."""

from __future__ import annotations

import itertools

import numpy as np
from matplotlib.figure import Figure

from propmap.fit.fit_record import FitRecord
from propmap.fit.parameters import EVERY, general
from propmap.report.page import csv_of_rows, number
from propmap.report.style import COLOURS, new_figure, style

STRONG = 0.9
"""Correlation from which two parameters are named as a pair."""


@style()
def interval_figure(fit: FitRecord) -> Figure:
    """A line per parameter, from its lower to its upper bound."""
    count = len(fit.parameters)
    figure = new_figure(8.6, 0.32 * count + 0.8)
    ax = figure.subplots()
    for k, p in enumerate(fit.parameters):
        low, value, high = ((v - p.lower) / (p.upper - p.lower) for v in (p.low, p.value, p.high))
        face = COLOURS[0] if p.identified else "white"
        ax.plot([0.0, 1.0], [k, k], color="0.85", linewidth=5.0, solid_capstyle="butt")
        ax.plot([low, high], [k, k], color=COLOURS[0], linewidth=2.0)
        ax.plot(value, k, marker="o", color=COLOURS[0], markerfacecolor=face, clip_on=False)
    ax.set_yticks(range(count), [p.name for p in fit.parameters])
    ax.set_ylim(count - 0.5, -0.5)
    ax.set_xticks([0.0, 1.0], ["lower bound", "upper bound"])
    ax.grid(visible=False)
    ax.tick_params(length=0.0)
    for side in ax.spines.values():
        side.set_visible(False)
    return figure


def parameter_rows(fit: FitRecord) -> list[tuple[str, ...]]:
    """Name, meaning, value, 95 % interval, unit, verdict and its reason; a row per parameter."""
    return [
        (
            p.name,
            EVERY[general(p.name)].meaning if general(p.name) in EVERY else "",
            number(p.value, 4),
            f"{number(p.low)} to {number(p.high)}",
            p.unit,
            "identified" if p.identified else "weak",
            p.verdict.removeprefix("weak").removeprefix("identified").lstrip(":, "),
        )
        for p in fit.parameters
    ]


def correlation_rows(fit: FitRecord) -> list[tuple[str, ...]]:
    """Name and correlations with every parameter; a row per parameter."""
    return [
        (p.name, *(number(round(v, 2) + 0.0 if np.isfinite(v) else None, 2) for v in row))
        for p, row in zip(fit.parameters, fit.correlation.tolist(), strict=True)
    ]


def strong_pairs(fit: FitRecord) -> list[str]:
    """Pairs of parameters with a strong correlation, such as "c_l1 and alpha_0"."""
    pairs = itertools.combinations(enumerate(p.name for p in fit.parameters), 2)
    return [f"{a} and {b}" for (i, a), (j, b) in pairs if abs(fit.correlation[i, j]) >= STRONG]


def parameter_sheet(fit: FitRecord) -> str:
    """Values, intervals and bounds as CSV."""
    return csv_of_rows(
        "parameter unit value low_95 high_95 lower_bound upper_bound identified verdict",
        [
            (p.name, p.unit, p.value, p.low, p.high, p.lower, p.upper, int(p.identified), p.verdict)
            for p in fit.parameters
        ],
    )


def correlation_sheet(fit: FitRecord) -> str:
    """The correlations as CSV."""
    names = [p.name for p in fit.parameters]
    rows = [(n, *row) for n, row in zip(names, fit.correlation.tolist(), strict=True)]
    return csv_of_rows(" ".join(("parameter", *names)), rows)
