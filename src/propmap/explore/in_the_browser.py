"""What the browser does by itself, by functions of assets/explore.js, and the page they are in."""

from __future__ import annotations

from typing import Any

from dash import ALL, ClientsideFunction, Dash, Input, Output, State

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
