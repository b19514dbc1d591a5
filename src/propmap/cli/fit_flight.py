"""``propmap fit flight`` and ``propmap fit terms``: section constants from flight logs."""

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
from propmap.cli.fit import (
    NO_DRAG,
    FitChoice,
    Output,
    PriorFrom,
    check_outputs,
    finish,
    note_prior,
    start_law,
)
from propmap.errors import InputError, quoted
from propmap.fit import comparison, flight, parameters
from propmap.fit.files import fit_text
from propmap.fit.fit import fit, range_warnings
from propmap.fit.moments import CENTER
from propmap.fit.tunnel import first_guess, model_with, section_with
from propmap.flight import checks, steady
from propmap.model.airfoil import PAPER_FOUR, parameter_set
from propmap.model.corrections import INSTALLED
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
from propmap.vehicle.log_readers import read_csv_log, read_recording
from propmap.vehicle.throttle import CURVE, HOVER_DRIVE, ThrottleCurve
from propmap.vehicle.vehicle import Vehicle

# --- Logs for fits and checks, as samples of whole flights or as steady operating points ---------

ENOUGH_SEGMENTS = 4
FROM_THROTTLE = (
    "a fitted curve converts throttle to rotor speed: thrust and drag are less certain than with "
    "measured rotor speeds, and the data hardly determine torque and power"
)
UNKNOWN_BATTERY = (
    "the log has throttle but no battery voltage, so the thrust at a given throttle drifts as the "
    "battery empties: name battery_voltage or hover_throttle in [log.columns], or log the voltage"
)


class Flights(NamedTuple):
    """A log, whether it contains only steady operating points, and remarks for the report."""

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

    Steady segments last at least ``seconds``, and ``picture`` shows them.  Whole flights have at
    most this number of ``samples``, because adjacent samples have similar errors; ``low_pass``
    [Hz] filters all signals, 0 for no filter.  ``curve`` has the constants that convert throttle
    to rotor speed, by default usual values and the hover throttle of the logs.
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
        fault = "steady segments with throttle instead of rotor speeds do not determine the "
        fault += "blade: any rotor speed could carry the weight"
        raise InputError(fault, "use --method balance, or log rotor speeds")
    if method != "balance" and not any(log.commanded for log in logs):
        points = _points(logs, seconds, picture, needed=method == "level")
        if points is not None:
            return Flights(True, points, tuple(remarks))
        remarks.append(
            f"fewer than {ENOUGH_SEGMENTS} steady segments of {seconds:g} s: the balance of all "
            "forces at all times is fitted instead"
        )
    needed = FEWEST_PER_PERIOD * low_pass
    for log in logs:
        rate = 1.0 / float(np.median(np.diff(log.time)))
        if rate < needed:
            remarks.append(
                f"{log.source}: unfiltered, because {rate:.3g} samples per second are too few for "
                f"a low-pass at {low_pass:g} Hz (expected {needed:g}): log the slowest signal "
                f"faster, or lower --low-pass to {rate / FEWEST_PER_PERIOD:.2g}"
            )
    logs = _turning([low_passed(log, low_pass) for log in logs], file.vehicle, curve)
    flying = joined([log.picked(steady.airborne(log)) for log in logs], names)
    picked = np.unique(np.linspace(0, len(flying) - 1, min(samples, len(flying))).astype(int))
    return Flights(False, flying.picked(picked), tuple(remarks), curve)


def _recorded(
    paths: Sequence[Path], file: VehicleFile, curve: Mapping[str, float] | None
) -> tuple[list[FlightLog], list[str], Mapping[str, float]]:
    """Read logs, warnings on probable mistakes, and the curve from throttle to rotor speeds."""
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
            found = "the log has only throttle, but the fit used measured rotor speeds"
            remedy = "compare with a log of rotor speeds, or add logs with throttle to the fit"
            raise InputError(found, remedy, driven[0])
    curve = curve or {}
    logs = _turning(logs, file.vehicle, curve)
    for log in logs:
        # The vehicle file may omit the unit only if it is rpm.
        unit = file.log.rotor_unit or "rpm"
        remarks += checks.check_rotor_speed(log, _nominal_rotor(file), file.vehicle, unit)
        checks.check_rotor_order(log, file.vehicle)
    return logs, [*remarks, *checks.mixed_vehicles(logs, file.vehicle)], curve


