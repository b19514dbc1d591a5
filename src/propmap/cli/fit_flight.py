"""``propmap fit flight`` and ``propmap fit terms``: section parameters from logs of flights."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import numpy as np
from typer import Argument, Option, echo

from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.cli.fit import FitChoice, Output, PriorFrom, check_outputs, finish, note_prior
from propmap.errors import InputError, quoted
from propmap.fit import comparison, flight, parameters
from propmap.fit.files import fit_text
from propmap.fit.fit import fit, range_warnings
from propmap.fit.moments import CENTRE
from propmap.fit.tunnel import first_guess, model_with, section_with
from propmap.flight import checks, steady
from propmap.model.airfoil import PAPER_FOUR, parameter_set
from propmap.model.envelope import MAIN_PART
from propmap.model.model import Model
from propmap.model.plausibility import air_warnings, blade_warnings
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.vehicle.files import VehicleFile, read_vehicle
from propmap.vehicle.log import (
    DERIVATIVE_CUTOFF,
    FEWEST_PER_PERIOD,
    FlightLog,
    flight_log,
    flight_names,
    joined,
    low_passed,
)
from propmap.vehicle.log_checks import check_recording
from propmap.vehicle.log_readers import read_recording
from propmap.vehicle.throttle import CURVE, HOVER_DRIVE, ThrottleCurve
from propmap.vehicle.vehicle import Vehicle

# -------------------------------------------------------------------------------------------------
# Logs of flight fits and checks, as samples or as operating points.

ENOUGH_STRETCHES = 4
FROM_THROTTLE = (
    "rotor speeds are from throttle, by a curve that is fitted with the rest: thrust and drag are "
    "known less well than from measured speeds, torque and power hardly"
)
UNKNOWN_BATTERY = (
    "there is no voltage of the battery beside the throttle, and thrust drifts as it empties: name "
    "battery_voltage or hover_throttle in [log.columns], or log it"
)


class Flights(NamedTuple):
    """A log, whether it holds steady operating points alone, and remarks for the report."""

    level: bool
    log: FlightLog
    remarks: tuple[str, ...]
    curve: Mapping[str, float] = {}  # constants of a ``ThrottleCurve``


def read_flights(
    paths: Sequence[Path],
    file: VehicleFile,
    method: str,
    *,
    seconds: float = 2.0,
    samples: int = 2**31,
    low_pass: float = 0.0,
    picture: Path | None = None,
    curve: Mapping[str, float] | None = None,
) -> Flights:
    """Read logs, or tables of operating points, for the method "level", "balance" or "auto".

    Steady stretches last ``seconds`` at least, and are drawn as a ``picture``. Whole flights
    have so many ``samples`` at most, as neighbours err alike, with all signals passed below
    ``low_pass`` [Hz], 0 for none.  Rotor speeds from throttle are by the constants of a ``curve``,
    by default the usual ones and the logs' own hover.
    """
    names = flight_names([str(path) for path in paths])
    if all_level_tables(paths):
        if method == "balance":
            fault = "a level-flight table has no accelerations"
            raise InputError(fault, "fit it with --method level")
        tables = [steady.read_level_table(path, file.vehicle) for path in paths]
        nominal, found = _nominal_rotor(file), list[str]()
        for table in tables:
            try:
                found += checks.check_rotor_speed(table, nominal, file.vehicle, "rpm")
            except InputError as error:
                remedy = "give rpm_1, rpm_2 ... in revolutions per minute of the propeller"
                raise InputError(error.found, remedy, table.source) from None
        return Flights(True, joined(tables, names), tuple(found))
    logs, remarks, curve = _recorded(paths, file, curve)
    if method == "level" and any(log.commanded for log in logs):
        fault = "steady stretches with throttle in place of rotor speeds say nothing of the blade: "
        fault += "they carry the weight at any"
        raise InputError(fault, "use --method balance, or log rotor speeds")
    if method != "balance" and not any(log.commanded for log in logs):
        points = _points(logs, seconds, picture, needed=method == "level")
        if points is not None:
            return Flights(True, points, tuple(remarks))
        remarks.append(
            f"fewer than {ENOUGH_STRETCHES} steady stretches of {seconds:g} s: the balance of all "
            "forces at all times is fitted instead"
        )
    needed = FEWEST_PER_PERIOD * low_pass
    for log in logs:
        rate = 1.0 / float(np.median(np.diff(log.time)))
        if rate < needed:
            remarks.append(
                f"{log.source}: {rate:.3g} samples per second are too few for a low-pass at "
                f"{low_pass:g} Hz, which takes {needed:g}, and are fitted as they are: log the "
                f"slowest signal faster, or lower --low-pass to {rate / FEWEST_PER_PERIOD:.2g}"
            )
    logs = _turning([low_passed(log, low_pass) for log in logs], file.vehicle, curve)
    flying = joined([log.picked(steady.airborne(log)) for log in logs], names)
    picked = np.unique(np.linspace(0, len(flying) - 1, min(samples, len(flying))).astype(int))
    return Flights(False, flying.picked(picked), tuple(remarks), curve)


def _recorded(
    paths: Sequence[Path], file: VehicleFile, curve: Mapping[str, float] | None
) -> tuple[list[FlightLog], list[str], Mapping[str, float]]:
    """Read logs, with warnings on what they may not be, and the curve from throttle to speeds."""
    logs, remarks = list[FlightLog](), list[str]()
    for path in paths:
        recording = read_recording(path, file)
        remarks += check_recording(recording)
        logs.append(flight_log(recording, file))
        if logs[-1].source != recording.source:
            remarks.append(logs[-1].source)
        if recording.commanded and recording.supply is None:
            remarks.append(f"{recording.source}: {UNKNOWN_BATTERY}")
    driven = [log.source for log in logs if log.commanded]
    if driven:
        remarks.append(FROM_THROTTLE)
        if curve is None:
            curve = {HOVER_DRIVE: checks.drive_in_hover(logs)}
        if HOVER_DRIVE not in curve:
            found = "there is throttle and no rotor speed, and the constants are of measured ones"
            remedy = "compare with a log of rotor speeds, or fit logs with throttle as well"
            raise InputError(found, remedy, driven[0])
    curve = curve or {}
    logs = _turning(logs, file.vehicle, curve)
    for log in logs:
        # Where it need not be stated, it is rpm.
        unit = file.log.rotor_unit or "rpm"
        remarks += checks.check_rotor_speed(log, _nominal_rotor(file), file.vehicle, unit)
        checks.check_rotor_order(log, file.vehicle)
    return logs, [*remarks, *checks.mixed_vehicles(logs, file.vehicle)], curve


def _turning(
    logs: list[FlightLog], vehicle: Vehicle, curve: Mapping[str, float]
) -> list[FlightLog]:
    """Give the logs rotor speeds by a ``curve`` where they have throttle."""
    if not any(log.commanded for log in logs):
        return logs
    return [log.with_curve(ThrottleCurve.of(vehicle, curve)) for log in logs]


def _points(
    logs: list[FlightLog], seconds: float, picture: Path | None, *, needed: bool
) -> FlightLog | None:
    found = []
    for log in logs:
        try:
            stretches = steady.steady_stretches(log, seconds=seconds)
        except InputError:
            if needed and len(logs) == 1:
                raise
            continue
        if picture is not None:
            from propmap.report.fit_curves import steady_parts

            out.save_picture(steady_parts(log, stretches), picture)
        found.append(steady.operating_points(log, stretches))
    if not found or (not needed and sum(len(p) for p in found) < ENOUGH_STRETCHES):
        if needed:
            fault = f"no log has a steady stretch of {seconds:g} s"
            raise InputError(fault, "lower --seconds, or use --method balance")
        return None
    return joined(found)


def _nominal_rotor(file: VehicleFile) -> Rotor:
    return Rotor(Model(file.vehicle.propeller, parameter_set("paper-apc"), file.vehicle.air))


def all_level_tables(paths: Sequence[Path]) -> bool:
    """Return whether all files are tables of operating points."""
    return all(steady.is_level_table(path) for path in paths)


# -------------------------------------------------------------------------------------------------
# What is free in fits to flights, and what is known of it beforehand.

LowPass = Annotated[
    float | None,
    Option(
        "--low-pass",
        metavar="HZ",
        help="Cut-off of all signals of whole flights; by default 6, 0 for none.",
    ),
]
BLADE = ("c_l1", "c_d", "alpha_0", "zero_lift_angle", "c_d0", "reynolds_camber")
"""Constants of the blade that a flight moves; it says nothing of the others."""
BODY_PLATE = "plate_area"
BODY_ALONG_Z = (BODY_PLATE, "download_area_x", "download_area_y")
"""Terms of the body that the drag of the rotors' mounts does not take the place of."""

