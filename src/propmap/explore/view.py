"""Base class of the views, controls, and figures as plain data for Plotly."""

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
from propmap.report.html import COLORS
from propmap.units import RPM

if TYPE_CHECKING:
    from dash import Dash

Figure = dict[str, Any]  # data and layout for Plotly


@dataclass(frozen=True)
class Table:
    """A table: heads, rows of texts, and a caption."""

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str


@dataclass(frozen=True)
class Answer:
    """The output of a view for its settings."""

    figures: Mapping[str, Figure]  # by the names of the graphs
    tables: Sequence[Table] = ()
    remarks: Sequence[str] = ()  # one line each
    legend: Sequence[tuple[str, str]] = ()  # names and colors; "-" before the color: dashed line


@dataclass(frozen=True)
class Graph:
    """A place for a figure: its name within the view, and its caption."""

    name: str
    label: str
    wide: bool = False  # full width of the page
    tall: bool = False  # square


@dataclass(frozen=True)
class Download:
    """A text file that a view can save: its name, and the label of its button."""

    file: str
    label: str


class Host(Protocol):
    """Interface of the application to the views: Dash, background fits and sessions."""

    dash: Dash
    jobs: Any

    def session(self, search: Any) -> Session:
        """Read the session of an address."""


class View:
    """A page of the application: controls and the answer to a question about the session."""

    name: str  # path in the address
    title: str  # entry in the menu
    question: str  # subtitle
    downloads: tuple[Download, ...]
    places: tuple[Graph, ...] = ()
    slow = False  # whether figures are updated only when the controls have stopped moving

    def controls(self, session: Session) -> Sequence[Control]:
        """Return the controls."""
        raise NotImplementedError

    def graphs(self, session: Session) -> Sequence[Graph]:  # noqa: ARG002 - for overrides
        """Return the places of the figures."""
        return self.places

    def answer(self, session: Session, values: Values, *, settled: bool) -> Answer:
        """Return the answer; ``settled`` if no control has moved for a moment."""
        raise NotImplementedError

    def shell(self, session: Session, values: Values) -> str:
        """Return shell commands that compute the same numbers."""
        raise NotImplementedError

    def python(self, session: Session, values: Values) -> str:
        """Return Python code that computes the same numbers."""
        raise NotImplementedError

    def text(self, session: Session, values: Values, file: str) -> str:
        """Return the content of ``file``, one of the downloads."""
        raise NotImplementedError

    def more(self) -> list[Any]:
        """Return further elements below the controls."""
        return []

    def register(self, application: Host) -> None:
        """Register the callbacks of the elements in ``more``."""


# --- Controls of a view; their values are also parameters of the address -------------------------

Values = dict[str, Any]  # values of the controls by name

LONGEST = 400  # maximum number of characters of a text


@dataclass(frozen=True)
class Slider:
    """A number within limits."""

    name: str  # parameter of the address
    label: str
    unit: str
    low: float
    high: float
    step: float
    default: float
    marked: tuple[float, float] | None = None  # range to mark, such as an interval
    group: str = ""  # heading above the control

    def read(self, given: Any) -> float:
        """Return a number, clipped to the limits; raise ``InputError`` for another value."""
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

    def read(self, given: Any) -> str:
        """Return a stripped text; raise ``InputError`` for a long text or another value."""
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

    def read(self, given: Any) -> str:
        """Return an option; raise ``InputError`` for another value."""
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

    def read(self, given: Any) -> list[str]:
        """Return the selected options in order; raise ``InputError`` for another value."""
        if isinstance(given, str):
            given = [part for part in given.split(",") if part]
        known = [value for value, _ in self.options]
        if not isinstance(given, list) or any(one not in known for one in given):
            raise InputError(f"{self.label} is {quoted(given)}", f"choose from {', '.join(known)}")
        return [one for one in known if one in given]


Control = Slider | Text | OneOf | Several


def values_of(controls: Sequence[Control], given: Mapping[str, Any]) -> tuple[Values, list[str]]:
    """Return the values of the controls, and an error message for each invalid value.

    Missing and invalid values become the default.
    """
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
    """Return the choice of measured loads."""
    names = session.measurements()
    options = tuple((name, name) for name in ("none", *names))
    return OneOf("data", "Measured loads", options, names[0] if names else "none")


# --- Figures as plain data for Plotly, with the colors, labels and units of the reports ----------

GRAY = "#777777"
CURVE = 31  # number of points of a curve
HOVER = ("hover model", GRAY, "dash")  # name, color and dash of the curves
# The markers of ``report.html.MARKERS``.
MARKS = ("circle", "square", "triangle-up", "diamond", "triangle-down", "cross", "x")
STATUS_MARKS = {
    "multiple_roots": ("circle-open", COLORS[4]),
    "windmill": ("triangle-up", COLORS[2]),
    "coarse": ("diamond", COLORS[3]),
    "reversed": ("triangle-down", COLORS[3]),
    "vortex_ring": ("square", COLORS[1]),
    "not_converged": ("x", "#CC0000"),
}  # marker and color of points with a status other than "ok"

# Axis titles, units and labels of the loads and the power.
TITLES = {**{name: load.title for name, load in LOADS.items()}, "power": "power P [W]"}
UNITS = {**{name: load.unit for name, load in LOADS.items()}, "power": "W"}
LABELS = {**{name: load.label for name, load in LOADS.items()}, "power": "power"}
AXES = {"speed": "airspeed V [m/s]", "rpm": "rpm", "beta": "angle β [deg]"}


