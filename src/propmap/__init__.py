"""propmap: the six loads of a propeller, from hover to fast oblique flight.

Importing the package loads only NumPy.  Each public name loads its module on first use, and the
first rotor loads the compiled core.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

import numpy  # noqa: F401 - every module needs it, and its import must not slow the first call

if TYPE_CHECKING:
    from propmap.catalogue.lookup import airfoil as airfoil
    from propmap.catalogue.lookup import catalogue_model as catalogue_model
    from propmap.catalogue.lookup import propeller as propeller
    from propmap.dynamic_inflow import DynamicInflow as DynamicInflow
    from propmap.errors import InputError as InputError
    from propmap.hover import HoverModel as HoverModel
    from propmap.model.air import Air as Air
    from propmap.model.airfoil import Airfoil as Airfoil
    from propmap.model.airfoil import SectionCovariance as SectionCovariance
    from propmap.model.airfoil import SectionTable as SectionTable
    from propmap.model.airfoil import SectionUncertainty as SectionUncertainty
    from propmap.model.airfoil import airfoil_names as airfoil_names
    from propmap.model.corrections import correction as correction
    from propmap.model.corrections import model_corrections as model_corrections
    from propmap.model.model import Model as Model
    from propmap.model.propeller import Propeller as Propeller
    from propmap.results import Loads as Loads
    from propmap.results import Wrench as Wrench
    from propmap.rotor import Rotor as Rotor
    from propmap.vehicle.files import read_vehicle as read_vehicle
    from propmap.vehicle.vehicle import Vehicle as Vehicle
    from propmap.vehicle.vehicle_forces import VehicleForces as VehicleForces
    from propmap.vehicle.vehicle_forces import VehicleWrench as VehicleWrench

__version__ = "1.0.0"

_PUBLIC = {
    "catalogue.lookup": "airfoil catalogue_model propeller",
    "dynamic_inflow": "DynamicInflow",
    "errors": "InputError",
    "hover": "HoverModel",
    "model.air": "Air",
    "model.airfoil": "Airfoil SectionCovariance SectionTable SectionUncertainty airfoil_names",
    "model.corrections": "correction model_corrections",
    "model.model": "Model",
    "model.propeller": "Propeller",
    "results": "Loads Wrench",
    "rotor": "Rotor",
    "vehicle.files": "read_vehicle",
    "vehicle.vehicle": "Vehicle",
    "vehicle.vehicle_forces": "VehicleForces VehicleWrench",
}
_PLACES = {name: module for module, names in _PUBLIC.items() for name in names.split()}
__all__ = sorted(_PLACES)


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'propmap' has no attribute {name!r}")
    found = globals()[name] = getattr(importlib.import_module(f"propmap.{_PLACES[name]}"), name)
    return found


def __dir__() -> list[str]:
    return sorted([*globals(), *_PLACES])
