"""Rotor speeds from throttle, where a log has commands to the motors and no measured speeds."""

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

# -------------------------------------------------------------------------------------------------
# Commands as logs have them, as shares of full throttle.

BEYOND, MOST_BEYOND = 0.05, 0.05
"""Share of its range by which a command may leave it, and share of the samples that may by more."""

PULSES = (1000.0, 2000.0)
"""Usual range of pulses to motor controllers [us]."""


def share_of_full(commands: Floats, limits: tuple[float, float], name: str) -> Floats:
    """Return commands (n, m) as shares of full throttle, from 0 to 1, by their two ``limits``.

    A command that is no number is that of a motor that is not armed.  Raises ``InputError`` for
    commands that leave their range, and for those that never change.
    """
    low, high = limits
    share = np.nan_to_num((commands - low) / (high - low))
    outside = np.any((share < -BEYOND) | (share > 1.0 + BEYOND), axis=1)
    if np.mean(outside) > MOST_BEYOND:
        ends = np.nanmin(commands), np.nanmax(commands)
        raise InputError(
            f"{name} goes from {ends[0]:.4g} to {ends[1]:.4g}, outside its range of {low:g} to "
            f"{high:g}",
            "write throttle_range = [at rest, at full throttle] in [log], such as [1000, 2000] for "
            "pulses, [48, 2047] for Betaflight, [0, 1]",
        )
    if not np.ptp(share, axis=0).any():
        remedy = "give a flight in which the motors were armed, and name the commands to them"
        raise InputError(f"{name} never changes ({commands.flat[0]:.4g})", remedy)
    return np.clip(share, 0.0, 1.0)


def worth_of_throttle(values: Floats, name: str, *, inverse: bool) -> Floats:
    """Return what a share of full throttle is worth (n, 1), by a voltage or, ``inverse``, by hover.

    What is not above zero is NaN.  Raises ``InputError`` where most of it is not.
    """
    known = values > 0.0
    if np.mean(known) < 1.0 - MOST_BEYOND:
        raise InputError(
            f"{name} is above 0 in {100.0 * np.mean(known):.0f} % of its samples",
            "name the column of the voltage, or leave it out, as if the battery were always full",
        )
    found = np.where(known, values, np.nan)
    return 1.0 / found if inverse else found


# -------------------------------------------------------------------------------------------------
# From throttle to rotor speed: a curve of two constants and the lag of the motors.
#
# Where d is what drives a motor, its throttle times what that is worth (``Recording.supply``), over
# the same in hover,
#
#     Omega^2 = k^2 Omega_h^2 ((1 - e) d + e d^2) ,
#
# the form by which ArduPilot (MOT_THST_EXPO) and PX4 (THR_MDL_FAC) take thrust for a mix of the
# throttle and its square.  Omega_h only makes k a number near 1: with a nominal section law the
# rotors carry the weight at it.  The motor follows d with a lag of first order.

SPEED, EXPO, LAG = CURVE = ("throttle_speed", "throttle_expo", "motor_lag")
USUAL = {SPEED: 1.0, EXPO: 0.5, LAG: 0.05}
"""Constants of the curve before a fit: k [-], e [-], the lag [s]."""

HOVER_DRIVE = "hover_drive"
LEAST = 1e-4  # square of a rotor speed over that in hover, at least


@dataclass(frozen=True)
class ThrottleCurve:
    """Rotor speeds of a vehicle by its throttle."""

    hover_speed: float  # Omega_h [rad/s]
    hover_drive: float  # what drives the motors in hover, in the unit of ``FlightLog.throttle``
    constants: Mapping[str, float]  # by the names of ``CURVE``

    @classmethod
    def of(cls, vehicle: Vehicle, values: Mapping[str, float]) -> ThrottleCurve:
        """Take the constants from ``values``, those that are not there as is usual."""
        nominal = Model(vehicle.propeller, parameter_set("paper-apc"), vehicle.air)
        lift = HoverModel.of(Rotor(nominal)).k_thrust * abs(float(vehicle.rotor_axes[:, 2].sum()))
        constants = {name: values.get(name, usual) for name, usual in USUAL.items()}
        speed = math.sqrt(vehicle.mass * GRAVITY / lift)
        return cls(speed, values[HOVER_DRIVE], constants)

    def speeds(
        self, throttle: Floats, by_lag: Floats, measured: Floats
    ) -> tuple[Floats, dict[str, Floats]]:
        """Return rotor speeds (n, m) [rad/s] and their derivatives by the constants.

        ``throttle`` and its derivative ``by_lag`` are those of a ``FlightLog``; where there is no
        throttle, speeds are those ``measured``.
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
    """Return values (n, m), every ``step`` [s], after the usual lag, and the derivatives by it.

    Between samples they are taken to change linearly.
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