# Standard deviations: areas of a body over that of all disks, and of a mount over that of its
# disk; places of the accelerometer and of the centre of mass over the hubs' mean distance; mass of
# a rotor at its radius over the vehicle's.
BODY_SHARE, MOUNT_SHARE = 0.4, 0.1
SENSOR_SHARE, CENTRE_SHARE = 0.5, 0.1
ROTOR_SHARE = 0.01


def flight_priors(vehicle: Vehicle, log: FlightLog, *, hover: bool) -> dict[str, parameters.Prior]:
    """Give priors of all parameters but the section's, and of stall, by the vehicle's size.

    With ``hover``, the thrust scale of each flight is expected where its own hover has it.
    """
    disk = math.pi * vehicle.propeller.radius**2
    bodies = parameters.Prior(0.0, BODY_SHARE * disk * len(vehicle.mounts))
    places = [math.hypot(*mount.position) for mount in vehicle.mounts]
    arm = sum(places) / len(places) or vehicle.propeller.radius
    heavy = ROTOR_SHARE * vehicle.mass * vehicle.propeller.radius**2
    scale = flight.HoverScale.of(vehicle, log)
    if not hover:
        scale = replace(scale, measured={})
    return {
        **parameters.IN_FLIGHT,
        **dict.fromkeys(parameters.BODY, bodies),
        "mount_area": parameters.Prior(0.0, MOUNT_SHARE * disk),
        **dict.fromkeys(flight.OFFSET, parameters.Prior(0.0, SENSOR_SHARE * arm)),
        **dict.fromkeys(
            ("clock_offset", *flight.of_each("clock_offset", log)),
            parameters.Prior(0.0, flight.CLOCK_DEVIATION),
        ),
        **dict.fromkeys(CENTRE, parameters.Prior(0.0, CENTRE_SHARE * arm)),
        "rotor_inertia": parameters.Prior(0.0, heavy),
        "thrust_scale": parameters.Prior(1.0, flight.OVER_FLIGHTS),
        **scale.priors,
    }


