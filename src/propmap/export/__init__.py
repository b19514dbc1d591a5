"""Exports to the file formats of other programs, listed in ``EXPORTS``.

Help and documentation use this list, so importing the package imports none of the exports.
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
    """Entry of the registry: a format that ``propmap export`` writes."""

    target: str  # name of the format, as in ``propmap export --to``
    source: str  # object that is exported, a key of ``SOURCES``
    function: str  # "module.function" in ``propmap.export`` that returns the files
    writes: str
    keeps: str  # properties of the source's loads that the format can represent
    loses: str = "nothing"  # properties that it cannot represent

    def make(self) -> Any:
        """Import the module of the export and return the function."""
        module, _, name = self.function.partition(".")
        return getattr(import_module(f"propmap.export.{module}"), name)


SOURCES = {
    "table": "a table",  # function(table) returns ``propmap.export.files.Files``
    "rotor": "a propeller",  # function(rotor) returns ``Files``
    "vehicle": "a vehicle",  # function(vehicle, table) returns ``Files``
    # function(aircraft, flights) returns ``AutopilotParameters``
    "autopilot": "a vehicle with 3 or more rotors",
    "pusher": "a pusher or tailsitter",  # function(aircraft) returns ``AutopilotParameters``
}

_BILINEAR = "thrust and torque (quadratic), the four loads due to in-plane velocity (bilinear)"
_DRAG = "drag along x and y, linear and quadratic in airspeed"
EXPORTS = (
    Export("c", "table", "c_header.c_files", "a C99 header",
           "everything: loads, gradient, inverse, status, wrench, inflow lag"),
    Export("multinomial", "table", "simple_models.multinomial_files", "polynomials in Python and C",
           _BILINEAR, "stall, fast descent, Reynolds number"),
    Export("gazebo", "table", "gazebo.table_files", "motor models in SDF",
           "static thrust and torque, linear drag and rolling moment",
           "change of thrust and torque with airspeed, side force, pitching moment"),
    Export("gazebo", "vehicle", "gazebo.vehicle_files", "motor models of all rotors in SDF",
           "static thrust and torque, linear drag and rolling moment",
           "change of thrust and torque with airspeed, side force, pitching moment"),
    Export("rotorpy", "table", "simple_models.rotorpy_files", "rotor parameters of RotorPy",
           "change of thrust with airspeed, four loads linear in the in-plane velocity",
           "change of torque with airspeed"),
    Export("jsbsim", "table", "simple_models.jsbsim_files",
           "JSBSim propeller with external reactions",
           "thrust and power over the axial advance ratio; four loads as in `multinomial`",
           "change of thrust and power with the in-plane velocity"),
    Export("npz", "table", "simple_models.npz_files", "the table for propmap", "everything"),
    Export("nc", "table", "simple_models.nc_files", "the table as NetCDF", "everything"),
    Export("csv", "table", "simple_models.csv_files", "the knots of the table as rows",
           "everything but the status"),
    Export("cpp", "rotor", "cpp_rotor.rotor_files", "a C++ header that includes propmap's core",
           "everything"),
    Export("c", "vehicle", "c_header.vehicle_c_files", "the whole vehicle as C99 headers",
           "everything, wakes included"),
    Export("rotorpy", "vehicle", "simple_models.vehicle_rotorpy_files", "a multirotor of RotorPy",
           "everything, wakes included; needs propmap"),
    Export("mujoco", "vehicle", "simple_models.vehicle_mujoco_files", "an MJCF model with a script",
           "everything, wakes included; needs propmap"),
    Export("px4", "autopilot", "px4.parameters", "parameters of PX4",
           f"{_DRAG}; rotor positions, torque-to-thrust ratio, thrust curve", "wakes, wings"),
    Export("ardupilot", "autopilot", "ardupilot.parameters", "parameters of ArduPilot",
           f"{_DRAG}; thrust curve", "wakes, wings"),
    Export("px4", "pusher", "px4.forward_propeller", "the propeller of PX4's simulator SIH",
           "thrust and power, quadratic in the axial advance ratio", "all other loads"),
)  # fmt: skip
"""All exports, in the order of ``propmap export --help``.

