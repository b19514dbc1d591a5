"""Several files at once, all of them or none."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path

from propmap.errors import InputError
from propmap.io.atomic_file import replacing

Files = Mapping[str, str | Callable[[Path], None]]
"""What to write: by name, a text or a function that writes to the path that it is given."""


def check_folder(folder: Path) -> None:
    """Raise ``InputError`` where no files can be written to ``folder``, made if need be."""
    where = str(folder)
    try:
        if not folder.exists():
            parent = folder.parent
            if not parent.is_dir():
                raise InputError(
                    f"there is no folder {str(parent)!r}", "make it or choose another", where
                )
            writable = os.access(parent, os.W_OK)
        elif not folder.is_dir():
            raise InputError("this is a file", "name a folder to write into", where)
        else:
            writable = os.access(folder, os.W_OK)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"not a path: {error}", "choose another name", where) from None
    if not writable:
        raise InputError("the folder cannot be written to", "choose another", where)


def write_files(files: Files, folder: Path, *, replace: bool) -> list[Path]:
    """Write files into a folder, which is made if need be; their paths.

    Without ``replace``, files that are there already raise ``InputError``.  All are complete
    before the first gets its name.
    """
    check_folder(folder)
    paths = [folder / name for name in files]
    for path in paths:
        if path.is_dir():
            raise InputError("this is a folder", "choose another folder to write into", str(path))
        if path.exists() and not replace:
            raise InputError("the file exists", "pass --force to replace it", str(path))
    made = not folder.exists()
    folder.mkdir(exist_ok=True)
    try:
        with ExitStack() as stack:
            for path, content in zip(paths, files.values(), strict=True):
                part = stack.enter_context(replacing(path))
                if isinstance(content, str):
                    part.write_text(content, encoding="utf-8", newline="")
                else:
                    content(part)
    except BaseException:
        if made:
            folder.rmdir()
        raise
    return paths