def free_by_default(vehicle: Vehicle, log: FlightLog, *, level: bool) -> tuple[str, ...]:
    """List what a fit to flights varies where nothing is stated.

    With steady stretches (``level``) the paper's four; with whole flights what else moves the
    residuals: drag of the rotors' mounts, which takes the place of the body's in the disk plane,
    the body's along z, the accelerometer, the wakes of several rotors on each other, and of each
    flight of the ``log`` the clock and, beside others, the thrust scale.
    """
    if level:
        return PAPER_FOUR
    turning = tuple(parameters.TURNING) if vehicle.inertia else ()
    mount = () if any(one.drag for one in vehicle.mounts) else tuple(parameters.INSTALLED)
    wakes = tuple(parameters.WAKES) if len(vehicle.mounts) > 1 else ()
    scales = flight.of_each("thrust_scale", log) if len(log.flights) > 1 else ()
    driven = (*CURVE, *flight.TILT) if log.commanded else ()
    own = (*flight.of_each("clock_offset", log), *scales, *driven)
    # A wing is a plate itself, with the lift of one at an angle.
    body = BODY_ALONG_Z if vehicle.wing is None else ("drag_area_z", *BODY_ALONG_Z[1:])
    return (*BLADE, *parameters.FLEX, *mount, *body, *flight.OFFSET, *turning, *wakes, *own)


def with_flight_priors(
    choice: parameters.Choice, known: Mapping[str, parameters.Prior]
) -> parameters.Choice:
    """Add what is known of those free parameters that have no prior.

    The body's plate starts at a deviation: 0 is its bound, which searches leave so slowly that they
    end in other minima.
    """
    more = {n: p for n, p in known.items() if n in choice.free and n not in choice.priors}
    start = {n: p.deviation for n, p in more.items() if n == BODY_PLATE}
    return replace(choice, priors={**more, **choice.priors}, start={**start, **choice.start})


# -------------------------------------------------------------------------------------------------
# ``propmap fit flight``: section parameters from flight logs of a vehicle.

# One in so many samples of whole flights is fitted from all starts, and all from the best end.
EVERY, FEW = 3, 1500


