"""The models of a vehicle's rotors, which differ in what they are mounted on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from propmap.model.model import Model

if TYPE_CHECKING:
    from propmap.vehicle.vehicle import Vehicle


def mounted_rotors(vehicle: Vehicle, model: Model) -> list[tuple[Model, NDArray[np.intp]]]:
    """Each model that some of the rotors have, and their indices.

    Parameters
    ----------
    vehicle : Vehicle
        Tells what its rotors are mounted on.
    model : Model
        Of a rotor of which it tells nothing.
    """
    drags = [mount.drag for mount in vehicle.mounts]
    return [
        (
            model if drag is None else model.with_mount(drag),
            np.array([k for k, other in enumerate(drags) if other == drag]),
        )
        for drag in dict.fromkeys(drags)
    ]
