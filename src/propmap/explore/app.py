"""The Dash application, its page, and the server: what a browser asks, and what it is answered."""

from __future__ import annotations

import contextlib
import errno
import ipaddress
import logging
import os
import secrets
import sys
import threading
import time
import webbrowser
from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import dash
from dash import ALL, ClientsideFunction, Dash, Input, Output, State, ctx, no_update
from dash.exceptions import PreventUpdate
from flask import Flask, Response, request
from werkzeug.serving import BaseWSGIServer, make_server

from propmap.errors import InputError
from propmap.explore.session import Session, Shelf
from propmap.explore.view import (
    Answer,
    Choices,
    Control,
    Figure,
    Graph,
    Table,
    Values,
    View,
    of_query,
    settings,
    subject,
    values_of,
)

# -------------------------------------------------------------------------------------------------
# The Dash application: what a browser asks, and what it is answered.

send_string: Any = dash.dcc.send_string  # type: ignore[attr-defined]

LIVE = "/_live"
"""Where figures are asked for while something moves."""


class Application(Choices):
    """The pages on a first session.

    Parameters
    ----------
    first : Session
        What the command line names.
    views : sequence of View
        The first is that of the address /.
    shelf : Shelf
        Where files are.
    """

    def __init__(self, first: Session, views: Sequence[View], shelf: Shelf) -> None:
        super().__init__(first, shelf)
        self.views = {view.name: view for view in views}
        self.jobs = Jobs()
        self.dash = Dash(
            "propmap.explore",
            assets_folder=str(Path(__file__).parent / "assets"),
            title="propmap explore",
            update_title="",
            serve_locally=True,
            suppress_callback_exceptions=True,
            add_log_handler=False,
        )
        self.dash.index_string = INDEX
        self.dash.layout = page(views)
        self._register()
        # The first page is what a browser waits for; this one finds what is the same for all.
        self.page("/", "")

    def view(self, path: Any) -> View:
        """The view of an address, the first for any other."""
        name = str(path or "").strip("/")
        return self.views.get(name) or next(iter(self.views.values()))

    def page(self, path: Any, search: Any) -> tuple[Any, Any]:
        """A view as it is first shown, and what the address has to tell of the session."""
        view, session = self.view(path), None
        try:
            session = self.session(search)
            controls = view.controls(session)
            values, remarks = values_of(controls, of_query(search))
            answer = view.answer(session, values, settled=False)
        except InputError as error:
            query = session.query() if session else {}
            return failed(session, str(error)), {
                "query": query,
                "view": view.name,
                "empty": True,
            }
        answer = replace(answer, remarks=[*remarks, *answer.remarks])
        shown = view_page(view, session, values, controls, answer)
        return shown, {"query": session.query(), "view": view.name}

    def live(self, asked: Mapping[str, Any]) -> dict[str, Any]:
        """Figures while something moves; none where that takes long or something is wrong.

        What is wrong is told as soon as all stands still.
        """
        try:
            view, session = self.view(asked.get("view")), self.session(asked.get("search"))
            if getattr(view, "slow", False):
                return {}
            values, _ = values_of(view.controls(session), _mapping(asked.get("values")))
            found = view.answer(session, values, settled=False)
        except InputError:
            return {}
        return {"figures": dict(found.figures)}

    def answer(self, path: Any, here: Any, given: Any) -> tuple[Any, ...]:
        """Figures, which are hidden, tables, remarks, legend, command and Python."""
        places = [entry["id"]["graph"] for entry in ctx.outputs_list[0]]
        try:
            view, session = self.view(path), self.session(here)
            values, unread = values_of(view.controls(session), given)
            found = view.answer(session, values, settled=True)
            told = view.shell(session, values), view.python(session, values)
        except InputError as error:
            same = [no_update] * len(places)
            wrong = remarks([str(error)], "trouble")
            return same, same, no_update, wrong, no_update, no_update, no_update
        drawn = [found.figures.get(name, no_update) for name in places]
        hidden = [name not in found.figures for name in places]
        tables = [table(one) for one in found.tables]
        lines = remarks([*unread, *found.remarks])
        return drawn, hidden, tables, lines, legend(found.legend), *told

    def _register(self) -> None:
        app = self.dash

        @app.callback(
            Output("page", "children"),
            Output("base", "data"),
            Input("address", "pathname"),
            Input("address", "search"),
        )
        def _page(path: Any, search: Any) -> Any:
            return self.page(path, search)

        together = (
            Output({"graph": ALL}, "figure", allow_duplicate=True),
            Output({"place": ALL}, "hidden", allow_duplicate=True),
            Output("tables", "children", allow_duplicate=True),
            Output("remarks", "children", allow_duplicate=True),
            Output("legend", "children", allow_duplicate=True),
            Output("command", "children", allow_duplicate=True),
            Output("python", "children", allow_duplicate=True),
        )
        where = (State("address", "pathname"), State("here", "data"))

        newest = Newest()

        # A step of a slider passes Dash by: half of what it takes was its bookkeeping.
        def _live() -> Any:
            asked = _mapping(request.get_json(silent=True))
            newest.told(asked)
            return self.live(asked)

        app.server.add_url_rule(LIVE, "live", _live, methods=["POST"])

        @app.callback(
            *together, Output("told", "data"),
            Input("settled", "data"), *where,
            prevent_initial_call=True,
        )  # fmt: skip
        def _settled(asked: Any, path: Any, here: Any) -> Any:
            asked = _mapping(asked)
            newest.told(asked)
            given = _mapping(asked.get("values"))
            with newest.in_turn:
                if not newest.is_it(asked):
                    # The page has moved on; whoever waits behind is to be answered sooner.
                    raise PreventUpdate
                found = self.answer(path, here, given)
            return *found, asked.get("serial", 0)

        @app.callback(
            Output("address", "search", allow_duplicate=True),
            Output("trouble", "children", allow_duplicate=True),
            Input("prop", "value"), Input("law", "value"), Input("physics", "value"),
            State("here", "data"),
            prevent_initial_call=True,
        )  # fmt: skip
        def _chosen(prop: Any, law: Any, physics: Any, here: Any) -> Any:
            return self.chosen(here, prop, law, physics)

        @app.callback(
            Output("address", "search", allow_duplicate=True),
            Output("trouble", "children", allow_duplicate=True),
            Input("upload", "contents"), State("upload", "filename"), State("here", "data"),
            prevent_initial_call=True,
        )  # fmt: skip
        def _uploaded(content: Any, name: Any, here: Any) -> Any:
            if content is None:
                raise PreventUpdate
            return self.uploaded(here, content, name)

        @app.callback(
            Output("address", "search", allow_duplicate=True),
            Input({"remove": ALL}, "n_clicks"), State("here", "data"),
            prevent_initial_call=True,
        )  # fmt: skip
        def _removed(clicks: Any, here: Any) -> Any:
            if not isinstance(clicks, list) or not any(clicks) or not ctx.triggered_id:
                raise PreventUpdate
            return self.removed(here, str(ctx.triggered_id["remove"]))

        @app.callback(
            Output("saved", "data"),
            Output("remarks", "children", allow_duplicate=True),
            Input({"save": ALL}, "n_clicks"),
            State({"control": ALL}, "value"), State({"control": ALL}, "id"), *where,
            prevent_initial_call=True,
        )  # fmt: skip
        def _saved(clicks: Any, values: Any, ids: Any, path: Any, here: Any) -> Any:
            if not any(clicks) or not ctx.triggered_id:
                raise PreventUpdate
            given = {one["control"]: value for one, value in zip(ids, values, strict=True)}
            file = str(ctx.triggered_id["save"])
            try:
                view, session = self.view(path), self.session(here)
                found, _ = values_of(view.controls(session), given)
                text = view.text(session, found, file)
            except InputError as error:
                return no_update, remarks([str(error)], "trouble")
            return send_string(text, file), no_update

        register_in_the_browser(self.dash)
        for view in self.views.values():
            more = getattr(view, "register", None)
            if more is not None:
                more(self)


