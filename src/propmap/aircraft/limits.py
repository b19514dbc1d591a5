"""What limits rotors, motors and battery, and how much of each limit a state uses."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from propmap.errors import InputError
from propmap.model.usual_ranges import FAST_TIP_MACH, SPEED_OF_SOUND
from propmap.typing import Floats
from propmap.vehicle.powertrain import ElectricState, Powertrain

LIMITS = {
    "rpm_limit": "the rotors' largest speed",
    "tip_speed_limit": f"a blade tip at Mach {FAST_TIP_MACH:g}, where the model ends",
    "motor_current_limit": "the motors' largest current",
    "voltage_limit": "full throttle: the battery's voltage",
    "battery_limit": "the battery's largest current or power",
}
"""Statuses of states beyond a limit, and the limit in words."""


@dataclass(frozen=True)
class Limits:
    """What n states of k rotors may not exceed.

    Attributes
    ----------
    powertrain : Powertrain
        Motors and battery.
    rotor_speed : float
        Largest speed of a rotor [rad/s], infinite where none is known.
    charge : float
        State of charge, 0 to 1, at which the battery's voltage is taken.

    Raises
    ------
    InputError
        For a charge beyond 0 to 1, and a speed that is not positive.
    """

    powertrain: Powertrain
    rotor_speed: float = math.inf
    charge: float = 1.0

    def __post_init__(self) -> None:
        if not self.rotor_speed > 0.0:
            raise InputError(f"the rotors' largest speed is {self.rotor_speed:g}", "give rad/s")
        if not 0.0 < self.charge <= 1.0:
            raise InputError(f"charge is {self.charge:g}", "give a share, 1 for a full battery")

    def used(self, omega: Floats, tip_speed: Floats, electric: ElectricState) -> dict[str, Floats]:
        """Share of each limit that is used, 1 at the limit.

        Parameters
        ----------
        omega, tip_speed : ndarray, shape (n, k)
            Of the rotors [rad/s], of their advancing tips through the air [m/s].
        electric : ElectricState
            What the powertrain takes.

        Returns
        -------
        dict of str to ndarray, shape (n,)
            By the keys of ``LIMITS``; zero where nothing is known of a limit.
        """
        motor, battery = self.powertrain.motor, self.powertrain.battery
        nothing = np.zeros(omega.shape[0])
        largest = min(self.rotor_speed, motor.maximum_speed if motor else math.inf)
        found = {
            "rpm_limit": omega.max(axis=1) / largest,
            "tip_speed_limit": tip_speed.max(axis=1) / (FAST_TIP_MACH * SPEED_OF_SOUND),
            "motor_current_limit": nothing,
            "voltage_limit": nothing,
            "battery_limit": nothing,
        }
        if motor is not None:
            found["motor_current_limit"] = (
                electric.motor_current.max(axis=1) / motor.maximum_current
            )
        if battery is not None:
            there = battery.voltage_or_least(electric.power, np.full_like(nothing, self.charge))
            found["voltage_limit"] = electric.controller_voltage.max(axis=1) / there
            found["battery_limit"] = battery.share_used(
                electric.power, np.full_like(nothing, self.charge)
            )
        return found
