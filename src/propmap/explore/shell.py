"""The page: what is there from the first, and the parts of a view."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import dash

from propmap.explore import figures
from propmap.explore.controls import Control, Values
from propmap.explore.session import Session
from propmap.explore.view import Answer, Graph, Table, View
from propmap.explore.widgets import settings, subject

html: Any = dash.html
dcc: Any = dash.dcc

LAYOUT = {"displayModeBar": False, "responsive": True, "doubleClick": "reset"}

STORES = ("base", "here", "settled", "told")

HEIGHTS = {
    (False, False): "255px",
    (True, False): "300px",
    (False, True): "min(86vw, 460px)",
    (True, True): "min(86vw, 560px)",
}
"""Of a graph by whether it is wide and tall: the same before and after it is drawn."""


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