def _turning(
    logs: list[FlightLog], vehicle: Vehicle, curve: Mapping[str, float]
) -> list[FlightLog]:
    """Return the logs with rotor speeds computed by the ``curve`` for logs with throttle."""
    if not any(log.commanded for log in logs):
        return logs
    return [log.with_curve(ThrottleCurve.of(vehicle, curve)) for log in logs]


def _points(
    logs: list[FlightLog], seconds: float, picture: Path | None, *, needed: bool
) -> FlightLog | None:
    found = []
    for log in logs:
        try:
            segments = steady.steady_segments(log, seconds=seconds)
        except InputError:
            if needed and len(logs) == 1:
                raise
            continue
        if picture is not None:
            from propmap.report.fit_curves import steady_parts

            out.save_picture(steady_parts(log, segments), picture)
        found.append(steady.operating_points(log, segments))
    if not found or (not needed and sum(len(p) for p in found) < ENOUGH_SEGMENTS):
        if needed:
            fault = f"no log has a steady segment of {seconds:g} s"
            raise InputError(fault, "lower --seconds, or use --method balance")
        return None
    return joined(found)


def _nominal_rotor(file: VehicleFile) -> Rotor:
    return Rotor(Model(file.vehicle.propeller, parameter_set("paper-apc"), file.vehicle.air))


def all_level_tables(paths: Sequence[Path]) -> bool:
    """Return whether all files are tables of operating points."""
    return all(steady.is_level_table(path) for path in paths)


# --- Free parameters of flight fits, and their priors --------------------------------------------

LowPass = Annotated[
    float | None,
    Option(
        "--low-pass",
        metavar="HZ",
        help="Cut-off frequency in Hz of the low-pass filter of the signals; 0 for no filter "
        "(default: 6). Steady segments are not filtered.",
    ),
]
BLADE = ("c_l1", "c_d", "alpha_0", "zero_lift_angle", "c_d0", "reynolds_camber")
"""Constants of the blade that flights determine."""
BODY_PLATE = "plate_area"

# Prior standard deviations, divided by a scale: body areas by the area of all disks, mount area by
# one disk area, positions of accelerometer and center of mass by the mean distance of the hubs,
# mass of a rotor (at its radius) by the mass of the vehicle.
BODY_SHARE, MOUNT_SHARE = 0.4, 0.1
SENSOR_SHARE, CENTER_SHARE = 0.5, 0.1
ROTOR_SHARE = 0.01


