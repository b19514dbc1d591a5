"""When a vehicle is in the air."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propmap.vehicle.flight_log import FlightLog

MOVING = 1.0
"""[m/s] above which a vehicle is certainly not on the ground."""

IDLE = 0.3
"""Share of the usual thrust below which the rotors do not carry the vehicle."""


def airborne(log: FlightLog) -> NDArray[np.bool_]:
    """Samples in which the rotors carry the vehicle; (n,).

    Rotors on the ground stand still or idle; the sum of the squared speeds, to which the thrust
    is proportional, is then far below its median in motion (without motion, its 90th percentile
    counts).  The unit of the speeds, which may be wrong, does not matter.
    """
    squares = np.sum(np.square(log.rotor_speed), axis=1)
    moving = log.speed > MOVING
    usual = np.median(squares[moving]) if moving.any() else np.percentile(squares, 90.0)
    return np.asarray((squares > IDLE * usual) & (squares > 0.0))