@opt.takes_choices
def fit_flight(
    logs: Annotated[
        list[Path],
        Argument(
            metavar="LOG...", help="CSV, Parquet, ULog, DataFlash, bag, or a level-flight table."
        ),
    ],
    vehicle: opt.VehicleOption,
    output: Output,
    method: Annotated[
        Literal["auto", "level", "balance"],
        Option(
            help="level: vertical balance of steady stretches, as in the paper; balance: all "
            "forces at all times; auto: level if there are enough steady stretches."
        ),
    ] = "auto",
    name_or_file: Annotated[
        str | None,
        Option(
            "--airfoil", metavar="NAME|FILE", help="Take the values of what is not free from here."
        ),
    ] = None,
    physics: opt.ModelOption = None,
    correction: opt.Corrections = None,
    seconds: Annotated[float, Option(help="Shortest steady stretch [s].")] = 2.0,
    samples: Annotated[
        int, Option(min=10, help="Largest number of samples used of whole flights.")
    ] = 500,
    low_pass: LowPass = None,
    hover_scale: Annotated[
        bool,
        Option(
            "--hover-scale/--no-hover-scale",
            help="Expect each flight's thrust scale where its own hover has it.",
        ),
    ] = True,
    body_study: Annotated[
        bool, Option("--body-study", help="Say whether terms for body lift and drag pay.")
    ] = False,
    stretches_picture: Annotated[
        Path | None, Option("--stretches", metavar="FILE", help="Draw the steady stretches.")
    ] = None,
    cluster: opt.Cluster = None,
    asked: FitChoice = FitChoice(starts=2),  # noqa: B008 - frozen
) -> None:
    """Fit flight logs of a vehicle.

    Whole flights have a thrust scale (where there are several) and a clock each. Wind is not
    estimated: state it in the vehicle file.
    """
    check_outputs(output, asked.picture, stretches_picture)
    base = opt.constants(name_or_file) if name_or_file else None
    file = read_vehicle(vehicle)
    warnings = [*blade_warnings(file.vehicle.propeller), *air_warnings(file.vehicle.air)]
    out.note(*warnings)
    cutoff = DERIVATIVE_CUTOFF if low_pass is None else low_pass
    flights = read_flights(
        logs,
        file,
        method,
        seconds=seconds,
        samples=samples,
        low_pass=cutoff,
        picture=stretches_picture,
    )
    default = free_by_default(file.vehicle, flights.log, level=flights.level)
    blade = file.vehicle.propeller
    expected = asked.expected(blade.name, blade, base)
    wing = flight.wing_values(file.vehicle)
    if not flights.level and asked.free is None:
        # With one blade in one air, what hardly moves stays where other propellers have it.
        held, believed = (
            [text.partition("=")[0].strip() for text in texts or ()]
            for texts in (asked.fix, asked.prior)
        )
        free = [name for name in dict.fromkeys((*default, *believed)) if name not in held]
        asked = replace(asked, free=",".join(free))
    chosen = asked.chosen(default, base, wing, expected)
    chosen = replace(chosen, fixed={**flights.curve, **chosen.fixed})
    if not flights.level:
        known = flight_priors(file.vehicle, flights.log, hover=hover_scale)
        if expected is None:
            del known["alpha_0"]
        chosen = with_flight_priors(chosen, known)
    law = base or (expected.airfoil if expected else first_guess())
    law = opt.with_physics(law, physics, correction)
    model = flight.ForceModel(file.vehicle, flights.log, law)
    make = flight.level_rows if flights.level else flight.balance_rows
    fewer = None
    if not flights.level and flights.log.rotor_speed.size >= FEW:
        part = flights.log.picked(slice(None, None, EVERY))
        fewer = make(flight.ForceModel(file.vehicle, part, law), chosen)
    remake = functools.partial(make, model, chosen)
    with opt.workers_of_bootstrap(cluster, asked.bootstrap) as workers:
        fitted = fit(remake(), chosen, asked.settings, fewer, workers=workers, remake=remake)
    if flights.curve:
        (turning,) = _turning([flights.log], file.vehicle, fitted.values)
        model = flight.ForceModel(file.vehicle, turning, law)
    remarks = [*flights.remarks, *range_warnings(fitted.rows)]
    remarks += comparison.residual_trends(fitted, model.log)
    remarks += comparison.unlikely_constants(fitted)
    if body_study:
        remarks += comparison.body_terms_verdict(fitted, lambda c: make(model, c))
    flown = comparison.by_flight(fitted, flights.log)
    wanted = hover_scale and not flights.level
    hovers = flight.HoverScale.of(file.vehicle, model.log) if wanted else None
    text = fit_text(
        fitted,
        kind="level flight" if flights.level else "flight",
        name=output.stem,
        model=model.model,
        data=[*logs, vehicle],
        covered=model.coverage(),
        envelope=model.envelope((0.0, 100.0) if flights.level else MAIN_PART),
        hover=flight.hover_rows(model, fitted.values, fitted.rows),
        remarks=[*note_prior(expected), *remarks, *warnings],
        options={
            "seconds": seconds,
            "samples": samples,
            "low_pass": 0.0 if flights.level else cutoff,
            "hover_reference": (hovers and hovers.reference_at(fitted.values)) or 0.0,
            "vehicle": file.vehicle.name,
        },
        flights=flown,
    )
    if asked.picture is not None:
        from propmap.report.fit_curves import level_flight

        drawn = section_with(model.model.airfoil, fitted.values)
        out.save_picture(level_flight(file.vehicle, model.log, drawn), asked.picture)
    finish(fitted, model_with(model.model, fitted.values), remarks, text, output, flown)


