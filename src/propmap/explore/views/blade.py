"""Blade: planform and twist, changed by dragging points, and the loads that follow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from propmap.explore import view
from propmap.explore.session import Recipe, Session, axis, number, rotor_of
from propmap.explore.view import (
    Answer,
    Control,
    Download,
    Graph,
    Slider,
    Table,
    Values,
    point_controls,
    point_lines,
    point_words,
)
from propmap.io.csv import OperatingPoints, loads_csv
from propmap.io.geometry import propeller_toml
from propmap.model.model import Propeller
from propmap.report.html import COLOURS
from propmap.typing import Floats
from propmap.units import RPM

PLACES = (0.2, 0.35, 0.5, 0.65, 0.8, 0.95)
"""y/R of the points that can be dragged."""

FILE, LOADS_FILE = "blade.toml", "blade-loads.csv"

FASTEST, ALONG = 20.0, 21
"""[m/s] and points of the curves."""

MM = 1e3


class BladeView:
    """The blade beside a changed one."""

    name, title = "blade", "Blade"
    question = "What does another chord or twist do to the loads?"
    downloads = (Download(FILE, "blade as TOML"), Download(LOADS_FILE, "loads as CSV"))

    def controls(self, session: Session) -> Sequence[Control]:
        """What can be set."""
        chords = [
            Slider(f"chord-{k}", f"at {y:g} R", "%", 40.0, 200.0, 1.0, 100.0, group="Chord")
            for k, y in enumerate(PLACES)
        ]
        twists = [
            Slider(f"twist-{k}", f"at {y:g} R", "deg", -15.0, 15.0, 0.1, 0.0, group="Twist, added")
            for k, y in enumerate(PLACES)
        ]
        return [*point_controls(session), *chords, *twists]

    def graphs(self, session: Session) -> Sequence[Graph]:  # noqa: ARG002 - the same for all
        """The blade and its loads."""
        return [
            Graph("outline", "outline, to scale", wide=True),
            Graph("chord", "chord: drag the points"),
            Graph("twist", "twist: drag the points"),
            Graph("thrust", "thrust against speed"),
            Graph("power", "power against speed"),
        ]

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """The blade as it was and as it is."""
        old, new = session.model.propeller, changed(session.model.propeller, values)
        model = replace(session.model, propeller=new)
        speed = np.linspace(0.0, FASTEST, ALONG)
        flow = values["rpm"] * RPM, speed, np.radians(values["beta"])
        before, after = rotor_of(session.model).loads(*flow), rotor_of(model).loads(*flow)
        shown = {
            "outline": _outline(old, new),
            "chord": _draggable(old, new, "chord", values),
            "twist": _draggable(old, new, "twist", values),
        }
        for name in ("thrust", "power"):
            pair = getattr(before, name), getattr(after, name)
            shown[name] = view.figure(
                [
                    view.line(speed, pair[0], "as it was", view.GREY, "dash"),
                    view.line(speed, pair[1], "as it is", COLOURS[0]),
                ],
                "speed V [m/s]",
                view.TITLES[name],
                shapes=[view.upright(values["speed"])],
                yaxis=view.span(*pair, zero=True),
                xaxis={"range": [0.0, FASTEST]},
            )
        key = [("as it was", f"-{view.GREY}"), ("as it is", COLOURS[0])]
        return Answer(shown, [_table(session, model, values)] if settled else [], (), key)

    def shell(self, session: Session, values: Values) -> str:
        """The loads of the blade as it is, from its file."""
        recipe = self._recipe(session, values)
        return recipe.shell(
            [
                *("sweep", recipe.prop, "--rpm", number(values["rpm"])),
                *("--speed", axis(0.0, FASTEST, ALONG), "--beta", number(values["beta"])),
                *(*recipe.options, "--no-bands", "-o", LOADS_FILE, "--force"),
            ],
            ["predict", recipe.prop, *point_lines(values), *recipe.options],
            ["plot", "planform", recipe.prop, "-o", "blade.png"],
        )

    def python(self, session: Session, values: Values) -> str:
        """The loads of the blade as it is."""
        return self._recipe(session, values).python(
            f"omega = {number(values['rpm'])} * np.pi / 30.0\n"
            f"speed = np.linspace(0.0, {number(FASTEST)}, {ALONG})\n"
            f"print(rotor.loads(omega, speed, np.radians({number(values['beta'])})))"
        )

    def text(self, session: Session, values: Values, file: str) -> str:
        """The blade, or what `propmap sweep` writes of its loads."""
        blade = changed(session.model.propeller, values)
        if file == FILE:
            return propeller_toml(blade)
        speed = np.linspace(0.0, FASTEST, ALONG)
        points = OperatingPoints.grid(np.array([values["rpm"]]), speed, np.array([values["beta"]]))
        rotor = rotor_of(replace(session.model, propeller=blade))
        return loads_csv(points, points.loads(rotor), {})

    def _recipe(self, session: Session, values: Values) -> Recipe:
        blade = changed(session.model.propeller, values)
        same = blade is session.model.propeller
        return Recipe(session) if same else Recipe(session, blade=blade)


def changed(blade: Propeller, values: Values) -> Propeller:
    """The blade with its chord scaled and its twist changed, smoothly between the places."""
    chords = [values[f"chord-{k}"] for k in range(len(PLACES))]
    twists = [values[f"twist-{k}"] for k in range(len(PLACES))]
    if set(chords) == {100.0} and set(twists) == {0.0}:
        return blade
    share = np.clip(blade.station / blade.radius, PLACES[0], PLACES[-1])
    factor = PchipInterpolator(PLACES, np.array(chords) / 100.0)(share)
    more = PchipInterpolator(PLACES, np.radians(twists))(share)
    return replace(
        blade,
        name=f"{blade.name} changed",
        chord=blade.chord * factor,
        twist=blade.twist + more,
        source=f"{blade.name}, changed in propmap explore",
    )


def _outline(old: Propeller, new: Propeller) -> view.Figure:
    traces, widest = [], MM * max(float(old.chord.max()), float(new.chord.max()))
    for blade, colour, dash in ((old, view.GREY, "dash"), (new, COLOURS[0], "solid")):
        y, half = MM * blade.station, 0.5 * MM * blade.chord
        edge = np.concatenate([half, -half[::-1], half[:1]])
        along = np.concatenate([y, y[::-1], y[:1]])
        traces.append(view.line(along, edge, blade.name, colour, dash))
    return view.figure(
        traces,
        "radius y [mm]",
        "about mid-chord [mm]",
        xaxis={"range": [0.0, 1.02 * MM * old.radius], "constrain": "domain"},
        yaxis={
            "scaleanchor": "x",
            "constrain": "domain",
            "range": [-0.6 * widest, 0.6 * widest],
        },
        shapes=[view.upright(MM * old.root)],
    )


def _draggable(old: Propeller, new: Propeller, what: str, values: Values) -> view.Figure:
    """Chord [mm] or twist [deg] with a point to drag at each place."""
    own, other = (
        (MM * blade.chord if what == "chord" else np.degrees(blade.twist)) for blade in (old, new)
    )
    y = MM * old.station
    at = np.array(PLACES) * MM * old.radius
    base, here = np.interp(at, y, own), np.interp(at, y, other)
    low = 0.0 if what == "chord" else min(float(other.min()), float(own.min()), 0.0)
    high = 1.25 * max(float(other.max()), float(own.max()))
    size = 0.016 * MM * old.radius, 0.03 * (high - low)
    label = "chord c [mm]" if what == "chord" else "twist θ [deg]"
    return view.figure(
        [
            view.line(y, own, "as it was", view.GREY, "dash"),
            view.line(y, other, "as it is", COLOURS[0]),
        ],
        "radius y [mm]",
        label,
        shapes=[
            {
                "type": "circle",
                "xref": "x",
                "yref": "y",
                "x0": float(x - size[0]),
                "x1": float(x + size[0]),
                "y0": float(z - size[1]),
                "y1": float(z + size[1]),
                "fillcolor": COLOURS[1],
                "line": {"color": COLOURS[1]},
                "editable": True,
            }
            for x, z in zip(at, here, strict=True)
        ],
        meta={
            "drag": [f"{what}-{k}" for k in range(len(PLACES))],
            "base": base.tolist(),
            "share": what == "chord",
            "step": 1.0 if what == "chord" else 0.1,
        },
        dragmode=False,
        xaxis={"range": [0.0, 1.02 * MM * old.radius]},
        yaxis={"range": [low, high]},
        revision=" ".join(str(values[f"{what}-{k}"]) for k in range(len(PLACES))),
    )


def _table(session: Session, model: Any, values: Values) -> Table:
    flow = values["rpm"] * RPM, values["speed"], np.radians(values["beta"])
    before, after = rotor_of(session.model).loads(*flow), rotor_of(model).loads(*flow)
    rows = []
    for name, label in view.LABELS.items():
        a, b = float(getattr(before, name)), float(getattr(after, name))
        change = f"{100.0 * (b / a - 1.0):+.1f} %" if abs(a) > 1e-9 else ""
        rows.append([label, view.digits(a), view.digits(b), change, view.UNITS[name]])
    solidity = _solidity(session.model.propeller), _solidity(model.propeller)
    rows.append(["solidity", *(view.digits(s) for s in solidity), "", "-"])
    heads = ("", "as it was", "as it is", "change", "unit")
    return Table(heads, rows, f"At {point_words(values)}")


def _solidity(blade: Propeller) -> float:
    """Share of the disk that the blades cover [-]."""
    loaded = blade.station >= blade.root
    y: Floats = blade.station[loaded]
    area = blade.blades * np.trapezoid(blade.chord[loaded], y)
    return float(area / (np.pi * blade.radius**2))
