"""Tables in the forms that other programs read, each with a note of what it costs."""

from __future__ import annotations

import os
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from propmap.errors import InputError, quoted
from propmap.export.folder import Files, check_folder, write_files
from propmap.table.query import LoadTable

__all__ = ["AUTOPILOTS", "TARGETS", "check_folder", "check_target", "export_table"]

_MAKERS = {
    "c": ("c_header", "files"),
    "multinomial": ("multinomial", "files"),
    "gazebo": ("gazebo", "files"),
    "rotorpy": ("rotorpy", "files"),
    "jsbsim": ("jsbsim", "files"),
    "npz": ("copies", "npz_files"),
    "nc": ("copies", "nc_files"),
    "csv": ("copies", "csv_files"),
}

TARGETS = tuple(_MAKERS)

AUTOPILOTS = ("px4", "ardupilot")
"""Targets of a vehicle, see ``propmap.export.autopilot``."""


def export_table(
    table: LoadTable, target: str, folder: str | os.PathLike[str], *, replace: bool = False
) -> list[Path]:
    """Write a table for a target, all files or none.

    Parameters
    ----------
    table : LoadTable
        The map.
    target : str
        One of ``TARGETS``.
    folder : path
        Where to; made if need be.
    replace : bool
        Whether files that exist are replaced.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    InputError
        For an unknown target, a folder that cannot be written to, files that exist, and a table
        that lacks what the target needs.
    """
    check_target(target)
    if target in AUTOPILOTS:
        raise InputError(f"{target} is of a vehicle", "use propmap.export.autopilot")
    place = Path(folder)
    check_folder(place)
    module, function = _MAKERS[target]
    make: Callable[[LoadTable], Files] = getattr(
        import_module(f"propmap.export.{module}"), function
    )
    return write_files(make(table), place, replace=replace)


def check_target(target: str) -> None:
    """Raise ``InputError`` for what is none of ``TARGETS`` and ``AUTOPILOTS``."""
    known = (*TARGETS, *AUTOPILOTS)
    if target not in known:
        raise InputError(
            f"there is no target {quoted(target)}", f"choose one of {', '.join(known)}"
        )
