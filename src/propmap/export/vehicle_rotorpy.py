"""Target ``rotorpy`` of a vehicle: a RotorPy multirotor with propmap's force and moment of the air.

The module that is written needs propmap: it reads the map beside it and asks ``VehicleForces``.
"""

from __future__ import annotations

from dataclasses import replace

from propmap.errors import InputError
from propmap.export.folder import Files
from propmap.export.literal import literal
from propmap.export.provenance import identifier, vehicle_name
from propmap.export.rotorpy import fit_rotor
from propmap.export.samples import sample
from propmap.export.template import rendered
from propmap.export.vehicle_note import vehicle_note
from propmap.results import spin_sign
from propmap.table.query import LoadTable
from propmap.vehicle.powertrain import Powertrain
from propmap.vehicle.rotors import Rotors
from propmap.vehicle.vehicle import Vehicle

ROTORS = 4
"""RotorPy's Multirotor inverts the matrix from its rotors' thrusts to thrust and moments."""


def files(vehicle: Vehicle, table: LoadTable) -> Files:
    """The module, the map and the note.

    Parameters
    ----------
    vehicle : Vehicle
        With four rotors.
    table : LoadTable
        Loads of its rotors.

    Raises
    ------
    InputError
        For another number of rotors, and where the table is of another propeller or air, see
        ``VehicleForces``.
    """
    if len(vehicle.mounts) != ROTORS:
        raise InputError(
            f"the vehicle has {len(vehicle.mounts)} rotors, RotorPy's Multirotor {ROTORS}",
            "write a multirotor of your own around propmap.VehicleForces",
        )
    Rotors.of(vehicle, table)
    name = vehicle_name(vehicle, table)
    text = rendered(
        "rotorpy_vehicle.py",
        table,
        v=name,
        vehicle=vehicle,
        made=literal(replace(vehicle, powertrain=Powertrain())),
        directions=[-spin_sign(mount.spin) for mount in vehicle.mounts],
        fitted=fit_rotor(table, sample(table)),
    )
    return {
        f"{name}_rotorpy.py": text,
        f"{identifier(table)}.npz": table.save,
        "README-rotorpy.txt": vehicle_note(vehicle, table, "rotorpy", v=name),
    }
