"""A folder that appears with all its files or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from propmap.errors import InputError


def check_folder(folder: Path, names: Collection[str]) -> None:
    """Raise ``InputError`` unless the folder can be made, or replaced without loss.

    names : of the files to be written.  A folder that is there may hold these and no others:
    it will be replaced as a whole.
    """
    where = str(folder)
    try:
        parent = folder.absolute().parent
        if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
            raise InputError("this is not a folder", "name a folder to write into", where)
        if not parent.is_dir():
            raise InputError(
                f"there is no folder {str(parent)!r}", "make it or choose another", where
            )
        others = (
            sorted(p.name for p in folder.iterdir() if p.name not in names or p.is_dir())
            if folder.exists()
            else []
        )
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
    """Write the files, text as UTF-8, into the folder, which they replace as a whole.

    names : of further files that the folder may hold, and that go with it.

    They are written beside it, under a name of their own, and the folder is renamed when all are
    there.  Raises ``InputError`` as ``check_folder`` does.
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
    """A name for a folder beside this one; whatever is there at the end is removed."""
    place = folder.absolute()
    path = place.with_name(f".{place.name[:100]}.{os.getpid()}.{ending}")
    try:
        yield path
    finally:
        shutil.rmtree(path, ignore_errors=True)
