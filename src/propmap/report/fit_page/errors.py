"""The errors that a fit leaves, by load and speed, beside the hover model's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from propmap.fit.fit_record import FitRecord
from propmap.report.fit_page.judgement import NAMES, Judged, judged, shown_band
from propmap.report.page import Section, Table, number
from propmap.report.part import Part, files_of, picture
from propmap.report.sheet import csv_of_rows
from propmap.report.style import COLOURS, HOVER, MARKERS, new_figure, style


@dataclass(frozen=True)
class BandErrors:
    """Errors of one load in one band of speed: of this model, its bias, and the hover model's."""

    load: str
    unit: str
    band: str
    rows: int
    rms: float
    bias: float
    worst: float
    hover_rms: float


def error_section(fit: FitRecord) -> Part:
    """A table over all speeds, a figure and a table by band."""
    bands = [
        BandErrors(
            one.name, one.unit, band, e.rows, e.rms, e.bias, e.worst, e.hover_rms
        )
        for one in fit.loads
        for band, e in one.by_speed.items()
    ]  # fmt: skip
    shown = picture(
        band_figure(bands),
        "fit-errors",
        "Rms error by band of flight speed, on the fitted data. Solid: this model. Dashed: the "
        "hover model with the constants of the same rotor at rest.",
        "Rms errors of both models against speed.",
    )
    section = Section(
        "errors",
        "Errors on the fitted data",
        (
            _whole(judged(fit)),
            shown,
            band_table(bands, "By band of speed: model minus measurement."),
        ),
    )
    return Part(section, files_of(shown) | {"fit-errors.csv": band_csv(bands)})


def band_figure(bands: Sequence[BandErrors]) -> Figure:
    """A panel per load; bands in the order of speed."""
    loads = list(dict.fromkeys(b.load for b in bands))
    columns = min(len(loads), 3)
    rows = -(-len(loads) // columns)
    with style():
        figure = new_figure(8.6, 2.7 * rows + 0.4)
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for ax in axes[len(loads) :]:
            ax.axis("off")
        for k, (ax, load) in enumerate(zip(axes, loads, strict=False)):
            mine = [b for b in bands if b.load == load]
            x = range(len(mine))
            ax.plot(
                x, [b.hover_rms for b in mine], marker="x", markersize=5.0, label="hover model",
                **HOVER,
            )  # fmt: skip
            ax.plot(
                x, [b.rms for b in mine], color=COLOURS[0], marker=MARKERS[0], markersize=4.5,
                linewidth=1.6, label="this model",
            )  # fmt: skip
            ax.set_xticks(list(x), [_tick(b.band) for b in mine])
            ax.tick_params(axis="x", labelsize=7.5)
            ax.set_ylim(bottom=0.0)
            ax.margins(x=0.08)
            ax.set_ylabel(f"{NAMES.get(load, load)}: rms error [{mine[0].unit}]")
            ax.set_xlabel("flight speed V [m/s]")
            if k == 0:
                handles, labels = ax.get_legend_handles_labels()
        figure.legend(handles[::-1], labels[::-1], loc="outside lower center", ncols=2)
    return figure


def band_table(bands: Sequence[BandErrors], caption: str) -> Table:
    """A line per load and band."""
    rows, above = [], ""
    for b in bands:
        name = NAMES.get(b.load, b.load)
        rows.append(
            (
                "" if b.load == above else f"{name} [{b.unit}]",
                shown_band(b.band),
                str(b.rows),
                *(number(v, 2) for v in (b.rms, b.hover_rms, b.bias, b.worst)),
            )
        )
        above = b.load
    return Table(
        caption,
        (
            ("load", ""), ("speed", ""), ("rows", "-"), ("rms", ""), ("hover model's rms", ""),
            ("mean", ""), ("worst", ""),
        ),
        tuple(rows),
    )  # fmt: skip


def band_csv(bands: Sequence[BandErrors]) -> str:
    """The same as CSV."""
    heads = ("load", "unit", "speed_band", "rows", "rms_in_unit", "mean_in_unit", "worst_in_unit",
             "hover_rms_in_unit")  # fmt: skip
    return csv_of_rows(
        heads,
        [(b.load, b.unit, b.band, b.rows, b.rms, b.bias, b.worst, b.hover_rms) for b in bands],
    )


def _tick(band: str) -> str:
    """A band of speed, short enough to stand beside its neighbours."""
    return shown_band(band.removesuffix(" m/s")).replace("above\N{NO-BREAK SPACE}", "> ")


def _whole(loads: Sequence[Judged]) -> Table:
    rows: list[tuple[str, ...]] = []
    for j in loads:
        e, crossed = j.load, j.load.cross_validated
        rows.append(
            (
                NAMES.get(j.load.name, j.load.name),
                str(e.rows),
                f"{number(e.rms)} {j.load.unit}",
                number(100.0 * e.rms / j.reference, 2),
                f"{number(crossed)} {j.load.unit}" if math.isfinite(crossed) else "not done",
                number(100.0 * crossed / j.reference, 2),
                f"{number(e.hover_rms)} {j.load.unit}",
                number(100.0 * e.hover_rms / j.reference, 2),
            )
        )
    columns = (
        ("load", ""), ("rows", "-"), ("rms error", ""), ("of measured", "%"),
        ("cross-validated", ""), ("of measured", "%"), ("hover model's", ""), ("of measured", "%"),
    )  # fmt: skip
    note = (
        "Cross-validated: each part of the data predicted by a fit to the others, the better "
        "guide to new data of the same kind. Shares are of the same size as in the first table."
    )
    return Table("Over all speeds.", columns, tuple(rows), note)
