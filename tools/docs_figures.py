"""Draw the figures of the documentation: angles, blade element, results, root search, architecture.

Usage: python -m tools.docs_figures FOLDER

The documentation build calls ``write``.  All figures are drawn from definitions, from
benchmarks/results/ and, for the lag of the inflow, from simulations.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, Polygon

import propmap
from propmap.io.csv import replacing
from propmap.report.html import COLORS, MARKERS, key, new_figure, style
from tools import architecture_picture, root_search_pictures

RESULTS = Path(__file__).resolve().parent.parent / "benchmarks" / "results"
BLUE, RED, GREEN, PINK = COLORS[:4]
INK = "0.15"

Point = tuple[float, float]


def write(folder: Path) -> None:
    """Write all figures as SVG, with text as outlines that do not depend on installed fonts."""
    choice, checked = (
        json.loads((RESULTS / name).read_text(encoding="utf-8"))
        for name in ("choice.json", "cross_check.json")
    )
    figures = {
        "angles": angles(),
        "element": element(),
        "choice": cost_against_error(choice),
        "mission": mission(checked),
        "inflow_lag": inflow_lag(),
        "architecture": architecture_picture.picture(),
        "root-search-one": root_search_pictures.one_root(),
        "root-search-three": root_search_pictures.three_roots(),
        "root-search-fold": root_search_pictures.fold(),
    }
    for name, figure in figures.items():
        with (
            style(),
            mpl.rc_context({"svg.fonttype": "path", "svg.hashsalt": name}),
            replacing(folder / f"{name}.svg") as part,
        ):
            figure.savefig(part, format="svg", metadata={"Date": None})


def angles() -> Figure:
    """Draw the disk from the side, with beta, and from above, with psi."""
    with style():
        figure = new_figure(8.4, 3.9)
        side, above = figure.subplots(1, 2)
        _from_the_side(side)
        _from_above(above)
    return figure


def _from_the_side(axes: Axes) -> None:
    _blank(axes, (-1.5, 1.75), (-1.05, 1.65), "from the side")
    axes.plot([-1.0, 1.0], [0.0, 0.0], color=INK, linewidth=4.0, solid_capstyle="round")
    axes.text(-1.02, -0.16, "disk, radius $R$", ha="left", va="top", color=INK)
    _arrow(axes, (0.0, 0.0), (0.0, 1.4), INK, "$z$", (0.07, 1.4), width=1.0)
    _arrow(axes, (0.0, 0.0), (1.45, 0.0), INK, "$x$", (1.5, -0.05), width=1.0)
    beta = math.radians(55.0)
    tip = (1.25 * math.sin(beta), 1.25 * math.cos(beta))
    _arrow(axes, (0.0, 0.0), tip, BLUE, "$V$", (tip[0] + 0.05, tip[1] + 0.03))
    axes.add_patch(Arc((0.0, 0.0), 0.9, 0.9, theta1=90.0 - 55.0, theta2=90.0, color=BLUE))
    axes.text(0.24, 0.49, r"$\beta$", color=BLUE)
    _arrow(axes, (0.0, 0.0), (0.0, 0.95), RED, "$T$", (-0.17, 0.85))
    _arrow(axes, (0.0, 0.0), (-0.75, 0.0), RED, "$D$", (-0.75, 0.09))
    _arrow(axes, (-0.45, 0.75), (-0.45, 0.3), GREEN, "$v_i$", (-0.66, 0.5))
    axes.text(
        -1.5,
        -0.5,
        r"$\beta = 0$: axial climb" + "\n" + r"$\beta = 90°$: edgewise flight" + "\n"
        r"$\beta = 180°$: axial descent",
        va="top",
        color=BLUE,
    )


def _from_above(axes: Axes) -> None:
    _blank(axes, (-1.75, 1.75), (-1.45, 1.45), "from above, thrust toward the reader")
    axes.add_patch(Circle((0.0, 0.0), 1.0, fill=False, edgecolor="0.6", linewidth=1.0))
    # V points up.  The blade turns counterclockwise, so the right side is the advancing side.
    _arrow(axes, (0.0, 0.0), (0.0, 1.3), BLUE, r"$V\,\sin\beta$", (0.08, 1.22))
    axes.plot([0.0, 0.0], [0.0, -1.0], color="0.6", linewidth=1.0, linestyle=":")
    psi = math.radians(50.0)
    tip = (math.sin(psi), -math.cos(psi))
    across = (math.cos(psi), math.sin(psi))
    corners = [
        (s * tip[0] + w * across[0], s * tip[1] + w * across[1])
        for s, w in ((0.1, -0.03), (1.0, -0.05), (1.0, 0.05), (0.1, 0.07))
    ]
    axes.add_patch(Polygon(corners, facecolor="0.8", edgecolor=INK, linewidth=0.8))
    axes.add_patch(Arc((0.0, 0.0), 0.7, 0.7, theta1=-90.0, theta2=-40.0, color=GREEN))
    axes.text(0.08, -0.52, r"$\psi$", color=GREEN)
    middle = (0.55 * tip[0], 0.55 * tip[1])
    axes.text(middle[0] - 0.02, middle[1] - 0.2, "$y$", color=INK)
    axes.annotate(
        "",
        xy=(1.16 * math.cos(0.35), 1.16 * math.sin(0.35)),
        xytext=(1.16 * math.cos(-0.2), 1.16 * math.sin(-0.2)),
        arrowprops={"arrowstyle": "-|>", "color": GREEN, "connectionstyle": "arc3,rad=0.25"},
    )
    axes.text(1.25, 0.1, r"$\Omega$", color=GREEN)
    axes.text(0.5, 0.35, "advancing\nside", ha="center", color=INK)
    axes.text(-0.5, 0.35, "retreating\nside", ha="center", color=INK)
    axes.text(0.0, -1.08, r"$\psi = 0$", ha="center", va="top", color=GREEN)


def element() -> Figure:
    """Draw a blade section, leading edge at the origin, with velocities, angles and forces."""
    theta, phi = math.radians(26.0), math.radians(12.0)
    with style():
        figure = new_figure(7.0, 3.2)
        axes = figure.subplots()
        _blank(axes, (-2.5, 2.5), (-0.95, 1.35), "")
        _draw_section(axes, theta)
        axes.plot([-2.4, 2.4], [0.0, 0.0], color="0.7", linewidth=0.8, linestyle=":")
        axes.text(2.4, 0.05, "parallel to the disk", ha="right", color="0.4")
        chord = (-2.0 * math.cos(theta), 2.0 * math.sin(theta))
        axes.plot([0.0, chord[0]], [0.0, chord[1]], color="0.5", linewidth=0.7, linestyle="--")
        axes.text(chord[0] + 0.08, chord[1] + 0.02, "chord line", color="0.4")
        # The air comes from the upper left, because the inflow points down.
        begin = (-2.2 * math.cos(phi), 2.2 * math.sin(phi))
        _arrow(axes, begin, (0.0, 0.0), BLUE, "$U$", (begin[0] + 0.25, begin[1] - 0.17))
        corner = (begin[0], 0.0)
        _arrow(axes, begin, corner, BLUE, "$U_P$", (begin[0] - 0.3, 0.2), 1.0)
        _arrow(axes, corner, (0.0, 0.0), BLUE, "$U_T$", (-1.8, -0.2), 1.0)
        for radius, low, high, name, where in (
            (1.15, 0.0, phi, r"$\phi$", (-1.28, 0.07)),
            (1.45, phi, theta, r"$\alpha$", (-1.5, 0.5)),
            (0.8, 0.0, theta, r"$\theta$", (-0.72, 0.17)),
        ):
            ends = {"theta1": 180.0 - math.degrees(high), "theta2": 180.0 - math.degrees(low)}
            axes.add_patch(Arc((0, 0), 2 * radius, 2 * radius, color=PINK, **ends))
            axes.text(*where, name, color=PINK)
        foot = (0.3 * math.cos(theta), -0.3 * math.sin(theta))
        lift = (foot[0] + 1.2 * math.sin(phi), foot[1] + 1.2 * math.cos(phi))
        drag = (foot[0] + 0.55 * math.cos(phi), foot[1] - 0.55 * math.sin(phi))
        _arrow(axes, foot, lift, RED, "$dL$, normal to $U$", (lift[0] + 0.07, lift[1] - 0.12))
        _arrow(axes, foot, drag, RED, "$dD$, along $U$", (drag[0] + 0.45, drag[1] + 0.03))
        _arrow(axes, (2.3, 0.55), (1.6, 0.55), GREEN, "rotation", (1.66, 0.63), 1.2)
        axes.text(-2.4, -0.75, r"$\alpha = \theta - \phi$; thrust is up", color=INK)
    return figure


def _draw_section(axes: Axes, theta: float) -> None:
    outline = []
    for k in range(81):
        turn = 2.0 * math.pi * k / 80
        share = 0.5 * (1.0 - math.cos(turn))
        # A round leading edge, a sharp trailing edge, and more thickness above than below.
        half = 0.34 * math.sqrt(share) * (1.0 - share)
        along, side = 1.3 * share, half if turn <= math.pi else -0.4 * half
        x = along * math.cos(theta) + side * math.sin(theta)
        outline.append((x, -along * math.sin(theta) + side * math.cos(theta)))
    axes.add_patch(Polygon(outline, facecolor="0.85", edgecolor=INK, linewidth=0.8))


def cost_against_error(found: dict[str, Any]) -> Figure:
    """Draw thrust error over time per point, against the full model and against measurements."""
    with style():
        figure = new_figure(7.6, 3.4)
        against_model, against_data = figure.subplots(1, 2, sharex=True)
        for k, way in enumerate(found["ways"]):
            look = {"color": COLORS[k], "marker": MARKERS[k], "linestyle": "none"}
            cost = way["microseconds_single"]
            if way["model_error"] is not None:
                against_model.plot(cost, 100.0 * way["model_error"]["thrust"], **look)
            against_data.plot(cost, 100.0 * way["measured"]["thrust"], **look, label=way["name"])
        for axes, what in (
            (against_model, "against the full model\n(share of static thrust)"),
            (against_data, "against the 2019 measurements\n(share of their rms)"),
        ):
            axes.set_xscale("log")
            axes.set_xlim(0.2, 2000.0)
            axes.set_title(what, fontsize=9.0)
            axes.set_xlabel("time of one point [µs]")
            axes.set_ylabel("thrust, rms error [%]")
        against_model.set_yscale("log")
        against_data.set_ylim(bottom=0.0)
        handles = against_data.get_legend_handles_labels()
        figure.legend(*handles, loc="outside lower center", ncols=4)
    return figure


def mission(found: dict[str, Any]) -> Figure:
    """Draw the mission of the cross-check with propmap's loads and with the hover model."""
    panels = (
        ("pitch, nose down [deg]", ("pitch_deg",)),
        ("rotor speeds [rad/s]", ("front", "rear")),
        ("shaft power [W]", ("power",)),
        ("distance from the course [m]", ("error",)),
    )
    with style():
        figure = new_figure(8.4, 5.0)
        rows = figure.subplots(2, 2, sharex=True)
        for axes, (title, names) in zip(rows.flat, panels, strict=True):
            for model, color in (("propmap", BLUE), ("hover", RED)):
                columns = found[model]["series"]
                for name, line in zip(names, ("-", "--"), strict=False):
                    axes.plot(columns["time"], columns[name], line, color=color, linewidth=1.2)
            axes.set_title(title, fontsize=9.0)
        for axes in rows[1]:
            axes.set_xlabel("time [s]")
        handles = [
            key("propmap", color=BLUE),
            key("hover model", color=RED),
            key("front rotors", color=INK),
            key("rear rotors", color=INK, linestyle="--"),
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure


def inflow_lag() -> Figure:
    """Draw the thrust of a 10x4.5 propeller with dynamic and with quasi-static inflow.

    Left: the tip speed steps from 50 to 60 m/s in hover.  Right: to brake at a tip speed of
    60 m/s and an airspeed of 12 m/s, the disk turns from 20 deg nose down to 25 deg up in 0.1 s.
    """
    rotor = propmap.Rotor(propmap.catalogue_model("10x4.5"))
    inflow, dt = propmap.DynamicInflow(rotor), 5e-4
    tip_rate = 1.0 / rotor.model.propeller.radius
    time = dt * np.arange(-20, 240)
    nose_up = np.radians(np.clip(-20.0 + 450.0 * time, -20.0, 25.0))
    braking = 12.0 * np.stack([np.cos(nose_up), 0.0 * time, -np.sin(nose_up)], axis=1)
    flights = {
        "step of the rotational speed": (np.where(time < 0.0, 50.0, 60.0), 0.0 * braking),
        "brake": (np.full(time.size, 60.0), braking),
    }
    with style():
        figure = new_figure(8.4, 3.2)
        panels = figure.subplots(1, 2)
        for axes, (name, (tip_speed, velocity)) in zip(panels, flights.items(), strict=True):
            omega = tip_speed * tip_rate
            state, lagging = inflow.steady(omega[0], velocity[0]), np.zeros(time.size)
            for k in range(time.size):
                wrench, state = inflow.advance(state, dt, omega[k], velocity[k])
                lagging[k] = wrench.force[2]
            static = rotor.loads_at_velocity(omega, velocity).thrust
            axes.plot(1e3 * time, lagging, color=BLUE, linewidth=1.2)
            axes.plot(1e3 * time, static, color=RED, linewidth=1.2)
            off = abs(lagging / static - 1.0)
            last = 1e3 * time[off > 0.01].max(initial=0.0)
            until = f", above 1 % until {last:.0f} ms" if last > 0.0 else ""
            found = f"difference up to {100.0 * off.max():.1f} %{until}"
            axes.set_title(f"{name}\n{found}", fontsize=9.0)
            axes.set_xlabel("time [ms]")
            axes.set_ylabel("thrust [N]")
        handles = [key("dynamic inflow", color=BLUE), key("quasi-static inflow", color=RED)]
        figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


def _blank(axes: Axes, across: Point, up: Point, title: str) -> None:
    axes.set_xlim(*across)
    axes.set_ylim(*up)
    axes.set_aspect("equal")
    axes.axis("off")
    if title:
        axes.set_title(title, fontsize=9.0)


def _arrow(
    axes: Axes, begin: Point, end: Point, color: str, name: str, where: Point, width: float = 1.8
) -> None:
    axes.annotate(
        "",
        xy=end,
        xytext=begin,
        arrowprops={
            "arrowstyle": "-|>",
            "color": color,
            "linewidth": width,
            "shrinkA": 0.0,
            "shrinkB": 0.0,
        },
    )
    axes.text(*where, name, color=color)


if __name__ == "__main__":
    write(Path(sys.argv[1]))