def _mapping(value: Any) -> dict[str, Any]:
    """What came from a browser, if it is a mapping; else an empty one."""
    return value if isinstance(value, dict) else {}


# -------------------------------------------------------------------------------------------------
# The page: what is there from the first, and the parts of a view.

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


def _edits(figure: Figure | None) -> dict[str, Any]:
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


# -------------------------------------------------------------------------------------------------
# The server: where it listens, whom it answers, and how it ends.

MOST_BYTES = 8_000_000
"""Of a request: an upload of 5 MB is a third larger on its way."""

LOOPBACK = ("localhost", "127.0.0.1", "[::1]")

PORTS_TRIED = 20


def guard(server: Flask, names: Iterable[str]) -> None:
    """Refuse what is not meant for this server, and what is too large.

    A page of another site that has its name point to this machine sends that name in ``Host``.

    Parameters
    ----------
    server : Flask
        To be guarded.
    names : iterable of str
        What it may be called, without port.
    """
    allowed = {name.lower() for name in names}
    server.config["MAX_CONTENT_LENGTH"] = MOST_BYTES

    @server.before_request
    def _known_host() -> Response | None:
        name = request.host.rpartition(":")[0] if _has_port(request.host) else request.host
        if name.lower() in allowed:
            return None
        return Response("This server does not answer under that name.\n", 403)

    @server.errorhandler(Exception)
    def _told(error: Exception) -> Any:
        code = getattr(error, "code", None)
        if isinstance(code, int):
            return Response(f"{getattr(error, 'name', 'error')}\n", code)
        logging.getLogger(__name__).debug("a request failed", exc_info=error)
        return Response("The request could not be answered.\n", 500)

    @server.after_request
    def _closed(response: Response) -> Response:
        response.headers["X-Content-Type-Options"] = "nosniff"
        response.headers["X-Frame-Options"] = "DENY"
        response.headers["Referrer-Policy"] = "no-referrer"
        response.headers["Content-Security-Policy"] = (
            "default-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; "
            "script-src 'self' 'unsafe-inline' 'unsafe-eval'; frame-ancestors 'none'"
        )
        return response


