"""Loads over speed, rotational speed or angle, beside the hover model and measurements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np

from propmap.baselines.hover import HoverModel
from propmap.errors import InputError, quoted
from propmap.explore import view
from propmap.explore.session import Recipe, Session, axis, fastest, hover_model, number, rotor_of
from propmap.explore.view import (
    Answer,
    Choice,
    Control,
    Download,
    Graph,
    Several,
    Slider,
    Text,
    Values,
    point_controls,
    point_lines,
    point_table,
)
from propmap.fit.tunnel import TunnelData
from propmap.io.csv import OperatingPoints, loads_csv, std_columns
from propmap.report.html import COLOURS
from propmap.results import Loads
from propmap.typing import Floats
from propmap.units import RPM

# -------------------------------------------------------------------------------------------------
# Loads: how thrust, drag, torque, moments and power go with speed, rpm or angle.

ALONG = 31
"""Points of a curve."""

MOST_CURVES = 6

SHOWN = ("thrust", "drag", "torque", "roll_moment", "pitch_moment", "power")

NAME = "loads.csv"


class LoadsView:
    """Loads along a line through the envelope, a curve for each angle or speed."""

    name, title = "loads", "Loads"
    question = "How do the loads go with speed, rpm and angle, and how sure are they?"
    downloads = (Download(NAME, "curves as CSV"),)

    def controls(self, session: Session) -> Sequence[Control]:
        """What can be set."""
        measured = tuple((name, name) for name in session.measurements())
        return [
            Choice(
                "x",
                "Against",
                (("speed", "speed"), ("rpm", "rpm"), ("beta", "angle β")),
                "speed",
            ),
            *point_controls(session),
            Text("angles", "Angles β, a curve each [deg]", "0,30,60,90"),
            Text("speeds", "Speeds, a curve each against β [m/s]", "0,5,10,20"),
            Slider("fastest", "Speeds up to", "m/s", 5.0, 60.0, 1.0, 20.0),
            Several(
                "show",
                "Panels",
                tuple((n, view.LABELS[n]) for n in view.TITLES),
                SHOWN,
            ),
            Several("bands", "How sure", (("on", "95 % bands"),), ("on",)),
            Choice(
                "data",
                "Measured",
                (("none", "none"), *measured),
                measured[0][0] if measured else "none",
            ),
        ]

    def graphs(self, session: Session) -> Sequence[Graph]:  # noqa: ARG002 - the same for all
        """One for each load."""
        return [Graph(name, title) for name, title in view.TITLES.items()]

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """Curves at once; deviations, points by status and words as soon as it is settled."""
        model, remarks = session.model, []
        curves = _curves(session, values)
        loads = rotor_of(model).loads(curves.omega, curves.speed, curves.beta)
        hover = hover_model(model)
        std: Mapping[str, Floats] = {}
        if settled and values["bands"] and model.uncertainty is not None:
            std = {name: getattr(loads.std, name) for name in values["show"]}
        data = session.measured(values["data"])
        near = near_curves(curves, values["x"], data) if data is not None else []
        if data is not None and not any(which.size for which in near):
            remarks.append(nothing_near(data, values))
        shown = {
            name: panel(name, values, curves, loads, hover, std, data, near, words=settled)
            for name in values["show"]
        }
        tables = [point_table(session, values)] if settled else []
        key = [*zip(curves.names, COLOURS, strict=False), ("hover model", f"-{view.GREY}")]
        if data is not None:
            remarks.append(f"Points: {data.source}")
        return Answer(shown, tables, remarks, key)

    def shell(self, session: Session, values: Values) -> str:
        """A sweep that makes the curves, and a prediction for the operating point."""
        recipe = Recipe(session)
        bands = [] if values["bands"] else ["--no-bands"]
        sweep = [
            "sweep",
            recipe.prop,
            *_axes(session, values),
            *recipe.options,
            *bands,
            "-o",
            NAME,
            "--force",
        ]
        return recipe.shell(sweep, ["predict", recipe.prop, *point_lines(values), *recipe.options])

    def python(self, session: Session, values: Values) -> str:
        """The curves."""
        c = _curves(session, values)
        inner = {"speed": "beta", "rpm": "beta", "beta": "speed"}[values["x"]]
        lines = {
            "omega": f"np.array({number(values['rpm'])}) * np.pi / 30.0",
            "speed": f"np.array({number(values['speed'])})",
            "beta": f"np.radians({number(values['beta'])})",
        }
        ends = [float(c.x[0]), float(c.x[-1])]
        along = f"np.linspace({number(ends[0])}, {number(ends[1])}, {ALONG})"
        lines[{"speed": "speed", "rpm": "omega", "beta": "beta"}[values["x"]]] = {
            "speed": along,
            "rpm": f"{along} * np.pi / 30.0",
            "beta": f"np.radians({along})",
        }[values["x"]]
        which = _list(values["angles" if inner == "beta" else "speeds"], inner)
        text = f"np.array({which})[:, None]"
        lines[inner] = f"np.radians({text})" if inner == "beta" else text
        sure = ", loads.std.thrust" if session.model.uncertainty is not None else ""
        asked = "\n".join(f"{key} = {value}" for key, value in lines.items())
        return Recipe(session).python(
            f"{asked}\nloads = rotor.loads(omega, speed, beta)\nprint(loads.thrust{sure})"
        )

    def text(self, session: Session, values: Values, file: str) -> str:  # noqa: ARG002 - one file
        """What `propmap sweep` writes."""
        points = _grid(session, values)
        loads = points.loads(rotor_of(session.model))
        spread = std_columns(loads, by_source=False) if values["bands"] else {}
        return loads_csv(points, loads, spread)


def _list(text: str, what: str) -> list[float]:
    try:
        found = sorted({float(part) for part in text.split(",") if part.strip()})
    except ValueError:
        found = []
    ends = {"beta": (0.0, 360.0), "speed": (0.0, 200.0)}[what]
    if not found or not all(ends[0] <= one <= ends[1] for one in found):
        raise InputError(
            f"{quoted(text)} is no list of numbers from {ends[0]:g} to {ends[1]:g}",
            "write such as 0,30,60",
        )
    if len(found) > MOST_CURVES:
        raise InputError(f"{len(found)} curves are too many", f"give at most {MOST_CURVES}")
    return found


def _along(session: Session, values: Values) -> Floats:
    highest = round(fastest(session.model) / RPM)
    ends = {
        "speed": (0.0, values["fastest"]),
        "rpm": (0.1 * highest, highest),
        "beta": (0.0, 180.0),
    }[values["x"]]
    return np.linspace(*ends, ALONG)


def _curves(session: Session, values: Values) -> Curves:
    x = _along(session, values)
    inner = "speed" if values["x"] == "beta" else "beta"
    each = np.array(_list(values["speeds" if inner == "speed" else "angles"], inner))
    rpm, speed, beta = (
        x if values["x"] == own else each[:, None] if inner == own else np.array(values[own])
        for own in ("rpm", "speed", "beta")
    )
    names = tuple(f"V = {e:g} m/s" if inner == "speed" else f"β = {e:g}°" for e in each.tolist())
    shape = (each.size, x.size)
    omega, v, angle = (np.broadcast_to(a, shape) for a in (rpm * RPM, speed, np.radians(beta)))
    return Curves(x, omega, v, angle, names)


def _grid(session: Session, values: Values) -> OperatingPoints:
    """These points, in the order of a sweep."""
    x = _along(session, values)
    axes: dict[str, Any] = {k: np.array([values[k]]) for k in ("rpm", "speed", "beta")}
    inner = "speed" if values["x"] == "beta" else "beta"
    axes[inner] = np.array(_list(values["speeds" if inner == "speed" else "angles"], inner))
    axes[values["x"]] = x
    return OperatingPoints.grid(axes["rpm"], axes["speed"], axes["beta"])


def _axes(session: Session, values: Values) -> list[str]:
    x = _along(session, values)
    told = {key: number(values[key]) for key in ("rpm", "speed", "beta")}
    inner = "speed" if values["x"] == "beta" else "beta"
    each = _list(values["speeds" if inner == "speed" else "angles"], inner)
    told[inner] = ",".join(number(one) for one in each)
    told[values["x"]] = axis(float(x[0]), float(x[-1]), ALONG)
    return [part for key, text in told.items() for part in (f"--{key}", text)]


# -------------------------------------------------------------------------------------------------
# Panels of loads along curves: bands, points by status, measured points.

WIDE = NormalDist().inv_cdf(0.975)
"""Standard deviations on either side of a band that holds 95 %."""

SAME_RPM, SAME_SPEED, SAME_ANGLE = 0.01, 0.03, 0.5
"""How near a measured point must be to a curve to be drawn with it: shares, and degrees."""


class Curves(NamedTuple):
    """Operating points (k, n) of k curves of n points, and how they are called."""

    x: Floats
    omega: Floats
    speed: Floats
    beta: Floats
    names: tuple[str, ...]


def panel(
    name: str,
    values: Values,
    curves: Curves,
    loads: Loads,
    hover: HoverModel,
    std: Mapping[str, Floats],
    data: TunnelData | None,
    near: list[Any],
    *,
    words: bool,
) -> view.Figure:
    """A load along all curves.

    Parameters
    ----------
    name : str
        Of the load, or "power".
    values : Values
        What is set.
    curves : Curves
        Where.
    loads : Loads
        There, fields of shape (k, n).
    hover : HoverModel
        To compare with.
    std : mapping of str to ndarray, shape (k, n)
        Standard deviations by load; may be empty.
    data : TunnelData or None
        Measured points.
    near : list of ndarray
        Which of these belong to each curve, from ``near_curves``.
    words : bool
        Whether all numbers are told at each point, and points are marked by their status.
    """
    found: Floats = getattr(loads, name)
    traces: list[dict[str, Any]] = []
    if name in std:
        for k, row in enumerate(found):
            half = WIDE * std[name][k]
            traces.append(view.band(curves.x, row - half, row + half, COLOURS[k]))
    for k, row in enumerate(found):
        more: dict[str, Any] = {
            "hovertemplate": f"%{{x:.4g}}: %{{y:.4g}}<extra>{curves.names[k]}</extra>"
        }
        if words:
            more = {"text": _words(curves, loads, k), "hovertemplate": "%{text}<extra></extra>"}
        traces.append(view.line(curves.x, row, curves.names[k], COLOURS[k], **more))
    still = hover.loads(curves.omega[0])
    torque = np.asarray(still["torque"])
    height = torque * curves.omega[0] if name == "power" else still[name]
    drawn = np.broadcast_to(height, curves.x.shape)
    traces.append(view.line(curves.x, drawn, "hover model", view.GREY, "dash"))
    shown = [found, drawn]
    if data is not None:
        measured, heights = _measured(name, values["x"], curves, data, near)
        traces += measured
        shown.append(heights)
    if words:
        traces += _by_status(curves, loads, found)
    own = {"speed": values["speed"], "rpm": values["rpm"], "beta": values["beta"]}[values["x"]]
    label = {"speed": "speed V [m/s]", "rpm": "rpm", "beta": "angle β [deg]"}[values["x"]]
    return view.figure(
        traces,
        label,
        view.TITLES[name],
        revision=f"{values['x']}",
        shapes=[view.upright(own)],
        xaxis={"range": [float(curves.x[0]), float(curves.x[-1])]},
        yaxis=view.span(*shown, zero=True),
    )


def _words(curves: Curves, loads: Loads, k: int) -> list[str]:
    """All numbers of the points of a curve."""
    rows = []
    for i in range(curves.x.size):
        told = [
            f"{curves.omega[k, i] / RPM:.0f} rpm, {curves.speed[k, i]:.4g} m/s, "
            f"β {np.degrees(curves.beta[k, i]):.4g}°: {loads.status[k, i]}"
        ]
        told += [
            f"{view.LABELS[n]} {view.digits(getattr(loads, n)[k, i])} {view.UNITS[n]}"
            for n in view.TITLES
        ]
        rows.append("<br>".join(told))
    return rows


def _by_status(curves: Curves, loads: Loads, found: Floats) -> list[dict[str, Any]]:
    traces = []
    x = np.broadcast_to(curves.x, found.shape)
    for status, (mark, colour) in view.STATUS_MARKS.items():
        which = loads.status == status
        if which.any():
            y = np.where(np.isfinite(found[which]), found[which], 0.0)
            traces.append(
                view.points(
                    x[which],
                    y,
                    status,
                    colour,
                    mark,
                    hovertemplate=f"%{{x:.4g}}: %{{y:.4g}}<extra>{status}</extra>",
                )
            )
    return traces


def near_curves(curves: Curves, x: str, data: TunnelData) -> list[Any]:
    """Which measured points of ``data`` belong to each of the ``curves`` along ``x``."""
    rpm, beta = data.omega / RPM, np.degrees(data.folded_beta)
    found = []
    for k in range(len(curves.names)):
        w, v, b = curves.omega[k] / RPM, curves.speed[k], np.degrees(curves.beta[k])
        fits = np.ones(len(data), bool)
        if x != "rpm":
            fits &= np.abs(rpm - w[0]) <= SAME_RPM * w[0]
        if x != "speed":
            fits &= np.abs(data.speed - v[0]) <= np.maximum(SAME_SPEED * v[0], 0.05)
        if x != "beta":
            # At rest the angle means nothing: those points go with the first curve.
            at_rest = (data.speed == 0.0) if k == 0 else False
            fits &= (np.abs(beta - b[0]) < SAME_ANGLE) | at_rest
        found.append(np.flatnonzero(fits))
    return found


def _measured(
    name: str, x: str, curves: Curves, data: TunnelData, near: list[Any]
) -> tuple[list[dict[str, Any]], Floats]:
    values = data.loads.get(name)
    if name == "power" and "torque" in data.loads:
        values = data.loads["torque"] * data.omega
    if values is None:
        return [], np.empty(0)
    along = {"speed": data.speed, "rpm": data.omega / RPM, "beta": np.degrees(data.folded_beta)}[x]
    inside = (along >= curves.x[0]) & (along <= curves.x[-1])
    # One trace for all: each costs some milliseconds of every step.
    mine = [which[inside[which]] for which in near]
    curve = np.repeat(np.arange(len(near)), [which.size for which in mine])
    every = np.concatenate(mine) if mine else np.empty(0, int)
    trace = view.points(along[every], values[every], f"measured: {data.source}", COLOURS[0])
    trace["marker"] = {
        "color": [COLOURS[k] for k in curve],
        "symbol": [view.MARKS[k] for k in curve],
        "size": 7,
    }
    trace["text"] = [curves.names[k] for k in curve]
    trace["hovertemplate"] = "%{x:.4g}: %{y:.4g}<extra>measured, %{text}</extra>"
    return [trace], values[every]


def nothing_near(data: TunnelData, values: Values) -> str:
    """Why none of the ``data`` is drawn with what ``values`` are set."""
    rpm = data.omega / RPM
    if values["x"] != "rpm":
        nearest = rpm[np.argmin(np.abs(rpm - values["rpm"]))]
        if abs(nearest - values["rpm"]) > SAME_RPM * values["rpm"]:
            return f"{data.source}: no row within 1 % of {values['rpm']:g} rpm; try {nearest:.0f}"
    return f"{data.source}: no row lies on one of these curves"
