"""A vehicle's parameters for the firmware of an autopilot, as files and a note."""

from __future__ import annotations

import os
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import numpy as np

from propmap.aircraft.trim import Aircraft
from propmap.errors import InputError
from propmap.export import AUTOPILOTS
from propmap.export.files import check_folder, vehicle_identifier, write_files
from propmap.export.inplane_drag import check_vehicle, inplane_forces
from propmap.export.parameter_set import AutopilotParameters, Flights, note
from propmap.typing import Floats

SPEEDS = np.linspace(1.0, 15.0, 8)
"""At which a vehicle is flown where nothing else is asked for [m/s]."""


def autopilot_parameters(
    aircraft: Aircraft, target: str, speeds: Floats = SPEEDS
) -> AutopilotParameters:
    """Find a vehicle's parameters for an autopilot.

    Parameters
    ----------
    aircraft : Aircraft
        The vehicle with the loads of its rotors.
    target : str
        One of ``AUTOPILOTS``.
    speeds : ndarray, shape (n,)
        Through the air [m/s], at which the drag model is fitted; at rest nothing is to be seen.

    Raises
    ------
    InputError
        For an unknown target, for a vehicle that is no multirotor as the drag models of autopilots
        take it to be, and where too few of the speeds are flown.
    """
    if target not in AUTOPILOTS:
        raise InputError(
            f"there is no autopilot {target!r}", f"choose one of {', '.join(AUTOPILOTS)}"
        )
    check_vehicle(aircraft.vehicle)
    moving = np.asarray(speeds, dtype=np.float64)
    moving = moving[moving > 0.0]
    if moving.size < 2:
        raise InputError("fewer than two speeds above 0", "give two or more, in m/s")
    flights = (inplane_forces(aircraft, "x", moving), inplane_forces(aircraft, "y", moving))
    make: Callable[[Aircraft, Flights], AutopilotParameters] = import_module(
        f"propmap.export.{target}"
    ).parameters
    return make(aircraft, flights)


def export_autopilot(
    aircraft: Aircraft,
    target: str,
    folder: str | os.PathLike[str],
    *,
    speeds: Floats = SPEEDS,
    replace: bool = False,
) -> list[Path]:
    """Write a vehicle's parameters in the autopilot's own format, and a note, all files or none.

    Parameters
    ----------
    aircraft, target, speeds
        As for ``autopilot_parameters``.
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
        As ``autopilot_parameters``, and for a folder that cannot be written to and files that
        exist.
    """
    place = Path(folder)
    check_folder(place)
    found = autopilot_parameters(aircraft, target, speeds)
    text = import_module(f"propmap.export.{target}").file_text
    name = vehicle_identifier(aircraft.vehicle)
    files = {f"{name}_{part.suffix}": text(part, aircraft.vehicle) for part in found.sets}
    return write_files(
        files | {f"README-{target}.md": note(found, aircraft)}, place, replace=replace
    )
