"""What a view is: a question, what can be set, and an answer; and the fields and figures of it."""

from __future__ import annotations

import base64
import json
import math
from base64 import b64decode
from binascii import Error as Base64Error
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol
from urllib.parse import parse_qsl, urlencode

import dash
import numpy as np
from dash import no_update
from numpy.typing import ArrayLike, NDArray

from propmap.catalogue import names
from propmap.errors import InputError, quoted
from propmap.explore.session import (
    KNOWN,
    MOST_BYTES,
    PHYSICS,
    Session,
    Shelf,
    fastest,
    hover_model,
    number,
    read_upload,
    rotor_of,
)
from propmap.io.csv import OperatingPoints
from propmap.loads import LOADS
from propmap.model.airfoil import airfoil_names
from propmap.report.html import COLOURS
from propmap.units import RPM

# -------------------------------------------------------------------------------------------------
# What a view is: a question, what can be set, and an answer to it.


@dataclass(frozen=True)
class Table:
    """A small table: heads, rows of texts, and a caption."""

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str


@dataclass(frozen=True)
class Answer:
    """What a view shows.

    Attributes
    ----------
    figures : mapping of str to Figure
        By the names of the view's graphs.
    tables : sequence of Table
        Of numbers.
    remarks : sequence of str
        A line each.
    legend : sequence of (str, str)
        What colours mean: a name and its colour, which begins with "-" where the line is dashed.
    """

    figures: Mapping[str, Figure]
    tables: Sequence[Table] = ()
    remarks: Sequence[str] = ()
    legend: Sequence[tuple[str, str]] = ()


@dataclass(frozen=True)
class Graph:
    """A place for a figure.

    Attributes
    ----------
    name, label : str
        Within the view; what it shows, in words.
    wide : bool
        Whether it takes the whole width.
    tall : bool
        Whether it is as high as it is wide.
    """

    name: str
    label: str
    wide: bool = False
    tall: bool = False


@dataclass(frozen=True)
class Download:
    """A text that can be saved: the name of its file, and what it is for the button."""

    file: str
    label: str


class View(Protocol):
    """A view; see the modules of ``propmap.explore.views``.

    Attributes
    ----------
    name, title, question : str
        In the address, in the menu, and what it answers.
    downloads : tuple of Download
        What can be saved.
    """

    @property
    def name(self) -> str: ...  # noqa: D102 - above
    @property
    def title(self) -> str: ...  # noqa: D102
    @property
    def question(self) -> str: ...  # noqa: D102
    @property
    def downloads(self) -> tuple[Download, ...]: ...  # noqa: D102

    def controls(self, session: Session) -> Sequence[Control]:
        """What can be set."""

    def graphs(self, session: Session) -> Sequence[Graph]:
        """Where figures are."""

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """What is shown; ``settled`` when nothing has been moved for a moment."""

    def shell(self, session: Session, values: Values) -> str:
        """Lines for a shell that make the same numbers."""

    def python(self, session: Session, values: Values) -> str:
        """The same in Python."""

    def text(self, session: Session, values: Values, file: str) -> str:
        """What is saved in the ``file`` of one of the downloads."""


# -------------------------------------------------------------------------------------------------
# What is set and chosen on a page: fields, sliders, choices.

html: Any = dash.html
dcc: Any = dash.dcc

KINDS = {
    "geometry": "propeller",
    "constants": "constants",
    "fit": "fit",
    "table": "table",
    "vehicle": "vehicle",
    "data": "measured loads",
}


def subject(session: Session | None) -> Any:
    """What is explored, to be changed."""
    session = session or Session()
    files = [
        html.Li(
            [
                f"{KINDS[kind]}: {given.name} ",
                html.Button("remove", id={"remove": kind}, className="quiet", n_clicks=0,
                            **{"aria-label": f"remove {given.name}"}),
            ]
        )
        for kind, given in session.files.items()
    ]  # fmt: skip
    laws = ((KNOWN, "best known"), *((name, name) for name in airfoil_names()))
    physics = (("", "as the constants"), *((name, name) for name in PHYSICS))
    return html.Div(
        [
            html.Div(
                [
                    html.Label("Propeller", htmlFor="prop"),
                    dcc.Input(id="prop", type="text", value=session.name, debounce=True,
                              list="props", maxLength=80, autoComplete="off", className="text"),
                    html.Datalist([html.Option(value=name) for name in names()], id="props"),
                ],
                className="field",
            ),
            radio("law", "Constants", laws, session.law),
            radio("physics", "Physics", physics, session.physics),
            html.Div(
                dcc.Upload(
                    html.Button("Open a file, or drop it here", className="quiet", type="button"),
                    id="upload",
                    max_size=-1,
                    className="drop",
                ),
                className="field",
            ),
            html.Ul(files, className="files") if files else html.Span(),
            html.P("", id="trouble", role="alert", className="trouble"),
        ],
        className="subject",
    )  # fmt: skip


