"""The folder of a report: it appears with all its files or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from propmap.errors import InputError

PAGE = "index.html"


def file_names(figures: Collection[str], tables: Collection[str]) -> frozenset[str]:
    """The page, an SVG and a CSV for each figure, a CSV for each table without a figure."""
    pairs = {f"{name}{ending}" for name in figures for ending in (".svg", ".csv")}
    return frozenset({PAGE, *pairs, *(f"{name}.csv" for name in tables)})


MOST_LOADS = 6
"""In flight, three forces and three moments."""

REPORT_FILES = file_names(
    [f"fit-{name}" for name in ("coverage", "errors", "loads", "parameters", "check", "measured")]
    + [f"fit-residuals-{k}" for k in range(1, MOST_LOADS + 1)]
    + [f"table-{name}" for name in ("cells", "loads", "maps", "hover")],
    ["fit-correlations", "table-certificate"],
)
"""What ``propmap report`` may write."""

TERMS_FILES = file_names(["fit-terms"], ["fit-terms-values", "fit-terms-worth"])
"""What ``propmap fit terms`` may write."""


def check_folder(folder: Path, names: Collection[str]) -> None:
    """Raise ``InputError`` unless the folder can be made, or replaced without loss.

    Parameters
    ----------
    folder : Path
        If it exists, it may hold no files but those named.
    names : collection of str
        Of the files to be written.
    """
    where = str(folder)
    try:
        parent = folder.absolute().parent
        if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
            raise InputError("this is not a folder", "name a folder to write into", where)
        if not parent.is_dir():
            told = f"there is no folder {str(parent)!r}"
            raise InputError(told, "make it or choose another", where)
        held = folder.iterdir() if folder.exists() else ()
        others = sorted(p.name for p in held if p.name not in names or p.is_dir())
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"not a path: {error}", "choose another name", where) from None
    if others:
        raise InputError(
            f"the folder holds {others[0]!r}, which this command does not write",
            "choose a new or an empty folder",
            where,
        )
    if not os.access(parent, os.W_OK):
        raise InputError("the folder cannot be written to", "choose another", where)


def write_folder(
    folder: Path, files: Mapping[str, str | bytes], names: Collection[str] = ()
) -> None:
    """Make the folder, or replace it, with these files.

    They are written into a folder beside it, which is renamed when all are there.

    Parameters
    ----------
    folder : Path
        Checked as by ``check_folder``, which may raise ``InputError``.
    files : mapping of str to str or bytes
        Contents by name; text is written as UTF-8.
    names : collection of str
        Of further files that the folder may hold; they are removed.
    """
    check_folder(folder, {*files, *names})
    with _beside(folder, "part") as part, _beside(folder, "old") as old:
        part.mkdir()
        for name, content in files.items():
            data = content.encode("utf-8") if isinstance(content, str) else content
            (part / name).write_bytes(data)
        if folder.exists():
            folder.rename(old)
        try:
            part.rename(folder)
        except BaseException:
            if old.exists():
                old.rename(folder)
            raise


@contextmanager
def _beside(folder: Path, ending: str) -> Iterator[Path]:
    """The path of a temporary folder beside this one; it is removed at the end."""
    place = folder.absolute()
    path = place.with_name(f".{place.name[:100]}.{os.getpid()}.{ending}")
    try:
        yield path
    finally:
        shutil.rmtree(path, ignore_errors=True)