# -------------------------------------------------------------------------------------------------
# ``propmap fit terms``: what each term of a flight fit is worth, as a page.

ALMOST_NONE = 1e-9  # area [m^2] of a mount that drags nothing
STALL = ("c_l1", "c_d", "alpha_0")  # the paper's four without c_l2, which level flights do not show
DRAGS, DOWN = ("drag_area_x", "drag_area_y", "drag_area_z"), ("download_area_x", "download_area_y")
ENDINGS = ("x", "y", "z")


def fit_terms_page(
    logs: Annotated[
        list[Path],
        Argument(metavar="LOG...", help="CSV, Parquet, ULog, DataFlash or bag; two or more."),
    ],
    vehicle: opt.VehicleOption,
    output: out.FolderOutput,
    samples: Annotated[
        int, Option(min=10, help="Largest number of samples that each fit takes.")
    ] = 300,
    low_pass: LowPass = None,
    prior_from: PriorFrom = None,
    prediction: Annotated[
        str | None,
        Option(
            metavar="COLUMNS",
            help="Compare with the forces along x, y, z [N] that something else predicts, in three "
            "columns of CSV logs, separated by commas. By default those ending in _fx, _fy, _fz.",
        ),
    ] = None,
) -> None:
    """Write a page that says which terms of a flight fit pay.

    The steps are the hover model, the vertical balance, then one term more at a time. Each is
    fitted to all flights but one and checked on that one, beside a prediction that comes with
    the logs.
    """
    from propmap.report.html import PAGE, TERMS_FILES, check_folder, write_folder

    check_folder(output, TERMS_FILES)
    file = read_vehicle(vehicle)
    # Moments play no part here, and the wakes are one of the terms.
    file = replace(file, vehicle=replace(file.vehicle, inertia=None, wakes=None))

    from propmap.report.terms_page import terms_pages

    cutoff = DERIVATIVE_CUTOFF if low_pass is None else low_pass
    flights, remarks = read_pairs(logs, file, cutoff, prediction)
    prior = expected(prior_from, file.vehicle)
    known = flight_priors(file.vehicle, flights[0].passed, hover=False)
    law = prior.airfoil.with_corrections(["pitt-peters"])
    found = comparison.fit_terms(
        file.vehicle,
        flights,
        steps(file.vehicle, prior, known),
        law,
        samples=samples,
        tell=lambda text: echo(text, err=True),
    )
    pages = terms_pages(
        file.vehicle, flights, found, low_pass=cutoff, samples=samples, remarks=remarks
    )
    write_folder(output, pages, TERMS_FILES)
    echo(f"wrote {output / PAGE} and {len(pages) - 1} files beside it")


def expected(prior_from: str | None, vehicle: Vehicle) -> parameters.SectionPrior:
    """Predict the constants of the vehicle's blade; ``InputError`` where no prior is wanted."""
    blade = vehicle.propeller
    prior = FitChoice(prior_from=prior_from).expected(blade.name, blade, None)
    if prior is None:
        raise InputError("the terms are fitted with a prior", "leave --prior-from none out")
    return prior


