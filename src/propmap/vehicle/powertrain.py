"""From shaft power to the battery: motor, speed controller and battery together."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from propmap.errors import InputError
from propmap.typing import Floats
from propmap.vehicle.battery import Battery
from propmap.vehicle.motor import RPM, Motor
from propmap.vehicle.speed_controller import SpeedController

USUAL_TIP_SPEED = (60.0, 900.0)
"""[m/s] of a blade on an unloaded motor at full charge.  A Kv in rad/s/V read as rpm/V is a tenth
of what it should be, one in rpm/V read as rad/s/V ten times as much."""


class ElectricState(NamedTuple):
    """What n states of m motors take; NaN where a part of the powertrain is not known.

    Attributes
    ----------
    motor_current, controller_voltage : ndarray, shape (n, m)
        [A]; the battery voltage that just drives the motor so [V].
    power : ndarray, shape (n,)
        At the battery's terminals [W].
    battery_current, battery_voltage : ndarray, shape (n,)
        [A], [V].
    """

    motor_current: Floats
    controller_voltage: Floats
    power: Floats
    battery_current: Floats
    battery_voltage: Floats


@dataclass(frozen=True)
class Powertrain:
    """What turns the rotors; None for what is not known.

    Attributes
    ----------
    motor : Motor or None
        Of every rotor.
    controller : SpeedController or None
        Of every motor; without one nothing is lost there.
    battery : Battery or None
        Of all.

    Raises
    ------
    InputError
        For a battery or a controller without a motor.
    """

    motor: Motor | None = None
    controller: SpeedController | None = None
    battery: Battery | None = None

    def __post_init__(self) -> None:
        if self.motor is None and (self.battery or self.controller):
            has = "[battery]" if self.battery else "[esc]"
            raise InputError(
                f"there is {has} and no [motor]",
                f"add [motor], or remove {has}: without a motor only shaft power is known",
            )

    def check_blade(self, radius: float) -> None:
        """Refuse a Kv that cannot be, for a blade of this ``radius`` [m] on this battery."""
        if self.motor is None or self.battery is None:
            return
        kv = self.motor.speed_constant
        full = float(self.battery.open_circuit_voltage(np.ones(())))
        tip = kv * full * radius
        low, high = USUAL_TIP_SPEED
        if not low <= tip <= high:
            unit = "in rad/s/V? multiply by 9.549" if tip < low else "of another motor?"
            raise InputError(
                f"kv_rpm_per_volt is {kv / RPM:g}: unloaded at {full:.1f} V the blade's tip would "
                f"move at {tip:.0f} m/s",
                f"check kv ({unit}), cells, and the propeller's size",
            )

    def driven(self, torque: Floats, omega: Floats, charge: float) -> ElectricState:
        """Currents, voltages and power of n states.

        Parameters
        ----------
        torque, omega : ndarray, shape (n, m)
            Of the shafts [N m], [rad/s].
        charge : float
            State of charge, 0 to 1.
        """
        nothing = np.full(torque.shape[:1], math.nan)
        if self.motor is None:
            unknown = np.full_like(torque, math.nan)
            return ElectricState(unknown, unknown, nothing, nothing, nothing)
        controller = self.controller or SpeedController()
        state = self.motor.driven(torque, omega)
        power = controller.power(state).sum(axis=1)
        voltage = controller.voltage(state)
        if self.battery is None:
            return ElectricState(state.current, voltage, power, nothing, nothing)
        power = power + self.battery.auxiliary_power
        full = np.full_like(power, charge)
        return ElectricState(
            state.current,
            voltage,
            power,
            self.battery.current(power, full),
            self.battery.voltage(power, full),
        )
