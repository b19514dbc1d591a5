"""Whether the rotor speeds of a log can carry the vehicle and are those of its rotors."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.flight.steady import airborne
from propmap.hover import HoverModel
from propmap.model.unit_errors import UNIT_ERRORS, Range, unit_errors
from propmap.typing import Floats
from propmap.units import GRAVITY, RPM
from propmap.vehicle.log import FlightLog, low_passed
from propmap.vehicle.vehicle import Vehicle

if TYPE_CHECKING:
    from propmap.rotor import Rotor

# -------------------------------------------------------------------------------------------------
# Whether the rotor speeds of a log can carry the vehicle: unit errors show in hover.

SLOW = 3.0  # speed [m/s] below which the hover model serves
QUIET = 0.1  # share of g by which the specific force may differ from it
FEWEST_SLOW = 20  # samples of slow flight, below which there is too little of it
NEAR_UNIT, NEAR_PAIRS = Range(0.75, 1.25), Range(0.9, 1.1)
"""Speeds over those that carry the weight, once corrected.  A nominal section law and a roughly
known blade give the thrust to about 50 %, the speed to 25 %; several numbers of pole pairs then fit
and the nearest is named, but few pairs must fit closely, as 2 is near 1."""

POLE_PAIRS = {str(count): float(count) for count in range(2, 15)}

CARRIED = Range(0.4, 2.5)  # thrust over the weight outside which a warning is due
POSSIBLE = Range(0.2, 5.0)  # and outside which it is an error: no blade is off by so much
PWM = Range(900.0, 2200.0)  # [us], pulses to motor controllers


def check_rotor_speed(
    log: FlightLog, rotor: Rotor, vehicle: Vehicle, rotor_unit: str | None = None
) -> list[str]:
    """Warn where the thrust that the rotor speeds give in slow flight is not the weight.

    The ``rotor`` has a nominal section law.  ``rotor_unit``, "rad/s", "rpm" or "erpm", is what the
    vehicle file states, and separates errors of like size.  Raises ``InputError`` where a rotor
    stands still, where a wrong unit, of the speeds or of the mass, explains the difference, and
    where the thrust is below a fifth of the weight or above five times.
    """
    for k, column in enumerate(log.rotor_speed.T, start=1):
        if not np.max(column) > 0.0:
            fault = f"rotor {k} stands still in the whole log (0 rad/s)"
            remedy = "check rotor_speed and rotor_order in [log] of the vehicle file, and that the "
            remedy += "motor controllers report their speed"
            raise InputError(fault, remedy, log.source)
    slow = log.picked(slow_flight(log))
    share = _thrust_share(slow, rotor, vehicle)
    found = f"in slow flight the rotors would carry {share:.3g} times the weight "
    found += f"at {float(np.mean(slow.rotor_speed)) / RPM:.0f} rpm"
    if unit_errors(1.0 / share, CARRIED, UNIT_ERRORS["mass"]):
        fault = f"{found}: the mass of {vehicle.mass:g} kg looks like grams"
        raise InputError(fault, "write kilograms in the vehicle file", log.source)
    read = slow.rotor_speed / (1.0 if rotor_unit == "rad/s" else RPM)
    low, high = np.percentile(read, [1.0, 99.0])
    pulses = share not in POSSIBLE and rotor_unit != "erpm" and low in PWM and high in PWM
    cause, remedy = _speed_error(math.sqrt(share), rotor_unit, pulses=pulses)
    if cause:
        raise InputError(f"{found}: {cause}", f"{remedy} in [log] of the vehicle file", log.source)
    if share in CARRIED:
        return []
    if share not in POSSIBLE:
        raise InputError(
            f"{found}, which no error of units explains that is common",
            "check mass and propeller in the vehicle file, and whether the log has rotor speeds in "
            "rpm, electrical rpm or rad/s: PWM and throttle are commands, no speeds",
            log.source,
        )
    return [f"{log.source}: {found}; check mass, propeller, air density and the rotor speeds"]


def drive_in_hover(logs: Sequence[FlightLog]) -> float:
    """Return what drives the motors in slow flight, on average over the logs that have throttle."""
    parts = [log.throttle[slow_flight(log)] for log in logs if log.commanded]
    return float(np.mean([np.mean(part) for part in parts]))


def slow_flight(log: FlightLog) -> NDArray[np.bool_]:
    """Return which samples (n,) are below 3 m/s with a specific force within 10 % of g.

    Where there is too little of it, the slowest tenth of the flight serves.  Time on the ground
    does not count.
    """
    flying = airborne(log)
    force = np.linalg.norm(log.specific_force, axis=1)
    quiet = np.isnan(force) | (np.abs(force / GRAVITY - 1.0) < QUIET)
    slow = flying & quiet & (log.speed < SLOW)
    if int(slow.sum()) >= FEWEST_SLOW:
        return slow
    return np.asarray(flying & (log.speed <= np.percentile(log.speed[flying], 10.0)))


def _thrust_share(log: FlightLog, rotor: Rotor, vehicle: Vehicle) -> float:
    """Divide the rotors' mean force along the vehicle's z axis by the force that flight takes."""
    up = np.mean(log.up[:, 2])
    measured = np.mean(log.specific_force[:, 2])
    needed = vehicle.mass * (GRAVITY / up if np.isnan(measured) else measured)
    force = HoverModel.of(rotor).k_thrust * float(
        np.mean(np.square(log.rotor_speed) @ vehicle.rotor_axes[:, 2])
    )
    if not (needed > 0.0 and force > 0.0):
        found = f"slow flight takes {needed:.3g} N along the vehicle's z axis, of rotors that give "
        found += f"{force:.3g} N"
        remedy = "check body_frame, world_frame and the axes of the rotors in the vehicle file"
        raise InputError(found, remedy, log.source)
    return float(force / needed)


def _speed_error(ratio: float, unit: str | None, *, pulses: bool) -> tuple[str, str]:
    """Return cause and remedy of speeds that are wrong by the factor ``ratio``; empty for none.

    With ``pulses``, they are in the range of PWM.
    """
    pwm, measured = "like PWM in us", "log measured speeds, as PWM is a command, and name them"

    def pole_pairs(factor: float) -> str:
        return next(iter(unit_errors(factor, NEAR_PAIRS, POLE_PAIRS)), "")

    if unit == "erpm":
        if pole_pairs(1.0 / ratio):
            cause = "they look like mechanical rpm, divided by pole_pairs for nothing"
            return cause, 'write rotor_unit = "rpm", or correct pole_pairs'
        pairs = pole_pairs(ratio)
        cause = f"they look as if divided by too few pole pairs, by a factor of about {pairs}"
        return (cause, "correct pole_pairs") if pairs else ("", "")
    if unit != "rpm" and ratio * RPM in NEAR_UNIT:
        cause, remedy = "they look like rpm read as rad/s", 'write rotor_unit = "rpm"'
        if unit == "rad/s":
            return cause, remedy
        # Not knowing what is stated, 9 or 10 pole pairs look like 60 / (2 pi).
        return f"{cause}, or like electrical rpm", f'{remedy}, or "erpm" and pole_pairs,'
    if unit != "rad/s" and ratio / RPM in NEAR_UNIT:
        cause, remedy = "they look like rad/s read as rpm", 'write rotor_unit = "rad/s"'
        return (f"{cause}, or {pwm}", f"{remedy}, or {measured}") if pulses else (cause, remedy)
    if pulses:
        return f"they look {pwm}", measured
    pairs = pole_pairs(ratio * RPM if unit == "rad/s" else ratio)
    cause = f"they look like electrical rpm of motors with about {pairs} pole pairs"
    return (cause, f'write rotor_unit = "erpm" and pole_pairs ({pairs}?)') if pairs else ("", "")


# -------------------------------------------------------------------------------------------------
# Whether the columns of rotor speeds are those of the rotors, and all flights of one vehicle.

BAND = (1.0, 6.0)
"""Frequencies [Hz] in which moments of the rotors turn the vehicle: slower ones, the air's turn it
as well; faster ones, motor controllers lag."""

MOST_ROTORS = 6  # rotors up to which all orders are tried
WRONG_ORDER, RIGHT_ORDER = 0.3, 0.7
"""Correlation of moment and angular acceleration below which an order is wrong, and above which
another one is right."""

FEWEST, AGILE = 200, 0.5
"""Samples in flight, and their angular acceleration [rad/s^2], from which an order shows."""

OTHER_VEHICLE = 1.15
"""Ratio of two flights' thrust per squared rotor speed in hover that batteries and air do not
explain."""


def check_rotor_order(log: FlightLog, vehicle: Vehicle) -> None:
    """Compare the moments of the rotors, as they are ordered, with how the vehicle turns.

    Raises ``InputError`` where another order turns it as it turned and the one given does not.
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
    arms = np.cross(vehicle.hub_positions, vehicle.rotor_axes)[:, :2]

    def correlation(arms: Floats) -> float:
        moment = thrust @ arms
        size = np.linalg.norm(moment, axis=0) * np.linalg.norm(turning, axis=0)
        if not (size > 0.0).all():
            return 0.0
        return float(np.mean(np.sum(moment * turning, axis=0) / size))

    given = correlation(arms)
    if given > WRONG_ORDER:
        return
    orders = [list(order) for order in itertools.permutations(range(count))]
    best = max(orders, key=lambda order: correlation(arms[order]))
    found = correlation(arms[best])
    if found < RIGHT_ORDER:
        return
    # Column k, which is rotor k's now, is the one of the rotor whose arm suits it.
    order = ", ".join(str(number + 1) for number in best)
    raise InputError(
        "the rotor speeds do not turn the vehicle as it turned (correlation "
        f"{given:.2f}); those of rotors 1 to {count} are rather of rotors {order} ({found:.2f})",
        "correct rotor_order, the columns, or the positions of the [[rotors]]",
        log.source,
    )


def mixed_vehicles(logs: Sequence[FlightLog], vehicle: Vehicle) -> list[str]:
    """Warn where ``logs`` cannot be of one vehicle, by what hover takes of the rotors."""
    found, axes = {}, vehicle.rotor_axes[:, 2]
    for log in logs:
        hover = log.picked(slow_flight(log))
        if len(hover) < FEWEST_SLOW or hover.speed.max() > SLOW:
            continue
        measured = bool(np.isfinite(hover.specific_force).all())
        force = np.mean(hover.specific_force[:, 2]) if measured else GRAVITY
        found[log.source] = float(force) / float(np.mean(np.square(hover.rotor_speed) @ axes))
    if len(found) < 2:
        return []
    low, high = min(found, key=lambda key: found[key]), max(found, key=lambda key: found[key])
    ratio = found[high] / found[low]
    if ratio < OTHER_VEHICLE:
        return []
    return [
        f"in slow flight {high} has {ratio:.2f} times the force per mass and squared rotor speed "
        f"of {low}: they are not of one vehicle, mass or propeller; fit them one by one"
    ]
