"""The page on a table: its envelope, loads, errors, and what a hover model would miss."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from propmap.export.files import evenly, table_sha256
from propmap.fit.least_squares import rms
from propmap.loads import LOADS
from propmap.report.html import (
    COLOURS,
    DASHED,
    HOVER,
    MODEL,
    angle_keys,
    csv_of_columns,
    csv_of_rows,
    key,
    legend_below,
    load_panels,
    marked,
    new_figure,
    number,
    report_files,
    style,
)
from propmap.report.words import PLACE, TITLES, claims, largest_at, parameter_claims
from propmap.table.interpolation import NO_VALUE, OK, STATUSES, UNRESOLVED, VORTEX_RING, cell_codes
from propmap.table.query import LoadTable
from propmap.typing import Floats
from propmap.units import RPM

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# -------------------------------------------------------------------------------------------------
# The page on a table and the files beside it.

PLACE_COLUMNS = ("at_rpm", "at_speed_mps", "at_beta_deg")


def table_pages(table: LoadTable, where: str) -> dict[str, str | bytes]:
    """All files of the page on a table by name; ``where`` names its file."""
    samples, found, info, content = sample(table), table.certificate, table.info, table.content
    parameters, law = info.get("parameter_uncertainty") or {}, info.get("airfoil") or {}
    figures = {
        "table-cells": cell_figure(table),
        "table-loads": curve_figure(samples),
        "table-maps": map_figure(samples),
    }
    sheets = {
        "table-cells": cell_sheet(table),
        "table-loads": curve_sheet(samples),
        "table-maps": map_sheet(samples),
    }
    values = {}
    if samples.hover:
        figures["table-hover"] = hover_figure(samples)
        sheets["table-hover"] = hover_sheet(samples)
    if found:
        columns = {"largest": found["max_error"], "rms": found["rms_error"]}
        if found["unresolved_cells"]:
            columns["largest, unresolved"] = found["unresolved_max_error"]
        if parameters:
            columns["by the parameters, median"] = parameters["median"]
            columns["by the parameters, 95 %"] = parameters["percentile_95"]
        places = largest_at(found)
        nowhere = len(PLACE) * [None] if places else []
        slugs = (name.replace(" ", "_").replace(",", "") + "_share" for name in columns)
        sheets["table-certificate"] = csv_of_rows(
            " ".join(("load", *slugs, *(PLACE_COLUMNS if places else ()))),
            [
                (
                    load,
                    *(float(by_load[load]) for by_load in columns.values()),
                    *(places.get(load) or nowhere),
                )
                for load in TITLES
            ],
        )
        values = {
            "holds": found.get("holds", max(found["max_error"].values()) <= found["tolerance"]),
            "claims": [*claims(found), *(parameter_claims(parameters) if parameters else ())],
            "error_heads": "|".join(
                (
                    "error, as a share of",
                    *(f"{name} [%]" for name in columns),
                    *(f"largest at [{unit}]" for unit in PLACE.values() if places),
                )
            ),
            "errors": [
                (
                    title,
                    *(number(100.0 * by_load[load], 2) for by_load in columns.values()),
                    *(number(value, 4) for value in places.get(load) or nowhere),
                )
                for load, title in TITLES.items()
            ],
        }
    constants = (f"{name} {value:.4g}" for name, value in law.items() if isinstance(value, float))
    (w0, w1), speeds, betas = table.envelope.values()
    return report_files(
        "report/table_page.html.j2",
        figures,
        sheets,
        name=info["propeller"].get("name") or "a propeller",
        where=where,
        info=info,
        airfoil=law,
        constants=", ".join(constants),
        content=content,
        sha256=table_sha256(table),
        samples=samples,
        certificate=found,
        parameters=parameters,
        envelope=(w0 / RPM, w1 / RPM, *speeds, *np.degrees(betas)),
        page=sys.modules[__name__],
        **values,
    )


# -------------------------------------------------------------------------------------------------
# A table asked for what its page shows.

POINTS = 32_768
"""Of the envelope, on which shares are counted."""

SPEEDS, ANGLES = 121, 91
"""Of the maps."""

CURVES = (0.0, 45.0, 90.0, 135.0, 180.0)
"""Angles of the curves [deg], where the envelope has them."""

FLOWS = (
    ("climb and fast cruise", 0.0, 60.0),
    ("level flight", 60.0, 100.0),
    ("descent", 100.0, 181.0),
)
"""Parts of the envelope by angle [deg]."""

BANDS = 5
"""Of the speeds, in which the hover model is judged."""

OFF = (0.05, 0.1)
"""Shares of the static thrust by which the hover model is said to be off."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Loads over speed at one angle [rad]: by name (n,), and the codes of the points (n,)."""

    beta: float
    loads: dict[str, Floats]
    code: NDArray[np.uint8]