def flight_priors(vehicle: Vehicle, log: FlightLog, *, hover: bool) -> dict[str, parameters.Prior]:
    """Return priors of stall and of all parameters outside the section law, for the vehicle's size.

    With ``hover``, the prior of each thrust scale follows from the hover phases of its flight.
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
        **{
            one: parameters.Prior(parameters.EVERY[name].start, deviation)
            for name, deviation in parameters.PER_FLIGHT.items()
            for one in flight.of_each(name, log)
        },
        "clock_offset": parameters.Prior(0.0, parameters.PER_FLIGHT["clock_offset"]),
        "thrust_scale": parameters.Prior(1.0, parameters.PER_FLIGHT["thrust_scale"]),
        **dict.fromkeys(CENTER, parameters.Prior(0.0, CENTER_SHARE * arm)),
        "rotor_inertia": parameters.Prior(0.0, heavy),
        **scale.priors,
    }


def free_by_default(vehicle: Vehicle, log: FlightLog, *, level: bool) -> tuple[str, ...]:
    """Return the parameters that a fit to flights varies by default.

    Fits to steady segments (``level``) vary the four constants of the paper.  Fits to whole
    flights vary ``BLADE``, and the parameters below that apply to the vehicle and the ``log``.
    Body and wakes of rotors vary only if the flight ``is_fast``.  The drag of the rotor mounts
    replaces the body drag in the disk plane.
    """
    if level:
        return PAPER_FOUR
    turning = tuple(parameters.TURNING) if vehicle.inertia else ()
    mount = () if any(one.drag for one in vehicle.mounts) else tuple(parameters.INSTALLED)
    fast = flight.is_fast(vehicle, log)
    wakes = tuple(parameters.WAKES) if fast and len(vehicle.mounts) > 1 else ()
    scales = flight.of_each("thrust_scale", log) if len(log.flights) > 1 else ()
    driven = (*CURVE, *flight.TILT) if log.commanded else ()
    own = (*flight.of_each("clock_offset", log), *scales, *driven)
    body = body_along_z(vehicle) if fast else ()
    return (*BLADE, *parameters.FLEX, *mount, *body, *flight.OFFSET, *turning, *wakes, *own)


def body_along_z(vehicle: Vehicle) -> tuple[str, ...]:
    """Return the terms of the body that neither rotor mounts nor a wing replace."""
    plate = BODY_PLATE if vehicle.wing is None else "drag_area_z"
    return (plate, "download_area_x", "download_area_y")


def with_flight_priors(
    choice: parameters.Choice, known: Mapping[str, parameters.Prior]
) -> parameters.Choice:
    """Add the ``known`` priors of free parameters that have no prior.

    The plate area of the body starts at one standard deviation.  From its bound of 0, searches
    move so slowly that they end in other minima.
    """
    more = {n: p for n, p in known.items() if n in choice.free and n not in choice.priors}
    start = {n: p.deviation for n, p in more.items() if n == BODY_PLATE}
    return replace(choice, priors={**more, **choice.priors}, start={**start, **choice.start})


# --- ``propmap fit flight``: section constants from flight logs of a vehicle ---------------------

# With FEW samples or more, all starts use only one in EVERY samples of whole flights; the fit to
# all samples then starts from the best result.
EVERY, FEW = 3, 1500


@opt.takes_choices
def fit_flight(
    logs: Annotated[
        list[Path],
        Argument(
            metavar="LOG...",
            help="Flight logs (CSV, Parquet, ULog, DataFlash, bag), or CSV tables of level flight.",
        ),
    ],
    vehicle: opt.VehicleOption,
    output: Output,
    method: Annotated[
        Literal["auto", "level", "balance"],
        Option(
            help="level: vertical force balance in steady segments, as in the paper; balance: all "
            "forces at all times; auto: level if there are enough steady segments, else balance."
        ),
    ] = "auto",
    name_or_file: opt.FitAirfoilOption = None,
    physics: opt.ModelOption = None,
    correction: opt.Corrections = None,
    seconds: Annotated[float, Option(help="Minimum length of a steady segment in s.")] = 2.0,
    samples: Annotated[
        int, Option(min=10, help="Maximum number of samples for --method balance.")
    ] = 500,
    low_pass: LowPass = None,
    hover_scale: Annotated[
        bool,
        Option(
            "--hover-scale/--no-hover-scale",
            help="Use the hover phases of each flight for the prior of its thrust scale.",
        ),
    ] = True,
    body_study: Annotated[
        bool, Option("--body-study", help="Report whether body lift and body drag improve the fit.")
    ] = False,
    segments_picture: Annotated[
        Path | None,
        Option(
            "--segments",
            metavar="FILE",
            help="Picture of the steady segments: .png, .svg or .pdf.",
        ),
    ] = None,
    cluster: opt.Cluster = None,
    asked: FitChoice = FitChoice(starts=2),  # noqa: B008 - frozen
) -> None:
    """Fit section constants to flight logs of a vehicle.

    With --method balance, the fit also estimates a clock offset for each flight. With two or more
    flights, it also estimates a factor on the thrust of each flight (thrust scale). The fit does
    not estimate wind; state the wind in the vehicle file.
    """
    check_outputs(output, asked.picture, segments_picture)
    base = start_law(name_or_file)
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
        picture=segments_picture,
    )
    default = free_by_default(file.vehicle, flights.log, level=flights.level)
    blade = file.vehicle.propeller
    expected = asked.expected(blade.name, blade, base)
    wing = flight.wing_values(file.vehicle)
    if not flights.level and asked.free is None:
        # Flights of one blade in one air do not determine the other constants: these keep the
        # values expected from other propellers.
        held, believed = (
            [text.partition("=")[0].strip() for text in texts or ()]
            for texts in (asked.fix, asked.prior)
        )
        free = [
            name
            for name in dict.fromkeys((*default, *believed))
            if not {name, parameters.general(name)} & set(held)
        ]
        asked = replace(asked, free=",".join(free))
    chosen = asked.chosen(default, base, wing, expected)
    chosen = replace(chosen, fixed={**flights.curve, **chosen.fixed})
    undetermined = dict[str, float]()
    if not flights.level:
        known = flight_priors(file.vehicle, flights.log, hover=hover_scale)
        if not flight.is_fast(file.vehicle, flights.log):
            left = set(body_along_z(file.vehicle)) - {*chosen.free, *chosen.fixed}
            undetermined = {name: known[name].deviation for name in sorted(left)}
        if expected is None:
            del known["alpha_0"]
        chosen = with_flight_priors(chosen, known)
    law = base or (expected.airfoil if expected else first_guess())
    law = opt.with_physics(law, physics, correction, installed=flights.level or None)
    model = flight.ForceModel(file.vehicle, flights.log, law)
    make = flight.level_rows if flights.level else flight.balance_rows
    fewer = None
    if not flights.level and flights.log.rotor_speed.size >= FEW:
        part = flights.log.picked(slice(None, None, EVERY))
        fewer = make(flight.ForceModel(file.vehicle, part, law), chosen)
    remake = functools.partial(make, model, chosen)
    with opt.workers_of_bootstrap(cluster, asked.bootstrap) as workers:
        fitted = fit(remake(), chosen, asked.settings, fewer, workers=workers, remake=remake)
    accepted = asked.refuse_implausible(fitted, [*flights.remarks, *warnings])
    if flights.curve:
        (turning,) = _turning([flights.log], file.vehicle, fitted.values)
        model = flight.ForceModel(file.vehicle, turning, law)
    remarks = [*accepted, *flights.remarks, *range_warnings(fitted.rows)]
    if flights.level and INSTALLED in (law.corrections or ()):
        remarks.append(NO_DRAG)
    if undetermined:
        slow = f"the flights are too slow to determine {', '.join(undetermined)}"
        remarks.append(f"{slow}: the bands of faster flights contain their priors")
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
            "undetermined": undetermined,
            "vehicle": file.vehicle.name,
        },
        flights=flown,
    )
    if asked.picture is not None:
        from propmap.report.fit_curves import level_flight

        drawn = section_with(model.model.airfoil, fitted.values)
        out.save_picture(level_flight(file.vehicle, model.log, drawn), asked.picture)
    finish(fitted, model_with(model.model, fitted.values), remarks, text, output, flown)


# --- ``propmap fit terms``: a web page on the benefit of each term of a flight fit ---------------

ALMOST_NONE = 1e-9  # area of a mount without drag [m^2]
STALL = ("c_l1", "c_d", "alpha_0")  # of the paper; level flights do not determine c_l2
DRAGS, DOWN = ("drag_area_x", "drag_area_y", "drag_area_z"), ("download_area_x", "download_area_y")
ENDINGS = ("x", "y", "z")


def fit_terms_page(
    logs: Annotated[
        list[Path],
        Argument(
            metavar="LOG...", help="Two or more flight logs (CSV, Parquet, ULog, DataFlash, bag)."
        ),
    ],
    vehicle: opt.VehicleOption,
    output: out.FolderOutput,
    samples: Annotated[int, Option(min=10, help="Maximum number of samples in each fit.")] = 300,
    low_pass: LowPass = None,
    prior_from: PriorFrom = None,
    prediction: Annotated[
        str | None,
        Option(
            metavar="COLUMNS",
            help="Compare with another model: columns of the CSV logs, separated by commas, with "
            "its forces along x, y, z in N (default: the columns ending in _fx, _fy, _fz).",
        ),
    ] = None,
) -> None:
    """Report which terms of the model improve a flight fit.

    The command compares a series of models. The first is the hover model, T = k rpm^2. The second
    fits section constants to the vertical force; each later model adds one term. Each model is
    fitted to all flights except one and checked on the held-out flight. The report shows the
    errors of another model, if the logs contain its predictions.
    """
    from propmap.report.html import PAGE, TERMS_FILES, check_folder, write_folder

    check_folder(output, TERMS_FILES)
    file = read_vehicle(vehicle)
    # The comparison ignores moments, and the wakes are one of its terms.
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
    echo(f"wrote {output / PAGE} and {len(pages) - 1} other files")


def expected(prior_from: str | None, vehicle: Vehicle) -> parameters.SectionPrior:
    """Return the prior of the vehicle's blade; raise ``InputError`` for ``--prior-from none``."""
    blade = vehicle.propeller
    prior = FitChoice(prior_from=prior_from).expected(blade.name, blade, None)
    if prior is None:
        raise InputError("fit terms needs a prior", "leave --prior-from none out")
    return prior