def steps(
    vehicle: Vehicle, prior: parameters.SectionPrior, known: Mapping[str, parameters.Prior]
) -> list[comparison.Step]:
    """List models of a vehicle's flights, each with one term more.

    Other propellers give the ``prior`` of the blade; ``known`` are the priors of other terms.
    """
    own_mounts = any(one.drag for one in vehicle.mounts)
    mount = () if own_mounts else tuple(parameters.INSTALLED)
    drag = DRAGS if own_mounts else (*mount, "drag_area_z")
    blade = (*BLADE, *drag, *flight.OFFSET, "clock_offset")
    wakes = tuple(parameters.WAKES) if len(vehicle.mounts) > 1 else ()
    named = {
        "three axes, body drag": (*BLADE, *DRAGS),
        "accelerometer's place and clock": (*BLADE, *DRAGS, *flight.OFFSET, "clock_offset"),
        "drag of installed rotors for the body's in x, y": () if own_mounts else blade,
        "the rotors' wakes": (*blade, *wakes) if wakes else (),
        "blades that give way": (*blade, *wakes, *parameters.FLEX),
        "download of the body": (*blade, *wakes, *parameters.FLEX, *DOWN),
        "the body as a plate": (*blade, *wakes, *parameters.FLEX, *DOWN, BODY_PLATE),
    }

    at = {name: float(getattr(prior.airfoil, name)) for name in parameters.SECTION}
    bare = {name: max(parameters.INSTALLED[name].start, ALMOST_NONE) for name in mount}
    absent = {**bare, **dict.fromkeys(parameters.FLEX, 0.0)}

    def choice(free: tuple[str, ...]) -> parameters.Choice:
        """Hold what is not free where other propellers have it, or absent."""
        fixed = {name: value for name, value in {**at, **absent}.items() if name not in free}
        start = {name: value for name, value in at.items() if name in free}
        return with_flight_priors(parameters.Choice(free, fixed, {}, start, prior), known)

    found = [comparison.Step("vertical balance alone", choice(STALL), vertical=True)]
    return found + [comparison.Step(name, choice(f)) for name, f in named.items() if f]


def read_pairs(
    paths: Sequence[Path], file: VehicleFile, cutoff: float, prediction: str | None
) -> tuple[list[comparison.RecordedFlight], list[str]]:
    """Read flights, their signals low-passed below ``cutoff`` [Hz] and raw, and remarks on them.

    Raises ``InputError`` for bad logs, and for columns of the ``prediction`` that are not there.
    """
    names = [path.stem for path in paths]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise InputError(f"two logs are called {twice[0]!r}", "give each flight once")
    found: list[comparison.RecordedFlight] = []
    remarks: list[str] = []
    for path in paths:
        passed, raw = (read_flights([path], file, "balance", low_pass=hz) for hz in (cutoff, 0.0))
        remarks += passed.remarks
        if passed.log.commanded:
            fault = "there are commands to the motors in place of rotor speeds"
            raise InputError(fault, "compare terms on flights with measured speeds", str(path))
        if not np.isfinite(passed.log.specific_force).all():
            fault = "there is no specific force (accelerometer) for all samples"
            raise InputError(fault, "log it", str(path))
        both = [
            _predicted(path, file, flown.log.time, hz, prediction)
            for flown, hz in ((passed, cutoff), (raw, 0.0))
        ]
        found.append(comparison.RecordedFlight(path.stem, passed.log, raw.log, *both))
    return found, remarks


def _predicted(
    path: Path, file: VehicleFile, time: Floats, cutoff: float, columns: str | None
) -> Floats | None:
    """Read forces [N] (n, 3) that columns of a CSV log predict at these times, low-passed."""
    if path.suffix.lower() != ".csv":
        return None
    with path.open(encoding="utf-8-sig", errors="replace") as lines:
        heads = [head.strip().strip('"') for head in lines.readline().split(",")]
    if columns is not None:
        names = [name.strip() for name in columns.split(",")]
        missing = [name for name in names if name not in heads]
        if missing or len(names) != len(ENDINGS):
            what = quoted(missing[0]) + " is no column" if missing else f"{len(names)} columns"
            raise InputError(f"--prediction: {what}", "name three columns of the log", str(path))
    else:
        stems = [head.removesuffix("_fx") for head in heads if head.endswith("_fx")]
        whole = [s for s in stems if all(f"{s}_f{axis}" in heads for axis in ENDINGS)]
        if len(whole) != 1:
            return None
        names = [f"{whole[0]}_f{axis}" for axis in ENDINGS]
    (clock,) = file.log.columns.get("time", (heads[0],))
    use = [heads.index(name) for name in (clock, *names)]
    table = np.genfromtxt(path, delimiter=",", skip_header=1, usecols=use)
    at, raw = table[:, 0], table[:, 1:]
    none = np.zeros_like(raw)
    up = none + np.array([0.0, 0.0, 1.0])
    carrier = FlightLog("prediction", at, raw, none, up, none, np.ones((len(raw), 1)))
    found = low_passed(carrier, cutoff).velocity
    return np.stack([np.interp(time, at, column) for column in found.T], axis=1)
