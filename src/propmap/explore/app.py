"""The Dash application and its server: pages, callbacks, access control and background fits."""

from __future__ import annotations

import contextlib
import errno
import ipaddress
import logging
import os
import secrets
import signal
import socket
import sys
import threading
import time
import webbrowser
from base64 import b64decode
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl, urlencode, urlsplit

import dash
from dash import ALL, ClientsideFunction, Dash, Input, Output, State, ctx, no_update
from dash.exceptions import PreventUpdate
from flask import Flask, Response, request
from werkzeug.serving import BaseWSGIServer, make_server

from propmap.errors import InputError
from propmap.explore.page import INDEX, failed, legend, page, remarks, table, view_page
from propmap.explore.session import FILE, KNOWN, Recent, Session, Shelf, read_upload
from propmap.explore.view import View, values_of

send_string: Any = dash.dcc.send_string  # type: ignore[attr-defined]

LIVE = "/_live"  # address of figures while a control moves
OF_BLADE = ("chord-", "twist-")  # prefixes of controls that apply to one blade only


class Application:
    """The application, with the ``first`` session from the command line and the first view at /."""

    def __init__(self, first: Session, views: Sequence[View], shelf: Shelf) -> None:
        self.first, self.shelf = first, shelf
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
        # Fills the caches, so the first page in the browser appears sooner.
        self.page("/", "")

    def session(self, search: Any, *, lost: bool = False) -> Session:
        """Return the session of an address.  Raise ``InputError`` for an invalid address and,
        unless ``lost``, for files that the server no longer stores."""
        if search is not None and not isinstance(search, str):
            raise InputError("the address is invalid", "open the start page /")
        query = query_of(search)
        if lost:
            query = {k: v for k, v in query.items() if not k.startswith(FILE) or v in self.shelf}
        return Session.of(query, self.first, self.shelf)

    def view(self, path: Any) -> View:
        """Return the view of an address, or the first view for an unknown address."""
        name = str(path or "").strip("/")
        return self.views.get(name) or next(iter(self.views.values()))

    def page(self, path: Any, search: Any) -> tuple[Any, Any]:
        """Return a view with its first answer, and the session data for the browser."""
        view, session = self.view(path), None
        try:
            session = self.session(search)
            controls = view.controls(session)
            values, unread = values_of(controls, query_of(search))
            answer = view.answer(session, values, settled=False)
        except InputError as error:
            base = {"query": session.query() if session else {}, "view": view.name, "empty": True}
            return failed(session, str(error)), base
        answer = replace(answer, remarks=[*unread, *answer.remarks])
        shown = view_page(view, session, values, controls, answer)
        return shown, {"query": session.query(), "view": view.name}

    def live(self, asked: Mapping[str, Any]) -> dict[str, Any]:
        """Return the figures while a control moves; none for slow views and after errors."""
        try:
            view, session = self.view(asked.get("view")), self.session(asked.get("search"))
            if view.slow:
                return {}
            values, _ = values_of(view.controls(session), _mapping(asked.get("values")))
            found = view.answer(session, values, settled=False)
        except InputError:
            return {}
        return {"figures": dict(found.figures)}

    def answer(self, path: Any, here: Any, given: Any) -> tuple[Any, ...]:
        """Return figures, which of them are hidden, tables, remarks, legend, command and Python."""
        places = [entry["id"]["graph"] for entry in ctx.outputs_list[0]]
        try:
            view, session = self.view(path), self.session(here)
            values, unread = values_of(view.controls(session), given)
            found = view.answer(session, values, settled=True)
            texts = view.shell(session, values), view.python(session, values)
        except InputError as error:
            same = [no_update] * len(places)
            wrong = remarks([str(error)], "trouble")
            return same, same, no_update, wrong, no_update, no_update, no_update
        drawn = [found.figures.get(name, no_update) for name in places]
        hidden = [name not in found.figures for name in places]
        tables = [table(one) for one in found.tables]
        lines = remarks([*unread, *found.remarks])
        return drawn, hidden, tables, lines, legend(found.legend), *texts

    def chosen(self, here: Any, prop: Any, law: Any, physics: Any) -> tuple[Any, str]:
        """Return the address for other propeller, constants or physics, and an error message."""
        try:
            session = self.session(here, lost=True)
            if (prop, law, physics) == (session.name, session.law, session.physics):
                # The callback also runs when the page was just drawn.
                return no_update, ""
            gone = []
            if prop != session.name:
                # These settings return to the defaults of the new blade.
                gone += ["file-fit", "file-geometry", "file-vehicle", "rpm", "data"]
            if law != session.law:
                gone += ["file-fit", "file-constants"]
            query = {
                name: value
                for name, value in {**settings_of(here), **session.query()}.items()
                if name not in gone and not name.startswith(OF_BLADE)
            }
            query |= {"prop": str(prop or session.prop), "law": str(law or KNOWN)}
            query["physics"] = str(physics or "")
            Session.of(query, self.first, self.shelf).model  # noqa: B018 - raises for invalid choices
        except InputError as error:
            return no_update, str(error)
        return f"?{urlencode(query)}", ""

    def uploaded(self, here: Any, content: Any, name: Any) -> tuple[Any, str]:
        """Return the address with an uploaded file, and an error message."""
        try:
            try:
                data = b64decode(str(content).partition(",")[2], validate=True)
            except ValueError:
                raise InputError("the upload is damaged", "drop the file again") from None
            given = read_upload(str(name), data)
            session = self.session(here, lost=True).with_file(given, self.shelf.put(given))
            session.model  # noqa: B018 - raises for invalid choices
            query = settings_of(here)
            if given.kind in ("geometry", "fit", "vehicle"):
                query.pop("rpm", None)
            if given.kind == "data":
                query["data"] = "file"
        except InputError as error:
            return no_update, str(error)
        return f"?{urlencode({**query, **session.query()})}", ""

    def removed(self, here: Any, kind: str) -> str:
        """Return the address without a file."""
        query = {**settings_of(here), **self.session(here, lost=True).query()}
        query.pop(f"file-{kind}", None)
        return f"?{urlencode(query)}"

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

        # Slow answers to older requests of a tab are skipped.
        newest, in_turn = Recent[Any](MOST_TABS), threading.Lock()

        # Steps of sliders bypass Dash, whose bookkeeping took half of the time.
        def _live() -> Any:
            asked = _mapping(request.get_json(silent=True))
            newest.put(_tab(asked), asked.get("serial"))
            return self.live(asked)

        app.server.add_url_rule(LIVE, "live", _live, methods=["POST"])

        @app.callback(
            *together, Output("answered", "data"),
            Input("settled", "data"), *where,
            prevent_initial_call=True,
        )  # fmt: skip
        def _settled(asked: Any, path: Any, here: Any) -> Any:
            asked = _mapping(asked)
            newest.put(_tab(asked), asked.get("serial"))
            given = _mapping(asked.get("values"))
            with in_turn:
                if newest.get(_tab(asked)) != asked.get("serial"):
                    # A newer request of the tab makes this answer useless.
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
            Input("dropped", "data"), State("here", "data"),
            prevent_initial_call=True,
        )  # fmt: skip
        def _uploaded(file: Any, here: Any) -> Any:
            if not file:
                raise PreventUpdate
            return self.uploaded(here, _mapping(file).get("content"), _mapping(file).get("name"))

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
            view.register(self)


