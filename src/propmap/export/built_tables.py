"""Tables that an export builds for a vehicle, or for a propeller of a typical multirotor."""

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
BEYOND = 1.1  # margin above the top speed, and below the slowest rotor in level flight
USUAL_TIP_SPEED, USUAL_SPEED = 70.0, 20.0  # in hover and top speed, without a vehicle [m/s]
BETA = (0.0, math.pi)  # [rad]

TOLERANCES = (0.025, 0.05, 0.1)
"""Tolerances, as fractions of the static loads; the first that can be met applies.  Most propellers
meet the first in seconds; smaller ones prevent this range of rotor speeds, because the Reynolds
number changes the loads."""

POINTS = 8192  # of the certificate; the points take most of the time

Ranges = tuple[Range, Range]  # of rotor speed [rad/s] and airspeed [m/s]


def with_mount_in_model(aircraft: Aircraft, rotor: Rotor) -> tuple[Aircraft, Rotor]:
    """Return the aircraft of a ``rotor`` with [mount] in the model of the rotor, and this rotor.

    Tables and C++ headers contain one rotor: raises ``InputError`` for different mounts.
    """
    vehicle = aircraft.vehicle
    (model, _), *others = mounted_rotors(vehicle, rotor.model)
    if others:
        found = "the rotors have different areas in [mount], and the export contains one rotor"
        raise InputError(found, "give one area for all rotors")
    mounts, one = (replace(mount, drag=None) for mount in vehicle.mounts), rotor.with_model(model)
    return Aircraft(replace(vehicle, mounts=tuple(mounts)), one), one


def ranges_of(aircraft: Aircraft) -> Ranges:
    """Return ranges with hover, a margin and level flight up to the top speed.

    At the top speed a rotor reaches the largest rotor speed of the range, or a limit of the
    vehicle.  Raises ``InputError`` for a vehicle that does not hover.
    """
    still = aircraft.steady(0.0, margin=False)
    if not still.found[0]:
        found = f"the vehicle does not hover: {STATUSES[str(still.status[0])]}"
        remedy = "check mass, propeller and motor, or build a table with propmap table and give it "
        raise InputError(found, f"{remedy}as --table FILE.npz")
    slow, fast = (
        AROUND_HOVER[0] * still.rotor_speed.min(),
        AROUND_HOVER[1] * still.rotor_speed.max(),
    )
    limited = Aircraft(aircraft.vehicle, aircraft.loads, maximum_rotor_speed=float(fast))
    top, _, flown = searched(limited, limited.steady([0.0, 1.0], margin=False), 0.0)
    slowest = flown.rotor_speed[flown.found].min() / BEYOND
    return (float(min(slow, slowest)), float(fast)), (0.0, BEYOND * top)


def usual_ranges(propeller: Propeller) -> Ranges:
    """Return the ranges of a ``propeller`` alone, on a typical multirotor."""
    least, most = (factor * USUAL_TIP_SPEED / propeller.radius for factor in AROUND_HOVER)
    return (least, most), (0.0, USUAL_SPEED)


def built_table(rotor: Rotor, ranges: Ranges, progress: Progress | None = None) -> LoadTable:
    """Build the table of a ``rotor`` over ``ranges`` with the smallest possible tolerance."""
    omega, speed = ranges
    build = partial(build_table, rotor, omega=omega, speed=speed, beta=BETA, progress=progress)
    for tolerance in TOLERANCES[:-1]:
        with suppress(InputError):
            return build(tolerance=tolerance, certificate_points=POINTS)
    return build(tolerance=TOLERANCES[-1], certificate_points=POINTS)