def array(values: ArrayLike) -> dict[str, Any]:
    """Return numbers in the binary encoding of Plotly, which is faster than lists."""
    found: NDArray[np.float64] = np.ascontiguousarray(values, np.float64)
    written = {"dtype": "f8", "bdata": base64.b64encode(found.tobytes()).decode()}
    if found.ndim > 1:
        written["shape"] = ", ".join(map(str, found.shape))
    return written


def line(
    x: ArrayLike, y: ArrayLike, name: str, color: str, dash: str = "solid", **more: Any
) -> dict[str, Any]:
    """Return a curve."""
    look = {"color": color, "width": 2, "dash": dash}
    return _scatter("lines", x, y, name=name, line=look, **more)


def band(x: ArrayLike, low: ArrayLike, high: ArrayLike, color: str) -> dict[str, Any]:
    """Return a shaded area between two curves."""
    along, least, most = np.asarray(x), np.asarray(low), np.asarray(high)
    known = np.isfinite(least) & np.isfinite(most)
    along, least, most = along[known], least[known], most[known]
    r, g, b = (int(color[k : k + 2], 16) for k in (1, 3, 5))
    around = np.concatenate([along, along[::-1]]), np.concatenate([most, least[::-1]])
    look: dict[str, Any] = {"fill": "toself", "fillcolor": f"rgba({r},{g},{b},0.22)"}
    return _scatter("lines", *around, line={"width": 0}, hoverinfo="skip", **look)


def points(
    x: ArrayLike, y: ArrayLike, name: str, color: str, mark: str = "circle", **more: Any
) -> dict[str, Any]:
    """Return points without line."""
    look = {"color": color, "symbol": mark, "size": 7}
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
    **layout: Any,
) -> Figure:
    """Return a figure with axis titles; a new ``revision`` resets the zoom."""
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
            "showlegend": False,
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
    """Return a figure of curves over ``x`` (n,): each (n,) with name, color and optional dash."""
    return figure(
        [line(x, *one) for one in lines],
        across,
        up,
        yaxis=span(*(one[0] for one in lines), zero=zero),
        **{"xaxis": {"range": [float(x[0]), float(x[-1])]}, **layout},
    )


def span(*values: ArrayLike, zero: bool = False) -> dict[str, Any]:
    """Return the range of an axis around the finite ``values``, with a margin."""
    flat = np.concatenate([np.ravel(v) for v in values]) if values else np.zeros(1)
    flat = flat[np.isfinite(flat)]
    if zero or not flat.size:
        flat = np.append(flat, 0.0)
    low, high = float(flat.min()), float(flat.max())
    room = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
    return {"range": [low - room, high + room]}


def upright(x: float) -> dict[str, Any]:
    """Return a thin vertical line at ``x``."""
    place = {"xref": "x", "yref": "paper", "x0": x, "x1": x, "y0": 0, "y1": 1}
    return {"type": "line", **place, "line": {"color": GRAY, "width": 1, "dash": "dot"}}


def digits(value: float) -> str:
    """Return a number with four digits, or "-" if it is not finite."""
    return f"{value:.4g}" if np.isfinite(value) else "-"


# --- The operating point, which the views share --------------------------------------------------


def point_controls(session: Session) -> list[Slider]:
    """Return the sliders for rpm, airspeed and angle."""
    usual = 60.0 / session.model.propeller.radius / RPM
    found = session.measured(next(iter(session.measurements()), "none"))
    if found is not None and len(found):
        # The nearest rotational speed with measured points.
        measured = found.omega / RPM
        usual = float(measured[np.argmin(np.abs(measured - usual))])
    usual = round(usual / 10.0) * 10.0
    highest = round(fastest(session.model) / RPM)
    return [
        Slider("rpm", "Rotational speed", "rpm", 100.0, highest, 10.0, max(usual, 100.0)),
        Slider("speed", "Airspeed V", "m/s", 0.0, 60.0, 0.5, 8.0),
        Slider("beta", "Angle β (0 climb, 90 edgewise)", "deg", 0.0, 180.0, 1.0, 60.0),
    ]


def point_of(values: Values) -> OperatingPoints:
    """Return the operating point."""
    rpm, speed, beta = (np.array([values[key]]) for key in POINT)
    return OperatingPoints(rpm, speed, beta)


def point_words(values: Values) -> str:
    """Return the operating point as text."""
    return f"{values['rpm']:g} rpm, {values['speed']:g} m/s, β {values['beta']:g}°"


def point_python(values: Values) -> str:
    """Return the operating point as Python arguments of ``Rotor.loads``."""
    return (
        f"{number(values['rpm'])} * np.pi / 30.0, {number(values['speed'])}, "
        f"np.radians({number(values['beta'])})"
    )


def sweep_python(values: Values, top: float, count: int) -> str:
    """Return Python code that prints the loads at ``count`` airspeeds up to ``top`` [m/s]."""
    return (
        f"omega = {number(values['rpm'])} * np.pi / 30.0\n"
        f"speed = np.linspace(0.0, {number(top)}, {count})\n"
        f"print(rotor.loads(omega, speed, np.radians({number(values['beta'])})))"
    )


def point_table(session: Session, values: Values) -> Table:
    """Return a table of the loads at the operating point with their 95 % intervals."""
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
        caption += "; ±: two standard deviations (95 %)"
    return Table(("", "value", "±", "hover model", "unit"), rows, caption)
