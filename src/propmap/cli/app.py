"""Entry point of the command line: imports each command on first use, prints errors in one line."""

from __future__ import annotations

import importlib
import io
import os
import re
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar

import typer
from typer import Option, echo
from typer.core import TyperGroup

import propmap
from propmap.errors import InputError

INTERRUPTED = 130

# SciPy's matrices are small here: threads of OpenBLAS would only compete with those of the core.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


class LazyGroup(TyperGroup):
    """A group that imports the module of a command only when the command or its help is needed."""

    places: ClassVar[dict[str, str]]  # "module.function" in ``propmap.cli``, by command name

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        none_yet: Any = dict.fromkeys(self.places)
        self.commands = none_yet

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the command, imported on first use, or None if the name is unknown."""
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
    """All commands, in the order of the help."""

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
        "wind": "wind.wind",
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
    help="Predict the six loads of a propeller, from hover to fast oblique flight.",
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
            help="Show the folder with the C++ headers of the core.",
        ),
    ] = False,
) -> None:
    pass


def main(arguments: Sequence[str] | None = None) -> int:
    """Run ``arguments`` (default: ``sys.argv``); return 0, 2 for bad input, 130 if interrupted."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    if isinstance(sys.stdout, io.TextIOWrapper):
        # A terminal that cannot encode the frame of a table prints "?" instead of a traceback.
        sys.stdout.reconfigure(errors="replace")
    command = typer.main.get_command(app)
    try:
        code = command.main(given or ["--help"], "propmap", standalone_mode=False, obj=given)
        sys.stdout.flush()
    except InputError as error:
        return _fail(str(error))
    except typer.TyperException as error:
        return _fail(_usage(error))
    except UnicodeError:
        return _fail("a name contains bytes that are not UTF-8; rename the file or the folder")
    except BrokenPipeError:
        # The reader, such as `head`, closed the pipe: the flush at exit must not fail.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:
        reason = error.strerror or str(error)
        return _fail(f"{error.filename}: {reason}" if error.filename else reason)
    if code == INTERRUPTED:
        echo("propmap: interrupted", err=True)
    return code or 0


# --- Answers to options and commands under the names that other tools and textbooks use ----------

ANSWERS = Path(__file__).with_name("answers.toml")


def _usage(error: typer.TyperException) -> str:
    """Return the message of an error in the command line, with what to type instead."""
    context: Any = getattr(error, "ctx", None)
    message = error.format_message().rstrip(".")
    unknown = getattr(error, "option_name", None)
    known = {name for one in (context.command.params if context else ()) for name in one.opts}
    answers = tomllib.loads(ANSWERS.read_text(encoding="utf-8"))
    for option in answers["options"]:
        applies = "needed" not in option or option["needed"] in known
        if applies and unknown in option["typed"].split():
            return f"No such option: {unknown}; {option['answer']}"
    command = re.match(r"No such command '([^']*)'", message)
    for name, others in answers["commands"].items():
        if command and context.parent is None and command[1].lower() in others.split():
            return f"No such command '{command[1]}'; use propmap {name}, see propmap {name} --help"
    value = re.search(r"'([^']*\d[:,]\d[^']*)' is not a valid (float|integer)", message)
    if value:
        option = message.partition("'")[2].partition("'")[0]
        grid = f"; propmap sweep PROP {option} {value[1]} ... computes a grid of points"
        found = f"{message.split(': ')[0]}: {value[1]!r} is not one number"
        return found + grid * (context.info_name == "predict")
    return f"{message}; see {context.command_path if context else 'propmap'} --help"


def _fail(message: str) -> int:
    echo(f"propmap: error: {' '.join(message.split())}", err=True)
    return 2