@dataclass(frozen=True)
class HoverErrors:
    """The hover model less the table in a band of speed [m/s], as shares of the static load.

    Attributes
    ----------
    points : int
        How many are in the band.
    rms : tuple of float
        Root mean squares of thrust, torque, and the drag, which the hover model lacks.
    off : tuple of float
        Share of the points where thrust is off by more than each of ``OFF``.
    """

    speed: tuple[float, float]
    points: int
    rms: tuple[float, ...]
    off: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class TableSamples:
    """What is drawn and counted.

    Attributes
    ----------
    rpm : float
        Rotational speed of the curves and maps [1/min], the geometric middle of the envelope.
    speed, beta : ndarray, shape (n,), (m,)
        Of the maps [m/s], [rad].
    maps : dict of str to ndarray, shape (n, m)
        Loads by name.
    code : ndarray, shape (n, m)
        Statuses of the maps.
    curves : sequence of Curve
        At the speeds of the maps.
    still : dict of str to float
        The hover model's loads: those of the table at rest, NaN where it has none.
    shares : dict of str to float
        Of the envelope, by status.
    by_angle : sequence of tuple of str
        Range of the angle, kind of flow, and the shares there [%].
    hover : sequence of HoverErrors
        By band of speed; empty without loads at rest.
    """

    rpm: float
    speed: Floats
    beta: Floats
    maps: dict[str, Floats]
    code: NDArray[np.uint8]
    curves: Sequence[Curve]
    still: dict[str, float]
    shares: dict[str, float]
    by_angle: Sequence[tuple[str, ...]]
    hover: Sequence[HoverErrors]


def sample(table: LoadTable) -> TableSamples:
    """Curves, maps and counts of a table."""
    (w0, w1), (v0, v1), (b0, b1) = table.envelope.values()
    omega = float(np.sqrt(w0 * w1))
    speed, beta = np.linspace(v0, v1, SPEEDS), np.linspace(b0, b1, ANGLES)
    found, rest = table.loads(omega, speed[:, None], beta), table.loads(omega, 0.0, b0)
    still = {
        load.name: 0.0 if load.inplane else float(getattr(rest, load.name))
        for load in LOADS.values()
    }
    points = evenly(table, POINTS)
    everywhere = table.loads(*points)
    return TableSamples(
        rpm=omega / RPM,
        speed=speed,
        beta=beta,
        maps={name: getattr(found, name) for name in LOADS},
        code=np.asarray(found.code),
        curves=[_curve(table, omega, speed, angle) for angle in _angles(b0, b1)],
        still=still,
        shares=_shares(everywhere.code),
        by_angle=_by_angle(points[2], everywhere.code),
        hover=_hover(points, everywhere, {n: k / omega**2 for n, k in still.items()}, (v0, v1)),
    )


def _angles(low: float, high: float) -> list[float]:
    inside = [a for a in np.radians(CURVES) if low - 1e-9 <= a <= high + 1e-9]
    far = [end for end in (low, high) if all(abs(end - a) > np.radians(10.0) for a in inside)]
    return sorted(float(a) for a in (*inside, *far))


