"""Tables that an export builds for a vehicle, or for a propeller of a typical multirotor."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from propmap.aircraft.performance import searched
from propmap.aircraft.trim import STATUSES, Aircraft, SteadyStates
from propmap.errors import InputError
from propmap.model.envelope import Range
from propmap.model.propeller import Propeller
from propmap.rotor import Rotor
from propmap.table.build import build_table
from propmap.table.query import LoadTable
from propmap.table.verification import Progress
from propmap.vehicle.vehicle_forces import mounted_rotors

AROUND_HOVER = (0.7, 1.5)  # range of rotor speeds over the speed in hover; 1.5 doubles the thrust
BEYOND = 1.1  # range of airspeeds over the top speed, and of rotor speeds below the slowest state
USUAL_TIP_SPEED, USUAL_SPEED = 70.0, 20.0  # in hover and top speed, without a vehicle [m/s]
BETA = (0.0, math.pi)  # [rad]

TOLERANCES = (0.025, 0.05, 0.1)
"""Tolerances of a built table, as fractions of the static loads; the first that can be met applies.
Most propellers meet the first in seconds; with a smaller one, the Reynolds number limits the range
of rotor speeds."""

POINTS = 8192  # of the certificate; the points take most of the time


class Envelope(NamedTuple):
    """Ranges of rotor speed [rad/s] and airspeed [m/s] of a built table; beta is 0 to 180 deg."""

    omega: Range
    speed: Range


def with_mount_in_model(aircraft: Aircraft, rotor: Rotor) -> tuple[Aircraft, Rotor]:
    """Return the aircraft of a ``rotor`` with [mount] in the model of the rotor, and this rotor.

    Tables and C++ headers contain one rotor: raises ``InputError`` for different mounts.
    """
    vehicle = aircraft.vehicle
    (model, _), *others = mounted_rotors(vehicle, rotor.model)
    if others:
        found = "the rotors have different areas in [mount], and the export contains one rotor"
        raise InputError(found, "give one area for all rotors")
    mounts = tuple(replace(mount, drag=None) for mount in vehicle.mounts)
    limits = {"maximum_rotor_speed": aircraft.maximum_rotor_speed, "charge": aircraft.charge}
    one = rotor.with_model(model)
    return Aircraft(replace(vehicle, mounts=mounts), one, **limits), one


def envelope_of(aircraft: Aircraft) -> Envelope:
    """Return an envelope with hover, its margin and level flight up to the top speed.

    At the top speed a rotor reaches the largest rotor speed of the envelope, or a limit of the
    vehicle.  Raises ``InputError`` for a vehicle that does not hover.
    """
    still = aircraft.steady(0.0, margin=False)
    if not still.found[0]:
        found = f"the vehicle does not hover ({STATUSES[str(still.status[0])]}), and the range of "
        found += "a table follows from hover"
        raise InputError(found, "build a table with propmap table and give it as --table FILE.npz")
    least, most = (f * w for f, w in zip(AROUND_HOVER, _ends(still), strict=True))
    largest = min(aircraft.maximum_rotor_speed, most)
    limited = Aircraft(
        aircraft.vehicle, aircraft.loads, maximum_rotor_speed=largest, charge=aircraft.charge
    )
    top, _, flown = searched(limited, limited.steady([0.0, 1.0], margin=False), 0.0)
    return Envelope((min(least, _ends(flown)[0] / BEYOND), most), (0.0, BEYOND * top))


def _ends(states: SteadyStates) -> Range:
    """Return the least and the largest rotor speed of the ``states`` [rad/s]."""
    return float(np.nanmin(states.rotor_speed)), float(np.nanmax(states.rotor_speed))


def usual_envelope(propeller: Propeller) -> Envelope:
    """Return the envelope of a multirotor with a typical tip speed for a ``propeller`` alone."""
    least, most = (factor * USUAL_TIP_SPEED / propeller.radius for factor in AROUND_HOVER)
    return Envelope((least, most), (0.0, USUAL_SPEED))


def built_table(rotor: Rotor, envelope: Envelope, progress: Progress | None = None) -> LoadTable:
    """Build the table of a ``rotor`` over an ``envelope`` with the smallest possible tolerance."""
    for tolerance in TOLERANCES:
        try:
            return build_table(
                rotor,
                omega=envelope.omega,
                speed=envelope.speed,
                beta=BETA,
                tolerance=tolerance,
                certificate_points=POINTS,
                progress=progress,
            )
        except InputError as error:
            fault = error
    remedy = "build a table with propmap table over a smaller range"
    raise InputError(fault.found, remedy)