A new export needs an entry here, a module with the function, and a template of the note that the
function writes. The template is ``templates/README-TARGET.txt.j2``, or
``README-TARGET-vehicle.txt.j2`` for a vehicle. A short note needs no template: the function passes
the note to ``propmap.export.files.note`` as ``text``. All autopilots share
``README-autopilot.md.j2``.
"""


def _targets(source: str) -> tuple[str, ...]:
    return tuple(export.target for export in EXPORTS if export.source == source)


TARGETS = _targets("table")
"""Targets of ``export_table``."""

ROTOR_TARGETS = _targets("rotor")
"""Targets of ``export_rotor``."""

VEHICLE_TARGETS = _targets("vehicle")
"""Targets of ``export_vehicle``."""

KNOTS = ("npz", "nc", "csv")  # targets that represent tables of backward rotation
AUTOPILOTS = _targets("autopilot")  # targets of ``propmap.export.autopilot.export_autopilot``


def find_export(target: str, source: str | None = None) -> Export:
    """Return the export to ``target`` from a ``source``; by default the first of any source."""
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
    table: LoadTable,
    target: str,
    folder: str | os.PathLike[str],
    *,
    replace: bool = False,
    **names: str,
) -> list[Path]:
    """Write a table in the format of a target, all files or none.

    Parameters
    ----------
    table : LoadTable
        The table.
    target : str
        One of ``TARGETS``.
    folder : path
        Output folder, created if it does not exist.
    replace : bool
        Whether to replace existing files.
    **names : str
        For ``gazebo``: names ``joint`` and ``link`` of the joints and links of the rotors, with {}
        for the number of the rotor, from 0 (default: "rotor_{}_joint" and "rotor_{}").

    Returns
    -------
    list of Path
        The written files.

    Raises
    ------
    InputError
        For an unknown target, a folder that is not writable, existing files without ``replace``,
        and a table without the operating points that the target needs.
    """
    return _write(find_export(target, "table"), folder, replace, table, **names)


def export_rotor(
    rotor: Rotor, target: str, folder: str | os.PathLike[str], *, replace: bool = False
) -> list[Path]:
    """Write a rotor in the format of a target.

    Parameters
    ----------
    rotor : Rotor
        The rotor, with its model and accuracy.
    target : str
        One of ``ROTOR_TARGETS``.
    folder, replace
        As for ``export_table``.

    Returns
    -------
    list of Path
        The written files.

    Raises
    ------
    InputError
        For an unknown target, a folder that is not writable, and existing files.
    """
    return _write(find_export(target, "rotor"), folder, replace, rotor)


def export_vehicle(
    vehicle: Vehicle,
    table: LoadTable,
    target: str,
    folder: str | os.PathLike[str],
    *,
    replace: bool = False,
    **names: str,
) -> list[Path]:
    """Write the aerodynamic force and moment on a vehicle in the format of a target.

    Parameters
    ----------
    vehicle : Vehicle
        The vehicle: rotors, body, wing and wakes.
    table : LoadTable
        Loads of the rotors.
    target : str
        One of ``VEHICLE_TARGETS``.
    folder, replace, **names
        As for ``export_table``.

    Returns
    -------
    list of Path
        The written files.

    Raises
    ------
    InputError
        For an unknown target, a table of another propeller or air, a folder that is not writable,
        and existing files.
    """
    return _write(find_export(target, "vehicle"), folder, replace, vehicle, table, **names)


def check_direction(loads: object, target: str) -> None:
    """Raise ``InputError`` if ``loads`` is a table of backward rotation without this ``target``."""
    if getattr(loads, "backward", False) and target not in KNOTS:
        found = f"the table is for a propeller that turns backward, which {target} cannot represent"
        remedy = f"choose one of {', '.join(KNOTS)}, or build a table with a positive --rpm"
        raise InputError(found, remedy)


def _write(
    export: Export, folder: str | os.PathLike[str], replace: bool, *source: object, **names: str
) -> list[Path]:
    """Check that the folder is writable, then write the files of ``export`` for its ``source``."""
    from propmap.export.files import check_folder, write_files

    place = Path(folder)
    for one in source:
        check_direction(one, export.target)
    check_folder(place)
    return write_files(export.make()(*source, **names), place, replace=replace)
