"""Aircraft: trim, power curve, range and top speed of a vehicle."""

from __future__ import annotations

import math
import shlex
from collections.abc import Sequence
from typing import Any

import numpy as np

from propmap.aircraft.assumptions import assumption_lines, assumptions, without_body_drag
from propmap.aircraft.performance import Performance, performance
from propmap.aircraft.performance import rows as state_rows
from propmap.aircraft.trim import LIMITS, STATUSES, Aircraft, SteadyStates
from propmap.errors import InputError
from propmap.explore import view
from propmap.explore.session import Session, axis, number, rotor_of, written_by_shell
from propmap.explore.view import Answer, Control, Download, Graph, Slider, Table, Values, digits
from propmap.io.csv import csv_text, number_or_none
from propmap.report.html import COLORS
from propmap.units import RPM

NAME = "trim.csv"
ALONG = 21  # number of airspeeds, as in `propmap trim`
PANELS = {
    "power": "power [W]",
    "pitch": "pitch, nose down [deg]",
    "rpm": "slowest and fastest rotor [rpm]",
    "margin": "thrust margin: maximum thrust / required thrust [-]",
}


class AircraftView(view.View):
    """Steady flight of a vehicle."""

    name, title = "aircraft", "Aircraft"
    question = "How much power does the vehicle need, and how far and how fast can it fly?"
    downloads = (Download(NAME, "states as CSV"),)
    places = tuple(Graph(name, title.partition(" [")[0]) for name, title in PANELS.items())
    slow = True

    def controls(self, session: Session) -> Sequence[Control]:
        """Return the controls; raise ``InputError`` without a vehicle."""
        if session.given("vehicle") is None:
            found = "there is no vehicle"
            raise InputError(found, "open a vehicle file here or with `propmap explore FILE.toml`")
        return [
            Slider("top", "Maximum airspeed", "m/s", 5.0, 60.0, 1.0, 20.0),
            Slider("climb", "Climb rate", "m/s", -5.0, 10.0, 0.5, 0.0),
            Slider("wind", "Headwind", "m/s", -10.0, 15.0, 0.5, 0.0),
            Slider("charge", "State of charge", "-", 0.05, 1.0, 0.05, 1.0),
        ]

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """Compute the steady states over airspeed, and the characteristic states."""
        craft, states = _states(session, values)
        hover = craft.with_hover_model().steady(states.speed, values["climb"])
        rpm, still = states.rotor_speed / RPM, hover.rotor_speed / RPM
        curves: dict[str, tuple[Any, ...]] = {
            "power": (states.power, hover.power),
            "pitch": (np.degrees(states.pitch), np.degrees(hover.pitch)),
            "rpm": (rpm.min(axis=1), rpm.max(axis=1), still.mean(axis=1)),
            "margin": (states.thrust_margin, hover.thrust_margin),
        }
        shown = {}
        for name, (*own, other) in curves.items():
            lines = [*((y, "this model", COLORS[0]) for y in own), (other, *view.HOVER)]
            axes = "horizontal airspeed [m/s]", PANELS[name]
            shown[name] = view.curves(states.speed, lines, *axes, zero=name != "rpm")
        tables = []
        if settled:
            found = performance(craft, states, climb=values["climb"], wind=values["wind"])
            tables = [_named(found, without_body_drag(craft.vehicle))]
        lost = sorted(set(states.status.tolist()) - {"ok"})
        remarks = assumption_lines(assumptions(craft.vehicle, craft.loads))
        remarks += craft.notes
        remarks += [f"{name}: {STATUSES.get(name, name)}" for name in lost]
        key = [("this model", COLORS[0]), ("hover model", f"-{view.GRAY}")]
        return Answer(shown, tables, remarks, key)

    def shell(self, session: Session, values: Values) -> str:
        """Return the command `propmap trim` with these settings."""
        given = session.files["vehicle"]
        lines = []
        if not given.path:
            text = given.data.decode("utf-8-sig", "replace").rstrip("\n")
            lines.append(written_by_shell(given.name, f"{text}\n"))
        law = [] if session.law == "known" else ["--airfoil", session.law]
        physics = ["--model", session.physics] if session.physics else []
        options = [
            *("--speed", axis(0.0, values["top"], ALONG), "--climb", number(values["climb"])),
            *("--wind", number(values["wind"]), "--charge", number(values["charge"])),
            *(*law, *physics, "--no-bands", "-o", NAME),
        ]
        lines.append(shlex.join(["propmap", "trim", given.path or given.name, *options]))
        return "\n".join(lines)

    def python(self, session: Session, values: Values) -> str:
        """Return code that prints the characteristic states."""
        given = session.files["vehicle"]
        return (
            "import numpy as np\nimport propmap\n"
            "from propmap.aircraft.performance import performance\n"
            "from propmap.aircraft.trim import Aircraft\n"
            "from propmap.vehicle.files import read_vehicle\n\n"
            f"file = read_vehicle({given.path or given.name!r})\n"
            "vehicle = file.vehicle\n"
            "model = propmap.catalogue_model(file.propeller, file.blades, air=vehicle.air)\n"
            "rotor = propmap.Rotor(model)\n"
            f"craft = Aircraft(vehicle, rotor, charge={number(values['charge'])})\n"
            f"states = craft.steady(np.linspace(0.0, {number(values['top'])}, {ALONG}), "
            f"{number(values['climb'])})\n"
            f"print(performance(craft, states, climb={number(values['climb'])}, "
            f"wind={number(values['wind'])}))\n"
        )

    def text(self, session: Session, values: Values, file: str) -> str:  # noqa: ARG002 - one file
        """Return the same CSV as `propmap trim -o trim.csv`."""
        craft, states = _states(session, values)
        found = performance(craft, states, climb=values["climb"], wind=values["wind"])
        listed = state_rows(states)
        for row, time, way in zip(listed, found.endurance, found.distance, strict=True):
            row["endurance_s"], row["distance_m"] = number_or_none(time), number_or_none(way)
        return csv_text(list(listed[0]), listed)


def _states(session: Session, values: Values) -> tuple[Aircraft, SteadyStates]:
    craft = Aircraft(
        session.given("vehicle").vehicle, rotor_of(session.model), charge=values["charge"]
    )
    return craft, craft.steady(np.linspace(0.0, values["top"], ALONG), values["climb"])


def _named(found: Performance, caution: str) -> Table:
    why = LIMITS.get(found.limit, found.limit)
    rows = []
    for _, label, state in found.named:
        if state is None:
            none = f"none; limit: {why}" if why and label == "top speed" else "none"
            rows.append([label, "-", "-", "-", none])
            continue
        power = state.electrical_power if math.isfinite(state.electrical_power) else state.power
        numbers = (state.speed, power, state.endurance / 60.0, state.distance / 1e3)
        rows.append([label + caution * (label != "hover"), *map(digits, numbers)])
    if found.limit:
        rows.append(["limit of the top speed", why, "", "", ""])
    heads = ("", "speed [m/s]", "power [W]", "time [min]", "distance [km]")
    return Table(heads, rows, "Characteristic states")
