"""Options of fits to flights, and which parameters are free in them by default."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.errors import InputError
from propmap.fit.parameters import FLEX, MOUNT, PAPER_FOUR, SENSOR, TURNING, WAKES, Choice, Prior

if TYPE_CHECKING:
    from propmap.fit.fitted import Fitted
    from propmap.fit.force_model import ForceModel
    from propmap.fit.learned_residual import LearnedResidual
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
        help="Scale rotor loads of each flight by its own hover, over that of the fit's flights.",
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

FLIGHT_PRIORS = {
    "untwist": Prior(0.02, 0.02),
    "download_area_x": Prior(0.0, 0.02),
    "download_area_y": Prior(0.0, 0.02),
    "wake_ahead": Prior(1.0, 3.0),
    "wake_beside": Prior(1.0, 1.0),
    "wake_downwash": Prior(1.0, 1.0),
    "wake_share": Prior(1.0, 0.5),
}
"""Thin plastic blades give way by 0.02 to 0.05 rad, see ``BladeUntwist``, stiff ones hardly.  A
download may come from any part of a body.  The vortex cylinder is right within a factor of about
two, and a wake is skewed by the inflow at the disk (1) or far below it (2) or by less, as air at
the rim is slower."""


def free_by_default(vehicle: Vehicle, *, level: bool) -> tuple[str, ...]:
    """Names of what a fit to flights of the ``vehicle`` varies where nothing is stated.

    With steady stretches (``level``) the paper's four; with whole flights what else moves the
    residuals: drag of the rotors' mounts, which takes the place of the body's in the disk plane,
    the body's along z, the accelerometer, and the wakes of several rotors on each other.
    """
    if level:
        return PAPER_FOUR
    turning = tuple(TURNING) if vehicle.inertia else ()
    mount = () if any(one.drag for one in vehicle.mounts) else tuple(MOUNT)
    wakes = tuple(WAKES) if len(vehicle.mounts) > 1 else ()
    return (*BLADE, *FLEX, *mount, *BODY_ALONG_Z, *SENSOR, *turning, *wakes)


def with_flight_priors(choice: Choice) -> Choice:
    """The ``choice`` with ``FLIGHT_PRIORS`` on those free parameters that have no prior."""
    more = {n: p for n, p in FLIGHT_PRIORS.items() if n in choice.free and n not in choice.priors}
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
