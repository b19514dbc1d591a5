"""Exports to the forms that other programs read, listed in ``EXPORTS``.

Importing this package loads none of the exports: help and documentation are made of the list.
"""

from __future__ import annotations

import os
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from propmap.errors import InputError, quoted

if TYPE_CHECKING:
    from propmap.rotor import Rotor
    from propmap.table.query import LoadTable
    from propmap.vehicle.vehicle import Vehicle


class Export(NamedTuple):
    """One line of the registry: a form that ``propmap export`` writes."""

    target: str  # its name, as in ``propmap export --to``
    source: str  # what it is made from, a key of ``SOURCES``
    function: str  # "module.function" of ``propmap.export`` that makes it
    writes: str
    keeps: str  # these two over the loads of the source
    loses: str = "nothing"

    def make(self) -> Any:
        """Import the module and return its function."""
        module, _, name = self.function.partition(".")
        return getattr(import_module(f"propmap.export.{module}"), name)


SOURCES = {
    "table": "a table",  # function(table) returns ``propmap.export.files.Files``
    "rotor": "a propeller",  # function(rotor) returns ``Files``
    "vehicle": "a vehicle and a table",  # function(vehicle, table) returns ``Files``
    # function(aircraft, flights) returns ``AutopilotParameters``
    "autopilot": "a vehicle with 3 or more rotors",
    "pusher": "a pusher or tailsitter",  # function(aircraft), likewise
}

_BILINEAR = "thrust and torque quadratic, the four loads by the in-plane velocity bilinear"
_DRAG = "drag along x and y, linear and quadratic in the speed"
EXPORTS = (
    Export("c", "table", "c_header.c_files", "a C99 header",
           "everything: loads, gradient, inverse, status, wrench; the inflow's delay"),
    Export("multinomial", "table", "simple_models.multinomial_files", "polynomials in Python and C",
           _BILINEAR, "stall, fast descent, Reynolds number"),
    Export("gazebo", "table", "simple_models.gazebo_files", "SDF of Gazebo's motor model",
           "static thrust and torque, a linear drag and rolling moment",
           "change of thrust and torque with speed, side force, pitching moment"),
    Export("rotorpy", "table", "simple_models.rotorpy_files", "rotor parameters of RotorPy",
           "the change of thrust with speed, four linear loads by the in-plane velocity",
           "change of torque"),
    Export("jsbsim", "table", "simple_models.jsbsim_files", "propeller and reactions of JSBSim",
           "thrust and power over the axial advance ratio; the other four as in `multinomial`",
           "change of thrust and power with the in-plane velocity"),
    Export("npz", "table", "simple_models.npz_files", "the table for propmap", "everything"),
    Export("nc", "table", "simple_models.nc_files", "the table as NetCDF", "everything"),
    Export("csv", "table", "simple_models.csv_files", "the table's knots as rows",
           "everything but the status"),
    Export("cpp", "rotor", "cpp_rotor.rotor_files", "a C++ header on propmap's own core",
           "everything"),
    Export("c", "vehicle", "c_header.vehicle_c_files", "the whole vehicle as C99 headers",
           "everything, wakes included"),
    Export("rotorpy", "vehicle", "simple_models.vehicle_rotorpy_files", "a multirotor of RotorPy",
           "everything, wakes included; needs propmap"),
    Export("mujoco", "vehicle", "simple_models.vehicle_mujoco_files", "an MJCF model that flies",
           "everything, wakes included; needs propmap"),
    Export("px4", "autopilot", "px4.parameters", "parameters of PX4",
           f"{_DRAG}; places of the rotors, torque over thrust, thrust curve", "wakes, wings"),
    Export("ardupilot", "autopilot", "ardupilot.parameters", "parameters of ArduPilot",
           f"{_DRAG}; thrust curve", "wakes, wings"),
    Export("px4", "pusher", "px4.forward_propeller", "the propeller of PX4's simulator SIH",
           "thrust and power over the axial advance ratio, quadratic", "all else"),
)  # fmt: skip
"""All exports, in the order of ``propmap export --help``; a new one is a line here and a module."""


def _targets(source: str) -> tuple[str, ...]:
    return tuple(export.target for export in EXPORTS if export.source == source)


TARGETS = _targets("table")
"""Targets of a table, see ``export_table``."""

ROTOR_TARGETS = _targets("rotor")
"""Targets of a rotor without a table, see ``export_rotor``."""

VEHICLE_TARGETS = _targets("vehicle")
"""Targets of a whole vehicle's force and moment, see ``export_vehicle``."""

AUTOPILOTS = _targets("autopilot")  # of a vehicle's parameters, see ``export_autopilot``


def find_export(target: str, source: str | None = None) -> Export:
    """Return the export to ``target`` from ``source``, or from whatever it is made of."""
    named = [export for export in EXPORTS if export.target == target]
    for export in named:
        if source in (None, export.source):
            return export
    found = f"there is no target {quoted(target)}"
    if source and named:
        made = " or ".join(SOURCES[export.source] for export in named)
        found = f"{target} is not made from {SOURCES[source]}, but from {made}"
    known = _targets(source) if source else dict.fromkeys(export.target for export in EXPORTS)
    raise InputError(found, f"choose one of {', '.join(known)}")


def export_table(
    table: LoadTable, target: str, folder: str | os.PathLike[str], *, replace: bool = False
) -> list[Path]:
    """Write a table for a target, all files or none.

    Parameters
    ----------
    table : LoadTable
        The table.
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
    return _write(find_export(target, "table"), folder, replace, table)


def export_rotor(
    rotor: Rotor, target: str, folder: str | os.PathLike[str], *, replace: bool = False
) -> list[Path]:
    """Write a rotor for a target, all files or none.

    Parameters
    ----------
    rotor : Rotor
        Its model and accuracy.
    target : str
        One of ``ROTOR_TARGETS``.
    folder, replace
        As for ``export_table``.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    InputError
        For another target, a folder that cannot be written to, and files that exist.
    """
    return _write(find_export(target, "rotor"), folder, replace, rotor)


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
    folder, replace
        As for ``export_table``.

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
    return _write(find_export(target, "vehicle"), folder, replace, vehicle, table)


def _write(
    export: Export, folder: str | os.PathLike[str], replace: bool, *source: object
) -> list[Path]:
    """Write what ``export`` makes of its ``source``, when the folder is known to be writable."""
    from propmap.export.files import check_folder, write_files

    place = Path(folder)
    check_folder(place)
    return write_files(export.make()(*source), place, replace=replace)