def radio(name: str, label: str, options: Sequence[tuple[str, str]], value: str) -> Any:
    """A choice behind a heading that says what is chosen."""
    told = dict(options).get(value, value)
    return html.Details(
        [
            html.Summary([f"{label}: ", html.Em(told)]),
            dcc.RadioItems(
                id=name,
                options=[{"value": key, "label": text} for key, text in options],
                value=value,
                className="options",
            ),
        ],
        className="field",
    )


def settings(controls: Sequence[Control], values: Values) -> list[Any]:
    """The controls, in their groups."""
    found: list[Any] = []
    groups: dict[str, list[Any]] = {}
    for control in controls:
        one = setting(control, values[control.name])
        if control.group:
            if control.group not in groups:
                groups[control.group] = []
                found.append((control.group, groups[control.group]))
            groups[control.group].append(one)
        else:
            found.append(one)
    return [
        html.Fieldset([html.Legend(item[0]), *item[1]]) if isinstance(item, tuple) else item
        for item in found
    ]


def setting(control: Control, value: Any) -> Any:
    """A control with its label."""
    key = {"control": control.name}
    target = json.dumps(key, separators=(",", ":"))
    if isinstance(control, Slider):
        number = {"number": control.name}
        unit = f" [{control.unit}]" if control.unit else ""
        parts: list[Any] = [
            html.Label(f"{control.label}{unit}", htmlFor=target),
            html.Div(
                [
                    dcc.Input(id=key, type="range", min=control.low, max=control.high,
                              step=control.step, value=value, className="range"),
                    html.Label(f"{control.label}, as a number", className="unseen",
                               htmlFor=json.dumps(number, separators=(",", ":"))),
                    dcc.Input(id=number, type="number", min=control.low, max=control.high,
                              step="any", value=value, debounce=True, className="number"),
                ],
                className="slider",
            ),
        ]  # fmt: skip
        if control.marked is not None:
            parts.append(_mark(control))
        return html.Div(parts, className="field")
    if isinstance(control, Text):
        return html.Div(
            [
                html.Label(control.label, htmlFor=target),
                dcc.Input(id=key, type="text", value=value, debounce=True, className="text"),
            ],
            className="field",
        )
    options = [{"value": key_, "label": text} for key_, text in control.options]
    make = dcc.RadioItems if isinstance(control, Choice) else dcc.Checklist
    return html.Fieldset(
        [
            html.Legend(control.label),
            make(id=key, options=options, value=value, className="options"),
        ],
        className="field",
    )


def _mark(control: Slider) -> Any:
    """The marked range under a slider."""
    assert control.marked is not None
    low, high = (
        100.0 * min(max((end - control.low) / (control.high - control.low), 0.0), 1.0)
        for end in control.marked
    )
    return html.Div(
        [
            html.Div(
                html.Span(style={"left": f"{low:.2f}%", "width": f"{max(high - low, 0.6):.2f}%"}),
                className="interval",
            ),
            html.Small(f"95 %: {control.marked[0]:.4g} to {control.marked[1]:.4g}"),
        ]
    )


# -------------------------------------------------------------------------------------------------
# What a user can set on a view, and how it stands in the address.

Values = dict[str, Any]
"""What is set, by the names of the controls."""

LONGEST = 400
"""Characters of a text that is set."""


@dataclass(frozen=True)
class Slider:
    """A number within limits.

    Attributes
    ----------
    name, label, unit : str
        In the address, and on the page.
    low, high, step : float
        Limits and the width of a step.
    default : float
        Where it stands at first.
    marked : tuple of 2 float, or None
        A range to be marked, such as an interval of confidence.
    group : str
        Under which it is shown; "" for none.
    """

    name: str
    label: str
    unit: str
    low: float
    high: float
    step: float
    default: float
    marked: tuple[float, float] | None = None
    group: str = ""

    def read(self, given: Any) -> float:
        """The number that is given, brought within the limits; ``InputError`` for none."""
        try:
            value = float(given)
        except (TypeError, ValueError):
            raise InputError(
                f"{self.label} is {quoted(given)}", f"give a number [{self.unit or '-'}]"
            ) from None
        if not math.isfinite(value):
            raise InputError(f"{self.label} is {value}", "give a finite number")
        return min(max(value, self.low), self.high)


