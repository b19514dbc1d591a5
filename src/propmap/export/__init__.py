"""Tables in the forms that other programs read, each with a note of what it costs."""

from __future__ import annotations

import os
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from propmap.errors import InputError, quoted
from propmap.export.files import Files, check_folder, write_files
from propmap.table.query import LoadTable
from propmap.vehicle.vehicle import Vehicle

__all__ = [
    "AUTOPILOTS",
    "TARGETS",
    "VEHICLE_TARGETS",
    "check_folder",
    "check_target",
    "export_table",
    "export_vehicle",
]

_MAKERS = {
    "c": ("c_header", "c_files"),
    "multinomial": ("simple_models", "multinomial_files"),
    "gazebo": ("simple_models", "gazebo_files"),
    "rotorpy": ("simple_models", "rotorpy_files"),
    "jsbsim": ("simple_models", "jsbsim_files"),
    "npz": ("simple_models", "npz_files"),
    "nc": ("simple_models", "nc_files"),
    "csv": ("simple_models", "csv_files"),
}

TARGETS = tuple(_MAKERS)

_VEHICLE_MAKERS = {
    "c": ("c_header", "vehicle_c_files"),
    "rotorpy": ("simple_models", "vehicle_rotorpy_files"),
}

VEHICLE_TARGETS = tuple(_VEHICLE_MAKERS)
"""Targets of a whole vehicle's force and moment, see ``export_vehicle``."""

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


def export_vehicle(
    vehicle: Vehicle,
    table: LoadTable,
    target: str,
    folder: str | os.PathLike[str],
    *,
    replace: bool = False,
) -> list[Path]:
    """Write force and moment of the air on a whole vehicle for a target, all files or none.

    Parameters
    ----------
    vehicle : Vehicle
        Its rotors, body, wing and, where it has them, wakes.
    table : LoadTable
        Loads of its rotors.
    target : str
        One of ``VEHICLE_TARGETS``.
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
        For another target, a table of another propeller or air, a folder that cannot be written
        to, and files that exist.
    """
    check_target(target)
    if target not in _VEHICLE_MAKERS:
        raise InputError(
            f"{target} is not of a vehicle's force and moment",
            f"choose one of {', '.join(VEHICLE_TARGETS)}, or export the map alone",
        )
    place = Path(folder)
    check_folder(place)
    module, function = _VEHICLE_MAKERS[target]
    make: Callable[[Vehicle, LoadTable], Files] = getattr(
        import_module(f"propmap.export.{module}"), function
    )
    return write_files(make(vehicle, table), place, replace=replace)


def check_target(target: str) -> None:
    """Raise ``InputError`` for what is none of ``TARGETS`` and ``AUTOPILOTS``."""
    known = (*TARGETS, *AUTOPILOTS)
    if target not in known:
        raise InputError(
            f"there is no target {quoted(target)}", f"choose one of {', '.join(known)}"
        )