def query_of(search: str | None) -> dict[str, str]:
    """Return the parameters of an address such as ``?a=1&b=2``."""
    return dict(parse_qsl((search or "").lstrip("?"), keep_blank_values=True, max_num_fields=100))


def settings_of(search: str | None) -> dict[str, str]:
    """Return the parameters of an address, except for its files."""
    return {key: value for key, value in query_of(search).items() if not key.startswith(FILE)}


def _mapping(value: Any) -> dict[str, Any]:
    """Return a value from a browser if it is a mapping, or an empty mapping."""
    return value if isinstance(value, dict) else {}


# --- The server: address, access control, start and end ------------------------------------------

LARGEST_REQUEST = 8_000_000  # bytes: base64 encoding makes an upload of 5 MB a third larger
LOOPBACK = ("localhost", "127.0.0.1", "::1")
PORTS_TRIED = 20


def guard(server: Flask, names: Iterable[str]) -> None:
    """Refuse large requests, and requests to other host names than ``names``.

    This prevents DNS rebinding: a page of another site would send the name of that site.
    """
    allowed = {name.lower() for name in names}
    server.config["MAX_CONTENT_LENGTH"] = LARGEST_REQUEST

    @server.before_request
    def _known_host() -> Response | None:
        with contextlib.suppress(ValueError):
            if urlsplit(f"//{request.host}").hostname in allowed:
                return None
        return Response("This server does not answer requests for this host name.\n", 403)

    @server.errorhandler(Exception)
    def _failed(error: Exception) -> Any:
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


