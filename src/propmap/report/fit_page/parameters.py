"""The fitted parameters: values, intervals, verdicts, and what hangs together."""

from __future__ import annotations

import itertools

import numpy as np
from matplotlib.figure import Figure

from propmap.fit.fit_record import FitRecord, FreeParameter
from propmap.fit.parameters import EVERY
from propmap.report.page import MINUS, Section, Table, Text, number
from propmap.report.part import Part, files_of, picture
from propmap.report.sheet import csv_of_rows
from propmap.report.style import COLOURS, new_figure, style

STRONG = 0.9
"""Correlation from which two parameters are named as a pair."""


def parameter_section(fit: FitRecord) -> Part:
    """Table, intervals, correlations and singular values."""
    shown = picture(
        interval_figure(fit),
        "fit-parameters",
        "95 % intervals, each from its parameter's lower to its upper bound. Filled: identified. "
        "Open: the data alone do not determine it.",
        "Intervals of the parameters within their bounds.",
    )
    weak = [p.name for p in fit.parameters if not p.identified]
    told = (
        "Every parameter is identified: its interval is well inside what propellers differ by."
        if not weak
        else f"Do not read {', '.join(weak)} as properties of the blade. The loads where there "
        "were data may be good all the same, and the shaded bands of the load curves show what "
        "the doubt means elsewhere."
    )
    section = Section(
        "parameters",
        "Parameters",
        (_table(fit), Text(told), shown, _correlations(fit), Text(_singular(fit))),
    )
    files = files_of(shown) | {
        "fit-parameters.csv": _csv(fit),
        "fit-correlations.csv": _correlations_csv(fit),
    }
    return Part(section, files)


def interval_figure(fit: FitRecord) -> Figure:
    """A line per parameter, from its lower to its upper bound."""
    count = len(fit.parameters)
    with style():
        figure = new_figure(8.6, 0.32 * count + 0.8)
        ax = figure.subplots()
        for k, p in enumerate(fit.parameters):
            low, value, high = (
                (v - p.lower) / (p.upper - p.lower) for v in (p.low, p.value, p.high)
            )
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


def _table(fit: FitRecord) -> Table:
    rows = tuple(
        (
            p.name,
            EVERY[p.name].meaning if p.name in EVERY else "",
            number(p.value, 4),
            f"{number(p.low)} to {number(p.high)}",
            p.unit,
            "identified" if p.identified else "weak",
            _reason(p),
        )
        for p in fit.parameters
    )
    columns = (
        ("parameter", ""), ("is", ""), ("value", ""), ("95 % interval", ""), ("unit", ""),
        ("verdict", ""), ("why", ""),
    )  # fmt: skip
    return Table("What the fit found.", columns, rows)


def _reason(p: FreeParameter) -> str:
    """The verdict after its first word."""
    return p.verdict.removeprefix("weak").removeprefix("identified").lstrip(":, ")


def _correlations(fit: FitRecord) -> Table:
    names = [p.name for p in fit.parameters]
    rows = tuple(
        (name, *(number(round(v, 2) + 0.0, 2) if np.isfinite(v) else number(None) for v in row))
        for name, row in zip(names, fit.correlation.tolist(), strict=True)
    )
    pairs = [
        f"{names[i]} and {names[j]}"
        for i, j in itertools.combinations(range(len(names)), 2)
        if abs(fit.correlation[i, j]) >= STRONG
    ]
    note = (
        f"Near 1 or {MINUS}1: the data fix a combination of the two better than either by itself."
    )
    if pairs:
        note += f" Here: {', '.join(pairs)}."
    columns = (("", ""), *((name, "-") for name in names))
    return Table("Correlations of the parameters' errors.", columns, rows, note)


def _singular(fit: FitRecord) -> str:
    values = ", ".join(number(v, 2) for v in fit.singular_values)
    least = float(fit.singular_values[-1])
    told = (
        f"Singular values of the sensitivities, relative to the largest: {values}. There is one "
        "for each independent combination of parameters, and it says how strongly the data see "
        "that combination."
    )
    if least < 0.01:
        return told + " The last is below 0.01: the data hardly see that combination."
    return told + " None is below 0.01: the data see every combination."


def _csv(fit: FitRecord) -> str:
    heads = ("parameter", "unit", "value", "low_95", "high_95", "lower_bound", "upper_bound",
             "identified", "verdict")  # fmt: skip
    rows = [
        (p.name, p.unit, p.value, p.low, p.high, p.lower, p.upper, int(p.identified), p.verdict)
        for p in fit.parameters
    ]
    return csv_of_rows(heads, rows)


def _correlations_csv(fit: FitRecord) -> str:
    names = [p.name for p in fit.parameters]
    rows = [(n, *r) for n, r in zip(names, fit.correlation.tolist(), strict=True)]
    return csv_of_rows(("parameter", *names), rows)
