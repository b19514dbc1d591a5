"""Blade: chord and twist, changed with sliders or dragged points, and the resulting loads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from propmap.explore import view
from propmap.explore.session import Recipe, Session, rotor_of
from propmap.explore.view import Answer, Control, Download, Graph, Slider, Table, Values
from propmap.io.csv import OperatingPoints, loads_csv
from propmap.io.geometry import propeller_toml
from propmap.model.model import Model
from propmap.model.propeller import Propeller
from propmap.report.html import COLORS
from propmap.units import MM, RPM

PLACES = (0.2, 0.35, 0.5, 0.65, 0.8, 0.95)  # y/R of the draggable points
FILE, LOADS_FILE = "blade.toml", "blade-loads.csv"
FASTEST, ALONG = 20.0, 21  # maximum airspeed [m/s] and number of points of the curves
BEFORE, AFTER = ("original blade", view.GRAY, "dash"), ("changed blade", COLORS[0])


class BladeView(view.View):
    """Comparison of the blade with a changed blade."""

    name, title = "blade", "Blade"
    question = "How do chord and twist affect the loads?"
    downloads = (Download(FILE, "blade as TOML"), Download(LOADS_FILE, "loads as CSV"))
    places = (
        Graph("outline", "outline to scale", wide=True),
        Graph("chord", "chord: drag the points"),
        Graph("twist", "twist: drag the points"),
        Graph("thrust", "thrust against airspeed"),
        Graph("power", "power against airspeed"),
    )

    def controls(self, session: Session) -> Sequence[Control]:
        """Return the controls."""
        chords = [
            Slider(f"chord-{k}", f"at {y:g} R", "%", 40.0, 200.0, 1.0, 100.0, group="Chord")
            for k, y in enumerate(PLACES)
        ]
        twists = [
            Slider(f"twist-{k}", f"at {y:g} R", "deg", -15.0, 15.0, 0.1, 0.0, group="Added twist")
            for k, y in enumerate(PLACES)
        ]
        return [*view.point_controls(session), *chords, *twists]

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """Draw the original and the changed blade with their loads."""
        old, model = session.model.propeller, model_of(session, values)
        speed = np.linspace(0.0, FASTEST, ALONG)
        flow = values["rpm"] * RPM, speed, np.radians(values["beta"])
        before, after = rotor_of(session.model).loads(*flow), rotor_of(model).loads(*flow)
        shown = {"outline": _outline(old, model.propeller)}
        for what in ("chord", "twist"):
            shown[what] = _draggable(old, model.propeller, what, values)
        for name in ("thrust", "power"):
            lines = [(getattr(before, name), *BEFORE), (getattr(after, name), *AFTER)]
            axes, here = (view.AXES["speed"], view.TITLES[name]), [view.upright(values["speed"])]
            shown[name] = view.curves(speed, lines, *axes, shapes=here, zero=True)
        key = [(BEFORE[0], f"-{view.GRAY}"), AFTER]
        return Answer(shown, [_table(session.model, model, values)] if settled else [], (), key)

    def shell(self, session: Session, values: Values) -> str:
        """Return commands for the loads and the planform of the blade."""
        recipe = self._recipe(session, values)
        return recipe.shell(
            recipe.sweep(values, FASTEST, ALONG, LOADS_FILE),
            recipe.predict(values),
            ["plot", "planform", recipe.prop, "-o", "blade.png"],
        )

    def python(self, session: Session, values: Values) -> str:
        """Return code that prints the loads of the blade."""
        return self._recipe(session, values).python(view.sweep_python(values, FASTEST, ALONG))

    def text(self, session: Session, values: Values, file: str) -> str:
        """Return the blade as TOML, or its loads as `propmap sweep` writes them."""
        model = model_of(session, values)
        if file == FILE:
            return propeller_toml(model.propeller)
        speed = np.linspace(0.0, FASTEST, ALONG)
        points = OperatingPoints.grid(np.array([values["rpm"]]), speed, np.array([values["beta"]]))
        return loads_csv(points, points.loads(rotor_of(model)), {})

    def _recipe(self, session: Session, values: Values) -> Recipe:
        blade = model_of(session, values).propeller
        return Recipe(session, None if blade is session.model.propeller else blade)


def model_of(session: Session, values: Values) -> Model:
    """Return the model with changed chord and twist, interpolated between the points."""
    model = session.model
    blade = model.propeller
    chords = [values[f"chord-{k}"] for k in range(len(PLACES))]
    twists = [values[f"twist-{k}"] for k in range(len(PLACES))]
    if set(chords) == {100.0} and set(twists) == {0.0}:
        return model
    from scipy.interpolate import PchipInterpolator

    share = np.clip(blade.station / blade.radius, PLACES[0], PLACES[-1])
    factor = PchipInterpolator(PLACES, np.array(chords) / 100.0)(share)
    more = PchipInterpolator(PLACES, np.radians(twists))(share)
    changed = replace(
        blade,
        name=f"{blade.name} changed",
        chord=blade.chord * factor,
        twist=blade.twist + more,
        source=f"{blade.name}, changed in propmap explore",
    )
    return replace(model, propeller=changed)


def _outline(old: Propeller, new: Propeller) -> view.Figure:
    traces, widest = [], MM * max(float(old.chord.max()), float(new.chord.max()))
    for blade, color, dash in ((old, view.GRAY, "dash"), (new, COLORS[0], "solid")):
        y, half = MM * blade.station, 0.5 * MM * blade.chord
        edge = np.concatenate([half, -half[::-1], half[:1]])
        along = np.concatenate([y, y[::-1], y[:1]])
        traces.append(view.line(along, edge, blade.name, color, dash))
    return view.figure(
        traces,
        "radius y [mm]",
        "distance from mid-chord [mm]",
        xaxis={"range": [0.0, 1.02 * MM * old.radius], "constrain": "domain"},
        yaxis={"scaleanchor": "x", "constrain": "domain", "range": [-0.6 * widest, 0.6 * widest]},
        shapes=[view.upright(MM * old.root)],
    )


def _draggable(old: Propeller, new: Propeller, what: str, values: Values) -> view.Figure:
    """Draw chord [mm] or twist [deg] with draggable points."""
    own, other = (
        (MM * blade.chord if what == "chord" else np.degrees(blade.twist)) for blade in (old, new)
    )
    y = MM * old.station
    at = np.array(PLACES) * MM * old.radius
    base, here = np.interp(at, y, own), np.interp(at, y, other)
    low = 0.0 if what == "chord" else min(float(other.min()), float(own.min()), 0.0)
    high = 1.25 * max(float(other.max()), float(own.max()))
    size = 0.016 * MM * old.radius, 0.03 * (high - low)
    look = {"fillcolor": COLORS[1], "line": {"color": COLORS[1]}, "editable": True}
    shapes: list[dict[str, Any]] = []
    for x, z in zip(at, here, strict=True):
        across = {"xref": "x", "x0": float(x - size[0]), "x1": float(x + size[0])}
        up = {"yref": "y", "y0": float(z - size[1]), "y1": float(z + size[1])}
        shapes.append({"type": "circle", **across, **up, **look})
    label = "chord c [mm]" if what == "chord" else "twist θ [deg]"
    return view.figure(
        [view.line(y, own, *BEFORE), view.line(y, other, *AFTER)],
        "radius y [mm]",
        label,
        shapes=shapes,
        meta={
            "drag": [f"{what}-{k}" for k in range(len(PLACES))],
            "base": base.tolist(),
            "share": what == "chord",
            "step": 0.1 if what == "twist" else 1.0,
        },
        dragmode=False,
        xaxis={"range": [0.0, 1.02 * MM * old.radius]},
        yaxis={"range": [low, high]},
        revision=" ".join(str(values[f"{what}-{k}"]) for k in range(len(PLACES))),
    )


def _table(old: Model, new: Model, values: Values) -> Table:
    flow = values["rpm"] * RPM, values["speed"], np.radians(values["beta"])
    before, after = (rotor_of(model).loads(*flow) for model in (old, new))
    rows = []
    for name, label in view.LABELS.items():
        a, b = float(getattr(before, name)), float(getattr(after, name))
        change = f"{100.0 * (b / a - 1.0):+.1f} %" if abs(a) > 1e-9 else ""
        rows.append([label, view.digits(a), view.digits(b), change, view.UNITS[name]])
    heads = ("", "original", "changed", "change", "unit")
    return Table(heads, rows, f"At {view.point_words(values)}")
