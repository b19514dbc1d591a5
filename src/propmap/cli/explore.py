"""``propmap explore``: the propeller in a browser."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Annotated

import typer

from propmap.catalogue.lookup import looks_like_path
from propmap.errors import InputError

PORT = 8765

Subject = Annotated[
    str | None,
    typer.Argument(
        metavar="[PROP|FIT.toml|TABLE.npz|VEHICLE.toml]",
        help="Name, designation or file of a propeller; a fit, constants, a table, a vehicle; or "
        "measured loads (.csv).",
        show_default=False,
    ),
]


def explore(
    subject: Subject = None,
    port: Annotated[
        int | None,
        typer.Option("--port", min=0, max=65535, help=f"By default {PORT} or the next free one."),
    ] = None,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Whether to open a browser.")
    ] = True,
    host: Annotated[
        str, typer.Option("--host", help="Where to listen; by default for this machine alone.")
    ] = "127.0.0.1",
) -> None:
    """See a propeller in the browser: loads, disk, blade, constants, aircraft, trust."""
    if importlib.util.find_spec("dash") is None:
        raise InputError(
            "the package dash is not installed", "pip install '.[explore]' in propmap's checkout"
        )
    from propmap.explore.app import Application, guard, is_loopback, listen, names_of, serve
    from propmap.explore.session import Session, Shelf, read_path
    from propmap.explore.views import VIEWS

    shelf, first = Shelf(), Session()
    if subject is not None and looks_like_path(subject):
        given = read_path(Path(subject))
        first = first.with_file(given, shelf.put(given, always=True))
    elif subject is not None:
        first = Session(prop=subject)
    first.model  # noqa: B018 - what is wrong with it is told before anything listens
    app = Application(first, VIEWS, shelf)
    guard(app.dash.server, names_of(host))
    server = listen(app.dash.server, host, port, PORT)
    if not is_loopback(host):
        typer.echo(
            f"propmap: warning: whoever reaches {host} can use this server: it has no password",
            err=True,
        )
    serve(server, typer.echo, browser=browser, host=host)