def steps(
    vehicle: Vehicle, prior: parameters.SectionPrior, known: Mapping[str, parameters.Prior]
) -> list[comparison.Step]:
    """Return models of a vehicle's flights, each with one more term.

    ``prior`` is the prior of the blade from other propellers; ``known`` has the other priors.
    """
    own_mounts = any(one.drag for one in vehicle.mounts)
    mount = () if own_mounts else tuple(parameters.INSTALLED)
    drag = DRAGS if own_mounts else (*mount, "drag_area_z")
    blade = (*BLADE, *drag, *flight.OFFSET, "clock_offset")
    wakes = tuple(parameters.WAKES) if len(vehicle.mounts) > 1 else ()
    named = {
        "three axes, body drag": (*BLADE, *DRAGS),
        "accelerometer position and clock offset": (*BLADE, *DRAGS, *flight.OFFSET, "clock_offset"),
        "drag of installed rotors instead of body drag in x, y": () if own_mounts else blade,
        "rotor wakes": (*blade, *wakes) if wakes else (),
        "blade untwist": (*blade, *wakes, *parameters.FLEX),
        "download of the body": (*blade, *wakes, *parameters.FLEX, *DOWN),
        "horizontal parts as a flat plate": (*blade, *wakes, *parameters.FLEX, *DOWN, BODY_PLATE),
    }

    at = {name: float(getattr(prior.airfoil, name)) for name in parameters.SECTION}
    bare = {name: max(parameters.INSTALLED[name].start, ALMOST_NONE) for name in mount}
    absent = {**bare, **dict.fromkeys(parameters.FLEX, 0.0)}

    def choice(free: tuple[str, ...]) -> parameters.Choice:
        """Fix parameters that are not free at the prior mean, or at zero for absent terms."""
        fixed = {name: value for name, value in {**at, **absent}.items() if name not in free}
        start = {name: value for name, value in at.items() if name in free}
        return with_flight_priors(parameters.Choice(free, fixed, {}, start, prior), known)

    found = [comparison.Step("vertical balance alone", choice(STALL), vertical=True)]
    return found + [comparison.Step(name, choice(f)) for name, f in named.items() if f]


