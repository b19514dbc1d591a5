"""Target ``c`` of a vehicle: a C99 header with force and moment of the air on all of it.

The loads are those of the rotor's header (``c_header``), the wakes those of ``wake_geometry``.
"""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np

from propmap.export import c_header
from propmap.export.folder import Files
from propmap.export.operation_count import cost
from propmap.export.provenance import identifier, vehicle_name
from propmap.export.template import rendered
from propmap.export.vehicle_note import vehicle_note
from propmap.export.wake_geometry import wake_geometry
from propmap.model.airfoil import Airfoil
from propmap.results import spin_sign
from propmap.table.query import LoadTable
from propmap.vehicle.interference import LARGEST_INFLOW, SLOW, STEPS, UPWASH
from propmap.vehicle.rotors import Rotors
from propmap.vehicle.vehicle import Vehicle


def files(vehicle: Vehicle, table: LoadTable) -> Files:
    """The rotor's header, the vehicle's, and the note.

    Parameters
    ----------
    vehicle : Vehicle
        Of the aircraft.
    table : LoadTable
        Loads of its rotors.

    Raises
    ------
    InputError
        Where the table is of another propeller or air, see ``VehicleForces``.
    """
    Rotors.of(vehicle, table)
    name = vehicle_name(vehicle, table)
    return {
        f"{identifier(table)}.h": c_header.header(table),
        f"{name}.h": header(vehicle, table),
        "README-c.txt": vehicle_note(
            vehicle, table, "c", v=name, cost=cost(vehicle, table).sentence
        ),
    }


def header(vehicle: Vehicle, table: LoadTable) -> str:
    """The text of the vehicle's header."""
    name = vehicle_name(vehicle, table)
    values: dict[str, Any] = {"pairs": vehicle.wakes is not None and len(vehicle.mounts) > 1}
    if values["pairs"]:
        values |= {
            "wakes": vehicle.wakes,
            "wake": wake_geometry(vehicle),
            "disk": vehicle.air.density * np.pi * vehicle.propeller.radius**2,
            "steps": STEPS,
            "largest": LARGEST_INFLOW,
            "slow": SLOW,
            "upwash": UPWASH,
        }
    return rendered(
        "vehicle.h",
        table,
        v=name,
        V=name.upper(),
        about=textwrap.wrap(cost(vehicle, table).sentence, 90),
        vehicle=vehicle,
        rotors=vehicle.mounts,
        spins=[spin_sign(mount.spin) for mount in vehicle.mounts],
        lifts=bool(vehicle.body.lift_area) or vehicle.wing is not None,
        sharpness=Airfoil.sharpness,
        numbers=c_header.numbers,
        rows_of_numbers=c_header.rows_of_numbers,
        blocks_of_numbers=c_header.blocks_of_numbers,
        blocks_of_singles=c_header.blocks_of_singles,
        **values,
    )
