"""Whether rotor speeds can carry the vehicle and are those of its rotors: slips of units, order."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from propmap.baselines.hover import HoverModel
from propmap.errors import InputError
from propmap.flight.steady import airborne
from propmap.typing import Floats
from propmap.units import GRAVITY, RPM
from propmap.vehicle.log import FlightLog, low_passed
from propmap.vehicle.vehicle import Vehicle

if TYPE_CHECKING:
    from propmap.rotor import Rotor


# -------------------------------------------------------------------------------------------------
# Whether the rotor speeds of a log can carry the vehicle: unit errors show in hover.

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


# -------------------------------------------------------------------------------------------------
# Whether the columns of rotor speeds are those of the rotors, and all flights of one vehicle.

BAND = (1.0, 6.0)
"""Frequencies [Hz] in which moments of the rotors turn the vehicle: slower ones, the air's turn it
as well; faster ones, motor controllers lag."""

MOST_ROTORS = 6
"""Of which all orders are tried."""

UNLIKE, ALIKE = 0.3, 0.7
"""Correlation of moment and angular acceleration below which an order is wrong, and above which
another one is right."""

FEWEST = 200
"""Samples in flight from which an order is told."""

AGILE = 0.5
"""Angular acceleration [rad/s^2] below which it is not."""

OTHER_VEHICLE = 1.15
"""Ratio of two flights' thrust per squared rotor speed in hover that batteries and air do not
explain."""


def check_rotor_order(log: FlightLog, vehicle: Vehicle) -> None:
    """Compare the moments of the rotors, as they are ordered, with how the vehicle turns.

    Parameters
    ----------
    log : FlightLog
        As it was flown.
    vehicle : Vehicle
        What flew.

    Raises
    ------
    InputError
        Where another order turns the vehicle as it turned and the one given does not.
    """
    count = len(vehicle.mounts)
    step = float(np.median(np.diff(log.time))) if len(log) > 1 else np.inf
    if not 3 <= count <= MOST_ROTORS or len(log) < FEWEST or 3.0 * BAND[1] * step > 1.0:
        return
    flying = airborne(log)
    quick, slow = (low_passed(log, frequency) for frequency in reversed(BAND))
    turning = (quick.angular_acceleration - slow.angular_acceleration)[flying, :2]
    thrust = (np.square(quick.rotor_speed) - np.square(slow.rotor_speed))[flying]
    if len(turning) < FEWEST or np.sqrt(np.mean(turning**2)) < AGILE:
        return
    hubs = np.array([mount.position for mount in vehicle.mounts])
    axes = np.array([mount.axis for mount in vehicle.mounts])
    arms = np.cross(hubs, axes)[:, :2]
    given = _alike(thrust, arms, turning)
    if given > UNLIKE:
        return
    orders = [list(order) for order in itertools.permutations(range(count))]
    best = max(orders, key=lambda order: _alike(thrust, arms[order], turning))
    alike = _alike(thrust, arms[best], turning)
    if alike < ALIKE:
        return
    # Column k, which is rotor k's now, is the one of the rotor whose arm suits it.
    order = ", ".join(str(number + 1) for number in best)
    raise InputError(
        "the rotor speeds do not turn the vehicle as it turned (correlation "
        f"{given:.2f}); those of rotors 1 to {count} are rather of rotors {order} ({alike:.2f})",
        "correct rotor_order, the columns, or the positions of the [[rotors]]",
        log.source,
    )


def _alike(thrust: Floats, arms: Floats, turning: Floats) -> float:
    """Mean correlation of the moments of the thrusts (n, m) with the turning (n, 2)."""
    moment = thrust @ arms
    size = np.linalg.norm(moment, axis=0) * np.linalg.norm(turning, axis=0)
    if not (size > 0.0).all():
        return 0.0
    return float(np.mean(np.sum(moment * turning, axis=0) / size))


def mixed_vehicles(logs: Sequence[FlightLog], vehicle: Vehicle) -> list[str]:
    """A warning where the logs cannot be of one vehicle, by what hover takes of the rotors.

    Parameters
    ----------
    logs : sequence of FlightLog
        Of one vehicle, as is said.
    vehicle : Vehicle
        Which it is.
    """
    axes = np.array([mount.axis[2] for mount in vehicle.mounts])
    found = {}
    for log in logs:
        hover = log.picked(slow_flight(log))
        if len(hover) < FEWEST_SLOW or hover.speed.max() > SLOW:
            continue
        force = np.nanmean(hover.specific_force[:, 2]) if _measured(hover) else GRAVITY
        squares = float(np.mean(np.square(hover.rotor_speed) @ axes))
        found[log.source] = float(force) / squares
    if len(found) < 2:
        return []
    low, high = min(found, key=lambda key: found[key]), max(found, key=lambda key: found[key])
    ratio = found[high] / found[low]
    if ratio < OTHER_VEHICLE:
        return []
    return [
        f"in slow flight {high} has {ratio:.2f} times the force per mass and squared rotor speed "
        f"of {low}: they are not of one vehicle, mass or propeller; fit them apart"
    ]


def _measured(log: FlightLog) -> bool:
    return bool(np.isfinite(log.specific_force).all())