@dataclass(frozen=True)
class Text:
    """A line of text, such as a list of angles."""

    name: str
    label: str
    default: str
    group: str = ""

    def read(self, given: Any) -> str:
        """The text that is given; ``InputError`` for what is none or too long."""
        if not isinstance(given, str) or len(given) > LONGEST or not given.isprintable():
            raise InputError(f"{self.label} is {quoted(given)}", f"give up to {LONGEST} characters")
        return given.strip()


@dataclass(frozen=True)
class Choice:
    """One of several ``options``, (value, label) each."""

    name: str
    label: str
    options: tuple[tuple[str, str], ...]
    default: str
    group: str = ""

    def read(self, given: Any) -> str:
        """The option that is given; ``InputError`` for another one."""
        known = [value for value, _ in self.options]
        if given not in known:
            raise InputError(
                f"{self.label} is {quoted(given)}", f"choose one of {', '.join(known)}"
            )
        return str(given)


@dataclass(frozen=True)
class Several:
    """Any of several ``options``, (value, label) each."""

    name: str
    label: str
    options: tuple[tuple[str, str], ...]
    default: tuple[str, ...]
    group: str = ""

    def read(self, given: Any) -> list[str]:
        """The options that are given, in their order; ``InputError`` for another one."""
        if isinstance(given, str):
            given = [part for part in given.split(",") if part]
        known = [value for value, _ in self.options]
        if not isinstance(given, list) or any(one not in known for one in given):
            raise InputError(f"{self.label} is {quoted(given)}", f"choose from {', '.join(known)}")
        return [one for one in known if one in given]


Control = Slider | Text | Choice | Several


def default_of(control: Control) -> Any:
    """What it is set to at first."""
    return list(control.default) if isinstance(control, Several) else control.default


def values_of(controls: Sequence[Control], given: Mapping[str, Any]) -> tuple[Values, list[str]]:
    """What is set, and a line for each control that was given something it cannot be.

    Parameters
    ----------
    controls : sequence of Control
        Of a view.
    given : mapping of str
        By their names; what is missing is at its default.
    """
    values, remarks = {}, []
    for control in controls:
        values[control.name] = default_of(control)
        if given.get(control.name) is None:
            continue
        try:
            values[control.name] = control.read(given[control.name])
        except InputError as error:
            remarks.append(str(error))
    return values, remarks


def of_query(search: str | None) -> dict[str, str]:
    """The parameters of an address by name, of ``?a=1&b=2``."""
    return dict(parse_qsl((search or "").lstrip("?"), keep_blank_values=True, max_num_fields=100))


# -------------------------------------------------------------------------------------------------
# What is explored, changed on the page: the address that follows, or what is wrong in a line.

OF_BLADE = ("chord-", "twist-")
"""How controls begin that mean nothing for another blade."""


class Choices:
    """Sessions by their addresses, and the addresses of changed ones.

    Parameters
    ----------
    first : Session
        That of the command line.
    shelf : Shelf
        Where files are.
    """

    def __init__(self, first: Session, shelf: Shelf) -> None:
        self.first, self.shelf = first, shelf

    def session(self, search: Any) -> Session:
        """What an address tells; ``InputError`` where it tells nonsense."""
        if search is not None and not isinstance(search, str):
            raise InputError("the address is damaged", "open / instead")
        return Session.of(of_query(search), self.first, self.shelf)

    def chosen(self, here: Any, prop: Any, law: Any, physics: Any) -> tuple[Any, str]:
        """The address of another propeller, constants or physics, or what is wrong."""
        try:
            session = self.session(here)
            if (prop, law, physics) == (session.name, session.law, session.physics):
                # The page has just been drawn.
                return no_update, ""
            query = {**of_query(here), **session.query()}
            if prop != session.name:
                for kind in ("fit", "geometry", "vehicle"):
                    query.pop(f"file-{kind}", None)
                # What follows from the blade is as usual for the new one.
                for name in ("rpm", "data"):
                    query.pop(name, None)
            if law != session.law:
                for kind in ("fit", "constants"):
                    query.pop(f"file-{kind}", None)
            query |= {
                "prop": str(prop or session.prop),
                "law": str(law or KNOWN),
                "physics": str(physics or ""),
            }
            for name in [name for name in query if name.startswith(OF_BLADE)]:
                del query[name]
            Session.of(query, self.first, self.shelf).model  # noqa: B018 - it may not exist
        except InputError as error:
            return no_update, str(error)
        return f"?{urlencode(query)}", ""

    def uploaded(self, here: Any, content: Any, name: Any) -> tuple[Any, str]:
        """The address with one more file, or what its reader says."""
        try:
            _, comma, body = str(content).partition(",")
            if not comma or len(body) > 1.4 * MOST_BYTES:
                raise InputError(
                    "the file is too large" if comma else "there is no file",
                    f"give one of at most {MOST_BYTES / 1e6:g} MB",
                    str(name)[-80:],
                )
            try:
                data = b64decode(body, validate=True)
            except (Base64Error, ValueError):
                raise InputError("the file came damaged", "give it again") from None
            given = read_upload(str(name), data)
            session = self.session(here).with_file(given, self.shelf.put(given))
            session.model  # noqa: B018 - it may not exist
            query = {k: v for k, v in of_query(here).items() if not k.startswith("file-")}
            if given.kind in ("geometry", "fit", "vehicle"):
                query.pop("rpm", None)
            if given.kind == "data":
                query["data"] = "file"
        except InputError as error:
            return no_update, str(error)
        return f"?{urlencode({**query, **session.query()})}", ""

    def removed(self, here: Any, kind: str) -> str:
        """The address without a file."""
        session = self.session(here)
        query = {**of_query(here), **session.query()}
        query.pop(f"file-{kind}", None)
        return f"?{urlencode(query)}"


