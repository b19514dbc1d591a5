"""What a fit was fitted to, and what is extrapolation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from propmap.fit.coverage import Covered, CoveredAngle
from propmap.fit.fit_record import FitRecord
from propmap.report.page import Section, Table, Text, number
from propmap.report.part import Part, files_of, picture
from propmap.report.sheet import csv_of_rows
from propmap.report.style import COLOURS, new_figure, style

GAP = 22.5
"""Distance [deg] of an angle from the nearest data from which it is said to have none."""


def data_section(fit: FitRecord) -> Part:
    """Files with hashes, and ranges by angle."""
    shown = picture(
        coverage_figure(fit),
        "fit-coverage",
        "Operating points of the data: each box spans the advance ratios V/(ΩR) and the angles of "
        "one group, the cross its points at rest. Elsewhere the model extrapolates. Loads over Ω² "
        "depend on these two and on little else.",
        "Advance ratios and angles that the data cover.",
    )
    section = Section(
        "data",
        "What it was fitted to, and what is extrapolation",
        (_files(fit), shown, _ranges(fit), Text(_extrapolation(fit))),
    )
    return Part(section, files_of(shown) | {"fit-coverage.csv": _csv(fit)})


def coverage_figure(fit: FitRecord) -> Figure:
    """Boxes over advance ratio and angle."""
    with style():
        figure = new_figure(8.6, 3.6)
        ax = figure.subplots()
        for one in fit.covered.angles:
            (left, right), (low, high) = one.advance, one.beta
            # A single angle gets a box that can be seen.
            low, high = min(low, one.typical_beta - 1.5), max(high, one.typical_beta + 1.5)
            ax.fill([left, right, right, left], [low, low, high, high], facecolor=COLOURS[0],
                    alpha=0.35, edgecolor=COLOURS[0], linewidth=1.2)  # fmt: skip
            ax.annotate(str(one.points), (right, 0.5 * (low + high)), (4, 0),
                        textcoords="offset points", va="center", fontsize=8.0)  # fmt: skip
        if fit.covered.at_rest is not None:
            ax.plot(0.0, 0.0, marker="X", color=COLOURS[1], markersize=7.0, linestyle="none",
                    clip_on=False)  # fmt: skip
            ax.annotate(f"at rest: {fit.covered.at_rest.points}", (0.0, 0.0), (8, 5),
                        textcoords="offset points", fontsize=8.0)  # fmt: skip
        top = max([one.advance[1] for one in fit.covered.angles], default=0.2)
        steepest = max([one.beta[1] for one in fit.covered.angles], default=90.0)
        ax.set_xlim(0.0, 1.25 * top)
        ax.set_ylim(-8.0, 185.0 if steepest > 95.0 else 98.0)
        ax.set_yticks(np.arange(0, 181 if steepest > 95.0 else 91, 30))
        ax.set_xlabel("advance ratio V/(ΩR) [-]")
        ax.set_ylabel("angle β of the flow to the axis [deg]")
        ax.set_title("numbers: operating points in each group", fontsize=9.0)
    return figure


def _files(fit: FitRecord) -> Table:
    rows = tuple((one.name, one.sha256 or "part of propmap") for one in fit.data)
    note = "A file is the one fitted if its SHA-256 is the same (sha256sum FILE)."
    return Table("Data of the fit.", (("file", ""), ("SHA-256", "")), rows, note)


def groups(fit: FitRecord) -> Sequence[tuple[str, Covered]]:
    """The points at rest and those about each angle, with a name."""
    named = [] if fit.covered.at_rest is None else [("at rest", fit.covered.at_rest)]
    return [*named, *((f"{one.typical_beta:.0f}°", one) for one in fit.covered.angles)]


def _ranges(fit: FitRecord) -> Table:
    rows = tuple(
        (
            name,
            str(one.points),
            f"{one.speed[0]:.1f} to {one.speed[1]:.1f}",
            f"{one.rpm[0]:.0f} to {one.rpm[1]:.0f}",
            f"{one.advance[0]:.3f} to {one.advance[1]:.3f}",
        )
        for name, one in groups(fit)
    )
    columns = (
        ("angle β", ""),
        ("points", "-"),
        ("speed", "m/s"),
        ("rotational speed", "1/min"),
        ("advance ratio", "-"),
    )
    note = "β: 0° climb along the axis, 90° edgewise flight, 180° descent along the axis."
    if fit.kind != "tunnel":
        note += " Points are those of every rotor."
    return Table("Operating points of the data.", columns, rows, note)


def _extrapolation(fit: FitRecord) -> str:
    angles = [one.typical_beta for one in fit.covered.main_angles]
    if not angles:
        return (
            "All data are from rest: every speed above zero is extrapolation, at every angle. Add "
            "data at speed."
        )
    far = [beta for beta in range(0, 181, 15) if min(abs(beta - a) for a in angles) > GAP]
    top = max(one.advance[1] for one in fit.covered.main_angles)
    told = f"Extrapolation: advance ratios above {number(top, 2)}"
    if far:
        told += f"; angles {_spans(far)} (flow from there was never measured)"
    low, high = fit.covered.rpm
    rpm = f"; rotational speeds outside {low:.0f} to {high:.0f} rpm, which matter less"
    return told + rpm + ", as they enter through the Reynolds number alone."


def _spans(angles: list[int]) -> str:
    spans: list[list[int]] = []
    for angle in angles:
        if spans and angle - spans[-1][1] == 15:
            spans[-1][1] = angle
        else:
            spans.append([angle, angle])
    return " and ".join(f"{a}° to {b}°" if a != b else f"about {a}°" for a, b in spans)


def _csv(fit: FitRecord) -> str:
    heads = ("group", "points", "beta_from_deg", "beta_to_deg", "speed_from_mps", "speed_to_mps",
             "rpm_from", "rpm_to", "advance_from", "advance_to")  # fmt: skip
    rows = [
        (
            name,
            one.points,
            *(one.beta if isinstance(one, CoveredAngle) else (None, None)),
            *one.speed,
            *one.rpm,
            *one.advance,
        )
        for name, one in groups(fit)
    ]
    return csv_of_rows(heads, rows)