def _curve(table: LoadTable, omega: float, speed: Floats, beta: float) -> Curve:
    found = table.loads(omega, speed, beta)
    return Curve(beta, {name: getattr(found, name) for name in LOADS}, np.asarray(found.code))


def _shares(code: NDArray[np.uint8]) -> dict[str, float]:
    return {STATUSES[k]: float(np.mean(code == k)) for k in (OK, VORTEX_RING, UNRESOLVED, NO_VALUE)}


def _by_angle(beta: Floats, code: NDArray[np.uint8]) -> list[tuple[str, ...]]:
    degrees, rows = np.degrees(beta), []
    for name, low, high in FLOWS:
        mine = (degrees >= low) & (degrees < high)
        if mine.any():
            ends = f"{max(low, degrees.min()):.0f}° to {min(high, degrees.max()):.0f}°"
            shares = _shares(code[mine]).values()
            rows.append((ends, name, *(number(100.0 * share) for share in shares)))
    return rows


def _hover(
    points: tuple[Floats, Floats, Floats],
    found: Any,
    constants: dict[str, float],
    ends: tuple[float, float],
) -> list[HoverErrors]:
    if not (constants["thrust"] > 0.0 and constants["torque"] > 0.0):
        return []
    omega, speed, _ = points
    thrust, torque = (constants[name] * omega**2 for name in ("thrust", "torque"))
    off = (thrust - found.thrust) / thrust
    shares = (off, (torque - found.torque) / torque, found.drag / thrust)
    bands = []
    for low, high in itertools.pairwise(np.linspace(*ends, BANDS + 1).tolist()):
        mine = (speed >= low) & (speed <= high) & np.isfinite(off)
        if mine.any():
            beyond = tuple(float(np.mean(np.abs(off[mine]) > limit)) for limit in OFF)
            each = tuple(rms(share[mine]) for share in shares)
            bands.append(HoverErrors((low, high), int(mine.sum()), each, beyond))
    return bands


# -------------------------------------------------------------------------------------------------
# The cells of a table: certified, vortex ring, unresolved, or without a value.

KINDS = {
    OK: ("certified", "#e8eef2"),
    VORTEX_RING: ("vortex ring: certified, but the theory is not valid there", COLOURS[5]),
    UNRESOLVED: ("unresolved: the loads jump", COLOURS[1]),
    NO_VALUE: ("no value", "0.55"),
}


@style()
def cell_figure(table: LoadTable) -> Figure:
    """Every cell over advance ratio and angle, in the colour of its status."""
    content, (rank, codes) = table.content, cell_ranks(table)
    (w0, w1), (_, fastest), _ = table.envelope.values()
    figure = new_figure(8.6, 5.0)
    ax = figure.subplots()
    ax.grid(visible=False)
    ax.pcolormesh(
        content.advance, np.degrees(content.beta), rank.T, vmin=-0.5, vmax=len(KINDS) - 0.5,
        cmap=ListedColormap([colour for _, colour in KINDS.values()]), shading="flat",
        rasterized=True,
    )  # fmt: skip
    for omega in (w0, float(np.sqrt(w0 * w1)), w1):
        limit = fastest / (omega * content.radius)
        ax.axvline(limit, color="0.2", linewidth=1.0, linestyle="-.")
        ax.annotate(
            f"{omega / RPM:.0f} rpm", (limit, 1.0), (-3, -4), xycoords=("data", "axes fraction"),
            textcoords="offset points", rotation=90.0, ha="right", va="top", fontsize=8.0,
        )  # fmt: skip
    ax.set_xlim(content.advance[0], content.advance[-1])
    ax.set_xlabel("advance ratio V/(ΩR) [-]")
    ax.set_ylabel("angle β [deg]")
    low, high = np.degrees(content.beta[[0, -1]])
    if high - low > 60.0:
        ax.set_yticks(np.arange(30 * np.ceil(low / 30.0), high + 1.0, 30.0))
    handles = [
        Patch(facecolor=colour, edgecolor="0.5", linewidth=0.5, label=label)
        for code, (label, colour) in KINDS.items()
        if (codes == code).any()
    ]
    legend_below(figure, handles, columns=2)
    return figure


