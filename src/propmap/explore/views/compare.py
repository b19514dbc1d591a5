"""Compare: two to four propellers, sets of constants or a table, side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from propmap.catalogue.lookup import looks_like_path
from propmap.errors import InputError, quoted
from propmap.explore import view
from propmap.explore.session import KNOWN, Recipe, Session, axis, number, rotor_of
from propmap.explore.view import (
    Answer,
    Choice,
    Control,
    Download,
    Graph,
    Slider,
    Table,
    Text,
    Values,
    point_controls,
    point_lines,
    point_words,
)
from propmap.io.csv import PREDICT_COLUMNS, OperatingPoints, csv_text
from propmap.model.airfoil import airfoil_names
from propmap.report.html import COLOURS
from propmap.units import RPM

ALONG = 31

ITEMS = ("a", "b", "c", "d")

GIVEN, TABLE = "this", "table"
"""What is explored, and the table that was given."""

NAME = "compare.csv"

SHOWN = ("thrust", "power", "drag", "torque")


@dataclass(frozen=True)
class Item:
    """What is compared: its name, its loads at points, and how a command names it."""

    name: str
    loads: Callable[..., Any]
    session: Session | None


class CompareView:
    """Curves of several, and their differences to the first."""

    name, title = "compare", "Compare"
    question = "Which of these is better, and by how much?"
    downloads = (Download(NAME, "all curves as CSV"),)

    def controls(self, session: Session) -> Sequence[Control]:
        """What can be set."""
        other = f"{GIVEN} @ paper-apc" if session.table is None else TABLE
        first = (GIVEN, other, "", "")
        hint = "a propeller, with @ and constants if others are meant"
        items = [
            Text(key, f"{'First' if key == 'a' else 'Beside it'}: {hint}", text)
            for key, text in zip(ITEMS, first, strict=True)
        ]
        equal = (("rpm", "rpm"), ("thrust", "thrust of the first"))
        return [
            *items,
            *point_controls(session),
            Slider("fastest", "Speeds up to", "m/s", 5.0, 60.0, 1.0, 20.0),
            Choice("equal", "At equal", equal, "rpm"),
        ]

    def graphs(self, session: Session) -> Sequence[Graph]:  # noqa: ARG002 - the same for all
        """Curves above, differences below."""
        curves = [Graph(name, f"{view.LABELS[name]} against speed") for name in SHOWN]
        apart = [Graph(f"{name}-apart", f"{view.LABELS[name]}: difference") for name in SHOWN]
        return [graph for pair in zip(curves, apart, strict=True) for graph in pair]

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """Curves, differences, and numbers at the operating point."""
        items = _items(session, values)
        speed = np.linspace(0.0, values["fastest"], ALONG)
        beta = np.radians(values["beta"])
        omega = _omegas(items, values, speed)
        every = [one.loads(w, speed, beta) for one, w in zip(items, omega, strict=True)]
        shown = {}
        for name in SHOWN:
            curves = [_of(loads, w, name) for loads, w in zip(every, omega, strict=True)]
            for apart in (False, True):
                rows = [c - curves[0] for c in curves] if apart else curves
                title = f"{view.TITLES[name]}{', minus the first' if apart else ''}"
                shown[f"{name}{'-apart' if apart else ''}"] = view.figure(
                    [
                        view.line(speed, row, one.name, colour)
                        for row, one, colour in zip(rows, items, COLOURS, strict=False)
                    ],
                    "speed V [m/s]",
                    title,
                    shapes=[view.upright(values["speed"])],
                    xaxis={"range": [0.0, values["fastest"]]},
                    yaxis=view.span(*rows, zero=True),
                )
        key = [(one.name, colour) for one, colour in zip(items, COLOURS, strict=False)]
        tables = [_table(items, values)] if settled else []
        return Answer(shown, tables, (), key)

    def shell(self, session: Session, values: Values) -> str:
        """A sweep for each, at equal rpm."""
        lines = []
        for k, one in enumerate(_items(session, values), start=1):
            if one.session is None:
                lines.append(f"propmap show {session.files['table'].path or 'map.npz'}")
                continue
            recipe = Recipe(one.session)
            sweep = [
                *("sweep", recipe.prop, "--rpm", number(values["rpm"])),
                *("--speed", axis(0.0, values["fastest"], ALONG)),
                *("--beta", number(values["beta"]), *recipe.options, "--no-bands"),
                *("-o", f"compare-{k}.csv", "--force"),
            ]
            point = ["predict", recipe.prop, *point_lines(values), *recipe.options]
            lines.append(recipe.shell(sweep, point))
        return "\n".join(lines)

    def python(self, session: Session, values: Values) -> str:
        """The same at equal rpm."""
        rest = (
            f"omega = {number(values['rpm'])} * np.pi / 30.0\n"
            f"speed = np.linspace(0.0, {number(values['fastest'])}, {ALONG})\n"
            f"print(rotor.loads(omega, speed, np.radians({number(values['beta'])})))"
        )
        parts = [
            Recipe(one.session).python(rest)
            for one in _items(session, values)
            if one.session is not None
        ]
        return "\n".join(parts)

    def text(self, session: Session, values: Values, file: str) -> str:  # noqa: ARG002 - one file
        """Rows of `propmap sweep`, with what they are of before them."""
        items = _items(session, values)
        speed = np.linspace(0.0, values["fastest"], ALONG)
        rows = []
        for one, omega in zip(items, _omegas(items, values, speed), strict=True):
            points = OperatingPoints(omega / RPM, speed, np.full(ALONG, values["beta"]))
            loads = one.loads(*points.si)
            if one.session is None:
                loads = replace_power(loads, points)
            rows += [{"of": one.name, **row} for row in points.rows(loads)]
        return csv_text(("of", *PREDICT_COLUMNS), rows)


def replace_power(loads: Any, points: OperatingPoints) -> Any:
    """The loads of a table with the power that follows."""
    from types import SimpleNamespace

    own = {name: getattr(loads, name) for name in view.TITLES if name != "power"}
    power = loads.torque * points.si[0]
    return SimpleNamespace(**own, power=power, status=loads.status)


def _items(session: Session, values: Values) -> list[Item]:
    """What is compared; raises ``InputError`` for a name that means nothing."""
    told = [values[key] for key in ITEMS if values[key]]
    if not told:
        raise InputError("nothing is named", f"write {GIVEN} or a name in the first field")
    return [_item(session, text) for text in told]


def _item(session: Session, text: str) -> Item:
    name, at, law = (part.strip() for part in text.partition("@"))
    if name == TABLE:
        if session.table is None:
            raise InputError("there is no table", "drop a file that `propmap table` wrote")
        return Item(f"table {session.files['table'].name}", session.table.loads, None)
    one = session
    if name != GIVEN:
        if looks_like_path(name):
            raise InputError(
                f"{quoted(name)} is no name of a propeller", "give one of the catalogue"
            )
        one = Session(prop=name, physics=session.physics)
    if at:
        if law not in (KNOWN, *airfoil_names()):
            names = ", ".join((KNOWN, *airfoil_names()))
            raise InputError(f"{quoted(law)} is no set of constants", f"choose one of {names}")
        kept = {k: v for k, v in one.files.items() if k not in ("constants", "fit")}
        tokens = {k: v for k, v in one.tokens.items() if k in kept}
        one = replace(one, law=law, files=kept, tokens=tokens)
    model = one.model
    told = text if name != GIVEN else text.replace(GIVEN, model.propeller.name, 1)
    return Item(told, rotor_of(model).loads, one)


def _omegas(items: Sequence[Item], values: Values, speed: Any) -> list[Any]:
    """Rotational speeds of each item at each speed [rad/s]."""
    first = np.full(speed.shape, values["rpm"] * RPM)
    if values["equal"] == "rpm":
        return [first for _ in items]
    beta = np.radians(values["beta"])
    wanted = items[0].loads(first, speed, beta).thrust
    return [first, *(_for_thrust(one, wanted, first, speed, beta) for one in items[1:])]


def _for_thrust(item: Item, wanted: Any, first: Any, speed: Any, beta: float) -> Any:
    """Where a rotor has the ``wanted`` thrust, by secants; NaN where that is not found."""
    before, after = first, 1.02 * first
    off = item.loads(before, speed, beta).thrust - wanted
    for _ in range(6):
        now = item.loads(after, speed, beta).thrust - wanted
        with np.errstate(all="ignore"):
            step = now * (after - before) / (now - off)
        step = np.where(np.isfinite(step), step, 0.0)
        before, off = after, now
        after = np.clip(after - step, 0.3 * first, 3.0 * first)
    return after


def _of(loads: Any, omega: Any, name: str) -> Any:
    return loads.torque * omega if name == "power" else getattr(loads, name)


def _table(items: Sequence[Item], values: Values) -> Table:
    speed = np.array([values["speed"]])
    omegas = _omegas(items, values, speed)
    beta = np.radians(values["beta"])
    every = [one.loads(w, speed, beta) for one, w in zip(items, omegas, strict=True)]
    rows = [["rpm", *_with_difference([float(w[0]) / RPM for w in omegas]), "1/min"]]
    for name, label in view.LABELS.items():
        found = [float(_of(x, w, name)[0]) for x, w in zip(every, omegas, strict=True)]
        rows.append([label, *_with_difference(found), view.UNITS[name]])
    rows.append(["status", *(str(x.status[0]) for x in every), ""])
    return Table(("", *(one.name for one in items), "unit"), rows, f"At {point_words(values)}")


def _with_difference(found: Sequence[float]) -> list[str]:
    first = found[0]
    told = [view.digits(first)]
    for value in found[1:]:
        apart = f" ({100.0 * (value / first - 1.0):+.1f} %)" if abs(first) > 1e-9 else ""
        told.append(f"{view.digits(value)}{apart}")
    return told
