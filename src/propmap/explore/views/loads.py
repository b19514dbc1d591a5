"""Loads: how thrust, drag, torque, moments and power go with speed, rpm or angle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from propmap.errors import InputError, quoted
from propmap.explore import figures
from propmap.explore.controls import Choice, Control, Several, Slider, Text, Values
from propmap.explore.load_panels import Curves, near_curves, nothing_near, panel
from propmap.explore.point import point_controls, point_lines, point_table
from propmap.explore.reproduce import Recipe, axis, number
from propmap.explore.rotors import fastest, hover_model, rotor_of
from propmap.explore.session import Session
from propmap.explore.view import Answer, Download, Graph
from propmap.io.csv_text import loads_csv
from propmap.io.operating_points import RPM, OperatingPoints, std_columns
from propmap.report.html import COLOURS
from propmap.typing import Floats

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
                tuple((n, figures.LABELS[n]) for n in figures.TITLES),
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
        return [Graph(name, title) for name, title in figures.TITLES.items()]

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
        key = [*zip(curves.names, COLOURS, strict=False), ("hover model", f"-{figures.GREY}")]
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
    """The same points, in the order of a sweep."""
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
