"""What the hover model would miss in a table's envelope."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from propmap.report.page import Section, Table, Text, Verdict, number
from propmap.report.part import Part, files_of, picture
from propmap.report.sheet import csv_of_rows
from propmap.report.style import COLOURS, HOVER, MARKERS, new_figure, style
from propmap.report.table_page.loads import hover_loads
from propmap.report.table_page.samples import OFF, RPM, TableSamples


def hover_section(samples: TableSamples) -> Part:
    """Verdict, figure, errors by speed; a sentence where the table does not hold rest."""
    title = "Would the hover model do?"
    if not samples.hover:
        told = "The envelope does not hold the propeller at rest, so that there is no hover model."
        return Part(Section("hover", title, (Text(told),)))
    shown = picture(
        hover_figure(samples),
        "table-hover",
        f"The hover model less the table at {samples.omega * RPM:.0f} rpm, as a share of the "
        "static load. Dashed, in every colour of an angle: what is drawn is the hover model's "
        "error. Zero is this table.",
        "The hover model's error in thrust and torque against speed.",
    )
    section = Section("hover", title, (_verdict(samples), shown, _table(samples)))
    return Part(section, files_of(shown) | {"table-hover.csv": _csv(samples)})


def hover_figure(samples: TableSamples) -> Figure:
    """Thrust and torque."""
    hover = hover_loads(samples)
    looks = {**HOVER, "linewidth": 1.5}
    del looks["color"]
    with style():
        figure = new_figure(8.6, 3.8)
        axes = figure.subplots(1, 2)
        for ax, load in zip(axes, ("thrust", "torque"), strict=True):
            ax.axhline(0.0, color="0.4", linewidth=0.8)
            for k, one in enumerate(samples.curves):
                off = 100.0 * (hover[load] - one.loads[load]) / hover[load]
                ax.plot(samples.speed, off, color=COLOURS[k], **looks)
                every = slice(6 + 3 * k, None, 24)
                ax.plot(
                    samples.speed[every], off[every], color=COLOURS[k], marker=MARKERS[k],
                    markersize=4.0, linestyle="none",
                )  # fmt: skip
            ax.set_ylabel(f"hover model less table, {load} [% of static]")
            ax.set_xlabel("flight speed V [m/s]")
            ax.margins(x=0.02)
        handles = [
            Line2D(
                [], [], color=COLOURS[k], marker=MARKERS[k], markersize=4.0,
                label=f"β = {np.degrees(one.beta):.0f}°", **looks,
            )
            for k, one in enumerate(samples.curves)
        ]  # fmt: skip
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return figure


def _verdict(samples: TableSamples) -> Verdict:
    total = sum(one.points for one in samples.hover)
    off = sum(one.off[0] * one.points for one in samples.hover) / total
    good = [one for one in samples.hover if one.off[0] < 0.05]
    limit = f"{100 * OFF[0]:.0f} %"
    told = f"In {100.0 * off:.0f} % of the envelope its thrust is off by more than {limit}."
    if len(good) == len(samples.hover):
        return Verdict("good", "Yes, for thrust", told + " It has no rotor drag at any speed.")
    if good:
        end = f"{number(good[-1].speed[1], 2)} m/s"
        return Verdict("caution", "Only in slow flight", f"{told} Up to {end} it mostly does.")
    return Verdict("bad", "No", told + " It has no rotor drag at any speed.")


def _table(samples: TableSamples) -> Table:
    rows = tuple(
        (
            f"{number(one.speed[0], 2)} to {number(one.speed[1], 2)}",
            *(number(100.0 * v, 2) for v in (one.thrust_rms, one.torque_rms, one.drag_rms)),
            *(f"{100.0 * share:.0f}" for share in one.off),
        )
        for one in samples.hover
    )
    columns = (
        ("speed", "m/s"), ("thrust, rms error", "%"), ("torque, rms error", "%"),
        ("rotor drag, rms, all missed", "%"),
        *((f"points with thrust off by {100 * limit:.0f} %", "%") for limit in OFF),
    )  # fmt: skip
    return Table(
        "The hover model against this table over the whole envelope, as shares of static loads "
        "(drag: of static thrust).",
        columns,
        rows,
    )


def _csv(samples: TableSamples) -> str:
    hover = hover_loads(samples)
    heads = ("beta_deg", "speed_mps", "rpm", "thrust_error_share", "torque_error_share")
    rows = [
        (
            float(np.degrees(one.beta)),
            speed,
            samples.omega * RPM,
            *(float((hover[n] - one.loads[n][k]) / hover[n]) for n in ("thrust", "torque")),
        )
        for one in samples.curves
        for k, speed in enumerate(samples.speed.tolist())
    ]
    return csv_of_rows(heads, rows)