def names_of(host: str) -> set[str]:
    """Return the allowed names of a server that listens on ``host``."""
    found = {*LOOPBACK, host.strip("[]")}
    if not is_loopback(host):
        own = socket.gethostname()
        found |= {own, socket.getfqdn()}
        if host in ("0.0.0.0", "::"):
            with contextlib.suppress(OSError):
                found |= {str(info[4][0]) for info in socket.getaddrinfo(own, None)}
    return found


def is_loopback(host: str) -> bool:
    """Return whether only this machine can reach ``host``."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def listen(app: Flask, host: str, port: int | None, first: int) -> BaseWSGIServer:
    """Listen on ``port``; if None, on ``first`` or the next free port.

    Raise ``InputError`` if the port is in use or not allowed, or the host does not exist.
    """
    tried = [port] if port is not None else list(range(first, first + PORTS_TRIED))
    name, family = host.strip("[]"), socket.AF_INET6 if ":" in host else socket.AF_INET
    for one in tried:
        # werkzeug must not bind the port: it would end the process if the port is in use.
        with socket.socket(family, socket.SOCK_STREAM) as listener:
            try:
                listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                listener.bind((name, one))
                listener.listen(64)
                return make_server(name, one, app, threaded=True, fd=listener.fileno())
            except OSError as error:
                if error.errno == errno.EADDRINUSE and one != tried[-1]:
                    continue
                reason = error.strerror or str(error)
                found = f"cannot listen on {host}, port {one}: {reason}"
                raise InputError(found, "give another --host or --port") from None
    raise AssertionError


def serve(server: BaseWSGIServer, say: Callable[[str], None], *, browser: bool, host: str) -> None:
    """Serve until Ctrl-C, which ends the process at once; ``say`` prints messages."""
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    shown = "127.0.0.1" if host in ("0.0.0.0", "::", "localhost") else host
    address = f"http://{f'[{shown}]' if ':' in shown else shown}:{server.port}/"
    # End at once, without waiting for a fit.  A KeyboardInterrupt inside Thread.start would end the
    # process with a traceback.
    signal.signal(signal.SIGINT, lambda *_: os._exit(0))
    say(f"propmap explore runs at {address}")
    say("Press Ctrl-C to stop.")
    if browser:
        threading.Thread(target=_open_browser, args=(address, say), daemon=True).start()
    server.serve_forever()


def _open_browser(address: str, say: Callable[[str], None]) -> None:
    opened = False
    if sys.platform != "linux" or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        with contextlib.suppress(webbrowser.Error):
            opened = webbrowser.open(address)
    if not opened:
        say("There is no display or no browser: open the address above in a browser.")


# --- Background fits, each under a name that only its tab knows ----------------------------------

MOST = 50  # maximum number of stored jobs


@dataclass
class Job:
    """A running or finished fit."""

    message: str = "waiting for other fits"  # progress or result
    found: Mapping[str, float] = field(default_factory=dict)  # constants, when finished
    done: bool = False
    begun: float = field(default_factory=time.monotonic)

    @property
    def line(self) -> str:
        """Progress with the elapsed time, or the result."""
        seconds = time.monotonic() - self.begun
        return self.message if self.done else f"{self.message} ({seconds:.0f} s)"

    def run(self, work: Callable[[Job], Mapping[str, float]]) -> None:
        """Set the result of ``work``, or a message on its failure."""
        try:
            self.found = work(self)
        except InputError as error:
            self.message = str(error)
        except Exception:
            logging.getLogger(__name__).exception("a fit failed")
            self.message = "the fit failed; see the terminal for details"
        self.done = True


class Jobs(Recent[Job]):
    """The last fits of a server, which run one at a time."""

    def __init__(self) -> None:
        super().__init__(MOST)
        self._in_turn = ThreadPoolExecutor(max_workers=1)

    def begin(self, work: Callable[[Job], Mapping[str, float]]) -> str:
        """Run ``work`` in a thread, and return the name of the job."""
        name, job = secrets.token_urlsafe(12), Job()
        self.put(name, job)
        self._in_turn.submit(job.run, work)
        return name


MOST_TABS = 1000  # maximum number of stored tabs


def _tab(asked: Mapping[str, Any]) -> str:
    return str(asked.get("tab"))[:40]


def register_in_the_browser(app: Dash) -> None:
    """Register the functions of assets/explore.js as callbacks."""

    def here(function: str, *parts: Any) -> None:
        register: Any = app.clientside_callback
        register(ClientsideFunction("propmap", function), *parts, prevent_initial_call=True)

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
        Input("answered", "data"), State({"menu": ALL}, "id"),
    )  # fmt: skip
    here(
        "dropped",
        Output("dropped", "data"), Output("trouble", "children", allow_duplicate=True),
        Input("upload", "contents"), State("upload", "filename"),
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
