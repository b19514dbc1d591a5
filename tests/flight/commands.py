"""Commands to motors that turn as a flight has it, by a curve and a lag of their own.

They share no code with ``propmap.vehicle.throttle``, whose curve is another mixture of the throttle
and its square: here d = ((1 - b) w + b w^2) U / V, w the rotor speed over that in hover, as a motor
with a resistance on a battery that sags has it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.typing import Floats
from propmap.vehicle.log import FlightLog

SQUARE, IN_HOVER, LAG = 0.25, 0.42, 0.04
"""b [-], d in hover at the battery's first voltage [-], and the motors' lag [s]."""

FULL, EMPTY = 16.6, 15.4
"""Voltage at the start and at the end [V]."""


@dataclass(frozen=True, eq=False)
class Commands:
    """Shares of full throttle (n, rotors) and the battery's voltage (n,) [V]."""

    share: Floats
    voltage: Floats


def commands(log: FlightLog, noise: float = 0.0) -> Commands:
    """What drives the motors of a log, whose first sample hovers, with noise as a share."""
    ratio = log.rotor_speed / np.mean(log.rotor_speed[0])
    earlier = ratio + LAG * np.gradient(ratio, log.time, axis=0)
    drive = (1.0 - SQUARE) * earlier + SQUARE * earlier**2
    voltage = np.linspace(FULL, EMPTY, log.time.size)
    share = IN_HOVER * drive * (FULL / voltage)[:, None]
    rng = np.random.default_rng(4)
    return Commands(share * (1.0 + noise * rng.standard_normal(share.shape)), voltage)
