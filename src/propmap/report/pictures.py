"""Figures of loads, disks, blades, power, rankings, missions and wind."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.hover import HoverModel
from propmap.loads import LOADS
from propmap.report.html import (
    BAND,
    COLORS,
    DASHED,
    HOVER,
    MEASURED,
    MODEL,
    angle_keys,
    key,
    legend_below,
    load_panels,
    marked,
    new_figure,
    style,
)
from propmap.typing import Floats
from propmap.units import MM, RPM

if TYPE_CHECKING:
    from propmap.aircraft.mission import Flown, Mission
    from propmap.aircraft.performance import Performance
    from propmap.aircraft.ranking import Judged
    from propmap.aircraft.sensitivity import StateChange
    from propmap.aircraft.trim import SteadyStates
    from propmap.fit.tunnel import TunnelData
    from propmap.flight.wind import WindEstimate
    from propmap.model.propeller import Propeller
    from propmap.results import Inflow
    from propmap.rotor import Rotor


NEAR_ANGLE = np.radians(0.5)


def along(measured: TunnelData, beta: float, *, at_rest: bool) -> NDArray[np.intp]:
    """Return the indices of points within half a degree of ``beta`` [rad], and of points at rest if
    ``at_rest``, sorted by airspeed."""
    near = np.abs(measured.beta - beta) < NEAR_ANGLE
    mine = np.flatnonzero(near | (at_rest & (measured.speed == 0.0)))
    return mine[np.argsort(measured.speed[mine], kind="stable")]


@style()
def load_curves(
    rotor: Rotor,
    omega: float,
    speed: Floats,
    betas: Sequence[float],
    measured: TunnelData | None = None,
    *,
    band: Rotor | None = None,
    band_label: str = "95 % band of the model",
) -> Figure:
    """Draw every load against ``speed`` (n,) [m/s], one curve for each of at most 7 angles [rad].

    The hover model is dashed. Points are ``measured`` loads; those at rest belong to the first
    angle. The 95 % band of the rotor ``band`` is shaded.
    """
    if len(betas) > len(COLORS):
        fault = f"{len(betas)} angles are too many for one picture"
        raise InputError(fault, f"give at most {len(COLORS)}")
    found = rotor.loads(omega, speed, np.array(betas)[:, None])
    edges: tuple[Any, ...] = ()
    if band is not None and band.model.uncertainty is not None:
        shaded = found if band is rotor else band.loads(omega, speed, np.array(betas)[:, None])
        edges = shaded.interval()
    hover = HoverModel.from_rotor(rotor).loads(omega if omega > 0.0 else np.nan)
    figure, axes = load_panels(3.3, sharex=True)
    for ax, load in zip(axes.ravel(), LOADS.values(), strict=True):
        ax.axhline(float(hover[load.name]), **HOVER)
        for k, curve in enumerate(getattr(found, load.name)):
            ax.plot(speed, curve, color=COLORS[k], **MODEL)
            if edges:
                ends = [getattr(edge, load.name)[k] for edge in edges]
                ax.fill_between(speed, *ends, color=COLORS[k], **BAND)
        if measured is not None and load.name in measured.loads:
            for k, beta in enumerate(betas):
                mine = along(measured, beta, at_rest=k == 0)
                values = measured.loads[load.name][mine]
                ax.plot(measured.speed[mine], values, **marked(k), **MEASURED)
        ax.set_ylabel(load.title)
        ax.margins(x=0.02)
    for ax in axes[-1]:
        ax.set_xlabel("airspeed V [m/s]")
    model = rotor.model
    title = f"{model.propeller.name}, airfoil {model.law_title}, {omega / RPM:.0f} rpm"
    figure.suptitle(title if measured is None else f"{title}\npoints: {measured.source}")
    keys: list[Any] = angle_keys(betas, markersize=0.0 if measured is None else 4.5, **MODEL)
    keys.append(key("hover model", **HOVER))
    if edges:
        keys.append(Patch(label=band_label, color="0.4", **BAND))
    legend_below(figure, keys)
    return figure


STALL: dict[str, Any] = {"color": COLORS[1], "linewidth": 1.6, "linestyle": "solid"}
REVERSE: dict[str, Any] = {"color": "white", "linewidth": 1.6, "linestyle": "dashed"}
ARROW: dict[str, Any] = {"arrowstyle": "-|>", "color": "0.2", "mutation_scale": 12.0}


@style()
def disk_picture(rotor: Rotor, omega: float, speed: float, beta: float) -> Figure:
    """Draw the angle of attack over the disk at an operating point [rad/s], [m/s], [rad].

    The disk is seen from above, turns counter-clockwise and flies upward.  Raise ``InputError`` if
    the inflow did not converge everywhere.
    """
    blade = rotor.model.propeller
    radius = np.linspace(*rotor.model.span, 160)
    azimuth = np.radians(np.linspace(0.0, 360.0, 361))
    field = rotor.inflow(omega, speed, beta, radius=radius, azimuth=azimuth)
    if not np.isfinite(field.alpha).all():
        found = "the inflow did not converge everywhere on the disk"
        raise InputError(found, "choose another operating point")
    # The automatic layout ignores labels around polar plots, so the axes have fixed places.
    figure = Figure(figsize=(9.2, 5.4))
    disk: Any = figure.add_axes((0.05, 0.15, 0.40, 0.66), projection="polar")
    degrees = np.degrees(field.alpha)
    # In reverse flow alpha reaches +-180 deg; the color scale covers the rest of the disk.
    rest = degrees[~field.reverse] if not field.reverse.all() else degrees
    low, high = np.floor(np.percentile(rest, 1.0)), np.ceil(np.percentile(rest, 99.0))
    disk.set_theta_zero_location("S")
    disk.grid(visible=False)
    mesh = disk.pcolormesh(
        azimuth, MM * radius, degrees, cmap="viridis", vmin=low, vmax=max(high, low + 1.0),
        shading="gouraud", rasterized=True,
    )  # fmt: skip
    disk.set(ylim=(0.0, MM * radius[-1]), xticks=[], yticks=[])
    bar = figure.colorbar(mesh, cax=figure.add_axes((0.53, 0.22, 0.014, 0.52)), extend="both")
    bar.set_label(r"angle of attack $\alpha$ [deg]")
    _directions(disk, MM * blade.radius, oblique=speed * abs(np.sin(beta)) > 1e-9)
    handles = _regions(disk, field)
    figure.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.25, 0.0), ncols=2)
    inflow = figure.add_axes((0.69, 0.52, 0.29, 0.37))
    thrust = figure.add_axes((0.69, 0.10, 0.29, 0.37), sharex=inflow)
    inflow.tick_params(labelbottom=False)
    inflow.plot(MM * radius, field.inflow, color=COLORS[0])
    inflow.set_ylabel("inflow $v_i$ [m/s]")
    thrust.plot(MM * radius, field.thrust_per_radius, color=COLORS[0])
    thrust.set(ylabel="thrust dT/dy [N/m]", xlabel="radius y [mm]")
    figure.suptitle(
        f"{blade.name}, airfoil {rotor.model.law_title}: {omega / RPM:.0f} rpm, "
        f"V = {speed:g} m/s, β = {np.degrees(beta):.4g}°"
    )
    return figure


def _regions(ax: Any, field: Inflow) -> list[Line2D]:
    """Outline stall and reverse flow, and return handles for the legend."""
    # Zero contours of continuous fields are smoother than outlines of the Boolean regions.
    regions = (
        ("stalled", field.stalled, field.past_stall, STALL),
        ("reverse flow", field.reverse, field.u_tangential, REVERSE),
    )
    handles = []
    for name, region, boundary, look in regions:
        if not region.any():
            continue
        if not region.all():
            ax.contour(
                field.azimuth, MM * field.radius, boundary, [0.0], colors=look["color"],
                linewidths=look["linewidth"], linestyles=look["linestyle"],
            )  # fmt: skip
        color = "0.5" if look["color"] == "white" else look["color"]
        label = f"{name}: {100.0 * field.share_of_disk(region):.2g} % of the disk"
        handles.append(Line2D([], [], **{**look, "color": color}, label=label))
    return handles


def _directions(ax: Any, tip: float, *, oblique: bool) -> None:
    """Label the sides, and draw arrows for the rotation and the flight direction."""
    sides = (" advancing", " retreating") if oblique else ("", "")
    label: dict[str, Any] = {"transform": ax.transAxes, "ha": "center", "va": "center"}
    ax.text(0.5, -0.035, "ψ = 0°", **label)
    ax.text(1.035, 0.5, f"ψ = 90°{sides[0]}", rotation=-90.0, **label)
    ax.text(0.5, 1.03, "ψ = 180°", **label)
    ax.text(-0.035, 0.5, f"ψ = 270°{sides[1]}", rotation=90.0, **label)
    turn = np.radians(np.linspace(32.0, 60.0, 30))
    ax.plot(turn, np.full(30, 1.06 * tip), color="0.2", linewidth=1.2, clip_on=False)
    ax.annotate(
        "", (turn[-1] + 0.03, 1.06 * tip), (turn[-2], 1.06 * tip), arrowprops=ARROW,
        annotation_clip=False,
    )  # fmt: skip
    middle = {"ha": "center", "va": "center", "rotation": 45.0}
    ax.text(np.radians(45.0), 1.12 * tip, "rotation", **middle)
    if oblique:
        up = {"xycoords": "axes fraction", "arrowprops": ARROW}
        ax.annotate("", xy=(0.5, 1.18), xytext=(0.5, 1.06), **up)
        ax.text(0.53, 1.12, "flight", transform=ax.transAxes, va="center")


WIDTH = 7.2  # width of the figure [inches]


@style()
def planform(propeller: Propeller) -> Figure:
    """Draw outline (centered on mid-chord, because the model has no sweep), chord and twist."""
    station, chord, root = 1e3 * propeller.station, 1e3 * propeller.chord, 1e3 * propeller.root
    tip = 1e3 * propeller.radius
    loaded = np.union1d(station[station > root], [root])
    half = 0.5 * np.interp(loaded, station, chord)
    # Height [inches] at which the outline, drawn to scale, fills the width of its panel.
    height = 1.2 * WIDTH * chord.max() / station[-1]
    figure = new_figure(WIDTH, height + 4.4)
    outline, chords, twists = figure.subplots(3, 1, sharex=True, height_ratios=(height, 1.7, 1.7))
    outline.fill_between(station, -0.5 * chord, 0.5 * chord, color="0.9", linewidth=0.0)
    outline.fill_between(loaded, -half, half, color=COLORS[5], alpha=0.6, linewidth=0.0)
    for side in (-0.5, 0.5):
        outline.plot(station, side * chord, color="0.2", linewidth=1.0)
    outline.axvline(root, color="0.4", linewidth=1.0, linestyle=":")
    outline.set_ylim(-0.55 * chord.max(), 0.55 * chord.max())
    outline.set_aspect("equal", adjustable="box")
    outline.set_ylabel("outline [mm]")
    points = {"marker": "o", "markersize": 3.0}
    chords.plot(station, chord, color=COLORS[0], **points)
    chords.set(ylabel="chord c [mm]", ylim=(0.0, None))
    twists.plot(station, np.degrees(propeller.twist), color=COLORS[1], **points)
    twists.set(ylabel="twist θ [deg]", xlabel="radius y [mm]", xlim=(0.0, 1.02 * station[-1]))
    upper = outline.secondary_xaxis("top", functions=(lambda y: y / tip, lambda x: x * tip))
    upper.set_xlabel("y/R")
    number = f"{propeller.blades} blades" if propeller.blades > 1 else "1 blade"
    figure.suptitle(f"{propeller.name}: {number}, R = {tip:.4g} mm, root at {root:.4g} mm")
    return figure


WIDE = NormalDist().inv_cdf(0.975)  # half width of a 95 % band in standard deviations


@style()
def power_curves(
    title: str,
    flown: Sequence[SteadyStates],
    hover: Sequence[SteadyStates],
    found: Performance | None = None,
    sure: Sequence[StateChange | None] = (),
) -> Figure:
    """Draw power, pitch, rotor speeds and thrust margin against airspeed.

    ``flown`` contains up to 7 climb rates, ``hover`` the same states with the hover model (dashed),
    ``sure`` their standard deviations for 95 % bands.  Symbols mark the named states of ``found``.
    """
    if len(flown) > len(COLORS):
        fault = f"{len(flown)} climb rates are too many for one picture"
        raise InputError(fault, f"give at most {len(COLORS)}")
    figure = new_figure(8.6, 6.2)
    axes = figure.subplots(2, 2, sharex=True)
    power, pitch, speed, margin = axes.ravel()
    bands = sure or [None] * len(flown)
    for states, still, known, color in zip(flown, hover, bands, COLORS, strict=False):
        v = states.speed
        same: dict[str, Any] = {"color": color}
        both = bool(np.isfinite(states.electrical_power).any())
        power.plot(v, states.power, **MODEL, **same)
        if both:
            power.plot(v, states.shaft_power, linewidth=0.9, **same)
        rpm = states.rotor_speed / RPM
        edges = rpm.min(axis=1), rpm.max(axis=1)
        for edge in edges:
            speed.plot(v, edge, **MODEL, **same)
        if known is not None:
            degrees, turning = np.degrees(states.pitch), known.rotor_speed.max(axis=1) / RPM
            for ax, low, high, std in (
                (power, states.power, states.power, known.power),
                (pitch, degrees, degrees, np.degrees(known.pitch)),
                (speed, *edges, turning),
            ):
                ax.fill_between(v, low - WIDE * std, high + WIDE * std, **BAND, **same)
        pitch.plot(v, np.degrees(states.pitch), **MODEL, **same)
        margin.plot(v, states.thrust_margin, **MODEL, **same)
        look = HOVER if len(flown) == 1 else {**DASHED, **same}
        for ax, values in (
            (power, still.power),
            (pitch, np.degrees(still.pitch)),
            (speed, still.rotor_speed.mean(axis=1) / RPM),
            (margin, still.thrust_margin),
        ):
            ax.plot(v, values, **look)
    margin.axhline(1.0, color="0.5", linewidth=0.8)
    electric = bool(np.isfinite(flown[0].electrical_power).any())
    power.set_ylabel("electrical power (thin: shaft power) [W]" if electric else "shaft power [W]")
    pitch.set_ylabel("pitch, nose down [deg]")
    speed.set_ylabel("slowest and fastest rotor [1/min]")
    margin.set_ylabel("maximum thrust / required [-]")
    power.set_ylim(bottom=0.0)
    margin.set_ylim(bottom=0.0)
    if not any(np.isfinite(states.thrust_margin).any() for states in flown):
        margin.text(0.5, 0.5, "unknown", transform=margin.transAxes, ha="center", va="center")
    for ax in (margin, speed):
        ax.set_xlabel("horizontal airspeed [m/s]")
    if found is not None:
        slowest, fastest = found.states.speed[[0, -1]]
        look = {"color": "black", "markersize": 5.0}
        for marker, (_, words, state) in zip("vDs", found.named[1:], strict=True):
            if state is not None and slowest <= state.speed <= fastest:
                label = words.partition(",")[0]
                power.plot(state.speed, state.power, marker, label=label, **look)
        if power.get_legend_handles_labels()[0]:
            power.legend(loc="lower left", fontsize=8.0)
    figure.suptitle(title)
    climbs = [float(states.climb[0]) for states in flown]
    keys: list[Any] = [
        key(f"climb {c:g} m/s" if c or len(climbs) > 1 else "this model", color=color, **MODEL)
        for c, color in zip(climbs, COLORS, strict=False)
    ]
    keys.append(key("hover model", **(HOVER if len(flown) == 1 else {**DASHED, "color": "0.35"})))
    if any(each is not None for each in bands):
        keys.append(Patch(label="95 % band", color="0.4", **BAND))
    legend_below(figure, keys)
    return figure


NAMED = 3  # number of top-ranked propellers to number, in addition to the names of the front


@style()
def propeller_choice(title: str, judged: Sequence[Judged], front: Sequence[int]) -> Figure:
    """Draw top speed against hover power for the suitable propellers of a ranking.

    ``judged`` lists the best first.  A line joins the Pareto front ``front``: no other propeller is
    better in both quantities.
    """
    figure = new_figure(8.6, 5.6)
    ax = figure.subplots()
    drawn = [k for k, one in enumerate(judged) if one.feasible and np.isfinite(one.top_speed)]
    power = [judged[k].hover_power for k in drawn]
    ax.plot(power, [judged[k].top_speed for k in drawn], "o", color=COLORS[5], markersize=4.0)
    along = [judged[k].hover_power for k in front], [judged[k].top_speed for k in front]
    ax.plot(*along, "-o", color=COLORS[1], markersize=5.0, linewidth=1.2)
    best = [k for k in range(min(NAMED, len(judged))) if k in drawn]
    for rank, k in enumerate(best, start=1):
        ax.plot(
            judged[k].hover_power, judged[k].top_speed, "s", color="black", fillstyle="none",
            markersize=9.0,
        )  # fmt: skip
        ax.annotate(
            f"{rank}", (judged[k].hover_power, judged[k].top_speed), xytext=(0, 6),
            textcoords="offset points", fontsize=8.0, ha="center", va="bottom",
        )  # fmt: skip
    for place, k in enumerate(front):
        up = place % 2 == 0
        ax.annotate(
            judged[k].candidate.name.removeprefix("uiuc-"),
            (judged[k].hover_power, judged[k].top_speed),
            xytext=(-7, 6) if up else (7, -8),
            textcoords="offset points",
            fontsize=7.5,
            ha="right" if up else "left",
            va="bottom" if up else "top",
        )
    ax.margins(0.12)
    ax.set(xlabel="hover power [W]", ylabel="top speed [m/s]")
    figure.suptitle(title)
    legend_below(
        figure,
        [
            key("suitable", color=COLORS[5], marker="o", linestyle="none", markersize=4.0),
            key("Pareto front", color=COLORS[1], marker="o", markersize=5.0),
            key("top of the ranking", color="black", marker="s", linestyle="none",
                fillstyle="none", markersize=8.0),
        ],
    )  # fmt: skip
    return figure


@style()
def mission_course(title: str, legs: Mission, flown: Flown) -> Figure:
    """Draw airspeed, power, charge and voltage against time; shade what cannot be flown."""
    figure = new_figure(8.6, 5.4)
    axes = figure.subplots(2, 2, sharex=True)
    motion, power, charge, voltage = axes.ravel()
    time = flown.course.time / 60.0
    over = time[:, [0, -1]].ravel()
    motion.plot(over, np.repeat(legs.speed, 2), color=COLORS[0], **MODEL)
    motion.plot(over, np.repeat(legs.climb, 2), color=COLORS[1], **DASHED)
    motion.set_ylabel("airspeed; climb rate [m/s]")
    power.plot(over, np.repeat(flown.states.power, 2), color=COLORS[0], **MODEL)
    power.set(ylabel="power [W]", ylim=(0.0, 1.1 * max(power.get_ylim()[1], 1.0)))
    charge.plot(time.ravel(), 100.0 * flown.course.charge.ravel(), color=COLORS[0], **MODEL)
    charge.set(ylabel="state of charge [%]", ylim=(0.0, 105.0))
    voltage.plot(time.ravel(), flown.course.voltage.ravel(), color=COLORS[0], **MODEL)
    voltage.set_ylabel("battery voltage [V]")
    for ax in (charge, voltage):
        ax.set_xlabel("time [min]")
    lost = ~flown.lasted
    if lost.any():
        end = time[int(np.argmax(lost)), 0]
        for ax in axes.ravel():
            ax.axvspan(end, time[-1, -1], color="0.92", linewidth=0.0)
    figure.suptitle(title)
    keys = [
        key("airspeed, power, charge, voltage", color=COLORS[0], **MODEL),
        key("climb rate", color=COLORS[1], **DASHED),
    ]
    if lost.any():
        keys.append(key("cannot be flown", color="0.88", linewidth=8.0))
    legend_below(figure, keys)
    return figure


@style()
def wind_picture(found: WindEstimate) -> Figure:
    """Draw the wind and the speed over the ground against time; shade times with a weak estimate.

    The lowest panel also shows the airspeed, and the measured airspeed if the log contains one.
    """
    columns = found.columns
    time, weak = columns["time_s"], ~np.isin(found.status, ("ok", "extrapolated"))
    names = {f"wind_{way}": f"wind {way} [m/s]" for way in ("east", "north", "up")}
    figure = new_figure(8.6, 8.2)
    axes = figure.subplots(4, 1, sharex=True)
    for ax, (name, label) in zip(axes, {**names, "airspeed": "speed [m/s]"}.items(), strict=True):
        ends = (columns[f"{name}_{end}_95_mps"] for end in ("low", "high"))
        ax.fill_between(time, *ends, color=COLORS[0], **BAND)
        ax.plot(time, columns[f"{name}_mps"], color=COLORS[0], **MODEL)
        ax.fill_between(time, 0.0, 1.0, weak, transform=ax.get_xaxis_transform(), color="0.92")
        ax.set_ylabel(label)
    axes[3].plot(time, columns["ground_speed_mps"], color=COLORS[1], **MODEL)
    axes[3].plot(time, columns["measured_airspeed_mps"], color=COLORS[2], marker=".", **MEASURED)
    axes[3].set(xlabel="time [s]", xlim=(time[0], time[-1]))
    keys: list[Any] = [
        key("wind, airspeed", color=COLORS[0], **MODEL),
        Patch(label="95 % band", color=COLORS[0], **BAND),
        key("ground speed", color=COLORS[1], **MODEL),
        *([key("measured airspeed", color=COLORS[2], marker=".", **MEASURED)]
          if np.isfinite(columns["measured_airspeed_mps"]).any() else []),
        Patch(label="weak estimate", color="0.92"),
    ]  # fmt: skip
    legend_below(figure, keys)
    figure.suptitle(found.log.source)
    return figure
