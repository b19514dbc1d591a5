"""Views: what can be set, what is answered, and figures as plain data for Plotly."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propmap.errors import InputError, quoted
from propmap.explore.session import POINT, Session, fastest, hover_model, number, rotor_of
from propmap.io.csv import OperatingPoints
from propmap.loads import LOADS
from propmap.report.html import COLOURS
from propmap.units import RPM

if TYPE_CHECKING:
    from dash import Dash

Figure = dict[str, Any]  # as Plotly takes it


@dataclass(frozen=True)
class Table:
    """A small table: heads, rows of texts, and a caption."""

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str


@dataclass(frozen=True)
class Answer:
    """What a view shows."""

    figures: Mapping[str, Figure]  # by the names of the view's graphs
    tables: Sequence[Table] = ()
    remarks: Sequence[str] = ()  # a line each
    legend: Sequence[tuple[str, str]] = ()  # names and colours; "-" before one of a dashed line


@dataclass(frozen=True)
class Graph:
    """A place for a figure: its name within the view, and what it shows in words."""

    name: str
    label: str
    wide: bool = False  # as wide as the page
    tall: bool = False  # as high as it is wide


@dataclass(frozen=True)
class Download:
    """A text that can be saved: the name of its file, and what it is for the button."""

    file: str
    label: str


class Host(Protocol):
    """The parts of the application that a view uses: Dash, background fits and sessions."""

    dash: Dash
    jobs: Any

    def session(self, search: Any) -> Session:
        """Read the session of an address."""


class View:
    """A question about what a session explores, what can be set, and an answer to it."""

    name: str  # in the address
    title: str  # in the menu
    question: str
    downloads: tuple[Download, ...]
    places: tuple[Graph, ...] = ()
    slow = False  # whether figures wait until all stands still

    def controls(self, session: Session) -> Sequence[Control]:
        """List what can be set."""
        raise NotImplementedError

    def graphs(self, session: Session) -> Sequence[Graph]:  # noqa: ARG002 - the same for most
        """List where figures are."""
        return self.places

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """Compute what is shown; ``settled`` when nothing has been moved for a moment."""
        raise NotImplementedError

    def shell(self, session: Session, values: Values) -> str:
        """Write lines for a shell that make the same numbers."""
        raise NotImplementedError

    def python(self, session: Session, values: Values) -> str:
        """Write lines of Python that make the same numbers."""
        raise NotImplementedError

    def text(self, session: Session, values: Values, file: str) -> str:
        """Write what is saved in the ``file`` of one of the downloads."""
        raise NotImplementedError

    def more(self) -> list[Any]:
        """Make what stands under the settings."""
        return []

    def register(self, application: Host) -> None:
        """Say what happens when something of ``more`` is used."""


# -------------------------------------------------------------------------------------------------
# What a user can set on a view, and how it stands in the address.

Values = dict[str, Any]  # what is set, by the names of the controls

LONGEST = 400  # characters of a text that is set


@dataclass(frozen=True)
class Slider:
    """A number within limits."""

    name: str  # in the address
    label: str
    unit: str
    low: float
    high: float
    step: float
    default: float
    marked: tuple[float, float] | None = None  # a range to be marked, such as an interval
    group: str = ""  # under which it is shown

    def read(self, given: Any) -> float:
        """Bring the number that is given within the limits; ``InputError`` for none."""
        try:
            value = float(given)
        except (TypeError, ValueError):
            found = f"{self.label} is {quoted(given)}"
            raise InputError(found, f"give a number [{self.unit or '-'}]") from None
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
        """Strip the text that is given; ``InputError`` for what is none or too long."""
        if not isinstance(given, str) or len(given) > LONGEST or not given.isprintable():
            raise InputError(f"{self.label} is {quoted(given)}", f"give up to {LONGEST} characters")
        return given.strip()


@dataclass(frozen=True)
class OneOf:
    """One of several ``options``, (value, label) each."""

    name: str
    label: str
    options: tuple[tuple[str, str], ...]
    default: str
    group: str = ""

    def read(self, given: Any) -> str:
        """Take the option that is given; ``InputError`` for another one."""
        known = [value for value, _ in self.options]
        if given not in known:
            found = f"{self.label} is {quoted(given)}"
            raise InputError(found, f"choose one of {', '.join(known)}")
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
        """Take the options that are given, in their order; ``InputError`` for another one."""
        if isinstance(given, str):
            given = [part for part in given.split(",") if part]
        known = [value for value, _ in self.options]
        if not isinstance(given, list) or any(one not in known for one in given):
            raise InputError(f"{self.label} is {quoted(given)}", f"choose from {', '.join(known)}")
        return [one for one in known if one in given]


Control = Slider | Text | OneOf | Several


def values_of(controls: Sequence[Control], given: Mapping[str, Any]) -> tuple[Values, list[str]]:
    """Read what is set by the controls' names, what is missing at its default, and a line for each
    that was given what it cannot be."""
    values, remarks = {}, []
    for control in controls:
        own = list(control.default) if isinstance(control, Several) else control.default
        values[control.name] = own
        if given.get(control.name) is not None:
            try:
                values[control.name] = control.read(given[control.name])
            except InputError as error:
                remarks.append(str(error))
    return values, remarks


def data_choice(session: Session) -> OneOf:
    """Make the choice of measured loads to compare with."""
    found = tuple((name, name) for name in session.measurements())
    return OneOf("data", "Measured", (("none", "none"), *found), found[0][0] if found else "none")


# -------------------------------------------------------------------------------------------------
# Figures as plain data for Plotly, in the reports' colours, labels and units.

GREY = "#777777"
CURVE = 31  # points of a curve
HOVER = ("hover model", GREY, "dash")  # name, colour and dash of its curves
# As ``report.html.MARKERS``.
MARKS = ("circle", "square", "triangle-up", "diamond", "triangle-down", "cross", "x")
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
}  # mark and colour of points that are not "ok"

# Axes, units and names of the loads and the power.
TITLES = {**{name: load.title for name, load in LOADS.items()}, "power": "power P [W]"}
UNITS = {**{name: load.unit for name, load in LOADS.items()}, "power": "W"}
LABELS = {**{name: load.label for name, load in LOADS.items()}, "power": "power"}
AXES = {"speed": "speed V [m/s]", "rpm": "rpm", "beta": "angle β [deg]"}


def array(values: ArrayLike) -> dict[str, Any]:
    """Write numbers as Plotly takes them fastest."""
    found: NDArray[np.float64] = np.ascontiguousarray(values, np.float64)
    written = {"dtype": "f8", "bdata": base64.b64encode(found.tobytes()).decode()}
    if found.ndim > 1:
        written["shape"] = ", ".join(map(str, found.shape))
    return written


def line(
    x: ArrayLike, y: ArrayLike, name: str, colour: str, dash: str = "solid", **more: Any
) -> dict[str, Any]:
    """Draw a curve."""
    look = {"color": colour, "width": 2, "dash": dash}
    return _scatter("lines", x, y, name=name, line=look, **more)


def band(x: ArrayLike, low: ArrayLike, high: ArrayLike, colour: str) -> dict[str, Any]:
    """Shade what is between two curves."""
    along, least, most = np.asarray(x), np.asarray(low), np.asarray(high)
    known = np.isfinite(least) & np.isfinite(most)
    along, least, most = along[known], least[known], most[known]
    r, g, b = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    around = np.concatenate([along, along[::-1]]), np.concatenate([most, least[::-1]])
    look: dict[str, Any] = {"fill": "toself", "fillcolor": f"rgba({r},{g},{b},0.22)"}
    return _scatter("lines", *around, line={"width": 0}, hoverinfo="skip", showlegend=False, **look)


def points(
    x: ArrayLike, y: ArrayLike, name: str, colour: str, mark: str = "circle", **more: Any
) -> dict[str, Any]:
    """Draw single points."""
    look = {"color": colour, "symbol": mark, "size": 7}
    return _scatter("markers", x, y, name=name, marker=look, **more)


def _scatter(mode: str, x: ArrayLike, y: ArrayLike, **look: Any) -> dict[str, Any]:
    return {"type": "scatter", "mode": mode, "x": array(x), "y": array(y), **look}


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
    """Make a figure with named axes; ``revision`` changes where a zoom is to be forgotten."""
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


def curves(
    x: NDArray[np.float64],
    lines: Sequence[tuple[Any, ...]],
    across: str,
    up: str,
    *,
    zero: bool = False,
    **layout: Any,
) -> Figure:
    """Draw curves over all of ``x`` (n,): each (n,) with name, colour and perhaps a dash."""
    return figure(
        [line(x, *one) for one in lines],
        across,
        up,
        yaxis=span(*(one[0] for one in lines), zero=zero),
        **{"xaxis": {"range": [float(x[0]), float(x[-1])]}, **layout},
    )


def span(*values: ArrayLike, zero: bool = False) -> dict[str, Any]:
    """Choose a range of an axis that holds the finite ones of ``values``, with some room."""
    flat = np.concatenate([np.ravel(v) for v in values]) if values else np.zeros(1)
    flat = flat[np.isfinite(flat)]
    if zero or not flat.size:
        flat = np.append(flat, 0.0)
    low, high = float(flat.min()), float(flat.max())
    room = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
    return {"range": [low - room, high + room]}


def upright(x: float) -> dict[str, Any]:
    """Draw a thin line at an operating point."""
    place = {"xref": "x", "yref": "paper", "x0": x, "x1": x, "y0": 0, "y1": 1}
    return {"type": "line", **place, "line": {"color": GREY, "width": 1, "dash": "dot"}}


def digits(value: float) -> str:
    """Write a number as the page shows it."""
    return f"{value:.4g}" if np.isfinite(value) else "-"


# -------------------------------------------------------------------------------------------------
# The operating point that all views share, and what is said of it.


def point_controls(session: Session) -> list[Slider]:
    """Make sliders for rpm, speed and angle."""
    usual = 60.0 / session.model.propeller.radius / RPM
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
    """Give the operating point."""
    rpm, speed, beta = (np.array([values[key]]) for key in POINT)
    return OperatingPoints(rpm, speed, beta)


def point_words(values: Values) -> str:
    """Write the operating point in words."""
    return f"{values['rpm']:g} rpm, {values['speed']:g} m/s, β {values['beta']:g}°"


def point_python(values: Values) -> str:
    """Write the operating point as arguments of ``Rotor.loads``."""
    return (
        f"{number(values['rpm'])} * np.pi / 30.0, {number(values['speed'])}, "
        f"np.radians({number(values['beta'])})"
    )


def sweep_python(values: Values, top: float, count: int) -> str:
    """Write lines of Python that print the loads at ``count`` speeds up to ``top`` [m/s]."""
    return (
        f"omega = {number(values['rpm'])} * np.pi / 30.0\n"
        f"speed = np.linspace(0.0, {number(top)}, {count})\n"
        f"print(rotor.loads(omega, speed, np.radians({number(values['beta'])})))"
    )


def point_table(session: Session, values: Values) -> Table:
    """Tabulate loads at the operating point as `propmap predict` does, and how sure they are."""
    point = point_of(values)
    loads = point.loads(rotor_of(session.model))
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
