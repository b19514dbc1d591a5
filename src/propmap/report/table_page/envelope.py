"""The envelope of a table, and where its loads are marked."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from propmap.report.page import Section, Table, Text, number
from propmap.report.part import Part, files_of, picture
from propmap.report.sheet import csv_of_rows
from propmap.report.style import COLOURS, new_figure, style
from propmap.report.table_page.samples import RPM, TableSamples
from propmap.table.lookup import NO_VALUE, OK, UNRESOLVED, VORTEX_RING, cell_codes
from propmap.table.query import LoadTable

KINDS = (
    (OK, "certified", "#e8eef2"),
    (VORTEX_RING, "vortex ring: certified, but the theory is not valid there", COLOURS[5]),
    (UNRESOLVED, "unresolved: the loads jump", COLOURS[1]),
    (NO_VALUE, "no value", "0.55"),
)


def envelope_section(table: LoadTable, samples: TableSamples) -> Part:
    """Ranges, shares, and the map of the cells."""
    shown = picture(
        cell_figure(table),
        "table-cells",
        "The table's cells over advance ratio V/(ΩR) and angle, all rotational speeds together. "
        "Lines: the largest speed of the envelope at three rotational speeds; what lies to the "
        "left of each is the envelope at that one. β: 0° climb along the axis, 90° edgewise, 180° "
        "descent.",
        "Map of certified, vortex ring and unresolved cells.",
    )
    section = Section(
        "envelope",
        "Where it holds",
        (_table(table), shown, _by_angle(samples), Text(_words(samples))),
    )
    return Part(section, files_of(shown) | {"table-cells.csv": _csv(table)})


def cell_figure(table: LoadTable) -> Figure:
    """Every cell in the colour of its status."""
    content = table.content
    codes = _codes(table)
    (w0, w1), (_, fastest), _ = table.envelope.values()
    index = np.zeros(int(max(code for code, _, _ in KINDS)) + 1, int)
    for k, (code, _, _) in enumerate(KINDS):
        index[code] = k
    with style():
        figure = new_figure(8.6, 5.0)
        ax = figure.subplots()
        ax.grid(visible=False)
        ax.pcolormesh(
            content.advance, np.degrees(content.beta), index[codes].T,
            cmap=ListedColormap([colour for _, _, colour in KINDS]), vmin=-0.5,
            vmax=len(KINDS) - 0.5, shading="flat", rasterized=True,
        )  # fmt: skip
        for omega in (w0, float(np.sqrt(w0 * w1)), w1):
            limit = fastest / (omega * content.radius)
            ax.axvline(limit, color="0.2", linewidth=1.0, linestyle="-.")
            ax.annotate(
                f"{omega * RPM:.0f} rpm", (limit, 1.0), (-3, -4),
                xycoords=("data", "axes fraction"),
                textcoords="offset points", rotation=90.0, ha="right", va="top", fontsize=8.0,
            )  # fmt: skip
        ax.set_xlim(content.advance[0], content.advance[-1])
        ax.set_xlabel("advance ratio V/(ΩR) [-]")
        ax.set_ylabel("angle β [deg]")
        low, high = np.degrees(content.beta[[0, -1]])
        if high - low > 60.0:
            ax.set_yticks(np.arange(30 * np.ceil(low / 30.0), high + 1.0, 30.0))
        present = set(np.unique(codes).tolist())
        handles = [
            Patch(facecolor=colour, edgecolor="0.5", linewidth=0.5, label=label)
            for code, label, colour in KINDS
            if code in present
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


def _codes(table: LoadTable) -> np.ndarray:
    """Statuses of the cells (n - 1, m - 1), with ``NO_VALUE`` where a corner has none."""
    content = table.content
    codes = cell_codes(content)
    lost: Any = np.isnan(content.coefficients).any(axis=(0, 1))
    corners = lost[:-1, :-1] | lost[1:, :-1] | lost[:-1, 1:] | lost[1:, 1:]
    return np.where(corners, np.uint8(NO_VALUE), codes)


def _table(table: LoadTable) -> Table:
    (w0, w1), (v0, v1), (b0, b1) = table.envelope.values()
    content = table.content
    ranges = (
        ("rotational speed", w0 * RPM, w1 * RPM, "1/min"),
        ("flight speed", v0, v1, "m/s"),
        ("angle β", np.degrees(b0), np.degrees(b1), "deg"),
        ("advance ratio V/(ΩR)", content.advance[0], content.advance[-1], "-"),
    )
    rows = tuple((name, number(low, 4), number(high, 4), unit) for name, low, high, unit in ranges)
    columns = (("quantity", ""), ("least", ""), ("largest", ""), ("unit", ""))
    return Table("Envelope. Outside it the table gives no value.", columns, rows)


def _by_angle(samples: TableSamples) -> Table:
    rows = tuple(
        (
            f"{one.beta[0]:.0f}° to {one.beta[1]:.0f}°",
            one.name,
            *(number(100.0 * one.shares[status], 3) for status in samples.shares),
        )
        for one in samples.by_angle
    )
    columns = (
        ("angle β", ""), ("flow", ""), ("valid", "%"), ("vortex ring", "%"), ("unresolved", "%"),
        ("no value", "%"),
    )  # fmt: skip
    return Table("Shares of the envelope, by angle.", columns, rows)


def _words(samples: TableSamples) -> str:
    shares = {name: f"{100.0 * share:.1f} %" for name, share in samples.shares.items()}
    told = f"Of the envelope, {shares['ok']} have valid loads within the certificate"
    if samples.shares["vortex_ring"]:
        told += (
            f"; {shares['vortex_ring']} are in the vortex ring state, where momentum theory does "
            "not hold and the loads are a blend with measured inflow: certified as a copy of the "
            "model, not as physics"
        )
    if samples.shares["unresolved"]:
        told += (
            f"; {shares['unresolved']} are unresolved, where the model's loads jump and the table "
            "cannot follow within its tolerance"
        )
    if samples.shares["no_value"]:
        told += f"; {shares['no_value']} have no value"
    return told + ". Every answer of the table carries its status."


def _csv(table: LoadTable) -> str:
    """Marked cells only: the rest of the envelope is certified."""
    content, codes = table.content, _codes(table)
    names = {VORTEX_RING: "vortex_ring", UNRESOLVED: "unresolved", NO_VALUE: "no_value"}
    degrees = np.degrees(content.beta).tolist()
    advance = content.advance.tolist()
    rows = [
        (advance[i], advance[i + 1], degrees[j], degrees[j + 1], names[int(codes[i, j])])
        for i, j in np.argwhere(codes != OK).tolist()
    ]
    return csv_of_rows(
        ("advance_from", "advance_to", "beta_from_deg", "beta_to_deg", "status"), rows
    )
