"""Elements of the page in the browser: controls, figures, tables and copied commands."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import dash

from propmap.catalogue import names
from propmap.explore.session import KNOWN, PHYSICS, Session
from propmap.explore.view import Answer, Control, Graph, OneOf, Slider, Table, Text, Values, View
from propmap.model.airfoil import airfoil_names

html: Any = dash.html
dcc: Any = dash.dcc

LAYOUT = {"displayModeBar": False, "responsive": True, "doubleClick": "reset"}
STORES = ("base", "here", "settled", "answered", "dropped")
EMPTY: Mapping[str, Any] = {"data": [], "layout": {"paper_bgcolor": "rgba(0,0,0,0)"}}
KINDS = {
    "geometry": "propeller",
    "constants": "constants",
    "fit": "fit",
    "table": "table",
    "vehicle": "vehicle",
    "data": "measured loads",
}

INDEX = Path(__file__).with_name("index.html").read_text(encoding="utf-8")


def page(views: Sequence[View]) -> Any:
    """Return the frame of the page, which the browser loads first."""
    menu = [
        dcc.Link(view.title, href=f"/{view.name}", id={"menu": view.name}, className="menu-item")
        for view in views
    ]
    return html.Div(
        [
            html.A("Skip to the view", href="#page", className="skip"),
            dcc.Location(id="address", refresh=False),
            *(dcc.Store(id=name) for name in STORES),
            dcc.Store(id="job", storage_type="session"),
            dcc.Interval(id="tick", interval=700, disabled=True),
            dcc.Download(id="saved"),
            html.Header(
                [
                    html.Strong("propmap explore", className="brand"),
                    html.Nav(menu, className="menu", **{"aria-label": "Views"}),
                    html.Button("Dark or light", id="theme", className="quiet", n_clicks=0),
                ]
            ),
            html.Main(html.P("Loading …", className="loading"), id="page", tabIndex="-1"),
            html.Div(id="void", hidden=True),
        ],
        id="whole",
    )


def view_page(
    view: View, session: Session, values: Values, controls: Sequence[Control], answer: Answer
) -> Any:
    """Return the page of a view with its first answer."""
    head = html.Div([html.H1(view.title), html.P(view.question, className="question")])
    undo = html.Button("undo", id="undo", n_clicks=0)
    set_here = *_settings(controls, values), undo, *view.more()
    settings = _part("settings", *set_here, role="group", **{"aria-label": "Settings"})
    said = remarks(answer.remarks)
    shown = _part(
        "answer",
        html.Div(said, id="remarks", role="status", **{"aria-live": "polite"}),
        _part("legend", *legend(answer.legend), id="legend"),
        _part("graphs", *(_place(one, answer) for one in view.graphs(session))),
        html.Div([table(one) for one in answer.tables], id="tables"),
        _reproduce(view),
    )
    look = f"view view-{view.name}"
    return _part(look, head, _subject(session), _part("columns", settings, shown))


def failed(session: Session | None, message: str) -> Any:
    """Return a page with an error message."""
    return _part(
        "view",
        html.Div([html.H1("This view cannot be shown")]),
        _subject(session),
        html.Div(remarks([message], "trouble"), id="remarks", role="alert"),
        *(html.Div(id=name, hidden=True) for name in ("tables", "legend", "command", "python")),
    )


def _part(look: str, *parts: Any, of: Any = html.Div, **more: Any) -> Any:
    """Return an element of CSS class ``look`` with children ``parts``."""
    return of(list(parts), className=look, **more)


# --- Controls: propeller, constants and files; fields, sliders and choices -----------------------


def _subject(session: Session | None) -> Any:
    """Return the controls for propeller, constants, physics and files."""
    session = session or Session()
    files = []
    for kind, given in session.files.items():
        name = {"id": {"remove": kind}, "aria-label": f"remove {given.name}"}
        remove = html.Button("remove", className="quiet", n_clicks=0, **name)
        what = f", {given.found.summary}" if kind == "geometry" else ""
        files.append(html.Li([f"{KINDS[kind]}: {given.name}{what} ", remove]))
    laws = [(KNOWN, "best available"), *((name, name) for name in airfoil_names())]
    physics = [("", "as used to identify the constants"), *((name, name) for name in PHYSICS)]
    prop = [
        html.Label("Propeller", htmlFor="prop"),
        dcc.Input(id="prop", type="text", value=session.name, debounce=True, list="props",
                  maxLength=80, autoComplete="off", className="text"),
        html.Datalist([html.Option(value=name) for name in names()], id="props"),
    ]  # fmt: skip
    upload = html.Button("Open a file or drop it here", className="quiet", type="button")
    drop = dcc.Upload(upload, id="upload", max_size=-1, className="drop")
    return _part(
        "subject",
        _part("field", *prop),
        _radio("law", "Constants", laws, session.law),
        _radio("physics", "Model", physics, session.physics),
        html.Div(drop, className="field"),
        html.Ul(files, className="files") if files else html.Span(),
        html.P("", id="trouble", role="alert", className="trouble"),
    )


def _radio(name: str, label: str, options: Sequence[tuple[str, str]], value: str) -> Any:
    """Return a collapsed choice whose heading shows the selected option."""
    shown = [{"value": key, "label": text} for key, text in options]
    summary = html.Summary([f"{label}: ", html.Em(dict(options).get(value, value))])
    choice = dcc.RadioItems(id=name, options=shown, value=value, className="options")
    return _part("field", summary, choice, of=html.Details)


def _settings(controls: Sequence[Control], values: Values) -> list[Any]:
    """Return all controls; a frame at the place of the first one encloses each group."""
    found: dict[tuple[str, str], list[Any]] = {}
    for control in controls:
        group = control.group if isinstance(control, Slider) else ""
        key = group, "" if group else control.name
        found.setdefault(key, []).append(_setting(control, values[control.name]))
    return [
        html.Fieldset([html.Legend(group), *parts]) if group else parts[0]
        for (group, _), parts in found.items()
    ]


def _setting(control: Control, value: Any) -> Any:
    key = {"control": control.name}
    target = json.dumps(key, separators=(",", ":"))
    if isinstance(control, Slider):
        number = {"number": control.name}
        unit = f" [{control.unit}]" if control.unit else ""
        ends: dict[str, Any] = {"min": control.low, "max": control.high, "value": value}
        typed = {"type": "number", "step": "any", "debounce": True, "className": "number"}
        its = {"htmlFor": json.dumps(number, separators=(",", ":")), "className": "unseen"}
        slider = _part(
            "slider",
            dcc.Input(id=key, type="range", step=control.step, className="range", **ends),
            html.Label(f"{control.label}, as a number", **its),
            dcc.Input(id=number, **typed, **ends),
        )
        parts: list[Any] = [html.Label(f"{control.label}{unit}", htmlFor=target), slider]
        if control.marked is not None:
            low, high = (
                100.0 * min(max((end - control.low) / (control.high - control.low), 0.0), 1.0)
                for end in control.marked
            )
            place = {"left": f"{low:.2f}%", "width": f"{max(high - low, 0.6):.2f}%"}
            interval = html.Div(html.Span(style=place), className="interval")
            words = f"95 %: {control.marked[0]:.4g} to {control.marked[1]:.4g}"
            parts.append(html.Div([interval, html.Small(words)]))
        return html.Div(parts, className="field")
    if isinstance(control, Text):
        field = dcc.Input(id=key, type="text", value=value, debounce=True, className="text")
        return _part("field", html.Label(control.label, htmlFor=target), field)
    options = [{"value": each, "label": text} for each, text in control.options]
    make = dcc.RadioItems if isinstance(control, OneOf) else dcc.Checklist
    choice = make(id=key, options=options, value=value, className="options")
    return _part("field", html.Legend(control.label), choice, of=html.Fieldset)


# --- Answers: figures, tables, remarks, and commands for the same numbers ------------------------


def _place(graph: Graph, answer: Answer) -> Any:
    """Return the element of a figure with its caption and save buttons."""
    figure = answer.figures.get(graph.name)
    # Only figures with draggable points are editable.
    drag = figure is not None and figure["layout"].get("meta", {}).get("drag")
    edits = {"edits": {"shapePosition": True}} if drag else {}
    look = " ".join(["place", *(["wide"] if graph.wide else []), *(["tall"] if graph.tall else [])])
    saves = [
        html.Button(
            kind.upper(), id={"picture": graph.name, "as": kind}, n_clicks=0, className="quiet",
            **{"aria-label": f"save {graph.label} as {kind}"},
        )
        for kind in ("svg", "png")
    ]  # fmt: skip
    shown = {"figure": figure or EMPTY, "config": {**LAYOUT, **edits}}
    drawing = dcc.Graph(id={"graph": graph.name}, className="graph", **shown)
    caption = html.Figcaption([html.Span(graph.label), *saves])
    inside = html.Div(drawing, role="img", **{"aria-label": graph.label})
    place: dict[str, Any] = {"id": {"place": graph.name}, "hidden": figure is None}
    return _part(look, caption, inside, of=html.Figure, **place)


def remarks(lines: Sequence[str], look: str = "remark") -> list[Any]:
    """Return one line per remark; ``look`` is "trouble" for errors."""
    return [html.P(line, className=look) for line in lines]


def legend(entries: Sequence[tuple[str, str]]) -> list[Any]:
    """Return a legend of names and line styles."""
    found = []
    for name, color in entries:
        dashed, style = color.startswith("-"), {"borderColor": color.lstrip("-")}
        mark = html.I(className="dashed" if dashed else "", style=style, **{"aria-hidden": "true"})
        found.append(html.Span([mark, name]))
    return found


def table(found: Table) -> Any:
    """Return the element of a table."""
    heads = [html.Th(head, scope="col") if head else html.Td() for head in found.heads]
    rows = [
        html.Tr([html.Th(row[0], scope="row"), *(html.Td(cell) for cell in row[1:])])
        for row in found.rows
    ]
    parts = [html.Caption(found.caption), html.Thead(html.Tr(heads)), html.Tbody(rows)]
    name = {"role": "region", "aria-label": found.caption or "numbers"}
    numbers = html.Table(parts, className="numbers")
    return html.Div(numbers, className="scroll", tabIndex="0", **name)


def _reproduce(view: View) -> Any:
    """Return buttons and texts for the command line, Python and files."""
    offered = {("copy", "command"): "copy command", ("copy", "python"): "copy Python"}
    offered |= {("save", one.file): f"save {one.label}" for one in view.downloads}
    buttons = [html.Button(label, id={do: of}, n_clicks=0) for (do, of), label in offered.items()]
    buttons.append(html.Span("", id="copied", role="status"))
    lines = [
        html.Summary("command line and Python"),
        html.Pre("", id="command", tabIndex="0", **{"aria-label": "command line"}),
        html.Pre("", id="python", tabIndex="0", **{"aria-label": "Python"}),
    ]
    head, more = html.H2("Reuse the numbers"), html.Details(lines)
    return _part("reproduce", head, _part("buttons", *buttons), more, of=html.Section)