# -------------------------------------------------------------------------------------------------
# Figures as plain data for Plotly, in the reports' colours, labels and units.

Figure = dict[str, Any]

GREY = "#777777"
MARKS = ("circle", "square", "triangle-up", "diamond", "triangle-down", "cross", "x")
"""Those of ``report.style.MARKERS``."""

STATUS_MARKS = {
    "multiple_roots": ("circle-open", COLOURS[4]),
    "windmill": ("triangle-up", COLOURS[2]),
    "coarse": ("diamond", COLOURS[3]),
    "vortex_ring": ("square", COLOURS[1]),
    "not_converged": ("x", "#CC0000"),
    "unresolved": ("diamond", COLOURS[1]),
    "clamped": ("square", COLOURS[3]),
    "no_value": ("x", "#CC0000"),
    "outside": ("x", GREY),
}
"""Mark and colour of points that are not "ok"."""


def array(values: ArrayLike) -> dict[str, Any] | list[Any]:
    """Numbers as Plotly takes them fastest."""
    found: NDArray[np.float64] = np.ascontiguousarray(values, np.float64)
    told = {"dtype": "f8", "bdata": base64.b64encode(found.tobytes()).decode()}
    if found.ndim > 1:
        told["shape"] = ", ".join(map(str, found.shape))
    return told


def line(
    x: ArrayLike, y: ArrayLike, name: str, colour: str, dash: str = "solid", **more: Any
) -> dict[str, Any]:
    """A curve."""
    return {
        "type": "scatter",
        "mode": "lines",
        "x": array(x),
        "y": array(y),
        "name": name,
        "line": {"color": colour, "width": 2, "dash": dash},
        **more,
    }


def band(x: ArrayLike, low: ArrayLike, high: ArrayLike, colour: str) -> dict[str, Any]:
    """What is shaded between two curves."""
    along, least, most = np.asarray(x), np.asarray(low), np.asarray(high)
    known = np.isfinite(least) & np.isfinite(most)
    along, least, most = along[known], least[known], most[known]
    r, g, b = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return {
        "type": "scatter",
        "mode": "lines",
        "x": array(np.concatenate([along, along[::-1]])),
        "y": array(np.concatenate([most, least[::-1]])),
        "fill": "toself",
        "fillcolor": f"rgba({r},{g},{b},0.22)",
        "line": {"width": 0},
        "hoverinfo": "skip",
        "showlegend": False,
    }


def points(
    x: ArrayLike, y: ArrayLike, name: str, colour: str, mark: str = "circle", **more: Any
) -> dict[str, Any]:
    """Single points."""
    return {
        "type": "scatter",
        "mode": "markers",
        "x": array(x),
        "y": array(y),
        "name": name,
        "marker": {"color": colour, "symbol": mark, "size": 7},
        **more,
    }


def figure(
    data: Sequence[dict[str, Any]],
    x: str,
    y: str,
    *,
    revision: str = "",
    shapes: Sequence[dict[str, Any]] = (),
    legend: bool = False,
    **layout: Any,
) -> Figure:
    """A figure with named axes; ``revision`` changes where a zoom is to be forgotten."""
    axis = {"gridcolor": "#dddddd", "zerolinecolor": "#bbbbbb", "automargin": False, "ticks": ""}
    own = {"x": layout.pop("xaxis", {}), "y": layout.pop("yaxis", {})}
    return {
        "data": list(data),
        "layout": {
            "xaxis": {**axis, "title": {"text": x, "standoff": 6}, **own["x"]},
            "yaxis": {**axis, "title": {"text": y, "standoff": 4}, **own["y"]},
            "margin": {"l": 62, "r": 12, "t": 12, "b": 44},
            "font": {"size": 12, "color": "#222222", "family": "system-ui, sans-serif"},
            "paper_bgcolor": "rgba(0,0,0,0)",
            "plot_bgcolor": "rgba(0,0,0,0)",
            "showlegend": legend,
            "legend": {"orientation": "h", "y": -0.22, "x": 0.0},
            "hovermode": "closest",
            "uirevision": revision,
            "shapes": list(shapes),
            **layout,
        },
    }


