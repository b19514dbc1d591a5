"""Options of fits: what they start from, which parameters are free, priors, flights."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.catalogue import Entry
from propmap.catalogue.expected import ExpectedBlade, airfoil_at, expected_prior, siblings, size_of
from propmap.catalogue.identified import PARAMETERS, all_identified
from propmap.catalogue.lookup import meant_by, own_constants
from propmap.errors import InputError, quoted
from propmap.fit.fit import Settings
from propmap.fit.parameters import (
    BODY,
    EVERY,
    FLEX,
    MOUNT,
    PAPER_FOUR,
    SECTION,
    TURNING,
    WAKES,
    Choice,
    Prior,
    SectionPrior,
    known,
)
from propmap.model.airfoil import Airfoil
from propmap.model.model import Propeller

if TYPE_CHECKING:
    from propmap.fit.fit import Fitted
    from propmap.fit.flight import ForceModel
    from propmap.fit.learned_residual import LearnedResidual
    from propmap.vehicle.log import FlightLog
    from propmap.vehicle.vehicle import Vehicle


# -------------------------------------------------------------------------------------------------
# Options that all fits share, and what they mean.

Free = Annotated[
    str | None,
    typer.Option("--free", metavar="NAMES", help="Free parameters, separated by commas."),
]
Fix = Annotated[
    list[str] | None, typer.Option("--fix", metavar="NAME=VALUE", help="Hold a parameter here.")
]
Priors = Annotated[
    list[str] | None,
    typer.Option("--prior", metavar="NAME=MEAN:SD", help="What is known of a free parameter."),
]
Starts = Annotated[int, typer.Option("--starts", min=1, help="Searches from different starts.")]
Robust = Annotated[bool, typer.Option("--robust", help="Let outliers count less (soft L1 loss).")]
Folds = Annotated[int, typer.Option("--folds", min=0, help="Folds of the cross-validation.")]
Bootstrap = Annotated[
    int, typer.Option("--bootstrap", min=0, help="Refits to rows drawn with replacement.")
]
Seed = Annotated[int, typer.Option("--seed", help="Of the random starts, folds and draws.")]


def choice_of(
    free: str | None,
    fix: Sequence[str] | None,
    priors: Sequence[str] | None,
    default: Sequence[str],
    base: Airfoil | None,
    also_fixed: dict[str, float] | None = None,
    expected: SectionPrior | None = None,
) -> Choice:
    """The free parameters and what holds the others.

    ``base`` gives the values of what is not free and the first start, ``also_fixed`` values known
    from elsewhere, as those of a vehicle's wing.  Where other propellers tell what is ``expected``,
    the constants of which they do are free by default, but those that are fixed, and any further
    ones of which ``priors`` tell.
    """
    law = base or (expected.airfoil if expected else None)
    given = {name: getattr(law, name) for name in SECTION} if law else {}
    stated = dict(_pair(text, "--fix") for text in fix or ())
    told = dict(_pair(text, "--prior") for text in priors or ())
    wanted = tuple(default)
    if free is not None:
        wanted = tuple(name.strip() for name in free.split(","))
    elif expected is not None:
        more = [name for name in (*default, *told) if name not in SECTION or name in told]
        wanted = tuple(dict.fromkeys((*PARAMETERS, *more)))
        wanted = tuple(name for name in wanted if name not in stated)
    values = given | (also_fixed or {}) | {n: _number(v, f"--fix {n}") for n, v in stated.items()}
    fixed = {n: v for n, v in values.items() if n not in wanted or n in stated}
    beliefs = {}
    for name, text in told.items():
        mean, colon, deviation = text.partition(":")
        if not colon:
            raise InputError(f"--prior {name} has no deviation", "write --prior c_l2=2.0:0.3")
        beliefs[name] = Prior(*(_number(v, f"--prior {name}") for v in (mean, deviation)))
    start = {n: v for n, v in values.items() if n in wanted}
    return Choice(wanted, fixed, beliefs, start, expected)


def settings_of(starts: int, robust: bool, folds: int, bootstrap: int, seed: int) -> Settings:
    """Settings of the fit."""
    return Settings(starts, "soft_l1" if robust else "linear", folds, bootstrap, seed)


def _pair(text: str, option: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals:
        example = next(iter(EVERY))
        raise InputError(f"{option} {quoted(text)} has no '='", f"write {option} {example}=6.0")
    return known(name.strip()), value.strip()


def _number(text: str, where: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{quoted(text)} is not a number", "give a number", where) from None


# -------------------------------------------------------------------------------------------------
# What a fit starts from: section constants to be expected of the propeller's family, or of any.

PriorFrom = Annotated[
    str | None,
    typer.Option(
        "--prior-from",
        metavar="family|population|none|CODE",
        help="Propellers that tell what constants to expect: those of its family, or any where it "
        "is not known; any; none; those of the family CODE, as apcsf. By default family, and none "
        "where --free or --airfoil says what to fit.",
    ),
]


def section_prior(
    wanted: str | None, prop: str, blade: Propeller | None = None, *, by_default: bool
) -> SectionPrior | None:
    """What other propellers tell of ``prop``; None for no prior.

    Parameters
    ----------
    wanted : str or None
        As ``--prior-from``.
    prop : str
        The propeller: a name of the catalogue, a designation, or anything else for an unknown one.
    blade : Propeller, optional
        Its blade, which tells its size; a middling one where it is not given.
    by_default : bool
        Whether there is a prior where none is asked for.

    Raises
    ------
    InputError
        For an unknown family.
    """
    source = (wanted or ("family" if by_default else "none")).strip().lower()
    if source == "none":
        return None
    meant = _meant(prop)
    family = meant.family if meant is not None else None
    known = None if meant is None or blade is None else own_constants(meant, blade.blades)
    own = known.tested if known is not None else None
    if source == "population":
        family = None
    elif source != "family":
        family = _family(source)
    size = None if blade is None else size_of(meant, blade)
    geometry = meant.geometry if isinstance(meant, ExpectedBlade) else "measured"
    distribution = expected_prior(family, size, geometry, without=own)
    members = siblings(family, without=own)
    few = "one propeller" if members == 1 else f"{members} propellers"
    of = f"{few} of the family {family}" if members else "small propellers of all families"
    told = f"what {of} let expect is the prior of the section constants"
    if own:
        told += " (its own in the catalogue left out)"
    return SectionPrior(distribution, airfoil_at(distribution.mean, "expected", told), told)


def say_prior(prior: SectionPrior | None) -> list[str]:
    """Say on standard error what a fit started from; the same as remarks for its file."""
    if prior is None:
        return []
    typer.echo(f"note: {prior.source}; without, by --prior-from none", err=True)
    return [prior.source]


def _meant(prop: str) -> Entry | ExpectedBlade | None:
    """What a name means; None for a file, or for the name of a blade in one."""
    try:
        return meant_by(prop)
    except InputError:
        return None


def _family(code: str) -> str:
    known = sorted({one.family for one in all_identified()})
    if code not in known:
        close = difflib.get_close_matches(code, known, n=3) or known
        raise InputError(
            f"{quoted(code)} is no family of identified propellers",
            f"give family, population, none or a code such as {', '.join(close)}",
            "--prior-from",
        )
    return code


# -------------------------------------------------------------------------------------------------
# Options of fits to flights, and which parameters are free in them by default.

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
