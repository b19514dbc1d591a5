"""Rotor speeds from motor commands, for logs without measured rotor speeds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from propmap.errors import InputError
from propmap.hover import HoverModel
from propmap.model.airfoil import parameter_set
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.vehicle import Vehicle

# --- Conversion of logged commands to fractions of full throttle ---------------------------------

BEYOND, MOST_BEYOND = 0.05, 0.05
"""Tolerance of the command range, as a fraction of it, and largest fraction of samples outside."""

PULSES = (1000.0, 2000.0)
"""Common range of pulses to motor controllers [us]."""


def share_of_full(commands: Floats, limits: tuple[float, float], name: str) -> Floats:
    """Return commands (n, m) as fractions of full throttle, from 0 to 1, by their two ``limits``.

    NaN is the command of a motor that is not armed, and counts as 0.  Raises ``InputError`` for
    commands outside their range, and for commands that never change.
    """
    low, high = limits
    share = np.nan_to_num((commands - low) / (high - low))
    outside = np.any((share < -BEYOND) | (share > 1.0 + BEYOND), axis=1)
    if np.mean(outside) > MOST_BEYOND:
        ends = np.nanmin(commands), np.nanmax(commands)
        raise InputError(
            f"{name} is between {ends[0]:.4g} and {ends[1]:.4g}, outside its range of {low:g} to "
            f"{high:g}",
            "write throttle_range = [at rest, at full throttle] in [log], such as [1000, 2000] for "
            "pulses, [48, 2047] for Betaflight, or [0, 1]",
        )
    if not np.ptp(share, axis=0).any():
        remedy = "give a flight with armed motors, and the columns or topics of the motor commands"
        raise InputError(f"{name} never changes ({commands.flat[0]:.4g})", remedy)
    return np.clip(share, 0.0, 1.0)


def worth_of_throttle(values: Floats, name: str, *, inverse: bool) -> Floats:
    """Return the scale of the throttle (n, 1): the values of a voltage, or their ``inverse`` for
    the throttle in hover.

    Values that are not above zero give NaN.  Raises ``InputError`` if too many are not above zero.
    """
    known = values > 0.0
    if np.mean(known) < 1.0 - MOST_BEYOND:
        raise InputError(
            f"{name} is above 0 in only {100.0 * np.mean(known):.0f} % of its samples",
            "give the correct column, or remove it to assume that the battery is always full",
        )
    found = np.where(known, values, np.nan)
    return 1.0 / found if inverse else found


# -------------------------------------------------------------------------------------------------
# The curve from throttle to rotor speed, with two constants and the lag of the motors.
#
# docs/theory.md, "Throttle in place of rotor speeds", contains the equation.  The drive of a motor
# is its throttle times the scale ``Recording.supply``.

SPEED, EXPO, LAG = CURVE = ("throttle_speed", "throttle_expo", "motor_lag")
USUAL = {SPEED: 1.0, EXPO: 0.5, LAG: 0.05}
"""Default constants of the curve: k [-], e [-], lag [s]; starting point of a fit."""

HOVER_DRIVE = "hover_drive"
LEAST = 1e-4  # lower limit of the squared rotor speed relative to hover


@dataclass(frozen=True)
class ThrottleCurve:
    """Curve from throttle to the rotor speeds of a vehicle."""

    hover_speed: float  # Omega_h [rad/s]
    hover_drive: float  # drive of the motors in hover, in the unit of ``FlightLog.throttle``
    constants: Mapping[str, float]  # by the names of ``CURVE``

    @classmethod
    def of(cls, vehicle: Vehicle, values: Mapping[str, float]) -> ThrottleCurve:
        """Return the curve of a ``vehicle`` with constants from ``values``, or the defaults."""
        nominal = Model(vehicle.propeller, parameter_set("paper-apc"), vehicle.air)
        lift = HoverModel.from_rotor(Rotor(nominal)).k_thrust * abs(
            float(vehicle.rotor_axes[:, 2].sum())
        )
        constants = {name: values.get(name, usual) for name, usual in USUAL.items()}
        speed = math.sqrt(vehicle.mass * GRAVITY / lift)
        return cls(speed, values[HOVER_DRIVE], constants)

    def speeds(
        self, throttle: Floats, by_lag: Floats, measured: Floats
    ) -> tuple[Floats, dict[str, Floats]]:
        """Return rotor speeds (n, m) [rad/s] and their derivatives with respect to the constants.

        ``throttle`` and its derivative ``by_lag`` are those of a ``FlightLog``.  Samples without
        throttle have the ``measured`` speeds.
        """
        gain, expo, lag = (self.constants[name] for name in CURVE)
        known = np.isfinite(throttle)
        drive = np.where(known, throttle + (lag - USUAL[LAG]) * by_lag, 1.0) / self.hover_drive
        square = (1.0 - expo) * drive + expo * drive**2
        root = np.sqrt(np.maximum(square, LEAST))
        by_square = 0.5 * gain * self.hover_speed / root
        by_square = np.where(known & (square > LEAST), by_square, 0.0)
        by_drive = by_square * (1.0 - expo + 2.0 * expo * drive)
        speed = np.where(known, gain * self.hover_speed * root, measured)
        return speed, {
            SPEED: np.where(known, self.hover_speed * root, 0.0),
            EXPO: by_square * (drive**2 - drive),
            LAG: by_drive * np.where(known, by_lag, 0.0) / self.hover_drive,
        }


def lagged(values: Floats, step: float) -> tuple[Floats, Floats]:
    """Return lagged values (n, m) every ``step`` [s], and derivatives with respect to the lag.

    The lag is the default.  Values are assumed to change linearly between samples.
    """
    from scipy.signal import lfilter

    lag = USUAL[LAG]
    kept = math.exp(-step / lag)
    entered = (1.0 - kept) * lag / step
    ways = [1.0 - entered, entered - kept], [1.0, -kept]

    def after(signal: Floats) -> Floats:
        steady = (kept + ways[0][1]) * signal[:1]
        return np.asarray(lfilter(*ways, signal, axis=0, zi=steady)[0])

    once = after(values)
    return once, (after(once) - once) / lag