def cell_sheet(table: LoadTable) -> str:
    """The cells that are not certified, as CSV."""
    content, codes = table.content, _codes(table)
    advance, beta = content.advance.tolist(), np.degrees(content.beta).tolist()
    return csv_of_rows(
        "advance_from advance_to beta_from_deg beta_to_deg status",
        [
            (advance[i], advance[i + 1], beta[j], beta[j + 1], STATUSES[codes[i, j]])
            for i, j in np.argwhere(codes != OK).tolist()
        ],
    )


def cell_ranks(table: LoadTable) -> tuple[np.ndarray, np.ndarray]:
    """Of each cell (n - 1, m - 1) of a ``table``: its place in ``KINDS``, and its status."""
    codes = _codes(table)
    return np.searchsorted(list(KINDS), codes), codes


def _codes(table: LoadTable) -> np.ndarray:
    """Statuses of the cells (n - 1, m - 1), ``NO_VALUE`` where a corner has none."""
    lost: Any = np.isnan(table.content.coefficients).any(axis=(0, 1))
    corners = lost[:-1, :-1] | lost[1:, :-1] | lost[:-1, 1:] | lost[1:, 1:]
    return np.where(corners, np.uint8(NO_VALUE), cell_codes(table.content))


# -------------------------------------------------------------------------------------------------
# Loads of a table as curves over speed and as maps over speed and angle.

NAMES = np.array(STATUSES)


@style()
def curve_figure(samples: TableSamples) -> Figure:
    """A panel per load, a colour per angle."""
    figure, axes = load_panels(3.3, sharex=True)
    for ax, load in zip(axes.ravel(), LOADS.values(), strict=True):
        if np.isfinite(samples.still["thrust"]):
            ax.axhline(samples.still[load.name], **HOVER)
        for k, one in enumerate(samples.curves):
            ring, values = one.code == VORTEX_RING, one.loads[load.name]
            solid, dotted = np.where(ring, np.nan, values), np.where(ring, values, np.nan)
            ax.plot(samples.speed, solid, color=COLOURS[k], **MODEL)
            ax.plot(samples.speed, dotted, color=COLOURS[k], linestyle=":", linewidth=1.1)
            mark(ax, k, samples.speed, values)
        ax.set_ylabel(load.title)
        ax.margins(x=0.02)
    for ax in axes[-1]:
        ax.set_xlabel("flight speed V [m/s]")
    keys = angle_keys([c.beta for c in samples.curves], markersize=4.0, **MODEL)
    legend_below(figure, [*keys, key("hover model", **HOVER)])
    return figure


def mark(ax: Axes, k: int, speed: Floats, values: Floats) -> None:
    """Some markers on curve k: the curves of axial flow lie on each other."""
    every = slice(6 + 3 * k, None, 24)
    ax.plot(speed[every], values[every], markersize=4.0, linestyle="none", **marked(k))


@style()
def map_figure(samples: TableSamples) -> Figure:
    """A panel per load: filled contours, the vortex ring hatched, what is unresolved black."""
    speed, beta = samples.speed, np.degrees(samples.beta)
    ring, loose = (np.where(samples.code == code, 1.0, 0.0).T for code in (VORTEX_RING, UNRESOLVED))
    figure, axes = load_panels(3.4, sharex=True, sharey=True)
    for ax, load in zip(axes.ravel(), LOADS.values(), strict=True):
        values = samples.maps[load.name].T
        ax.grid(visible=False)
        if np.isfinite(values).any():
            filled = ax.contourf(speed, beta, values, 12, cmap="viridis")
            figure.colorbar(filled, ax=ax, label=load.title)
        if ring.any():
            ax.contourf(speed, beta, ring, [0.5, 1.5], colors="none", hatches=["//"])
            ax.contour(speed, beta, ring, [0.5], colors="white", linewidths=0.8)
        if loose.any():
            ax.contourf(speed, beta, loose, [0.5, 1.5], colors="black")
    for ax in axes[-1]:
        ax.set_xlabel("flight speed V [m/s]")
    for ax in axes[:, 0]:
        ax.set_ylabel("angle β [deg]")
    return figure


