"""The entry point: commands that are imported when they are asked for, and errors in one line."""

from __future__ import annotations

import importlib
import io
import os
import sys
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar

import typer
from typer import Option, echo
from typer.core import TyperGroup

import propmap
from propmap.errors import InputError

INTERRUPTED = 130

# SciPy's matrices are small here: threads of its own would wait for each other beside the core's.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


class LazyGroup(TyperGroup):
    """A group that imports the module of a command when that command, or all help, is asked for."""

    places: ClassVar[dict[str, str]]  # "module.function" within ``propmap.cli``, by command

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        none_yet: Any = dict.fromkeys(self.places)
        self.commands = none_yet

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the command, imported on first use, or None where there is none of the name."""
        if cmd_name in self.places and self.commands[cmd_name] is None:
            module, _, name = self.places[cmd_name].partition(".")
            found = getattr(importlib.import_module(f"propmap.cli.{module}"), name)
            if isinstance(found, typer.Typer):
                self.commands[cmd_name] = typer.main.get_group(found)
            else:
                alone = typer.Typer(add_completion=False, rich_markup_mode=None)
                alone.command(cmd_name)(found)
                self.commands[cmd_name] = typer.main.get_command(alone)
        return super().get_command(ctx, cmd_name)


class Commands(LazyGroup):
    """All commands, in the order in which help lists them."""

    places: ClassVar = {
        "demo": "demo.demo",
        "predict": "predict.predict",
        "sweep": "sweep.sweep",
        "study": "sweep.study",
        "table": "table.table",
        "show": "table.show_table",
        "export": "export.export",
        "trim": "trim.trim",
        "choose": "choose.choose",
        "check": "check.check",
        "report": "check.report",
        "explore": "plot.explore",
        "fit": "fit.fit_app",
        "simulate": "simulate.simulate_app",
        "plot": "plot.plot_app",
        "vehicle": "simulate.vehicle_app",
        "props": "listings.props_app",
        "airfoils": "listings.airfoils_app",
    }


app = typer.Typer(
    cls=Commands,
    help="Predict a propeller's six loads, from hover to fast oblique flight.",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        echo(f"propmap {propmap.__version__}")
        raise typer.Exit


def _show_headers(wanted: bool) -> None:
    if wanted:
        from propmap.rotor import include_folder

        echo(include_folder())
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, Option("--version", callback=_show_version, is_eager=True, help="Show the version.")
    ] = False,
    include_dir: Annotated[
        bool,
        Option(
            "--include-dir",
            callback=_show_headers,
            is_eager=True,
            help="Show the folder of the core's C++ headers.",
        ),
    ] = False,
) -> None:
    pass


def main(arguments: Sequence[str] | None = None) -> int:
    """Run ``arguments``, or the process's; return 0, 2 for bad input, 130 when interrupted."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    if isinstance(sys.stdout, io.TextIOWrapper):
        # A terminal without the characters of a table shows "?" rather than a traceback.
        sys.stdout.reconfigure(errors="replace")
    command = typer.main.get_command(app)
    try:
        code = command.main(given or ["--help"], "propmap", standalone_mode=False, obj=given)
        sys.stdout.flush()
    except InputError as error:
        return _fail(str(error))
    except typer.TyperException as error:
        context = getattr(error, "ctx", None)
        command_path = context.command_path if context else "propmap"
        return _fail(f"{error.format_message().rstrip('.')}; see {command_path} --help")
    except UnicodeError:
        return _fail("a name holds bytes that are not UTF-8; rename the file or the folder")
    except BrokenPipeError:
        # The reader, such as `head`, has seen enough; what is left must not fail at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:
        reason = error.strerror or str(error)
        return _fail(f"{error.filename}: {reason}" if error.filename else reason)
    if code == INTERRUPTED:
        echo("propmap: interrupted", err=True)
    return code or 0


def _fail(message: str) -> int:
    echo(f"propmap: error: {' '.join(message.split())}", err=True)
    return 2
