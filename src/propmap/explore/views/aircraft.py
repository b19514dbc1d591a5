"""Aircraft: trim, power curve and top speed of a vehicle."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from propmap.aircraft.performance import NamedState, Performance, performance
from propmap.aircraft.performance import rows as state_rows
from propmap.aircraft.trim import LIMITS, STATUSES, Aircraft, SteadyStates
from propmap.errors import InputError
from propmap.explore import view
from propmap.explore.session import Session, axis, number, rotor_of
from propmap.explore.view import Answer, Control, Download, Graph, Slider, Table, Values
from propmap.io.csv import csv_text
from propmap.report.html import COLOURS
from propmap.units import RPM

NAME = "trim.csv"

ALONG = 21
"""Speeds of the curves, as many as `propmap trim` takes."""

PANELS = {
    "power": "power [W]",
    "pitch": "pitch, nose down [deg]",
    "rpm": "slowest and fastest rotor [rpm]",
    "margin": "thrust at the first limit / thrust [-]",
}


class AircraftView:
    """A vehicle in steady flight."""

    name, title = "aircraft", "Aircraft"
    question = "How much power does the vehicle take, how far and how fast does it fly?"
    downloads = (Download(NAME, "states as CSV"),)
    slow = True

    def controls(self, session: Session) -> Sequence[Control]:
        """What can be set."""
        if session.vehicle is None:
            raise InputError(
                "there is no vehicle", "open a vehicle file here, or by `propmap explore FILE.toml`"
            )
        return [
            Slider("top", "Speeds up to", "m/s", 5.0, 60.0, 1.0, 20.0),
            Slider("climb", "Climb rate", "m/s", -5.0, 10.0, 0.5, 0.0),
            Slider("wind", "Headwind", "m/s", -10.0, 15.0, 0.5, 0.0),
            Slider("charge", "State of charge", "-", 0.05, 1.0, 0.05, 1.0),
        ]

    def graphs(self, session: Session) -> Sequence[Graph]:  # noqa: ARG002 - the same for all
        """Power, attitude, rotors, margin."""
        return [Graph(name, title.partition(" [")[0]) for name, title in PANELS.items()]

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """States at all speeds, and those that have a name."""
        craft = _aircraft(session, values)
        speed = np.linspace(0.0, values["top"], ALONG)
        states = craft.steady(speed, values["climb"])
        hover = craft.with_hover_model().steady(speed, values["climb"])
        shown = _figures(states, hover)
        key = [("this model", COLOURS[0]), ("hover model", f"-{view.GREY}")]
        tables = []
        if settled:
            found = performance(craft, states, climb=values["climb"], wind=values["wind"])
            tables = [_named(found)]
        lost = sorted(set(states.status.tolist()) - {"ok"})
        remarks = [f"{name}: {STATUSES.get(name, name)}" for name in lost]
        return Answer(shown, tables, remarks, key)

    def shell(self, session: Session, values: Values) -> str:
        """`propmap trim` with the same settings."""
        given = session.files["vehicle"]
        lines = []
        if not given.path:
            text = given.data.decode("utf-8-sig", "replace").rstrip("\n")
            lines.append(f"cat > '{given.name}' <<'END_OF_FILE'\n{text}\nEND_OF_FILE")
        law = [] if session.law == "known" else ["--airfoil", session.law]
        physics = ["--model", session.physics] if session.physics else []
        options = [
            *("--speed", axis(0.0, values["top"], ALONG), "--climb", number(values["climb"])),
            *("--wind", number(values["wind"]), "--charge", number(values["charge"])),
            *(*law, *physics, "--no-bands", "-o", NAME),
        ]
        import shlex

        lines.append(shlex.join(["propmap", "trim", given.path or given.name, *options]))
        return "\n".join(lines)

    def python(self, session: Session, values: Values) -> str:
        """The states."""
        given = session.files["vehicle"]
        return (
            "import numpy as np\nimport propmap\n"
            "from propmap.aircraft.performance import performance\n"
            "from propmap.aircraft.trim import Aircraft\n"
            "from propmap.vehicle.files import read_vehicle\n\n"
            f"vehicle = read_vehicle({given.path or given.name!r}).vehicle\n"
            "model = propmap.known_model(vehicle.propeller.name, air=vehicle.air)\n"
            "rotor = propmap.Rotor(model)\n"
            f"craft = Aircraft(vehicle, rotor, charge={number(values['charge'])})\n"
            f"states = craft.steady(np.linspace(0.0, {number(values['top'])}, {ALONG}), "
            f"{number(values['climb'])})\n"
            f"print(performance(craft, states, climb={number(values['climb'])}, "
            f"wind={number(values['wind'])}))\n"
        )

    def text(self, session: Session, values: Values, file: str) -> str:  # noqa: ARG002 - one file
        """What `propmap trim -o trim.csv` writes."""
        craft = _aircraft(session, values)
        states = craft.steady(np.linspace(0.0, values["top"], ALONG), values["climb"])
        found = performance(craft, states, climb=values["climb"], wind=values["wind"])
        listed = state_rows(states)
        for row, time, way in zip(listed, found.endurance, found.distance, strict=True):
            row["endurance_s"] = float(time) if math.isfinite(time) else None
            row["distance_m"] = float(way) if math.isfinite(way) else None
        return csv_text(list(listed[0]), listed)


def _aircraft(session: Session, values: Values) -> Aircraft:
    vehicle = session.vehicle
    if vehicle is None:
        raise InputError("there is no vehicle", "open a vehicle file here")
    return Aircraft(vehicle, rotor_of(session.model), charge=values["charge"])


def _figures(states: SteadyStates, hover: SteadyStates) -> dict[str, view.Figure]:
    rpm, still = states.rotor_speed / RPM, hover.rotor_speed / RPM
    curves = {
        "power": ([states.power], hover.power),
        "pitch": ([np.degrees(states.pitch)], np.degrees(hover.pitch)),
        "rpm": ([rpm.min(axis=1), rpm.max(axis=1)], still.mean(axis=1)),
        "margin": ([states.thrust_margin], hover.thrust_margin),
    }
    found = {}
    for name, (own, other) in curves.items():
        traces = [view.line(states.speed, y, "this model", COLOURS[0]) for y in own]
        traces.append(view.line(hover.speed, other, "hover model", view.GREY, "dash"))
        found[name] = view.figure(
            traces,
            "horizontal speed [m/s]",
            PANELS[name],
            xaxis={"range": [0.0, float(states.speed[-1])]},
            yaxis=view.span(*own, other, zero=name != "rpm"),
        )
    return found


def _named(found: Performance) -> Table:
    rows = []
    named = {
        "hover": found.hover,
        "least power, longest time": found.least_power,
        "best range": found.best_range,
        "top speed": found.fastest,
    }
    for label, state in named.items():
        if state is None:
            why = LIMITS.get(found.limit, found.limit) if label == "top speed" else ""
            rows.append([label, "-", "-", "-", f"none {why}".strip()])
        else:
            rows.append([label, *_state(state)])
    if found.limit:
        rows.append(["what ends it", LIMITS.get(found.limit, found.limit), "", "", ""])
    heads = ("", "speed [m/s]", "power [W]", "time [min]", "distance [km]")
    return Table(heads, rows, "States that have a name")


def _state(state: NamedState) -> list[str]:
    power = state.electrical_power if math.isfinite(state.electrical_power) else state.power
    return [
        view.digits(state.speed),
        view.digits(power),
        view.digits(state.endurance / 60.0),
        view.digits(state.distance / 1e3),
    ]
