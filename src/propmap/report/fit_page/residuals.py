"""Pictures of what a model leaves over, against every variable that it may depend on."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from propmap.fit.still_explained import Trend
from propmap.report.fit_page.judgement import label_of
from propmap.report.page import csv_of_columns
from propmap.report.style import BAND, COLOURS, key, legend_below, new_figure, style
from propmap.typing import Floats

BINS = 8
"""Of equal numbers of samples."""

SPREAD = (10.0, 90.0)
"""Percentiles of the residuals of a bin that are shaded."""

COLUMNS = 5


def binned(trend: Trend) -> dict[str, Floats]:
    """Bins of a ``trend``: ends, middle, mean residual, its block-wise standard error, percentiles.

    Of each, an array (bins,); errors within a stretch of time count as one.
    """
    ends = np.unique(np.percentile(trend.at, np.linspace(0.0, 100.0, BINS + 1)))
    place = np.clip(np.searchsorted(ends, trend.at, side="right") - 1, 0, max(ends.size - 2, 0))
    rows = []
    for k in np.unique(place):
        mine = place == k
        off = trend.residual[mine]
        _, block = np.unique(trend.block[mine], return_inverse=True)
        sums = np.bincount(block, weights=off - off.mean())
        error = float(np.sqrt(sums @ sums)) / off.size
        low, high = ends[k], ends[min(k + 1, ends.size - 1)]
        middle = float(np.mean(trend.at[mine]))
        rows.append((low, high, middle, off.mean(), error, *np.percentile(off, SPREAD), off.size))
    names = ("from", "to", "middle", "mean", "error", "low", "high", "samples")
    return dict(zip(names, np.array(rows).T, strict=True))


@style()
def residual_figure(trends: Sequence[Trend]) -> Figure:
    """Residuals of one load against every candidate, the strongest first.

    Parameters
    ----------
    trends : sequence of Trend
        Of one load.
    """
    rows = -(-len(trends) // COLUMNS)
    figure = new_figure(11.5, 2.25 * rows + 0.7)
    axes = figure.subplots(rows, COLUMNS, squeeze=False, sharey=True)
    for ax in axes.ravel()[len(trends) :]:
        ax.axis("off")
    for ax, trend in zip(axes.ravel(), trends, strict=False):
        colour, found = COLOURS[1 if trend.tells else 0], binned(trend)
        ax.axhline(0.0, color="0.5", linewidth=0.8)
        ax.fill_between(found["middle"], found["low"], found["high"], color=colour, **BAND)
        ax.errorbar(
            found["middle"], found["mean"], 2.0 * found["error"], color=colour, marker="o",
            markersize=3.5, linewidth=1.3, elinewidth=1.0, capsize=2.0,
        )  # fmt: skip
        ax.set_xlabel(_in_two_lines(trend.variable), fontsize=7.5)
        ax.tick_params(labelsize=7.5)
        share = f"{100.0 * trend.share:.0f} % of the variance"
        ax.set_title(share, fontsize=8.0, fontweight="bold" if trend.tells else "normal")
    for ax in axes[:, 0]:
        ax.set_ylabel(f"error [{trends[0].unit}]")
    look: dict[str, Any] = {"marker": "o", "markersize": 4.0, "linewidth": 1.3}
    legend_below(
        figure,
        [
            key("still explains something", color=COLOURS[1], **look),
            key("no more than chance, or little", color=COLOURS[0], **look),
            key("mean and two standard errors of it, by stretches of 1 s", color="0.3", **look),
            key("middle 80 % of the samples", color="0.7", linewidth=6.0),
        ],
        fontsize=8.5,
    )
    figure.suptitle(f"{label_of(trends[0].load)}: model minus measurement")
    return figure


def residual_sheet(trends: Sequence[Trend]) -> str:
    """The bins as CSV; ``trends`` are those of one load."""
    groups = []
    for trend in trends:
        found = binned(trend)
        name, _, unit = trend.variable.rstrip("]").partition(" [")
        groups.append(
            {
                "load": trend.load,
                "unit": trend.unit,
                "variable": name,
                "variable_unit": unit,
                "share_of_variance": trend.share,
                "slope": trend.slope,
                "slope_error": trend.error,
                **{f"bin_{end}": found[end] for end in ("from", "to", "middle")},
                "mean_in_unit": found["mean"],
                "mean_error_in_unit": found["error"],
                "low_10_in_unit": found["low"],
                "high_90_in_unit": found["high"],
                "samples": found["samples"],
            }
        )
    return csv_of_columns(groups)


def sentences(loads: Sequence[Sequence[Trend]]) -> list[str]:
    """What still explains something, the strongest first; a sequence of trends per load."""
    telling = [trend for trend in itertools.chain(*loads) if trend.tells]
    return [trend.sentence for trend in sorted(telling, key=lambda trend: -trend.share)]


def _in_two_lines(name: str) -> str:
    """A long name broken before its unit."""
    name = name.replace("^2", "²")
    return name.replace(" [", "\n[") if len(name) > 24 else name
