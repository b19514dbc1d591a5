"""Loads at rest, the curve of thrust by the signal, and the factor that autopilots make of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from propmap.aircraft.trim import Aircraft
from propmap.export.inplane_drag import load_errors, rotor_sources
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import RPM
from propmap.vehicle.powertrain import Motor

# -------------------------------------------------------------------------------------------------
# A vehicle's rotors at rest, with the errors of their loads.


@dataclass(frozen=True, eq=False)
class StaticLoads:
    """Thrust and torque of the mean rotor at rest."""

    thrust: float  # [N]
    torque: float  # [N m]
    errors: Floats  # what each of E independent causes adds to them at one deviation (E, 2)

    def std_of(self, by_thrust: float, by_torque: float) -> float | None:
        """Return the deviation of what has these derivatives; None where none is known."""
        if not self.errors.size:
            return None
        return float(np.linalg.norm(self.errors @ [by_thrust, by_torque]))


def static_loads(aircraft: Aircraft, omega: float) -> StaticLoads:
    """Average the loads at rest of an ``aircraft``'s rotors at ``omega`` [rad/s]."""
    count, parts = len(aircraft.vehicle.mounts), []
    for source, mine in rotor_sources(aircraft.vehicle, aircraft.loads):
        found = load_errors(source, np.array([omega]), np.zeros((1, 3)))
        share = mine.size / count
        parts.append((share * found.loads[[0, 2], 0], share * found.errors[:, [0, 2], 0]))
    loads, errors = (np.sum(each, axis=0) for each in zip(*parts, strict=True))
    return StaticLoads(float(loads[0]), float(loads[1]), errors)


# -------------------------------------------------------------------------------------------------
# Static thrust by the signal to the speed controller, from motor, controller and battery.
#
# The signal is the share of the battery's voltage that the controller passes on, as in
# ``propmap.vehicle.powertrain``; all rotors get the same, and the battery sags under all of them.

KNOTS = 12  # rotor speeds at which loads at rest over their square are computed; they vary slowly
SPEEDS = 2000  # rotor speeds at which the signal is computed


@dataclass(frozen=True, eq=False)
class SignalCurve:
    """Thrust of a rotor at rest by the signal, rising from 0 to 1."""

    signal: Floats  # (n,)
    thrust: Floats  # the mean of the rotors (n,) [N]
    full_thrust: float  # at the signal 1 [N]
    full_torque: float  # [N m]
    full_speed: float  # [rad/s]
    full_current: float  # of a motor [A]

    def at(self, signal: Floats) -> Floats:
        """Return the thrust [N] at ``signal``."""
        return np.asarray(np.interp(signal, self.signal, self.thrust))

    def full_signal(self, motor: Motor | None) -> str:
        """Say what the full signal asks of a ``motor``."""
        rpm = self.full_speed / RPM
        words = f"At rest, full signal: {rpm:.0f} rpm, {self.full_current:.3g} A per motor."
        if motor is not None and self.full_current > motor.maximum_current:
            words += f" That is above the motor's {motor.maximum_current:g} A."
        if motor is not None and self.full_speed > motor.maximum_speed:
            words += f" That is above the motor's {motor.maximum_speed / RPM:.0f} rpm."
        return words


def known_curve(aircraft: Aircraft) -> tuple[SignalCurve | None, str]:
    """Return the curve of an ``aircraft`` at its state of charge, or why there is none."""
    powertrain = aircraft.vehicle.powertrain
    missing = [
        name
        for name, part in (("[motor]", powertrain.motor), ("[battery]", powertrain.battery))
        if part is None
    ]
    if missing:
        return None, f"the vehicle file has no {' and no '.join(missing)}"
    curve = thrust_curve(aircraft, aircraft.charge)
    if curve is None:
        return None, "the battery cannot deliver the power of full throttle"
    if not isinstance(aircraft.loads, Rotor):
        fastest = aircraft.loads.envelope["omega"][1]
        if curve.full_speed > fastest:
            return None, (
                f"the table ends at {fastest / RPM:.0f} rpm, and full throttle is "
                f"{curve.full_speed / RPM:.0f}"
            )
    return curve, ""


def thrust_curve(aircraft: Aircraft, charge: float, more_torque: float = 0.0) -> SignalCurve | None:
    """Find the curve of a vehicle with motor and battery at a ``charge`` 0 to 1, None where it does
    not reach signal 1; ``more_torque`` is a share added to the model's."""
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
    full = (
        float(np.interp(1.0, signal[upto], values[upto]))
        for values in (lift, turn, omega, state.motor_current[:, 0])
    )
    # Below the signal that overcomes the motor's own friction there is no thrust.
    rising, lifting = (np.concatenate([[0.0], values[upto]]) for values in (signal, lift))
    return SignalCurve(rising, lifting, *full)


def _over_square(aircraft: Aircraft, fastest: float) -> tuple[Floats, Floats, Floats]:
    """Return rotor speeds, and mean thrust and torque at rest over their square there."""
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


# -------------------------------------------------------------------------------------------------
# The one number by which an autopilot describes a thrust curve, and how sure it is.

DISCHARGED = 0.3  # state of charge besides the given one for which factors are stated

Shares = Callable[[Callable[[Floats], Floats]], Floats]
"""Makes of a curve, thrust by signal, its thrust over the largest at equally spaced x (n,)."""


@dataclass(frozen=True)
class CurveFactor:
    """A curve as f x^2 + (1 - f) x, thrust over the largest and x from 0 to 1."""

    factor: float  # f [-]
    worst: float  # largest difference from the curve, over the largest thrust [-]
    std: float | None  # deviation of f by that of the torque [-]; None where it is not known
    charge: float  # state of charge of the battery
    discharged: float  # f at the charge ``DISCHARGED``; NaN where there is no full throttle then

    @property
    def holds(self) -> str:
        """Say what it is good for."""
        here = (
            f"At rest, battery at {self.charge:.0%}: within {self.worst:.1%} of the largest thrust."
        )
        if np.isfinite(self.discharged):
            return f"{here} At {DISCHARGED:.0%} it would be {self.discharged:.3f}."
        return f"{here} At {DISCHARGED:.0%} the battery does not deliver full throttle."


def curve_factor(
    aircraft: Aircraft,
    curve: SignalCurve,
    still: StaticLoads,
    shares: Shares,
    limits: tuple[float, float],
) -> CurveFactor:
    """Fit f, within ``limits``, to the ``curve`` of an aircraft, whose loads at rest are ``still``;
    ``shares`` are what the autopilot takes as x."""
    charge = aircraft.charge

    def factor(found: SignalCurve | None) -> float:
        return float("nan") if found is None else fitted_factor(shares(found.at), limits)

    here, share = factor(curve), shares(curve.at)
    spread = still.std_of(0.0, 1.0 / still.torque)
    more = None if spread is None else factor(thrust_curve(aircraft, charge, spread))
    x = np.linspace(0.0, 1.0, share.size)
    return CurveFactor(
        factor=here,
        worst=float(np.abs(x + here * (x**2 - x) - share).max()),
        std=None if more is None else abs(more - here),
        charge=charge,
        discharged=factor(thrust_curve(aircraft, DISCHARGED)),
    )


def fitted_factor(share: Floats, limits: tuple[float, float]) -> float:
    """Fit f within its ``limits`` to thrusts over the largest, ``share`` (n,)."""
    x = np.linspace(0.0, 1.0, share.size)
    bent = x**2 - x
    return float(np.clip(np.sum((share - x) * bent) / np.sum(bent**2), *limits))
