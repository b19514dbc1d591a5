"""The lines of a text file, or an ``InputError`` that says why there are none."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from propmap.errors import InputError

MAX_BYTES = 5_000_000


def read_lines(path: str | os.PathLike[str], content: str = "geometry") -> list[str]:
    """The lines of the UTF-8 text file at ``path``, without their line ends.

    Parameters
    ----------
    path : path
        Of the file.
    content : str
        What kind of file is expected, for the messages.

    Raises
    ------
    InputError
        For a missing file, a directory, a file above 5 MB, and a file that is empty, binary or in
        another encoding.
    """
    where = os.fspath(path)
    data = _read_bytes(where, content)
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise InputError("the text is in UTF-16, expected UTF-8", "save it as UTF-8", where)
    if b"\0" in data:
        raise InputError(
            "found binary data, expected text", f"give a text file with the {content}", where
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"line {line}: byte 0x{data[error.start]:02x} is not UTF-8 text",
            "save the file as UTF-8",
            where,
        ) from None
    if not text.strip():
        raise InputError(
            f"the file is empty, expected the {content}", f"give a {content} file", where
        )
    # Not str.splitlines, which also splits at form feeds and would shift the line numbers.
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _read_bytes(where: str, content: str) -> bytes:
    try:
        status = Path(where).stat()
        fault = _fault(status, content)
        if fault is None:
            return Path(where).read_bytes()
    except FileNotFoundError:
        fault = ("no such file", "check the path")
    except OSError as error:
        reason = error.strerror or type(error).__name__
        fault = (f"cannot read it: {reason}", "check the path and the rights to read it")
    except ValueError as error:
        # A path with a null character.
        fault = (f"not a path: {error}", "check the path")
    raise InputError(*fault, where)


def _fault(status: os.stat_result, content: str) -> tuple[str, str] | None:
    """What keeps a path from being a readable text file, and the remedy."""
    if stat.S_ISDIR(status.st_mode):
        return "this is a directory, expected a file", "name a file inside it"
    if not stat.S_ISREG(status.st_mode):
        return "this is a device or pipe, expected a file", "save the data to a file"
    if status.st_size > MAX_BYTES:
        megabytes, limit = status.st_size / 1e6, MAX_BYTES / 1e6
        return (
            f"{megabytes:.1f} MB is not a {content} file, expected at most {limit:g} MB",
            f"name the file with the {content}",
        )
    return None
