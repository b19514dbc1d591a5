"""The commands of ``propmap fit`` together."""

from __future__ import annotations

import typer

from propmap.cli.fit_catalogue import fit_catalogue
from propmap.cli.fit_flight import fit_flight
from propmap.cli.fit_static import fit_static
from propmap.cli.fit_terms import fit_terms_page
from propmap.cli.fit_tunnel import fit_tunnel

fit_app = typer.Typer(
    name="fit", help="Identify section parameters.", no_args_is_help=True, rich_markup_mode=None
)
fit_app.command("tunnel")(fit_tunnel)
fit_app.command("flight")(fit_flight)
fit_app.command("static")(fit_static)
fit_app.command("terms")(fit_terms_page)
fit_app.command("catalogue")(fit_catalogue)
