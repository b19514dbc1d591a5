"""Whether the columns of rotor speeds are those of the rotors, and all flights of one vehicle."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from propmap.errors import InputError
from propmap.flight.plausible_rpm import FEWEST_SLOW, SLOW, slow_flight
from propmap.flight.steady import airborne
from propmap.typing import Floats
from propmap.vehicle.log import GRAVITY, FlightLog, low_passed
from propmap.vehicle.vehicle import Vehicle

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
