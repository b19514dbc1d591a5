"""Options of fits to flights, and which parameters are free in them by default."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.errors import InputError
from propmap.fit.parameters import BODY, FLEX, MOUNT, PAPER_FOUR, TURNING, WAKES, Choice, Prior

if TYPE_CHECKING:
    from propmap.fit.fit import Fitted
    from propmap.fit.flight import ForceModel
    from propmap.fit.learned_residual import LearnedResidual
    from propmap.vehicle.log import FlightLog
    from propmap.vehicle.vehicle import Vehicle

LowPass = Annotated[
    float | None,
    typer.Option(
        "--low-pass",
        metavar="HZ",
        help="Cut-off for all signals of whole flights alike, by default 6; 0 for none.",
    ),
]
HoverScale = Annotated[
    bool,
    typer.Option(
        "--hover-scale/--no-hover-scale",
        help="Expect each flight's thrust scale where its own hover has it, in fits and checks.",
    ),
]
Residual = Annotated[
    bool,
    typer.Option(
        "--residual",
        help="Also learn a small correction of what the physics leaves, told and filed apart.",
    ),
]

BLADE = ("c_l1", "c_d", "alpha_0", "zero_lift_angle", "c_d0", "reynolds_camber")
"""Constants of the blade that a flight moves; those that are left out, it does not tell."""

BODY_ALONG_Z = ("drag_area_z", "download_area_x", "download_area_y")
"""Of the body's terms, those that the drag of the rotors' mounts does not take the place of."""

WAKE_PRIORS = {
    "wake_ahead": Prior(1.0, 3.0),
    "wake_beside": Prior(1.0, 1.0),
    "wake_downwash": Prior(1.0, 1.0),
    "wake_share": Prior(1.0, 0.5),
}
"""The vortex cylinder is right within a factor of about two, and a wake is skewed by the inflow at
the disk (1) or far below it (2) or by less, as air at the rim is slower."""

UNTWIST = Prior(0.02, 0.02)
"""Thin plastic blades give way by 0.02 to 0.05 rad, see ``BladeUntwist``, stiff ones hardly."""

CLOCK = Prior(0.0, 0.01)
"""[s]; filters of sensors delay them by some milliseconds."""

ROTOR_SPEEDS = Prior(1.0, 0.01)
"""What motor controllers report is right within a hundredth: a clock's error, and rounding."""

BODY_SHARE, MOUNT_SHARE = 0.4, 0.5
"""Areas of a body over that of all disks, and of a mount over that of its disk, as deviations."""

SENSOR_SHARE, CENTRE_SHARE = 0.5, 0.1
"""Places of the accelerometer and of the centre of mass over the hubs' mean distance, likewise."""

ROTOR_SHARE = 0.01
"""Of the vehicle's mass that a rotor has at its radius, likewise."""


def flight_priors(vehicle: Vehicle, log: FlightLog, *, hover: bool) -> dict[str, Prior]:
    """What is known beforehand of all parameters but the section's, by the vehicle's size.

    With ``hover``, the thrust scale of each flight is expected where its own hover has it.
    """
    from propmap.fit.flight import CENTRE, OFFSET, OVER_FLIGHTS, of_each
    from propmap.fit.flight import HoverScale as Measured

    disk = math.pi * vehicle.propeller.radius**2
    bodies = Prior(0.0, BODY_SHARE * disk * len(vehicle.mounts))
    places = [math.hypot(*mount.position) for mount in vehicle.mounts]
    arm = sum(places) / len(places) or vehicle.propeller.radius
    heavy = ROTOR_SHARE * vehicle.mass * vehicle.propeller.radius**2
    scale = Measured.of(vehicle, log)
    if not hover:
        scale = replace(scale, measured={})
    return {
        **dict.fromkeys(BODY, bodies),
        "mount_area": Prior(0.0, MOUNT_SHARE * disk),
        "untwist": UNTWIST,
        **dict.fromkeys(OFFSET, Prior(0.0, SENSOR_SHARE * arm)),
        **dict.fromkeys(("clock_offset", *of_each("clock_offset", log)), CLOCK),
        **dict.fromkeys(CENTRE, Prior(0.0, CENTRE_SHARE * arm)),
        "rotor_inertia": Prior(0.0, heavy),
        **WAKE_PRIORS,
        "rotor_speed_scale": ROTOR_SPEEDS,
        "thrust_scale": Prior(1.0, OVER_FLIGHTS),
        **scale.priors,
    }


def free_by_default(vehicle: Vehicle, log: FlightLog, *, level: bool) -> tuple[str, ...]:
    """Names of what a fit to flights of the ``vehicle`` varies where nothing is stated.

    With steady stretches (``level``) the paper's four; with whole flights what else moves the
    residuals: drag of the rotors' mounts, which takes the place of the body's in the disk plane,
    the body's along z, the accelerometer, the wakes of several rotors on each other, and of each
    flight of the ``log`` the clock and, beside others, the thrust scale.
    """
    if level:
        return PAPER_FOUR
    from propmap.fit.flight import OFFSET, of_each

    turning = tuple(TURNING) if vehicle.inertia else ()
    mount = () if any(one.drag for one in vehicle.mounts) else tuple(MOUNT)
    wakes = tuple(WAKES) if len(vehicle.mounts) > 1 else ()
    scales = of_each("thrust_scale", log) if len(log.flights) > 1 else ()
    own = (*of_each("clock_offset", log), *scales)
    return (*BLADE, *FLEX, *mount, *BODY_ALONG_Z, *OFFSET, *turning, *wakes, *own)


def with_flight_priors(choice: Choice, known: Mapping[str, Prior]) -> Choice:
    """The ``choice`` with what is ``known`` of those free parameters that have no prior."""
    more = {n: p for n, p in known.items() if n in choice.free and n not in choice.priors}
    return replace(choice, priors={**more, **choice.priors}) if more else choice


def learned_residual(
    model: ForceModel, fitted: Fitted, *, wanted: bool, level: bool
) -> LearnedResidual | None:
    """What ``--residual`` learns from the samples of a fit; None where it is not ``wanted``.

    Raises ``InputError`` for steady stretches (``level``), and flights that are too short.
    """
    if not wanted:
        return None
    if level:
        raise InputError("--residual is for whole flights", "add --method balance")
    from propmap.fit.learned_residual import learn

    left = model.vehicle.mass * model.log.specific_force - model.at(fitted.values, ()).force
    return learn(model.vehicle, model.log, left)
