"""Steady states as an xarray dataset over climb rate and speed."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import TYPE_CHECKING

import numpy as np
import xarray

import propmap
from propmap.aircraft.performance import columns
from propmap.aircraft.trim import STATUSES, Aircraft
from propmap.rotor import Rotor

if TYPE_CHECKING:
    from propmap.aircraft.sensitivity import Spread
    from propmap.aircraft.trim import SteadyStates

AXES = ("climb_mps", "speed_mps")


def dataset(
    craft: Aircraft, flown: list[SteadyStates], sure: list[Spread | None], command: str
) -> xarray.Dataset:
    """States at the same n speeds for each of several climb rates, with provenance.

    ``sure`` are their standard deviations.
    """
    parts = [columns(*both) for both in zip(flown, sure, strict=True)]
    speed, climb = parts[0]["speed_mps"], parts[0]["climb_mps"]
    rates = np.array([states.climb[0] for states in flown])
    coordinates = {
        "climb_mps": ("climb_mps", rates, {"units": climb.unit, "long_name": climb.meaning}),
        "speed_mps": ("speed_mps", speed.values, {"units": speed.unit, "long_name": speed.meaning}),
        "rotor": ("rotor", np.arange(1, len(craft.vehicle.mounts) + 1)),
    }
    variables = {}
    for name, column in parts[0].items():
        if name in AXES or any(name not in part for part in parts):
            continue
        dims = (*AXES, "rotor") if column.values.ndim == 2 else AXES
        values = np.stack([part[name].values for part in parts])
        variables[name] = (dims, values, {"units": column.unit, "long_name": column.meaning})
    found = xarray.Dataset(variables, coordinates, _provenance(craft, command))
    names = list(STATUSES)
    codes = [[names.index(status) for status in states.status.tolist()] for states in flown]
    flags = {
        "long_name": "whether the state was found within the limits",
        "flag_values": np.arange(len(names), dtype=np.uint8),
        "flag_meanings": " ".join(names),
    }
    found["status"] = (AXES, np.array(codes, np.uint8), flags)
    return found


def _provenance(craft: Aircraft, command: str) -> dict[str, str | float]:
    vehicle, loads = craft.vehicle, craft.loads
    told: dict[str, str | float] = {
        "title": f"Steady flight of {vehicle.name}",
        "propmap_version": propmap.__version__,
        "mass_kg": vehicle.mass,
        "propeller": vehicle.propeller.name,
        "geometry_sha256": vehicle.propeller.fingerprint(),
        "air_density_kg_m3": vehicle.air.density,
        "command": command,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    if isinstance(loads, Rotor):
        told |= {"section_law": loads.model.law_title, "model_sha256": loads.model.fingerprint()}
    return told
