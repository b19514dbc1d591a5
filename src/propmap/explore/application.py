"""The Dash application: what a browser asks, and what it is answered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import dash
from dash import ALL, Dash, Input, Output, State, ctx, no_update
from dash.exceptions import PreventUpdate
from flask import request

from propmap.errors import InputError
from propmap.explore import shell
from propmap.explore.choices import Choices
from propmap.explore.controls import of_query, values_of
from propmap.explore.given import Shelf
from propmap.explore.in_the_browser import INDEX, register_in_the_browser
from propmap.explore.jobs import Jobs
from propmap.explore.newest import Newest
from propmap.explore.session import Session
from propmap.explore.view import View

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
        self.dash.layout = shell.page(views)
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
            return shell.failed(session, str(error)), {
                "query": query,
                "view": view.name,
                "empty": True,
            }
        answer = replace(answer, remarks=[*remarks, *answer.remarks])
        shown = shell.view_page(view, session, values, controls, answer)
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
            values, remarks = values_of(view.controls(session), given)
            found = view.answer(session, values, settled=True)
            told = view.shell(session, values), view.python(session, values)
        except InputError as error:
            same = [no_update] * len(places)
            wrong = shell.remarks([str(error)], "trouble")
            return same, same, no_update, wrong, no_update, no_update, no_update
        drawn = [found.figures.get(name, no_update) for name in places]
        hidden = [name not in found.figures for name in places]
        tables = [shell.table(table) for table in found.tables]
        lines = shell.remarks([*remarks, *found.remarks])
        return drawn, hidden, tables, lines, shell.legend(found.legend), *told

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
                return no_update, shell.remarks([str(error)], "trouble")
            return send_string(text, file), no_update

        register_in_the_browser(self.dash)
        for view in self.views.values():
            more = getattr(view, "register", None)
            if more is not None:
                more(self)


def _mapping(value: Any) -> dict[str, Any]:
    """What came from a browser, if it is a mapping; else an empty one."""
    return value if isinstance(value, dict) else {}
