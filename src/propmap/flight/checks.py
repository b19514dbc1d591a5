"""Plausibility checks of logged rotor speeds: unit, order of rotors, same vehicle in all logs."""

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
# Comparison of the thrust at the logged rotor speeds with the weight, which reveals unit errors.

SLOW = 3.0  # largest speed at which the hover model is accurate enough [m/s]
QUIET = 0.1  # largest relative difference between specific force and g
FEWEST_SLOW = 20  # least number of samples of slow flight
NEAR_UNIT, NEAR_PAIRS = Range(0.75, 1.25), Range(0.9, 1.1)
"""Accepted ratio: corrected rotor speeds / speeds that carry the weight.  The correction is another
unit or number of pole pairs.  A nominal section law and a roughly known blade determine thrust to
about 50 % and speed to 25 %.  Of several accepted numbers of pole pairs, the message names the one
with the ratio nearest to 1.  ``NEAR_PAIRS`` is narrow: with a wider range, a section law that
overestimates thrust would make correct speeds look like electrical rpm with 2 pole pairs."""

POLE_PAIRS = {str(count): float(count) for count in range(2, 15)}

CARRIED = Range(0.4, 2.5)  # thrust / weight outside this range causes a warning
POSSIBLE = Range(0.2, 5.0)  # thrust / weight outside this range is an error: no blade explains it
PWM = Range(900.0, 2200.0)  # pulse widths of commands to motor controllers [us]


def check_rotor_speed(
    log: FlightLog, rotor: Rotor, vehicle: Vehicle, rotor_unit: str | None = None
) -> list[str]:
    """Return warnings if the thrust from the rotor speeds in slow flight differs from the weight.

    The ``rotor`` has a nominal section law.  ``rotor_unit`` is the unit in the vehicle file,
    "rad/s", "rpm" or "erpm"; the stated unit distinguishes unit errors with similar factors.  Raise
    ``InputError`` if a rotor stands still or if a wrong unit explains the difference.  Also raise
    ``InputError`` if the thrust is outside 0.2 to 5 times the weight.
    """
    for k, column in enumerate(log.rotor_speed.T, start=1):
        if not np.max(column) > 0.0:
            fault = f"rotor {k} stands still in the whole log (0 rad/s)"
            remedy = "check rotor_speed and rotor_order in [log] of the vehicle file, and whether "
            remedy += "the motor controllers report speeds"
            raise InputError(fault, remedy, log.source)
    slow = log.picked(slow_flight(log))
    share = _thrust_share(slow, rotor, vehicle)
    found = f"the rotor speeds, on average {float(np.mean(slow.rotor_speed)) / RPM:.0f} rpm, "
    found += f"would carry {share:.3g} times the weight in slow flight"
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
            f"{found}, and no common error of units explains the difference",
            "check mass and propeller in the vehicle file, and whether the log has rotor speeds in "
            "rpm, electrical rpm or rad/s: PWM and throttle are commands, not speeds",
            log.source,
        )
    return [f"{log.source}: {found}; check mass, propeller, air density and the rotor speeds"]


def drive_in_hover(logs: Sequence[FlightLog]) -> float:
    """Return the mean ``throttle`` in slow flight, over the logs with throttle."""
    parts = [log.throttle[slow_flight(log)] for log in logs if log.commanded]
    return float(np.mean([np.mean(part) for part in parts]))


def slow_flight(log: FlightLog) -> NDArray[np.bool_]:
    """Return whether each sample (n,) is in flight below 3 m/s, with a specific force near g.

    With too few such samples, return the slowest tenth of the samples in flight.
    """
    flying = airborne(log)
    force = np.linalg.norm(log.specific_force, axis=1)
    quiet = np.isnan(force) | (np.abs(force / GRAVITY - 1.0) < QUIET)
    slow = flying & quiet & (log.speed < SLOW)
    if int(slow.sum()) >= FEWEST_SLOW:
        return slow
    return np.asarray(flying & (log.speed <= np.percentile(log.speed[flying], 10.0)))