def _has_port(host: str) -> bool:
    return host.rpartition(":")[2].isdigit() and (host.count(":") == 1 or "]:" in host)


def names_of(host: str) -> set[str]:
    """What a server that listens on ``host`` may be called."""
    found = {*LOOPBACK, host, f"[{host}]"}
    if not is_loopback(host):
        import socket

        found |= {socket.gethostname(), socket.getfqdn()}
        if host in ("0.0.0.0", "::"):
            found |= {info[4][0] for info in _own_addresses(socket.gethostname())}
    return {str(name) for name in found}


def _own_addresses(name: str) -> list[Any]:
    import socket

    try:
        return socket.getaddrinfo(name, None)
    except OSError:
        return []


def is_loopback(host: str) -> bool:
    """Whether ``host`` is this machine alone."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def listen(app: Flask, host: str, port: int | None, first: int) -> BaseWSGIServer:
    """A server that listens.

    Parameters
    ----------
    app : Flask
        What it serves.
    host : str
        Where.
    port : int or None
        Asked for; None for ``first`` or the next that is free.
    first : int
        Tried first where none is asked for.

    Raises
    ------
    InputError
        Where the port is taken or may not be used, and where there is no such host.
    """
    tried = [port] if port is not None else list(range(first, first + PORTS_TRIED))
    for one in tried:
        try:
            return _bound(app, host, one)
        except OSError as error:
            if error.errno == errno.EADDRINUSE and one != tried[-1]:
                continue
            if error.errno == errno.EADDRINUSE:
                found = f"port {one} of {host} is in use"
                raise InputError(found, "give another by --port, or end what uses it") from None
            reason = error.strerror or str(error)
            raise InputError(
                f"cannot listen on {host}, port {one}: {reason}", "give another --host or --port"
            ) from None
    raise AssertionError


def _bound(app: Flask, host: str, port: int) -> BaseWSGIServer:
    import socket

    # Bound here: werkzeug would print its own lines and leave the process where a port is taken.
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host.strip("[]"), port))
        listener.listen(64)
        server = make_server(host.strip("[]"), port, app, threaded=True, fd=listener.fileno())
    finally:
        listener.close()
    return server


def serve(server: BaseWSGIServer, say: Callable[[str], None], *, browser: bool, host: str) -> None:
    """Answer until Ctrl-C, which ends the process's work at once.

    Parameters
    ----------
    server : BaseWSGIServer
        From ``listen``.
    say : callable
        Gets lines for the terminal.
    browser : bool
        Whether one is opened.
    host : str
        As it was asked for.
    """
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    shown = "127.0.0.1" if host in ("0.0.0.0", "::", "localhost") else host
    address = f"http://{f'[{shown}]' if ':' in shown else shown}:{server.port}/"
    with contextlib.suppress(KeyboardInterrupt):
        say(f"propmap explore is at {address}")
        say("Ctrl-C ends it.")
        if browser:
            threading.Thread(target=_open, args=(address, say), daemon=True).start()
        server.serve_forever()
    # A fit under way is not waited for.
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


def _open(address: str, say: Callable[[str], None]) -> None:
    opened = False
    if sys.platform != "linux" or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        try:
            opened = webbrowser.open(address)
        except webbrowser.Error:
            opened = False
    if not opened:
        say("There is no display or no browser here: open the address above yourself.")


# -------------------------------------------------------------------------------------------------
# Fits that run while the page goes on: each under a name that its tab alone knows.

MOST = 50
"""Jobs that are remembered."""


@dataclass
class Job:
    """A fit under way or done.

    Attributes
    ----------
    told : str
        How far it is, or what came of it.
    found : mapping of str to float
        Constants, once it is done.
    done, failed : bool
        Whether it has ended, and without a result.
    begun : float
        When it began, by ``time.monotonic``.
    """

    told: str = "waiting for its turn"
    found: Mapping[str, float] = field(default_factory=dict)
    done: bool = False
    failed: bool = False
    begun: float = field(default_factory=time.monotonic)

    @property
    def line(self) -> str:
        """What is told of it, with the time it has taken so far."""
        return self.told if self.done else f"{self.told} ({time.monotonic() - self.begun:.0f} s)"


Work = Callable[[Job], Mapping[str, float]]


class Jobs:
    """All fits of a server, one at a time."""

    def __init__(self) -> None:
        self._kept: OrderedDict[str, Job] = OrderedDict()
        self._lock = threading.Lock()
        self._turn = threading.Lock()

    def begin(self, work: Work) -> str:
        """Do ``work`` in a thread of its own; the name under which it is asked for."""
        name, job = secrets.token_urlsafe(12), Job()
        with self._lock:
            waiting = sum(not other.done for other in self._kept.values())
            if waiting >= MOST:
                raise InputError("too many fits are under way", "wait for one to end")
            self._kept[name] = job
            for old in [k for k, other in self._kept.items() if other.done][: -MOST // 2]:
                del self._kept[old]
        threading.Thread(target=self._run, args=(job, work), daemon=True).start()
        return name

    def get(self, name: str) -> Job | None:
        """A fit by its name; None where there is none of it."""
        with self._lock:
            return self._kept.get(name)

    def _run(self, job: Job, work: Work) -> None:
        with self._turn:
            try:
                job.found = work(job)
            except InputError as error:
                job.told, job.failed = str(error), True
            except Exception:
                logging.getLogger(__name__).exception("a fit failed")
                job.told, job.failed = "the fit failed; the terminal says more", True
        job.done = True


# -------------------------------------------------------------------------------------------------
# Which request of a tab is its newest.

MOST_TABS = 1000
"""That are remembered."""


class Newest:
    """Which request of a tab is its newest: others need no answer that takes long."""

    def __init__(self) -> None:
        self.in_turn = threading.Lock()
        self._serials: OrderedDict[str, Any] = OrderedDict()
        self._lock = threading.Lock()

    def told(self, asked: Mapping[str, Any]) -> None:
        """Take note of the request that was ``asked``."""
        with self._lock:
            self._serials[_tab(asked)] = asked.get("serial")
            self._serials.move_to_end(_tab(asked))
            while len(self._serials) > MOST_TABS:
                self._serials.popitem(last=False)

    def is_it(self, asked: Mapping[str, Any]) -> bool:
        """Whether none has come from the same tab since this one was ``asked``."""
        return bool(self._serials.get(_tab(asked)) == asked.get("serial"))


def _tab(asked: Mapping[str, Any]) -> str:
    return str(asked.get("tab"))[:40]


# -------------------------------------------------------------------------------------------------
# What the browser does by itself, by functions of assets/explore.js, and the page they are in.

NAMESPACE = "propmap"

# Plotly is asked for at once, not only when the first figure comes.
INDEX = """<!DOCTYPE html>
<html lang="en">
<head>
{%metas%}
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{%title%}</title>
<link rel="icon" href="data:,">
{%css%}
</head>
<body>
{%app_entry%}
<footer>
{%config%}
{%scripts%}
{%renderer%}
<script src="/_dash-component-suites/plotly/package_data/plotly.min.js"></script>
</footer>
</body>
</html>
"""


def register_in_the_browser(app: Dash) -> None:
    """Tell the ``app`` which functions of assets/explore.js run at what."""

    def here(function: str, *parts: Any) -> None:
        register: Any = app.clientside_callback
        register(ClientsideFunction(NAMESPACE, function), *parts, prevent_initial_call=True)

    here(
        "moved",
        Output("here", "data"), Output({"menu": ALL}, "href", allow_duplicate=True),
        Input({"control": ALL}, "value"), Input("base", "data"),
        State({"control": ALL}, "id"), State({"menu": ALL}, "id"),
    )  # fmt: skip
    here(
        "typed",
        Output("void", "dir"), Input({"number": ALL}, "value"), State({"number": ALL}, "id"),
    )  # fmt: skip
    here(
        "dragged",
        Output("void", "accessKey"), Input({"graph": ALL}, "relayoutData"),
        State({"graph": ALL}, "figure"), State({"graph": ALL}, "id"),
    )  # fmt: skip
    here("undo", Output("void", "contentEditable"), Input("undo", "n_clicks"))
    here(
        "ticking",
        Output("tick", "disabled"), Input("job", "data"), Input("base", "data"),
    )  # fmt: skip
    here(
        "settled",
        Output("void", "className"), Output({"menu": ALL}, "href"),
        Input("told", "data"), State({"menu": ALL}, "id"),
    )  # fmt: skip
    here("theme", Output("theme", "title"), Input("theme", "n_clicks"))
    here(
        "copied",
        Output("copied", "children"), Input({"copy": ALL}, "n_clicks"),
        State("command", "children"), State("python", "children"),
    )  # fmt: skip
    here(
        "picture",
        Output("void", "lang"), Input({"picture": ALL, "as": ALL}, "n_clicks"),
    )  # fmt: skip
