"""propmap: a propeller's six loads, from hover to fast oblique flight.

Importing the package loads NumPy alone; each public name loads its own module when it is first
asked for, and the first rotor the compiled core.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

import numpy  # noqa: F401 - all that follows needs it, and no first call is to wait for it

if TYPE_CHECKING:
    from propmap.catalogue.lookup import airfoil, known_model, propeller
    from propmap.dynamic_inflow import DynamicInflow
    from propmap.errors import InputError
    from propmap.hover import HoverModel
    from propmap.model.airfoil import (
        Airfoil,
        SectionCovariance,
        SectionTable,
        SectionUncertainty,
        airfoil_names,
    )
    from propmap.model.corrections import correction, corrections_of
    from propmap.model.model import Air, Model, Propeller
    from propmap.results import Loads, Wrench
    from propmap.rotor import Rotor
    from propmap.vehicle.files import read_vehicle
    from propmap.vehicle.vehicle import Vehicle
    from propmap.vehicle.vehicle_forces import VehicleForces, VehicleWrench

__version__ = "0.1.0"

__all__ = [
    "Air",
    "Airfoil",
    "DynamicInflow",
    "HoverModel",
    "InputError",
    "Loads",
    "Model",
    "Propeller",
    "Rotor",
    "SectionCovariance",
    "SectionTable",
    "SectionUncertainty",
    "Vehicle",
    "VehicleForces",
    "VehicleWrench",
    "Wrench",
    "airfoil",
    "airfoil_names",
    "correction",
    "corrections_of",
    "known_model",
    "propeller",
    "read_vehicle",
]

_PLACES = {
    "Air": "model.model",
    "Airfoil": "model.airfoil",
    "DynamicInflow": "dynamic_inflow",
    "HoverModel": "hover",
    "InputError": "errors",
    "Loads": "results",
    "Model": "model.model",
    "Propeller": "model.model",
    "Rotor": "rotor",
    "SectionCovariance": "model.airfoil",
    "SectionTable": "model.airfoil",
    "SectionUncertainty": "model.airfoil",
    "Vehicle": "vehicle.vehicle",
    "VehicleForces": "vehicle.vehicle_forces",
    "VehicleWrench": "vehicle.vehicle_forces",
    "Wrench": "results",
    "airfoil": "catalogue.lookup",
    "airfoil_names": "model.airfoil",
    "correction": "model.corrections",
    "corrections_of": "model.corrections",
    "known_model": "catalogue.lookup",
    "propeller": "catalogue.lookup",
    "read_vehicle": "vehicle.files",
}


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'propmap' has no attribute {name!r}")
    found = globals()[name] = getattr(importlib.import_module(f"propmap.{_PLACES[name]}"), name)
    return found


def __dir__() -> list[str]:
    return sorted([*globals(), *_PLACES])