def curve_sheet(samples: TableSamples) -> str:
    """The curves as CSV, the hover model's loads beside them."""
    return csv_of_columns(
        {
            "beta_deg": np.degrees(one.beta),
            "speed_mps": samples.speed,
            "rpm": samples.rpm,
            "status": NAMES[one.code],
            **{load.column: one.loads[name] for name, load in LOADS.items()},
            **{f"hover_{load.column}": samples.still[name] for name, load in LOADS.items()},
        }
        for one in samples.curves
    )


def map_sheet(samples: TableSamples) -> str:
    """The maps as CSV."""
    return csv_of_columns(
        [
            {
                "speed_mps": samples.speed[:, None],
                "beta_deg": np.degrees(samples.beta),
                "rpm": samples.rpm,
                "status": NAMES[samples.code],
                **{load.column: samples.maps[name] for name, load in LOADS.items()},
            }
        ]
    )


# -------------------------------------------------------------------------------------------------
# What the hover model would miss in a table's envelope.

HOVER_LOADS = ("thrust", "torque")


@style()
def hover_figure(samples: TableSamples) -> Figure:
    """The hover model less the table in thrust and torque over speed, in the colours of angles."""
    look: dict[str, Any] = {**DASHED, "linewidth": 1.5}
    figure = new_figure(8.6, 3.8)
    for ax, load in zip(figure.subplots(1, 2), HOVER_LOADS, strict=True):
        ax.axhline(0.0, color="0.4", linewidth=0.8)
        for k, one in enumerate(samples.curves):
            off = 100.0 * (samples.still[load] - one.loads[load]) / samples.still[load]
            ax.plot(samples.speed, off, color=COLOURS[k], **look)
            mark(ax, k, samples.speed, off)
        ax.set_ylabel(f"hover model less table, {load} [% of static]")
        ax.set_xlabel("flight speed V [m/s]")
        ax.margins(x=0.02)
    legend_below(figure, angle_keys([c.beta for c in samples.curves], markersize=4.0, **look))
    return figure


def judged(samples: TableSamples) -> dict[str, Any]:
    """The verdict: its level and word, the share of points off, the speed up to which it holds."""
    total = sum(one.points for one in samples.hover)
    off = sum(one.off[0] * one.points for one in samples.hover) / total
    good = [one for one in samples.hover if one.off[0] < OFF[0]]
    if len(good) == len(samples.hover):
        return {"level": "good", "word": "Yes, for thrust", "off": off}
    if good:
        speed = good[-1].speed[1]
        return {"level": "caution", "word": "Only in slow flight", "off": off, "speed": speed}
    return {"level": "bad", "word": "No", "off": off}


def error_rows(samples: TableSamples) -> list[tuple[str, ...]]:
    """Speed, errors of thrust, torque and drag, and shares of points off; a row per band."""
    return [
        (
            f"{number(one.speed[0], 2)} to {number(one.speed[1], 2)}",
            *(number(100.0 * value, 2) for value in one.rms),
            *(f"{100.0 * share:.0f}" for share in one.off),
        )
        for one in samples.hover
    ]


def hover_sheet(samples: TableSamples) -> str:
    """The figure's numbers as CSV."""
    return csv_of_columns(
        {"beta_deg": np.degrees(one.beta), "speed_mps": samples.speed, "rpm": samples.rpm}
        | {
            f"{load}_error_share": (samples.still[load] - one.loads[load]) / samples.still[load]
            for load in HOVER_LOADS
        }
        for one in samples.curves
    )
