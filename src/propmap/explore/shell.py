"""The page: what is there from the first, and the parts of a view."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import dash

from propmap.catalogue import names
from propmap.explore import figures
from propmap.explore.controls import Choice, Control, Slider, Text, Values
from propmap.explore.session import KNOWN, PHYSICS, Session
from propmap.explore.view import Answer, Graph, Table, View
from propmap.model.airfoil import airfoil_names

html: Any = dash.html
dcc: Any = dash.dcc

LAYOUT = {"displayModeBar": False, "responsive": True, "doubleClick": "reset"}

STORES = ("base", "here", "live", "answered", "settled", "told")

HEIGHTS = {
    (False, False): "255px",
    (True, False): "300px",
    (False, True): "min(86vw, 460px)",
    (True, True): "min(86vw, 560px)",
}
"""Of a graph by whether it is wide and tall: the same before and after it is drawn."""

KINDS = {
    "geometry": "propeller",
    "constants": "constants",
    "fit": "fit",
    "table": "table",
    "vehicle": "vehicle",
    "data": "measured loads",
}


def page(views: Sequence[View]) -> Any:
    """What the browser gets first."""
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
            html.P("", id="state", role="status", className="state"),
            html.Div(id="void", hidden=True),
        ],
        id="whole",
    )


def view_page(
    view: View, session: Session, values: Values, controls: Sequence[Control], answer: Answer
) -> Any:
    """A view with its first answer."""
    graphs = view.graphs(session)
    return html.Div(
        [
            html.Div([html.H1(view.title), html.P(view.question, className="question")]),
            subject(session),
            html.Div(
                [
                    html.Div([*settings(controls, values), *more(view)], className="settings",
                             role="group", **{"aria-label": "Settings"}),
                    html.Div(
                        [
                            html.Div(remarks(answer.remarks), id="remarks", role="status",
                                     **{"aria-live": "polite"}),
                            html.Div(legend(answer.legend), id="legend", className="legend"),
                            html.Div([place(g, answer) for g in graphs], className="graphs"),
                            html.Div([table(t) for t in answer.tables], id="tables"),
                            reproduce(view),
                        ],
                        className="answer",
                    ),
                ],
                className="columns",
            ),
        ],
        className=f"view view-{view.name}",
    )  # fmt: skip


def more(view: View) -> list[Any]:
    """Buttons under the settings."""
    own = getattr(view, "more", None)
    return [html.Button("undo", id="undo", n_clicks=0), *(own() if own else [])]


def failed(session: Session | None, message: str) -> Any:
    """A page that says in a line what is wrong."""
    return html.Div(
        [
            html.Div([html.H1("Nothing to show")]),
            subject(session),
            html.Div(remarks([message], "trouble"), id="remarks", role="alert"),
            *(html.Div(id=name, hidden=True) for name in ("tables", "legend", "command", "python")),
        ],
        className="view",
    )


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


def place(graph: Graph, answer: Answer) -> Any:
    """Where a figure is, with what can be saved of it."""
    figure = answer.figures.get(graph.name)
    look = " ".join(["place", *(["wide"] if graph.wide else []), *(["tall"] if graph.tall else [])])
    return html.Figure(
        [
            html.Figcaption(
                [
                    html.Span(graph.label),
                    *(
                        html.Button(
                            kind.upper(), id={"picture": graph.name, "as": kind}, n_clicks=0,
                            className="quiet", **{"aria-label": f"save {graph.label} as {kind}"},
                        )
                        for kind in ("svg", "png")
                    ),
                ]
            ),
            html.Div(
                dcc.Graph(
                    id={"graph": graph.name},
                    figure=figure or EMPTY,
                    config={**LAYOUT, **_edits(figure)},
                    className="graph",
                    style={"height": HEIGHTS[(graph.wide, graph.tall)]},
                ),
                role="img",
                **{"aria-label": graph.label},
            ),
        ],
        id={"place": graph.name},
        hidden=figure is None,
        className=look,
    )  # fmt: skip


def _edits(figure: figures.Figure | None) -> dict[str, Any]:
    """Points that can be dragged, where a figure has such."""
    if figure is None or not figure["layout"].get("meta", {}).get("drag"):
        return {}
    return {"edits": {"shapePosition": True}}


EMPTY: Mapping[str, Any] = {"data": [], "layout": {"paper_bgcolor": "rgba(0,0,0,0)"}}


def remarks(lines: Sequence[str], look: str = "remark") -> list[Any]:
    """Remarks, a line each; ``look`` is "trouble" for errors."""
    return [html.P(line, className=look) for line in lines]


def legend(entries: Sequence[tuple[str, str]]) -> list[Any]:
    """What colours mean."""
    return [
        html.Span(
            [
                html.I(
                    className="dashed" if colour.startswith("-") else "",
                    style={"borderColor": colour.lstrip("-")},
                    **{"aria-hidden": "true"},
                ),
                name,
            ]
        )
        for name, colour in entries
    ]


def table(found: Table) -> Any:
    """A table of numbers."""
    heads = [html.Th(head, scope="col") for head in found.heads]
    rows = [
        html.Tr([html.Th(row[0], scope="row"), *(html.Td(cell) for cell in row[1:])])
        for row in found.rows
    ]
    return html.Div(
        html.Table(
            [html.Caption(found.caption), html.Thead(html.Tr(heads)), html.Tbody(rows)],
            className="numbers",
        ),
        className="scroll",
        tabIndex="0",
        role="region",
        **{"aria-label": found.caption or "numbers"},
    )


def reproduce(view: View) -> Any:
    """Command line, Python and files."""
    return html.Section(
        [
            html.H2("The same numbers elsewhere"),
            html.Div(
                [
                    html.Button("copy command", id={"copy": "command"}, n_clicks=0),
                    html.Button("copy Python", id={"copy": "python"}, n_clicks=0),
                    *(
                        html.Button(f"save {d.label}", id={"save": d.file}, n_clicks=0)
                        for d in view.downloads
                    ),
                    html.Span("", id="copied", role="status"),
                ],
                className="buttons",
            ),
            html.Details(
                [
                    html.Summary("command line and Python"),
                    html.Pre("", id="command", tabIndex="0", **{"aria-label": "command line"}),
                    html.Pre("", id="python", tabIndex="0", **{"aria-label": "Python"}),
                ]
            ),
        ],
        className="reproduce",
    )
