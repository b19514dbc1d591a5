"""Tables that ``propmap export`` builds for a vehicle, or for a propeller without a vehicle."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace
from functools import partial

from propmap.aircraft.performance import searched
from propmap.aircraft.trim import STATUSES, Aircraft
from propmap.errors import InputError
from propmap.model.envelope import Range
from propmap.model.propeller import Propeller
from propmap.rotor import Rotor
from propmap.table.build import build_table
from propmap.table.query import LoadTable
from propmap.table.verification import Progress
from propmap.vehicle.vehicle_forces import mounted_rotors

AROUND_HOVER = (0.7, 1.5)  # range of rotor speeds over the speed in hover; 1.5 doubles the thrust
BEYOND = 1.1  # factor on the top speed, and divisor of the slowest rotor speed in level flight
USUAL_TIP_SPEED = 70.0  # assumed tip speed in hover of a propeller without a vehicle [m/s]
USUAL_SPEED = 20.0  # assumed largest airspeed of a propeller without a vehicle [m/s]
BETA = (0.0, math.pi)  # range of beta: from climb to descent [rad]

TOLERANCES = (0.025, 0.05, 0.1)
"""Tolerances of a table, as fractions of the static loads, in the order of attempts.  For most
propellers, a table with the first tolerance is feasible and takes seconds.  Smaller tolerances are
often not feasible for this range of rotor speeds, because the Reynolds number changes the loads."""

POINTS = 8192  # points of the certificate; their evaluation takes most of the time of a build

Ranges = tuple[Range, Range]  # ranges of rotor speed [rad/s] and airspeed [m/s]


def with_mount_in_model(aircraft: Aircraft, rotor: Rotor) -> tuple[Aircraft, Rotor]:
    """Return an aircraft and its rotor, with the drag of [mount] in the model of the ``rotor``.

    Raises ``InputError`` for different mounts, because tables and C++ headers contain one rotor.
    """
    vehicle = aircraft.vehicle
    (model, _), *others = mounted_rotors(vehicle, rotor.model)
    if others:
        found = "the rotors have different areas in [mount], and the export contains one rotor"
        raise InputError(found, "give one area for all rotors")
    mounts, one = (replace(mount, drag=None) for mount in vehicle.mounts), rotor.with_model(model)
    return Aircraft(replace(vehicle, mounts=tuple(mounts)), one), one


def ranges_of(aircraft: Aircraft) -> Ranges:
    """Return ranges that include hover and level flight up to the top speed, with a margin.

    At the top speed, a rotor reaches the largest rotor speed of the range, or a limit of the
    vehicle.  Raises ``InputError`` for a vehicle that does not hover.
    """
    still = aircraft.steady(0.0, margin=False)
    if not still.found[0]:
        found = f"the vehicle does not hover: {STATUSES[str(still.status[0])]}"
        remedy = "check mass, propeller and motor, or build a table with propmap table and add it"
        raise InputError(found, f"{remedy} as --table FILE.npz")
    slow, fast = (
        AROUND_HOVER[0] * still.rotor_speed.min(),
        AROUND_HOVER[1] * still.rotor_speed.max(),
    )
    limited = Aircraft(aircraft.vehicle, aircraft.loads, maximum_rotor_speed=float(fast))
    top, _, flown = searched(limited, limited.steady([0.0, 1.0], margin=False), 0.0)
    slowest = flown.rotor_speed[flown.found].min() / BEYOND
    return (float(min(slow, slowest)), float(fast)), (0.0, BEYOND * top)


def usual_ranges(propeller: Propeller) -> Ranges:
    """Return the ranges of a ``propeller`` without a vehicle, as on a typical multirotor."""
    least, most = (factor * USUAL_TIP_SPEED / propeller.radius for factor in AROUND_HOVER)
    return (least, most), (0.0, USUAL_SPEED)


def built_table(rotor: Rotor, ranges: Ranges, progress: Progress | None = None) -> LoadTable:
    """Return the table of a ``rotor`` over ``ranges`` with the smallest feasible tolerance."""
    omega, speed = ranges
    build = partial(build_table, rotor, omega=omega, speed=speed, beta=BETA, progress=progress)
    for tolerance in TOLERANCES[:-1]:
        with suppress(InputError):
            return build(tolerance=tolerance, certificate_points=POINTS)
    return build(tolerance=TOLERANCES[-1], certificate_points=POINTS)