def span(*values: ArrayLike, zero: bool = False) -> dict[str, Any]:
    """A range of an axis that holds the finite ones of ``values``, with some room."""
    flat = np.concatenate([np.ravel(v) for v in values]) if values else np.zeros(1)
    flat = flat[np.isfinite(flat)]
    if zero or not flat.size:
        flat = np.append(flat, 0.0)
    low, high = float(flat.min()), float(flat.max())
    room = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
    return {"range": [low - room, high + room]}


def upright(x: float) -> dict[str, Any]:
    """A thin line at an operating point."""
    return {
        "type": "line",
        "xref": "x",
        "yref": "paper",
        "x0": x,
        "x1": x,
        "y0": 0,
        "y1": 1,
        "line": {"color": GREY, "width": 1, "dash": "dot"},
    }


TITLES = {**{name: load.title for name, load in LOADS.items()}, "power": "power P [W]"}
"""Of loads and the power, for axes."""

UNITS = {**{name: load.unit for name, load in LOADS.items()}, "power": "W"}

LABELS = {**{name: load.label for name, load in LOADS.items()}, "power": "power"}


def digits(value: float) -> str:
    """A number as it is told on the page."""
    return f"{value:.4g}" if np.isfinite(value) else "-"


# -------------------------------------------------------------------------------------------------
# The operating point that all views share, and what is told of it.


def point_controls(session: Session) -> list[Slider]:
    """Sliders for rpm, speed and angle."""
    blade = session.model.propeller
    usual = 60.0 / blade.radius / RPM
    found = session.measured(next(iter(session.measurements()), "none"))
    if found is not None and len(found):
        # Where measured points are.
        measured = found.omega / RPM
        usual = float(measured[np.argmin(np.abs(measured - usual))])
    usual = round(usual / 10.0) * 10.0
    highest = round(fastest(session.model) / RPM)
    return [
        Slider("rpm", "Rotational speed", "rpm", 100.0, highest, 10.0, max(usual, 100.0)),
        Slider("speed", "Flight speed V", "m/s", 0.0, 60.0, 0.5, 8.0),
        Slider("beta", "Angle β, 0 climb, 90 edgewise", "deg", 0.0, 180.0, 1.0, 60.0),
    ]


def point_of(values: Values) -> OperatingPoints:
    """The operating point."""
    rpm, speed, beta = (np.array([values[key]]) for key in ("rpm", "speed", "beta"))
    return OperatingPoints(rpm, speed, beta)


def point_lines(values: Values) -> list[str]:
    """Options of a command for it."""
    return [part for key in ("rpm", "speed", "beta") for part in (f"--{key}", number(values[key]))]


def point_words(values: Values) -> str:
    """The operating point in words."""
    return f"{values['rpm']:g} rpm, {values['speed']:g} m/s, β {values['beta']:g}°"


def point_table(session: Session, values: Values) -> Table:
    """Loads at the operating point as `propmap predict` tells them, and how sure they are."""
    rotor = rotor_of(session.model)
    point = point_of(values)
    loads = point.loads(rotor)
    still = hover_model(session.model).loads(point.si[0])
    hover = {**still, "power": still["torque"] * point.si[0]}
    known = loads.std if session.model.uncertainty is not None else None
    rows = []
    for name, label in LABELS.items():
        std = "" if known is None else f"± {2.0 * float(getattr(known, name)[0]):.2g}"
        found = digits(float(getattr(loads, name)[0]))
        rows.append([label, found, std, digits(float(hover[name][0])), UNITS[name]])
    rows += [
        ["mean inflow", digits(float(loads.mean_inflow[0])), "", "", "m/s"],
        ["reverse flow", digits(100.0 * float(loads.reverse_flow[0])), "", "", "% of disk"],
        ["status", str(loads.status[0]), "", "", ""],
    ]
    caption = f"At {point_words(values)}"
    if known is not None:
        caption += "; ± two standard deviations, 95 %"
    return Table(("", "value", "±", "hover model", "unit"), rows, caption)
