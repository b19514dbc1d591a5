"""The entry point: the commands together, and errors as one line."""

from __future__ import annotations

import io
import os
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Annotated, Any, ClassVar

import typer

import propmap
from propmap.cli.lazy_group import LazyGroup
from propmap.errors import DRAG_FACTOR, InputError

INTERRUPTED = 130

# SciPy's matrices are small here: threads of its own would wait for each other beside the core's.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


class Commands(LazyGroup):
    """All commands, in the order in which help lists them."""

    places: ClassVar = {
        "predict": "predict.predict",
        "sweep": "sweep.sweep",
        "study": "study.study",
        "table": "table.table",
        "show": "show.show_table",
        "export": "export.export",
        "trim": "trim.trim",
        "choose": "choose.choose",
        "check": "check.check",
        "report": "report.report",
        "explore": "explore.explore",
        "fit": "fit.fit_app",
        "simulate": "simulate.simulate_app",
        "plot": "plot.plot_app",
        "props": "listings.props_app",
        "airfoils": "listings.airfoils_app",
    }


app = typer.Typer(
    cls=Commands,
    help="A propeller's six loads, from hover to fast oblique flight.",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"propmap {propmap.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    pass


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit code: 0, 2 for bad input, 130 when interrupted.

    The ``arguments``, without the program's name, are by default those of the process.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    if isinstance(sys.stdout, io.TextIOWrapper):
        # A terminal without the characters of a table shows "?" rather than a traceback.
        sys.stdout.reconfigure(errors="replace")
    command = typer.main.get_command(app)
    try:
        with _deprecations_in_one_line():
            code = command.main(given or ["--help"], "propmap", standalone_mode=False, obj=given)
        sys.stdout.flush()
    except InputError as error:
        return _fail(str(error))
    except typer.TyperException as error:
        context = getattr(error, "ctx", None)
        command_path = context.command_path if context else "propmap"
        return _fail(f"{error.format_message().rstrip('.')}; see {command_path} --help")
    except BrokenPipeError:
        # The reader, such as `head`, has seen enough; what is left must not fail at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:
        reason = error.strerror or str(error)
        return _fail(f"{error.filename}: {reason}" if error.filename else reason)
    if code == INTERRUPTED:
        typer.echo("propmap: interrupted", err=True)
    return code or 0


@contextmanager
def _deprecations_in_one_line() -> Iterator[None]:
    """What is deprecated in propmap as a line of its own, once."""
    said: list[str] = []
    with warnings.catch_warnings():
        show = warnings.showwarning

        def tell(message: Any, *where: Any) -> None:
            if str(message) != DRAG_FACTOR:
                show(message, *where)
            elif not said:
                said.append(DRAG_FACTOR)
                typer.echo(f"propmap: warning: {message}", err=True)

        warnings.filterwarnings("always", DRAG_FACTOR, DeprecationWarning)
        warnings.showwarning = tell  # type: ignore[assignment]
        yield


def _fail(message: str) -> int:
    typer.echo(f"propmap: error: {' '.join(message.split())}", err=True)
    return 2
