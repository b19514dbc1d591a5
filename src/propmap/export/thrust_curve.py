"""Static thrust by the signal to the speed controller, from motor, controller and battery.

The signal is the share of the battery's voltage that the controller passes on, as in
``propmap.vehicle.powertrain``; all rotors get the same, and the battery sags under all of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.aircraft.steady import Aircraft
from propmap.export.load_errors import rotor_sources
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.vehicle.motor import RPM, Motor

KNOTS = 12
"""Rotor speeds at which loads at rest over their square are computed; they vary slowly."""

SPEEDS = 2000
"""Rotor speeds at which the signal is computed."""


@dataclass(frozen=True, eq=False)
class ThrustCurve:
    """Thrust of a rotor at rest.

    Attributes
    ----------
    signal, thrust : ndarray, shape (n,)
        Rising from 0 to 1; the mean of the rotors [N].
    full_thrust, full_torque, full_speed, full_current : float
        At the signal 1 [N], [N m], [rad/s], [A] of a motor.
    """

    signal: Floats
    thrust: Floats
    full_thrust: float
    full_torque: float
    full_speed: float
    full_current: float

    def at(self, signal: Floats) -> Floats:
        """Thrust [N] at ``signal``."""
        return np.asarray(np.interp(signal, self.signal, self.thrust))

    def full_signal(self, motor: Motor | None) -> str:
        """What the full signal asks of a ``motor``, in words."""
        rpm = self.full_speed / RPM
        told = f"At rest, full signal: {rpm:.0f} rpm, {self.full_current:.3g} A per motor."
        if motor is not None and self.full_current > motor.maximum_current:
            told += f" That is above the motor's {motor.maximum_current:g} A."
        if motor is not None and self.full_speed > motor.maximum_speed:
            told += f" That is above the motor's {motor.maximum_speed / RPM:.0f} rpm."
        return told


def known_curve(aircraft: Aircraft) -> tuple[ThrustCurve | None, str]:
    """The curve of an ``aircraft`` at its state of charge, or why there is none."""
    powertrain = aircraft.vehicle.powertrain
    missing = [
        name
        for name, part in (("[motor]", powertrain.motor), ("[battery]", powertrain.battery))
        if part is None
    ]
    if missing:
        return None, f"the vehicle file has no {' and no '.join(missing)}"
    curve = thrust_curve(aircraft, aircraft.limits.charge)
    if curve is None:
        return None, "the battery cannot deliver the power of full throttle"
    if not isinstance(aircraft.loads, Rotor):
        fastest = aircraft.loads.envelope["omega"][1]
        if curve.full_speed > fastest:
            return None, (
                f"the map ends at {fastest / RPM:.0f} rpm, and full throttle is "
                f"{curve.full_speed / RPM:.0f}"
            )
    return curve, ""


def thrust_curve(aircraft: Aircraft, charge: float, more_torque: float = 0.0) -> ThrustCurve | None:
    """The curve of a vehicle with motor and battery; None where it does not reach the signal 1.

    Parameters
    ----------
    aircraft : Aircraft
        The vehicle and the loads of its rotors.
    charge : float
        State of charge, 0 to 1.
    more_torque : float
        Share by which the torque is larger than the model's, to see what its error does [-].
    """
    powertrain, count = aircraft.vehicle.powertrain, len(aircraft.vehicle.mounts)
    motor, battery = powertrain.motor, powertrain.battery
    assert motor is not None and battery is not None
    unloaded = motor.speed_constant * float(battery.open_circuit_voltage(np.array(charge)))
    knots, thrust, torque = _over_square(aircraft, unloaded)
    omega = np.linspace(0.0, unloaded, SPEEDS)
    lift = np.interp(omega, knots, thrust) * omega**2
    turn = np.interp(omega, knots, torque) * omega**2 * (1.0 + more_torque)
    each = np.repeat(turn[:, None], count, axis=1), np.repeat(omega[:, None], count, axis=1)
    state = powertrain.driven(*each, charge)
    signal = state.controller_voltage[:, 0] / state.battery_voltage
    beyond = np.flatnonzero(~(signal < 1.0))
    if not beyond.size or np.isnan(signal[beyond[0]]):
        return None
    upto = slice(0, int(beyond[0]) + 1)
    signal, lift = signal[upto], lift[upto]

    def full(values: Floats) -> float:
        return float(np.interp(1.0, signal, values[upto]))

    # Below the signal that overcomes the motor's own friction there is no thrust.
    risen = np.concatenate([[0.0], signal])
    return ThrustCurve(
        signal=risen,
        thrust=np.concatenate([[0.0], lift]),
        full_thrust=float(np.interp(1.0, signal, lift)),
        full_torque=full(turn),
        full_speed=full(omega),
        full_current=full(state.motor_current[:, 0]),
    )


def _over_square(aircraft: Aircraft, fastest: float) -> tuple[Floats, Floats, Floats]:
    """Rotor speeds, and mean thrust and torque at rest over their square there."""
    omega = np.linspace(0.1, 1.0, KNOTS) * fastest
    if not isinstance(aircraft.loads, Rotor):
        low, high = aircraft.loads.envelope["omega"]
        omega = np.linspace(low, min(high, fastest), KNOTS)
    thrust, torque = np.zeros(KNOTS), np.zeros(KNOTS)
    for source, mine in rotor_sources(aircraft.vehicle, aircraft.loads):
        found = source.loads(omega, 0.0, 0.0)
        thrust += mine.size * found.thrust
        torque += mine.size * found.torque
    count = len(aircraft.vehicle.mounts)
    return omega, thrust / omega**2 / count, torque / omega**2 / count
