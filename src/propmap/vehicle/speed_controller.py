"""An electronic speed controller: what it loses between battery and motor."""

from __future__ import annotations

from dataclasses import dataclass

from propmap.errors import InputError
from propmap.typing import Floats
from propmap.vehicle.motor import MotorState


@dataclass(frozen=True)
class SpeedController:
    """A resistance in series with the motor, or an efficiency.

    As a chopper it takes the motor's power from the battery at the battery's voltage.  That its
    efficiency falls at part throttle is left out: see C. R. Green, R. A. McDonald, Modeling and
    Test of the Efficiency of Electronic Speed Controllers for Brushless DC Motors, AIAA 2015-3191,
    doi 10.2514/6.2015-3191.

    Attributes
    ----------
    resistance : float
        [ohm], at full throttle.
    efficiency : float
        Motor power over battery power besides [-].

    Raises
    ------
    InputError
        For a negative resistance, and an efficiency that is none.
    """

    resistance: float = 0.0
    efficiency: float = 1.0

    def __post_init__(self) -> None:
        if not self.resistance >= 0.0:
            raise InputError(f"resistance is {self.resistance:g} ohm", "give 0 or more")
        if not 0.5 <= self.efficiency <= 1.0:
            raise InputError(
                f"efficiency is {self.efficiency:g}", "give a share from 0.5 to 1, such as 0.95"
            )

    def power(self, motor: MotorState) -> Floats:
        """What is taken from the battery for a ``motor`` in this state [W]."""
        return (motor.power + self.resistance * motor.current**2) / self.efficiency

    def voltage(self, motor: MotorState) -> Floats:
        """Of a battery that just keeps a ``motor`` in this state, at full throttle [V]."""
        return motor.voltage + self.resistance * motor.current
