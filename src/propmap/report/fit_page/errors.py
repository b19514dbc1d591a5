"""Errors by load and band of speed, beside the hover model's."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from propmap.fit.residuals import Errors
from propmap.report.fit_page.judgement import Judged, label_of, shown_band
from propmap.report.page import csv_of_rows, number
from propmap.report.style import COLOURS, HOVER, MARKERS, legend_below, new_figure, style

Bands = Mapping[tuple[str, str], Mapping[str, Errors]]
"""Errors by load with its unit, then by band of speed."""


@style()
def band_figure(bands: Bands) -> Figure:
    """A panel per load; bands in the order of speed."""
    columns = min(len(bands), 3)
    rows = -(-len(bands) // columns)
    figure = new_figure(8.6, 2.7 * rows + 0.4)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax in axes[len(bands) :]:
        ax.axis("off")
    for ax, ((load, unit), found) in zip(axes, bands.items(), strict=False):
        x, errors = range(len(found)), found.values()
        ax.plot(
            x, [e.hover_rms for e in errors], marker="x", markersize=5.0, label="hover model",
            **HOVER,
        )  # fmt: skip
        ax.plot(
            x, [e.rms for e in errors], color=COLOURS[0], marker=MARKERS[0], markersize=4.5,
            linewidth=1.6, label="this model",
        )  # fmt: skip
        ax.set_xticks(list(x), [_tick(band) for band in found])
        ax.tick_params(axis="x", labelsize=7.5)
        ax.set_ylim(bottom=0.0)
        ax.margins(x=0.08)
        ax.set_ylabel(f"{label_of(load)}: rms error [{unit}]")
        ax.set_xlabel("flight speed V [m/s]")
    legend_below(figure, axes[0].get_legend_handles_labels()[0][::-1])
    return figure


def band_rows(bands: Bands) -> list[tuple[str, ...]]:
    """Load, speed, rows, rms, the hover model's, mean and worst; a row per load and band."""
    return [
        (
            f"{label_of(load)} [{unit}]" if k == 0 else "",
            shown_band(band),
            str(e.rows),
            *(number(v, 2) for v in (e.rms, e.hover_rms, e.bias, e.worst)),
        )
        for (load, unit), found in bands.items()
        for k, (band, e) in enumerate(found.items())
    ]


def band_sheet(bands: Bands) -> str:
    """The same as CSV."""
    return csv_of_rows(
        "load unit speed_band rows rms_in_unit mean_in_unit worst_in_unit hover_rms_in_unit",
        [
            (*load, band, e.rows, e.rms, e.bias, e.worst, e.hover_rms)
            for load, found in bands.items()
            for band, e in found.items()
        ],
    )


def whole_rows(loads: Sequence[Judged]) -> list[tuple[str, ...]]:
    """Load, rows, and three errors with their shares: rms, cross-validated, the hover model's."""
    rows = []
    for one in loads:
        errors = (one.load.rms, one.load.cross_validated, one.load.hover_rms)
        cells = [
            (f"{number(e)} {one.load.unit}", number(100.0 * e / one.reference, 2)) for e in errors
        ]
        if not math.isfinite(one.load.cross_validated):
            cells[1] = ("not done", number(None))
        rows.append((one.label, str(one.load.rows), *itertools.chain(*cells)))
    return rows


def _tick(band: str) -> str:
    """A band of speed, short enough to stand beside its neighbours."""
    return shown_band(band.removesuffix(" m/s")).replace("above\N{NO-BREAK SPACE}", "> ")
