"""What a fit was fitted to, and where it extrapolates."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from propmap.fit.coverage import Covered, CoveredAngle
from propmap.fit.fit_record import FitRecord
from propmap.report.page import csv_of_rows
from propmap.report.style import COLOURS, new_figure, style

GAP, STEP = 22.5, 15
"""[deg]: angles further than the first from all data have none; they are told in such steps."""


@style()
def coverage_figure(fit: FitRecord) -> Figure:
    """Boxes over advance ratio and angle, with the number of operating points in each."""
    figure = new_figure(8.6, 3.6)
    ax = figure.subplots()
    small: dict[str, Any] = {"textcoords": "offset points", "fontsize": 8.0}
    for one in fit.covered.angles:
        left, right = one.advance
        # A single angle gets a box that can be seen.
        low, high = (
            min(one.beta[0], one.typical_beta - 1.5),
            max(one.beta[1], one.typical_beta + 1.5),
        )
        ax.fill([left, right, right, left], [low, low, high, high], facecolor=COLOURS[0],
                alpha=0.35, edgecolor=COLOURS[0], linewidth=1.2)  # fmt: skip
        ax.annotate(str(one.points), (right, 0.5 * (low + high)), (4, 0), va="center", **small)
    rest = fit.covered.at_rest
    if rest is not None:
        cross: dict[str, Any] = {
            "marker": "X",
            "markersize": 7.0,
            "linestyle": "none",
            "clip_on": False,
        }
        ax.plot(0.0, 0.0, color=COLOURS[1], **cross)
        ax.annotate(f"at rest: {rest.points}", (0.0, 0.0), (8, 5), **small)
    top = max((one.advance[1] for one in fit.covered.angles), default=0.2)
    descent = max((one.beta[1] for one in fit.covered.angles), default=90.0) > 95.0
    ax.set_xlim(0.0, 1.25 * top)
    ax.set_ylim(-8.0, 185.0 if descent else 98.0)
    ax.set_yticks(np.arange(0, 181 if descent else 91, 30))
    ax.set_xlabel("advance ratio V/(ΩR) [-]")
    ax.set_ylabel("angle β of the flow to the axis [deg]")
    ax.set_title("numbers: operating points in each group", fontsize=9.0)
    return figure


def file_rows(fit: FitRecord) -> list[tuple[str, str]]:
    """Name and SHA-256; a row per file."""
    return [(one.name, one.sha256 or "part of propmap") for one in fit.data]


def range_rows(fit: FitRecord) -> list[tuple[str, ...]]:
    """Angle, points, speeds, rotational speeds and advance ratios; a row per group."""
    return [
        (
            name,
            str(one.points),
            f"{one.speed[0]:.1f} to {one.speed[1]:.1f}",
            f"{one.rpm[0]:.0f} to {one.rpm[1]:.0f}",
            f"{one.advance[0]:.3f} to {one.advance[1]:.3f}",
        )
        for name, one in _groups(fit).items()
    ]


def coverage_sheet(fit: FitRecord) -> str:
    """The ranges as CSV."""
    return csv_of_rows(
        "group points beta_from_deg beta_to_deg speed_from_mps speed_to_mps rpm_from rpm_to "
        "advance_from advance_to",
        [
            (
                name,
                one.points,
                *(one.beta if isinstance(one, CoveredAngle) else (None, None)),
                *one.speed,
                *one.rpm,
                *one.advance,
            )
            for name, one in _groups(fit).items()
        ],
    )


def angles_without_data(fit: FitRecord) -> str:
    """Angles far from all data, such as "30° to 60° and about 180°"; empty if there are none."""
    angles = [one.typical_beta for one in fit.covered.main_angles]
    far = [beta for beta in range(0, 181, STEP) if all(abs(beta - a) > GAP for a in angles)]
    spans = []
    for _, group in itertools.groupby(enumerate(far), lambda pair: pair[1] - STEP * pair[0]):
        _, run = zip(*group, strict=True)
        spans.append(f"{run[0]}° to {run[-1]}°" if len(run) > 1 else f"about {run[0]}°")
    return " and ".join(spans)


def _groups(fit: FitRecord) -> dict[str, Covered]:
    """The points at rest and those about each angle, by name."""
    rest = fit.covered.at_rest
    named: dict[str, Covered] = {} if rest is None else {"at rest": rest}
    return named | {f"{one.typical_beta:.0f}°": one for one in fit.covered.angles}
