"""propmap: a propeller's six loads, from hover to fast oblique flight.

Importing the package needs NumPy alone; the compiled core is loaded with the first rotor.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from propmap.catalogue.known import known_model
from propmap.catalogue.lookup import airfoil, propeller
from propmap.errors import InputError

# The functions share their names with the modules they come from; importing them here, once,
# makes the package's attribute the function.
from propmap.model.air import Air
from propmap.model.airfoil import Airfoil, airfoil_names
from propmap.model.corrections import correction, corrections_of
from propmap.model.model import Model
from propmap.model.propeller import Propeller
from propmap.model.section_covariance import SectionCovariance
from propmap.model.section_table import SectionTable
from propmap.model.uncertainty import SectionUncertainty

if TYPE_CHECKING:
    from propmap.baselines.hover import HoverModel
    from propmap.dynamic_inflow import DynamicInflow
    from propmap.results import Loads, Wrench
    from propmap.rotor import Rotor
    from propmap.vehicle.vehicle import Vehicle
    from propmap.vehicle.vehicle_forces import VehicleForces, VehicleWrench
    from propmap.vehicle.vehicle_toml import read_vehicle

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

_LAZY = {
    "DynamicInflow": "dynamic_inflow",
    "HoverModel": "baselines.hover",
    "Loads": "results",
    "Rotor": "rotor",
    "Vehicle": "vehicle.vehicle",
    "VehicleForces": "vehicle.vehicle_forces",
    "VehicleWrench": "vehicle.vehicle_forces",
    "Wrench": "results",
    "read_vehicle": "vehicle.vehicle_toml",
}


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(importlib.import_module(f"propmap.{_LAZY[name]}"), name)
    raise AttributeError(f"module 'propmap' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_LAZY])
