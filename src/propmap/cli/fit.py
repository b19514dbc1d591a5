"""The commands of ``propmap fit`` together."""

from __future__ import annotations

from typing import ClassVar

import typer

from propmap.cli.lazy_group import LazyGroup


class FitCommands(LazyGroup):
    """What can be fitted, in the order in which help lists it."""

    places: ClassVar = {
        "tunnel": "fit_tunnel.fit_tunnel",
        "flight": "fit_flight.fit_flight",
        "static": "fit_static.fit_static",
        "terms": "fit_terms.fit_terms_page",
        "catalogue": "fit_catalogue.fit_catalogue",
    }


fit_app = typer.Typer(
    name="fit",
    cls=FitCommands,
    help="Identify section parameters.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