def _thrust_share(log: FlightLog, rotor: Rotor, vehicle: Vehicle) -> float:
    """Return the ratio of rotor force to mass times specific force, along z of the vehicle."""
    up = np.mean(log.up[:, 2])
    measured = np.mean(log.specific_force[:, 2])
    needed = vehicle.mass * (GRAVITY / up if np.isnan(measured) else measured)
    force = HoverModel.from_rotor(rotor).k_thrust * float(
        np.mean(np.square(log.rotor_speed) @ vehicle.rotor_axes[:, 2])
    )
    if not (needed > 0.0 and force > 0.0):
        found = f"slow flight needs {needed:.3g} N along the z axis of the vehicle, but the rotors "
        found += f"produce {force:.3g} N"
        remedy = "check body_frame, world_frame and the axes of the rotors in the vehicle file"
        raise InputError(found, remedy, log.source)
    return float(force / needed)


def _speed_error(ratio: float, unit: str | None, *, pulses: bool) -> tuple[str, str]:
    """Return cause and remedy of speeds that are wrong by the factor ``ratio``, or empty texts.

    ``pulses`` is true for numbers in the range of PWM.
    """
    pwm, measured = "like PWM in us", "log measured speeds, not PWM commands; name their columns"

    def pole_pairs(factor: float) -> str:
        return next(iter(unit_errors(factor, NEAR_PAIRS, POLE_PAIRS)), "")

    if unit == "erpm":
        if pole_pairs(1.0 / ratio):
            cause = "they look like mechanical rpm, wrongly divided by pole_pairs"
            return cause, 'write rotor_unit = "rpm", or correct pole_pairs'
        pairs = pole_pairs(ratio)
        cause = f"pole_pairs looks too small, by a factor of about {pairs}"
        return (cause, "correct pole_pairs") if pairs else ("", "")
    if unit != "rpm" and ratio * RPM in NEAR_UNIT:
        cause, remedy = "they look like rpm read as rad/s", 'write rotor_unit = "rpm"'
        if unit == "rad/s":
            return cause, remedy
        # Without the stated unit, 9 or 10 pole pairs look like the factor 60 / (2 pi).
        return f"{cause}, or like electrical rpm", f'{remedy}, or "erpm" and pole_pairs,'
    if unit != "rad/s" and ratio / RPM in NEAR_UNIT:
        cause, remedy = "they look like rad/s read as rpm", 'write rotor_unit = "rad/s"'
        return (f"{cause}, or {pwm}", f"{remedy}, or {measured}") if pulses else (cause, remedy)
    if pulses:
        return f"they look {pwm}", measured
    pairs = pole_pairs(ratio * RPM if unit == "rad/s" else ratio)
    cause = f"they look like electrical rpm of motors with about {pairs} pole pairs"
    return (cause, f'write rotor_unit = "erpm" and pole_pairs ({pairs}?)') if pairs else ("", "")


# --- Order of the rotors in the log, and whether all flights are of one vehicle ------------------

BAND = (1.0, 6.0)
"""Frequencies [Hz] at which moments of the rotors turn the vehicle.  At lower frequencies, other
aerodynamic moments turn it, too; at higher frequencies, motor controllers lag."""

MOST_ROTORS = 6  # largest number of rotors for which all orders are tried
# The given order is wrong if its correlation of moment and angular acceleration is below the first
# limit; another order is right if its correlation exceeds the second.
WRONG_ORDER, RIGHT_ORDER = 0.3, 0.7

FEWEST, AGILE = 200, 0.5
"""Least number of samples in flight and rms angular acceleration [rad/s^2] for the order check."""

OTHER_VEHICLE = 1.15
"""Two hovers belong to different vehicles if specific force / Omega^2 differs by a larger factor.
Different batteries or air explain smaller factors."""


def check_rotor_order(log: FlightLog, vehicle: Vehicle) -> None:
    """Check the order of the rotors by comparing their moments with the angular acceleration.

    Raise an ``InputError`` if only another order explains the angular acceleration.
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
    # Column k, now assigned to rotor k, fits the arm of rotor ``best[k]``.
    order = ", ".join(str(number + 1) for number in best)
    raise InputError(
        "the rotor speeds do not explain how the vehicle turned (correlation "
        f"{given:.2f}); the columns of rotors 1 to {count}, in this order, fit rotors {order} "
        f"(correlation {found:.2f})",
        "correct rotor_order, the columns, or the positions of the [[rotors]]",
        log.source,
    )


def mixed_vehicles(logs: Sequence[FlightLog], vehicle: Vehicle) -> list[str]:
    """Return a warning if the rotor speeds in hover show that ``logs`` are not of one vehicle."""
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
        f"{high}: force / (mass * rotor speed^2) in slow flight is {ratio:.2f} times that of "
        f"{low}: vehicle, mass or propeller differ; fit the flights one by one"
    ]
