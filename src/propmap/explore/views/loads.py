"""Loads: over airspeed, rotational speed or angle, with hover model and measurements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError, quoted
from propmap.explore import view
from propmap.explore.session import Recipe, Session, axis, fastest, hover_model, number, rotor_of
from propmap.explore.view import Answer, Control, Download, Graph, OneOf, Several, Text, Values
from propmap.fit.tunnel import TunnelData
from propmap.io.csv import OperatingPoints, loads_csv, std_columns
from propmap.report.html import COLORS
from propmap.results import Loads
from propmap.typing import Floats
from propmap.units import RPM

MOST_CURVES = 6  # maximum number of curves
SHOWN = ("thrust", "drag", "torque", "roll_moment", "pitch_moment", "power")
NAME = "loads.csv"
# Largest differences between a curve and its measured points: relative, relative and in degrees.
SAME_RPM, SAME_SPEED, SAME_ANGLE = 0.01, 0.03, 0.5


class LoadsView(view.View):
    """Loads over one variable, with a curve for each angle or airspeed."""

    name, title = "loads", "Loads"
    question = "How do the loads vary with airspeed, rpm and angle, and how uncertain are they?"
    downloads = (Download(NAME, "curves as CSV"),)
    places = tuple(Graph(name, title) for name, title in view.TITLES.items())

    def controls(self, session: Session) -> Sequence[Control]:
        """Return the controls."""
        against = (("speed", "airspeed"), ("rpm", "rpm"), ("beta", "angle β"))
        panels = tuple((name, view.LABELS[name]) for name in view.TITLES)
        return [
            OneOf("x", "Against", against, "speed"),
            *view.point_controls(session),
            Text("angles", "Angles β [deg], one curve each", "0,30,60,90"),
            Text("speeds", "Airspeeds [m/s] of the curves against β", "0,5,10,20"),
            view.Slider("fastest", "Maximum airspeed", "m/s", 5.0, 60.0, 1.0, 20.0),
            Several("show", "Panels", panels, SHOWN),
            Several("bands", "Uncertainty", (("on", "95 % bands"),), ("on",)),
            view.data_choice(session),
        ]

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """Draw curves at once; bands, points by status and texts only when settled."""
        model, remarks = session.model, []
        along = values["x"]
        axes = _axes(session, values)
        flow = _flow(axes, along)
        omega = flow["rpm"] * RPM
        loads = rotor_of(model).loads(omega, flow["speed"], np.radians(flow["beta"]))
        names = [
            f"β = {each:g}°" if _across(along) == "beta" else f"V = {each:g} m/s"
            for each in axes[_across(along)].tolist()
        ]
        still = hover_model(model).loads(omega[0])
        still = {**still, "power": np.asarray(still["torque"]) * omega[0]}
        sure = settled and values["bands"] and model.uncertainty is not None
        ends = loads.interval() if sure else ()
        data = session.measured(values["data"])
        near = near_curves(flow, along, data) if data is not None else []
        if data is not None and not any(which.size for which in near):
            remarks.append(nothing_near(data, values))

        shown = {}
        x = axes[along]
        for name in values["show"]:
            found: Floats = getattr(loads, name)
            traces: list[dict[str, Any]] = []
            if ends:
                for k in range(len(found)):
                    low, high = (getattr(end, name)[k] for end in ends)
                    traces.append(view.band(x, low, high, COLORS[k]))
            for k, row in enumerate(found):
                template = f"%{{x:.4g}}: %{{y:.4g}}<extra>{names[k]}</extra>"
                traces.append(view.line(x, row, names[k], COLORS[k], hovertemplate=template))
            hover = np.broadcast_to(still[name], x.shape)
            traces.append(view.line(x, hover, *view.HOVER))
            heights = [found, hover]
            if data is not None:
                drawn, measured = _measured(name, along, x, names, data, near)
                traces += drawn
                heights.append(measured)
            if settled:
                traces += _by_status(x, loads, found)
            shown[name] = view.figure(
                traces,
                view.AXES[along],
                view.TITLES[name],
                revision=along,
                shapes=[view.upright(values[along])],
                xaxis={"range": [float(x[0]), float(x[-1])]},
                yaxis=view.span(*heights, zero=True),
            )
        tables = [view.point_table(session, values)] if settled else []
        key = [*zip(names, COLORS, strict=False), ("hover model", f"-{view.GRAY}")]
        if data is not None:
            remarks.append(f"Measured points: {data.source}")
        return Answer(shown, tables, remarks, key)

    def shell(self, session: Session, values: Values) -> str:
        """Return commands for the curves and for the operating point."""
        recipe, axes, along = Recipe(session), _axes(session, values), values["x"]
        options = []
        for name, each in axes.items():
            text = ",".join(map(number, each))
            if name == along:
                text = axis(float(each[0]), float(each[-1]), view.CURVE)
            options += [f"--{name}", text]
        bands = [] if values["bands"] else ["--no-bands"]
        sweep = ["sweep", recipe.prop, *options, *recipe.options, *bands, "-o", NAME, "--force"]
        return recipe.shell(sweep, recipe.predict(values))

    def python(self, session: Session, values: Values) -> str:
        """Return code that prints the thrust of the curves."""
        axes, along = _axes(session, values), values["x"]
        lines = []
        for name, each in axes.items():
            if name == along:
                text = f"np.linspace({number(each[0])}, {number(each[-1])}, {view.CURVE})"
            elif name == _across(along):
                text = f"np.array({each.tolist()})[:, None]"
            else:
                text = number(each[0])
                text = text if name == "beta" else f"np.array({text})"
            forms = {"rpm": f"omega = {text} * np.pi / 30.0", "beta": f"beta = np.radians({text})"}
            lines.append(forms.get(name, f"{name} = {text}"))
        sure = ", loads.std.thrust" if session.model.uncertainty is not None else ""
        lines += ["loads = rotor.loads(omega, speed, beta)", f"print(loads.thrust{sure})"]
        return Recipe(session).python("\n".join(lines))

    def text(self, session: Session, values: Values, file: str) -> str:  # noqa: ARG002 - one file
        """Return the same CSV as `propmap sweep`."""
        points = OperatingPoints.grid(*_axes(session, values).values())
        loads = points.loads(rotor_of(session.model))
        spread = std_columns(loads, by_source=False) if values["bands"] else {}
        return loads_csv(points, loads, spread)


# -------------------------------------------------------------------------------------------------
# Operating points: rpm, airspeed or angle varies along a curve, and a second one between curves.


def _across(along: str) -> str:
    """Return the variable that differs between curves."""
    return "speed" if along == "beta" else "beta"


def _axes(session: Session, values: Values) -> dict[str, Floats]:
    """Return the values of rpm, airspeed and beta [deg]: along a curve, by curve, or one."""
    along = values["x"]
    highest = round(fastest(session.model) / RPM)
    ends = {
        "speed": (0.0, values["fastest"]),
        "rpm": (0.1 * highest, highest),
        "beta": (0.0, 180.0),
    }
    axes = {name: np.array([values[name]]) for name in ("rpm", "speed", "beta")}
    axes[along] = np.linspace(*ends[along], view.CURVE)
    across = _across(along)
    text = values["speeds" if across == "speed" else "angles"]
    top = {"beta": 360.0, "speed": 200.0}[across]
    try:
        found = sorted({float(part) for part in text.split(",") if part.strip()})
    except ValueError:
        found = []
    if not found or not all(0.0 <= one <= top for one in found):
        fault = f"{quoted(text)} is not a list of numbers from 0 to {top:g}"
        raise InputError(fault, "give a list such as 0,30,60")
    if len(found) > MOST_CURVES:
        raise InputError(f"{len(found)} curves are too many", f"give at most {MOST_CURVES}")
    axes[across] = np.array(found)
    return axes


def _flow(axes: Mapping[str, Floats], along: str) -> dict[str, Floats]:
    """Return rpm, airspeed and beta [deg] of n points on each of k curves, (k, n)."""
    shaped = (each[:, None] if name == _across(along) else each for name, each in axes.items())
    return dict(zip(axes, np.broadcast_arrays(*shaped), strict=True))


# --- Further elements of the figures: points by status, measured points --------------------------


def _by_status(x: Floats, loads: Loads, found: Floats) -> list[dict[str, Any]]:
    """Return markers on the points of a load (k, n) with a status other than "ok"."""
    traces = []
    for status, (mark, color) in view.STATUS_MARKS.items():
        which = loads.status == status
        if which.any():
            heights = np.where(np.isfinite(found[which]), found[which], 0.0)
            template = f"%{{x:.4g}}: %{{y:.4g}}<extra>{status}</extra>"
            at = np.broadcast_to(x, found.shape)[which]
            traces.append(view.points(at, heights, status, color, mark, hovertemplate=template))
    return traces


def near_curves(flow: Mapping[str, Floats], along: str, data: TunnelData) -> list[NDArray[np.intp]]:
    """Return the indices of the measured points of each curve."""
    rpm, beta = data.omega / RPM, np.degrees(data.folded_beta)
    found = []
    for k, (w, v, b) in enumerate(zip(flow["rpm"], flow["speed"], flow["beta"], strict=True)):
        fits = np.ones(len(data), bool)
        if along != "rpm":
            fits &= np.abs(rpm - w[0]) <= SAME_RPM * w[0]
        if along != "speed":
            fits &= np.abs(data.speed - v[0]) <= np.maximum(SAME_SPEED * v[0], 0.05)
        if along != "beta":
            # Points at rest have no angle and belong to the first curve.
            at_rest = (data.speed == 0.0) if k == 0 else False
            fits &= (np.abs(beta - b[0]) < SAME_ANGLE) | at_rest
        found.append(np.flatnonzero(fits))
    return found


def _measured(
    name: str, along: str, x: Floats, names: Sequence[str], data: TunnelData, near: list[Any]
) -> tuple[list[dict[str, Any]], Floats]:
    """Return the measured points within ``x``, in the colors of their curves, and their values."""
    values = data.loads.get(name)
    if name == "power" and "torque" in data.loads:
        values = data.loads["torque"] * data.omega
    if values is None:
        return [], np.empty(0)
    at = {"speed": data.speed, "rpm": data.omega / RPM, "beta": np.degrees(data.folded_beta)}[along]
    inside = (at >= x[0]) & (at <= x[-1])
    # One trace for all points: each trace adds some milliseconds to every update.
    mine = [which[inside[which]] for which in near]
    curve = [k for k, which in enumerate(mine) for _ in which]
    every = np.concatenate(mine)
    trace = view.points(at[every], values[every], f"measured: {data.source}", COLORS[0])
    colors, marks = [COLORS[k] for k in curve], [view.MARKS[k] for k in curve]
    trace["marker"] = {"color": colors, "symbol": marks, "size": 7}
    trace["text"] = [names[k] for k in curve]
    trace["hovertemplate"] = "%{x:.4g}: %{y:.4g}<extra>measured, %{text}</extra>"
    return [trace], values[every]


def nothing_near(data: TunnelData, values: Values) -> str:
    """Return why no measured point is drawn with these ``values`` of the controls."""
    rpm = data.omega / RPM
    if values["x"] != "rpm":
        nearest = rpm[np.argmin(np.abs(rpm - values["rpm"]))]
        if abs(nearest - values["rpm"]) > SAME_RPM * values["rpm"]:
            near = f"{values['rpm']:g} rpm; set {nearest:.0f} rpm"
            return f"{data.source}: no row within 1 % of {near}"
    return f"{data.source}: no row is on one of these curves"
