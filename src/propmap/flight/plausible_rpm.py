"""Whether the rotor speeds of a log can carry the vehicle: unit errors show in hover."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from propmap.baselines.hover import HoverModel
from propmap.errors import InputError
from propmap.flight.steady import airborne
from propmap.vehicle.log import GRAVITY, FlightLog
from propmap.vehicle.powertrain import RPM
from propmap.vehicle.vehicle import Vehicle

if TYPE_CHECKING:
    from propmap.rotor import Rotor

SLOW = 3.0
"""Speed [m/s] below which the hover model serves."""

QUIET = 0.1
"""Share of g by which the specific force may differ from it."""

FEWEST_SLOW = 20
"""Samples of slow flight, below which there is too little of it."""

NEAR_RPM = 0.25
NEAR_POLE_PAIRS = 0.1
"""Relative differences of a speed ratio from that of a unit error.  A nominal section law and
a roughly known blade give the thrust to about 50 %, the speed to 25 %; several numbers of pole
pairs then fit and the nearest is named, but few pairs must fit closely, as 2 is near 1."""

POLE_PAIRS = range(2, 15)
DOUBTFUL = 2.5
"""Factor of the thrust above which a warning is due."""

GRAMS = 1000.0
"""In a kilogram."""


def check_rotor_speed(
    log: FlightLog, rotor: Rotor, vehicle: Vehicle, rotor_unit: str | None = None
) -> list[str]:
    """Compare the thrust that the rotor speeds give in slow flight with the weight.

    Slow flight is below 3 m/s with a specific force within 10 % of g; where there is too little
    of it, the slowest tenth of the flight serves.  Time on the ground does not count.

    Parameters
    ----------
    log, vehicle : FlightLog, Vehicle
        What was flown.
    rotor : Rotor
        The vehicle's propeller with a nominal section law.
    rotor_unit : str, optional
        What the vehicle file states: "rad/s", "rpm" or "erpm"; tells apart errors of like size.

    Returns
    -------
    list of str
        Warnings.

    Raises
    ------
    InputError
        Where a rotor stands still or the ratio of the forces is that of a wrong unit, of the speeds
        or of the mass.
    """
    for k, column in enumerate(log.rotor_speed.T, start=1):
        if not np.max(column) > 0.0:
            raise InputError(
                f"rotor {k} stands still in the whole log (0 rad/s)",
                "check rotor_speed and rotor_order in [log] of the vehicle file, and that the "
                "motor controllers report their speed",
                log.source,
            )
    chosen = log.picked(slow_flight(log))
    share = _thrust_share(chosen, rotor, vehicle)
    found = (
        f"in slow flight the rotors would carry {share:.3g} times the weight "
        f"at {float(np.mean(chosen.rotor_speed)) / RPM:.0f} rpm"
    )
    slip = _unit_slip(math.sqrt(share), rotor_unit)
    if slip is not None:
        cause, line = slip
        raise InputError(f"{found}: {cause}", f"{line} in [log] of the vehicle file", log.source)
    if 1.0 / DOUBTFUL <= share <= DOUBTFUL:
        return []
    if 1.0 / DOUBTFUL <= GRAMS * share <= DOUBTFUL:
        raise InputError(
            f"{found}: the mass of {vehicle.mass:g} kg looks like grams",
            "write kilograms in the vehicle file",
            log.source,
        )
    return [f"{log.source}: {found}; check mass, propeller, air density and the rotor speeds"]


def slow_flight(log: FlightLog) -> NDArray[np.bool_]:
    """Samples (n,) of slow and quiet flight, else the slowest tenth of the ``log``."""
    flying = airborne(log)
    force = np.linalg.norm(log.specific_force, axis=1)
    quiet = np.isnan(force) | (np.abs(force / GRAVITY - 1.0) < QUIET)
    slow = flying & quiet & (log.speed < SLOW)
    if int(slow.sum()) >= FEWEST_SLOW:
        return slow
    return np.asarray(flying & (log.speed <= np.percentile(log.speed[flying], 10.0)))


def _thrust_share(log: FlightLog, rotor: Rotor, vehicle: Vehicle) -> float:
    """Mean force of the rotors along the vehicle's z axis over the force that it takes."""
    up = np.mean(log.up[:, 2])
    measured = np.mean(log.specific_force[:, 2])
    needed = vehicle.mass * (GRAVITY / up if np.isnan(measured) else measured)
    k_thrust = HoverModel.of(rotor).k_thrust
    axes = np.array([mount.axis[2] for mount in vehicle.mounts])
    force = k_thrust * float(np.mean(np.square(log.rotor_speed) @ axes))
    if not (needed > 0.0 and force > 0.0):
        raise InputError(
            f"slow flight takes {needed:.3g} N along the vehicle's z axis, of rotors that give "
            f"{force:.3g} N",
            "check body_frame, world_frame and the axes of the rotors in the vehicle file",
            log.source,
        )
    return float(force / needed)


def _unit_slip(ratio: float, unit: str | None) -> tuple[str, str] | None:
    """The unit error that explains speeds wrong by the factor ``ratio``: cause and line."""
    if unit == "erpm":
        if _pole_pairs(1.0 / ratio):
            cause = "they look like mechanical rpm, divided by pole_pairs for nothing"
            return cause, 'write rotor_unit = "rpm", or correct pole_pairs'
        pairs = _pole_pairs(ratio)
        cause = f"they look as if divided by too few pole pairs, by a factor of about {pairs}"
        return (cause, "correct pole_pairs") if pairs else None
    if unit != "rpm" and abs(ratio * RPM - 1.0) < NEAR_RPM:
        cause, line = "they look like rpm read as rad/s", 'write rotor_unit = "rpm"'
        if unit == "rad/s":
            return cause, line
        # Not knowing what is stated, 9 or 10 pole pairs cannot be told from 60 / (2 pi).
        return f"{cause}, or like electrical rpm", f'{line}, or "erpm" and pole_pairs,'
    if unit != "rad/s" and abs(ratio / RPM - 1.0) < NEAR_RPM:
        return "they look like rad/s read as rpm", 'write rotor_unit = "rad/s"'
    pairs = _pole_pairs(ratio * RPM if unit == "rad/s" else ratio)
    cause = f"they look like electrical rpm of motors with about {pairs} pole pairs"
    return (cause, f'write rotor_unit = "erpm" and pole_pairs ({pairs}?)') if pairs else None


def _pole_pairs(ratio: float) -> int | None:
    """The number of pole pairs that a ratio of speeds is near, or None."""
    nearest = min(POLE_PAIRS, key=lambda count: abs(ratio / count - 1.0))
    return nearest if abs(ratio / nearest - 1.0) < NEAR_POLE_PAIRS else None