def read_pairs(
    paths: Sequence[Path], file: VehicleFile, cutoff: float, prediction: str | None
) -> tuple[list[comparison.RecordedFlight], list[str]]:
    """Read flights with low-passed (``cutoff`` [Hz]) and raw signals, and remarks on them.

    Raises ``InputError`` for bad logs and for missing columns of the ``prediction``.
    """
    names = [path.stem for path in paths]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise InputError(f"two logs have the name {twice[0]!r}", "give each flight once")
    found: list[comparison.RecordedFlight] = []
    remarks: list[str] = []
    for path in paths:
        passed, raw = (read_flights([path], file, "balance", low_pass=hz) for hz in (cutoff, 0.0))
        remarks += passed.remarks
        if passed.log.commanded:
            fault = "there are motor commands instead of rotor speeds"
            raise InputError(fault, "use flights with measured rotor speeds", str(path))
        if not np.isfinite(passed.log.specific_force).all():
            fault = "the specific force (accelerometer) is missing in some samples"
            raise InputError(fault, "log the accelerometer", str(path))
        both = [
            _predicted(path, file, flown.log.time, hz, prediction)
            for flown, hz in ((passed, cutoff), (raw, 0.0))
        ]
        found.append(comparison.RecordedFlight(path.stem, passed.log, raw.log, *both))
    return found, remarks


def _predicted(
    path: Path, file: VehicleFile, time: Floats, cutoff: float, columns: str | None
) -> Floats | None:
    """Read predicted forces [N] (n, 3) at these times from columns of a CSV log, low-passed."""
    if path.suffix.lower() != ".csv":
        return None
    with path.open(encoding="utf-8-sig", errors="replace") as lines:
        heads = [head.strip().strip('"') for head in lines.readline().split(",")]
    if columns is not None:
        names = [name.strip() for name in columns.split(",")]
        missing = [name for name in names if name not in heads]
        if missing or len(names) != len(ENDINGS):
            what = quoted(missing[0]) + " is not a column" if missing else f"{len(names)} columns"
            raise InputError(f"--prediction: {what}", "name three columns of the log", str(path))
    else:
        stems = [head.removesuffix("_fx") for head in heads if head.endswith("_fx")]
        whole = [s for s in stems if all(f"{s}_f{axis}" in heads for axis in ENDINGS)]
        if len(whole) != 1:
            return None
        names = [f"{whole[0]}_f{axis}" for axis in ENDINGS]
    map_ = replace(file.log, columns={**file.log.columns, "velocity": tuple(names)})
    velocity = read_csv_log(path, map_).velocity
    at, raw = velocity.time, velocity.values
    none = np.zeros_like(raw)
    up = none + np.array([0.0, 0.0, 1.0])
    carrier = FlightLog("prediction", at, raw, none, up, none, np.ones((len(raw), 1)))
    found = low_passed(carrier, cutoff).velocity
    return np.stack([np.interp(time, at, column) for column in found.T], axis=1)
