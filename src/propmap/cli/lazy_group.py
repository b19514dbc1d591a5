"""Groups of commands whose modules are imported when their command is asked for."""

from __future__ import annotations

import importlib
from typing import Any, ClassVar

import typer
from typer.core import TyperGroup


class LazyGroup(TyperGroup):
    """A group that imports the module of a command when that command, or all help, is asked for."""

    places: ClassVar[dict[str, str]]
    """Module of ``propmap.cli`` and the function or app in it, "predict.predict", by command."""

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        none_yet: Any = dict.fromkeys(self.places)
        self.commands = none_yet

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command, or None where there is none of the name."""
        if cmd_name in self.places and self.commands[cmd_name] is None:
            module, _, name = self.places[cmd_name].partition(".")
            found = getattr(importlib.import_module(f"propmap.cli.{module}"), name)
            self.commands[cmd_name] = _command(cmd_name, found)
        return super().get_command(ctx, cmd_name)


def _command(name: str, found: Any) -> Any:
    """What Typer makes of a function, or of an app that is a group."""
    if isinstance(found, typer.Typer):
        return typer.main.get_group(found)
    alone = typer.Typer(add_completion=False, rich_markup_mode=None)
    alone.command(name)(found)
    return typer.main.get_command(alone)
