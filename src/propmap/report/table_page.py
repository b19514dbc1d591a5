"""The report on a table: envelope, certificate and loads."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from propmap.export.files import evenly
from propmap.loads import LOADS
from propmap.report import html
from propmap.table import interpolation
from propmap.table.certificate import PLACE, TITLES, claims, largest_at, parameter_claims
from propmap.table.interpolation import NO_VALUE, OK, STATUSES, UNRESOLVED, VORTEX_RING, cell_codes
from propmap.table.query import LoadTable
from propmap.typing import Floats
from propmap.units import RPM

NAMES = np.array(STATUSES)
SPEEDS, ANGLES = 121, 91  # number of values in curves and maps
CURVES = (0.0, 45.0, 90.0, 135.0, 180.0)  # [deg], if within the envelope
FLOWS = (
    ("climb and fast cruise", 0.0, 60.0),
    ("level flight", 60.0, 100.0),
    ("descent", 100.0, 181.0),
)  # parts of the envelope by angle [deg]


def table_pages(table: LoadTable, where: str) -> dict[str, str | bytes]:
    """Return all files of the report on a table by name; ``where`` is the path of the table."""
    info, found = table.info, table.certificate
    parameters, law = info.get("parameter_uncertainty") or {}, info.get("airfoil") or {}
    (w0, w1), speeds, betas = table.envelope.values()
    omega = math.copysign(math.sqrt(w0 * w1), w0)  # geometric mean
    rest = table.loads(omega, 0.0, betas[0])
    still = {
        load.name: 0.0 if load.inplane else float(getattr(rest, load.name))
        for load in LOADS.values()
    }
    points = evenly(table)
    code = table.loads(*points).code % interpolation.REVERSED  # counts REVERSED as OK
    records = [table_cells(table), load_lines(table, omega, still), load_maps(table, omega)]
    values = {}
    if found:
        record, heads = table_errors(found, parameters)
        records.append(record)
        values = {
            "holds": found.get("holds", max(found["max_error"].values()) <= found["tolerance"]),
            "claims": [*claims(found), *(parameter_claims(parameters) if parameters else ())],
            "error_heads": heads,
        }
    constant = (f"{name} {value:.4g}" for name, value in law.items() if isinstance(value, float))
    return html.record_files(
        "report/table_page.html.j2",
        records,
        name=info["propeller"].get("name") or "a propeller",
        where=where,
        info=info,
        airfoil=law,
        constants=", ".join(constant),
        content=table.content,
        sha256=table.content.sha256,
        rpm=f"{omega / RPM:.0f} rpm",
        shares=_shares(code),
        by_angle=_by_angle(points[2], code),
        certificate=found,
        parameters=parameters,
        envelope=(w0 / RPM, w1 / RPM, *speeds, *np.degrees(betas)),
        **values,
    )


def _shares(code: NDArray[np.uint8]) -> dict[str, float]:
    return {STATUSES[k]: float(np.mean(code == k)) for k in (OK, VORTEX_RING, UNRESOLVED, NO_VALUE)}


def _by_angle(beta: Floats, code: NDArray[np.uint8]) -> list[tuple[str, ...]]:
    """Return table rows with the fraction [%] of each status by range of angles."""
    degrees, rows = np.degrees(beta), []
    for name, low, high in FLOWS:
        mine = (degrees >= low) & (degrees < high)
        if mine.any():
            ends = f"{max(low, degrees.min()):.0f}° to {min(high, degrees.max()):.0f}°"
            shares = _shares(code[mine]).values()
            rows.append((ends, name, *(html.number(100.0 * share) for share in shares)))
    return rows


def table_errors(
    found: dict[str, Any], parameters: dict[str, Any]
) -> tuple[html.FigureRecord, str]:
    """Return the errors of each load, over the static load, with operating points, and heads."""
    errors = {"largest": found["max_error"], "rms": found["rms_error"]}
    if found["unresolved_cells"]:
        errors["largest, unresolved"] = found["unresolved_max_error"]
    if parameters:
        errors["by the parameters, median"] = parameters["median"]
        errors["by the parameters, 95 %"] = parameters["percentile_95"]
    places = largest_at(found)
    slugs = [f"{name.replace(' ', '_').replace(',', '')}_share" for name in errors]
    rows, cells = [], []
    for load, title in TITLES.items():
        shares = [float(one[load]) for one in errors.values()]
        place = places[load] or len(PLACE) * [None]
        rows.append((load, *shares, *place))
        shown = [html.number(100.0 * share, 2) for share in shares]
        cells.append((title, *shown, *(html.number(value, 4) for value in place)))
    named = (name.replace("by the parameters", "std. dev. from constants") for name in errors)
    heads = ["error / reference"]
    heads += [f"{name.replace('95 %', '95th percentile')} [%]" for name in named]
    heads += [f"location of largest error [{unit}]" for unit in PLACE.values()]
    columns = html.columns_of(" ".join(["load", *slugs, "at_rpm at_speed_mps at_beta_deg"]), rows)
    return html.FigureRecord("table-certificate", columns, cells=cells), "|".join(heads)


# --- The cells of a table: certified, vortex ring, unresolved, or without a value ----------------

KINDS = {
    OK: ("certified", "#e8eef2"),
    VORTEX_RING: ("vortex ring: certified, but the theory is not valid", html.COLORS[5]),
    UNRESOLVED: ("unresolved: loads with jumps", html.COLORS[1]),
    NO_VALUE: ("no value", "0.55"),
}


def table_cells(table: LoadTable) -> html.FigureRecord:
    """Return the cells with a status other than "ok"; the figure shows all cells.  The status of a
    cell with a corner without value is "no_value"."""
    content = table.content
    beta = np.degrees(content.beta)
    lost: Any = np.isnan(content.coefficients).any(axis=(0, 1))
    corners = lost[:-1, :-1] | lost[1:, :-1] | lost[:-1, 1:] | lost[1:, 1:]
    codes = np.where(corners, np.uint8(NO_VALUE), cell_codes(content) % interpolation.REVERSED)
    rank = np.searchsorted(list(KINDS), codes)

    def draw() -> Figure:
        (w0, w1), (_, fastest), _ = table.envelope.values()
        figure = html.new_figure(8.6, 5.0)
        ax = figure.subplots()
        ax.grid(visible=False)
        ax.pcolormesh(
            content.advance, beta, rank.T, vmin=-0.5, vmax=len(KINDS) - 0.5,
            cmap=ListedColormap([color for _, color in KINDS.values()]), shading="flat",
            rasterized=True,
        )  # fmt: skip
        for omega in (w0, math.copysign(math.sqrt(w0 * w1), w0), w1):
            limit = fastest / (abs(omega) * content.radius)
            ax.axvline(limit, color="0.2", linewidth=1.0, linestyle="-.")
            ax.annotate(
                f"{omega / RPM:.0f} rpm", (limit, 1.0), (-3, -4), textcoords="offset points",
                xycoords=("data", "axes fraction"), rotation=90.0, ha="right", va="top",
                fontsize=8.0,
            )  # fmt: skip
        ax.set_xlim(content.advance[0], content.advance[-1])
        ax.set_xlabel("advance ratio V/(ΩR) [-]")
        ax.set_ylabel("angle β [deg]")
        if beta[-1] - beta[0] > 60.0:
            ax.set_yticks(np.arange(30 * np.ceil(beta[0] / 30.0), beta[-1] + 1.0, 30.0))
        look: dict[str, Any] = {"edgecolor": "0.5", "linewidth": 0.5}
        there = [kind for code, kind in KINDS.items() if (codes == code).any()]
        handles = [Patch(facecolor=color, label=label, **look) for label, color in there]
        html.legend_below(figure, handles, columns=2)
        return figure

    i, j = np.nonzero(codes != OK)
    columns = {
        "advance_from": content.advance[i],
        "advance_to": content.advance[i + 1],
        "beta_from_deg": beta[j],
        "beta_to_deg": beta[j + 1],
        "status": NAMES[codes[i, j]],
    }
    return html.FigureRecord("table-cells", [columns], draw)


# --- Loads of a table as curves over speed and as maps over speed and angle ----------------------


def load_lines(table: LoadTable, omega: float, still: dict[str, float]) -> html.FigureRecord:
    """Return loads over airspeed at ``omega`` [rad/s], a curve per angle, and the hover model."""
    _, ends, (low, high) = table.envelope.values()
    speed = np.linspace(*ends, SPEEDS)
    inside = [a for a in np.radians(CURVES) if low - 1e-9 <= a <= high + 1e-9]
    far = [end for end in (low, high) if all(abs(end - a) > np.radians(10.0) for a in inside)]
    betas = sorted(float(a) for a in (*inside, *far))
    groups = []
    for beta in betas:
        found = table.loads(omega, speed, beta)
        groups.append(
            {
                "beta_deg": np.degrees(beta),
                "speed_mps": speed,
                "rpm": omega / RPM,
                "status": NAMES[np.asarray(found.code)],
                **{load.column: getattr(found, name) for name, load in LOADS.items()},
                **{f"hover_{load.column}": still[name] for name, load in LOADS.items()},
            }
        )

    def draw() -> Figure:
        figure, axes = html.load_panels(3.3, sharex=True)
        for ax, load in zip(axes.ravel(), LOADS.values(), strict=True):
            if np.isfinite(still["thrust"]):
                ax.axhline(still[load.name], **html.HOVER)
            for k, one in enumerate(groups):
                ring, values = one["status"] == NAMES[VORTEX_RING], one[load.column]
                solid, dotted = np.where(ring, np.nan, values), np.where(ring, values, np.nan)
                ax.plot(speed, solid, color=html.COLORS[k], **html.MODEL)
                ax.plot(speed, dotted, color=html.COLORS[k], linestyle=":", linewidth=1.1)
                # Add markers, because in-plane loads of axial flow coincide at zero.
                points = {"markersize": 4.0, "markevery": (6 + 3 * k, 24)}
                ax.plot(speed, values, linestyle="none", **points, **html.marked(k))
            ax.set_ylabel(load.title)
            ax.margins(x=0.02)
        for ax in axes[-1]:
            ax.set_xlabel("airspeed V [m/s]")
        keys = html.angle_keys(betas, markersize=4.0, **html.MODEL)
        html.legend_below(figure, [*keys, html.key("hover model", **html.HOVER)])
        return figure

    return html.FigureRecord("table-loads", groups, draw)


def load_maps(table: LoadTable, omega: float) -> html.FigureRecord:
    """Return loads over airspeed and angle at ``omega`` [rad/s]; hatched: vortex ring."""
    _, speeds, betas = table.envelope.values()
    speed, beta = np.linspace(*speeds, SPEEDS), np.linspace(*betas, ANGLES)
    found = table.loads(omega, speed[:, None], beta)
    code, degrees = np.asarray(found.code), np.degrees(beta)

    def draw() -> Figure:
        ring, loose = (np.where(code == each, 1.0, 0.0).T for each in (VORTEX_RING, UNRESOLVED))
        figure, axes = html.load_panels(3.4, sharex=True, sharey=True)
        for ax, load in zip(axes.ravel(), LOADS.values(), strict=True):
            values = getattr(found, load.name).T
            ax.grid(visible=False)
            if np.isfinite(values).any():
                filled = ax.contourf(speed, degrees, values, 12, cmap="viridis")
                figure.colorbar(filled, ax=ax, label=load.title)
            if ring.any():
                ax.contourf(speed, degrees, ring, [0.5, 1.5], colors="none", hatches=["//"])
                ax.contour(speed, degrees, ring, [0.5], colors="white", linewidths=0.8)
            if loose.any():
                ax.contourf(speed, degrees, loose, [0.5, 1.5], colors="black")
        for ax in axes[-1]:
            ax.set_xlabel("airspeed V [m/s]")
        for ax in axes[:, 0]:
            ax.set_ylabel("angle β [deg]")
        return figure

    columns = {
        "speed_mps": speed[:, None],
        "beta_deg": degrees,
        "rpm": omega / RPM,
        "status": NAMES[code],
        **{load.column: getattr(found, name) for name, load in LOADS.items()},
    }
    return html.FigureRecord("table-maps", [columns], draw)
