"""Compare: loads of up to four propellers, sets of constants or tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from propmap.errors import InputError
from propmap.explore import view
from propmap.explore.session import Recipe, Session, check_law, check_name, rotor_of
from propmap.explore.view import LABELS, Answer, Control, Download, Graph, OneOf, Table, Values
from propmap.io.csv import PREDICT_COLUMNS, OperatingPoints, csv_text
from propmap.report.html import COLORS
from propmap.units import RPM

ITEMS = ("a", "b", "c", "d")
GIVEN, TABLE = "this", "table"  # names of the session's own propeller and table
NAME = "compare.csv"
SHOWN = ("thrust", "power", "drag", "torque")
SAME_THRUST = 1e-3  # largest difference between equal thrusts, relative to the largest thrust


class Item(NamedTuple):
    """One compared item: name, load function, and session for commands (None for a table)."""

    name: str
    loads: Callable[..., Any]
    session: Session | None


class CompareView(view.View):
    """Curves of several items, and their differences from the first."""

    name, title = "compare", "Compare"
    question = "How do the loads of several propellers differ?"
    downloads = (Download(NAME, "all curves as CSV"),)
    places = tuple(
        Graph(f"{name}{suffix}", f"{LABELS[name]}{words}")
        for name in SHOWN
        for suffix, words in (("", " against airspeed"), ("-difference", ": difference"))
    )

    def controls(self, session: Session) -> Sequence[Control]:
        """Return the controls."""
        other = f"{GIVEN} @ paper-apc" if session.given("table") is None else TABLE
        first = (GIVEN, other, "", "")
        hint = "'this' (the propeller above), NAME, or NAME @ CONSTANTS"
        labels = f"First: {hint}", "Second", "Third", "Fourth"
        items = [
            view.Text(key, label, text)
            for key, label, text in zip(ITEMS, labels, first, strict=True)
        ]
        equal = (("rpm", "rpm"), ("thrust", "thrust"))
        return [
            *items,
            *view.point_controls(session),
            view.Slider("fastest", "Maximum airspeed", "m/s", 5.0, 60.0, 1.0, 20.0),
            OneOf("equal", "Compare at equal", equal, "rpm"),
        ]

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """Draw curves and differences; tabulate the loads at the operating point."""
        items = _items(session, values)
        speed = np.linspace(0.0, values["fastest"], view.CURVE)
        omega = _omegas(items, values, speed)
        every = _loads(items, omega, speed, values)
        key = [(one.name, color) for one, color in zip(items, COLORS, strict=False)]
        shown = {}
        for name in SHOWN:
            own = [getattr(loads, name) for loads in every]
            for suffix, rows, words in (
                ("", own, ""),
                ("-difference", [row - own[0] for row in own], ", minus the first"),
            ):
                lines = [(row, *look) for row, look in zip(rows, key, strict=True)]
                axes = view.AXES["speed"], f"{view.TITLES[name]}{words}"
                here = [view.upright(values["speed"])]
                shown[f"{name}{suffix}"] = view.curves(speed, lines, *axes, shapes=here, zero=True)
        tables = [_table(items, values)] if settled else []
        return Answer(shown, tables, _gaps(items, every), key)

    def shell(self, session: Session, values: Values) -> str:
        """Return a sweep command for each item, at equal rpm."""
        lines = []
        for k, one in enumerate(_items(session, values), start=1):
            if one.session is None:
                lines.append(f"propmap show {session.files['table'].path or 'map.npz'}")
                continue
            recipe = Recipe(one.session)
            sweep = recipe.sweep(values, values["fastest"], view.CURVE, f"compare-{k}.csv")
            lines.append(recipe.shell(sweep, recipe.predict(values)))
        return "\n".join(lines)

    def python(self, session: Session, values: Values) -> str:
        """Return code that prints the loads of each item at equal rpm."""
        rest = view.sweep_python(values, values["fastest"], view.CURVE)
        items = _items(session, values)
        return "\n".join(Recipe(one.session).python(rest) for one in items if one.session)

    def text(self, session: Session, values: Values, file: str) -> str:  # noqa: ARG002 - one file
        """Return the rows of `propmap sweep` for all items; the first column is the name."""
        items = _items(session, values)
        speed = np.linspace(0.0, values["fastest"], view.CURVE)
        omegas = _omegas(items, values, speed)
        rows = []
        every = _loads(items, omegas, speed, values)
        for one, omega, loads in zip(items, omegas, every, strict=True):
            points = OperatingPoints(omega / RPM, speed, np.full(view.CURVE, values["beta"]))
            rows += [{"of": one.name, **row} for row in points.rows(loads)]
        return csv_text(("of", *PREDICT_COLUMNS), rows)


def _items(session: Session, values: Values) -> list[Item]:
    """Return the compared items; raise ``InputError`` for an unknown name."""
    texts = [values[key] for key in ITEMS if values[key]]
    if not texts:
        raise InputError("no propeller is given", f"write '{GIVEN}' or a name in the first field")
    return [_item(session, text) for text in texts]


def _item(session: Session, text: str) -> Item:
    name, at, law = (part.strip() for part in text.partition("@"))
    if name == TABLE:
        if session.given("table") is None:
            raise InputError("there is no table", "open a file written by `propmap table`")
        return Item(f"table {session.files['table'].name}", session.given("table").loads, None)
    one = session
    if name != GIVEN:
        check_name(name)
        one = Session(prop=name, physics=session.physics)
    if at:
        check_law(law)
        one = replace(one, law=law).without("constants", "fit")
    model = one.model
    shown = text if name != GIVEN else text.replace(GIVEN, model.propeller.name, 1)
    return Item(shown, rotor_of(model).loads, one)


def _omegas(items: Sequence[Item], values: Values, speed: Any) -> list[Any]:
    """Return the rotational speeds of each item at each airspeed [rad/s]."""
    first = np.full(speed.shape, values["rpm"] * RPM)
    if values["equal"] == "rpm":
        return [first for _ in items]
    beta = np.radians(values["beta"])
    wanted = items[0].loads(first, speed, beta).thrust
    return [first, *(_for_thrust(one, wanted, first, speed, beta) for one in items[1:])]


def _for_thrust(item: Item, wanted: Any, first: Any, speed: Any, beta: float) -> Any:
    """Return the rotational speeds nearest to ``first`` for the ``wanted`` thrust, or NaN."""
    from scipy.optimize.elementwise import bracket_root, find_root

    def excess(omega: Any, along: Any, thrust: Any) -> Any:
        return item.loads(omega, along, beta).thrust - thrust

    args, limits = (speed, wanted), {"xmin": 0.02 * first, "xmax": 10.0 * first}
    near = bracket_root(excess, 0.98 * first, 1.02 * first, args=args, maxiter=20, **limits)
    found = find_root(excess, near.bracket, args=args, tolerances={"xrtol": 1e-6})
    # The search also ends where thrust jumps past the wanted value, for example at stall.
    equal = np.abs(found.f_x) <= SAME_THRUST * np.fmax.reduce(np.abs(wanted))
    return np.where(found.success & equal, found.x, np.nan)


def _loads(items: Sequence[Item], omegas: Sequence[Any], speed: Any, values: Values) -> list[Any]:
    """Return loads, power and status of each item; loads without equal thrust are NaN.

    The power is computed from the torque, since tables do not contain it.
    """
    found = []
    for one, omega in zip(items, omegas, strict=True):
        equal = np.isfinite(omega)
        loads = one.loads(np.where(equal, omega, 1.0), speed, np.radians(values["beta"]))
        own = {n: np.where(equal, getattr(loads, n), np.nan) for n in LABELS if n != "power"}
        status = np.where(equal, loads.status, "no equal thrust")
        found.append(SimpleNamespace(**own, power=own["torque"] * omega, status=status))
    return found


def _gaps(items: Sequence[Item], every: Sequence[Any]) -> list[str]:
    """Return a remark for each item and each status of its points without loads."""
    remarks = []
    for one, loads in zip(items, every, strict=True):
        lost = loads.status[np.isnan(loads.thrust)].tolist()
        for status in sorted(set(lost)):
            where = f"{lost.count(status)} of {view.CURVE} airspeeds"
            remarks.append(f"{one.name}: no loads at {where}, status: {status}")
    return remarks


def _table(items: Sequence[Item], values: Values) -> Table:
    speed = np.array([values["speed"]])
    omegas = _omegas(items, values, speed)
    every = _loads(items, omegas, speed, values)
    rows = [["rpm", *_with_difference([float(omega[0]) / RPM for omega in omegas]), "1/min"]]
    for name, label in LABELS.items():
        found = [float(getattr(loads, name)[0]) for loads in every]
        rows.append([label, *_with_difference(found), view.UNITS[name]])
    rows.append(["status", *(str(loads.status[0]) for loads in every), ""])
    return Table(("", *(one.name for one in items), "unit"), rows, f"At {view.point_words(values)}")


def _with_difference(found: Sequence[float]) -> list[str]:
    first, *others = found
    cells = [view.digits(first)]
    for value in others:
        known = abs(first) > 1e-9 and np.isfinite(value)
        change = f" ({100.0 * (value / first - 1.0):+.1f} %)" if known else ""
        cells.append(f"{view.digits(value)}{change}")
    return cells
