"""``propmap fit flight`` and ``propmap fit terms``: section parameters from logs of flights."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from propmap.cli.fit import Output, Picture, check_outputs, finish
from propmap.cli.fit_options import (
    BLADE,
    Bootstrap,
    Fix,
    Folds,
    Free,
    HoverScale,
    LowPass,
    PriorFrom,
    Priors,
    Residual,
    Robust,
    Seed,
    Starts,
    choice_of,
    flight_priors,
    free_by_default,
    learned_residual,
    say_prior,
    section_prior,
    settings_of,
    with_flight_priors,
)
from propmap.cli.options import (
    Cluster,
    Corrections,
    ModelOption,
    constants,
    say_doubts,
    with_physics,
    workers_of_bootstrap,
)
from propmap.errors import InputError, quoted
from propmap.fit.parameters import FLEX, MOUNT, SECTION, SENSOR, WAKES, Choice, Prior
from propmap.flight.checks import check_rotor_order, check_rotor_speed, mixed_vehicles
from propmap.flight.steady import (
    airborne,
    is_level_table,
    operating_points,
    read_level_table,
    steady_stretches,
)
from propmap.model.plausibility import doubts_on_air, doubts_on_blade
from propmap.typing import Floats
from propmap.vehicle.files import VehicleFile
from propmap.vehicle.log import (
    FEWEST_PER_PERIOD,
    FlightLog,
    flight_log,
    flight_names,
    joined,
    low_passed,
)
from propmap.vehicle.log_checks import check_recording
from propmap.vehicle.log_readers import read_recording

if TYPE_CHECKING:
    from propmap.fit.comparison import RecordedFlight, Step
    from propmap.fit.fit import Fitted
    from propmap.fit.flight import ForceModel
    from propmap.fit.parameters import SectionPrior
    from propmap.rotor import Rotor
    from propmap.vehicle.files import VehicleFile
    from propmap.vehicle.log import FlightLog
    from propmap.vehicle.vehicle import Vehicle


# -------------------------------------------------------------------------------------------------
# LOG arguments of flight fits and checks, as samples or as operating points.

ENOUGH_STRETCHES = 4


@dataclass(frozen=True, eq=False)
class Flights:
    """A log, whether it holds steady operating points alone, and remarks for the report."""

    level: bool
    log: FlightLog
    remarks: tuple[str, ...]


def read_flights(
    paths: Sequence[Path],
    file: VehicleFile,
    method: str,
    *,
    seconds: float,
    samples: int,
    low_pass: float = 0.0,
    picture: Path | None = None,
) -> Flights:
    """Read logs, or tables of operating points, for the method "level", "balance" or "auto".

    Parameters
    ----------
    paths, file : sequence of Path, VehicleFile
        What was flown, and by what.
    method : str
        As in ``propmap fit flight``.
    seconds : float
        Shortest steady stretch [s].
    samples : int
        Of whole flights, at most; more would be no more information, as neighbours err alike.
    low_pass : float
        Cut-off for all signals of whole flights [Hz], 0 for none.
    picture : Path, optional
        Of the steady stretches.
    """
    names = flight_names([str(path) for path in paths])
    if all_level_tables(paths):
        if method == "balance":
            raise InputError(
                "a level-flight table has no accelerations", "fit it with --method level"
            )
        tables = [read_level_table(path, file.vehicle) for path in paths]
        found = [text for table in tables for text in _table_remarks(table, file)]
        return Flights(True, joined(tables, names), tuple(found))
    logs, remarks = _recorded(paths, file)
    if method != "balance":
        points = _points(logs, seconds, picture, needed=method == "level")
        if points is not None:
            return Flights(True, points, tuple(remarks))
        remarks.append(
            f"fewer than {ENOUGH_STRETCHES} steady stretches of {seconds:g} s: the balance of all "
            "forces at all times is fitted instead"
        )
    remarks += [text for log in logs for text in _too_slow_to_filter(log, low_pass)]
    logs = [low_passed(log, low_pass) for log in logs]
    flying = joined([log.picked(airborne(log)) for log in logs], names)
    picked = np.unique(np.linspace(0, len(flying) - 1, min(samples, len(flying))).astype(int))
    return Flights(False, flying.picked(picked), tuple(remarks))


def _recorded(paths: Sequence[Path], file: VehicleFile) -> tuple[list[FlightLog], list[str]]:
    """Logs, and warnings on what they may not be."""
    logs, remarks = [], []
    for path in paths:
        recording = read_recording(path, file)
        remarks += check_recording(recording)
        logs.append(flight_log(recording, file))
        if logs[-1].source != recording.source:
            remarks.append(logs[-1].source)
        remarks += _rpm_remarks(logs[-1], file)
        check_rotor_order(logs[-1], file.vehicle)
    return logs, [*remarks, *mixed_vehicles(logs, file.vehicle)]


def _too_slow_to_filter(log: FlightLog, low_pass: float) -> list[str]:
    rate = 1.0 / float(np.median(np.diff(log.time)))
    needed = FEWEST_PER_PERIOD * low_pass
    if rate >= needed:
        return []
    return [
        f"{log.source}: {rate:.3g} samples per second are too few for a low-pass at {low_pass:g} "
        f"Hz, which takes {needed:g}, and are fitted as they are: log the slowest signal faster, "
        f"or lower --low-pass to {rate / FEWEST_PER_PERIOD:.2g}"
    ]


def _points(
    logs: list[FlightLog], seconds: float, picture: Path | None, *, needed: bool
) -> FlightLog | None:
    found = []
    for log in logs:
        try:
            stretches = steady_stretches(log, seconds=seconds)
        except InputError:
            if needed and len(logs) == 1:
                raise
            continue
        if picture is not None:
            from propmap.report.fit_curves import steady_parts
            from propmap.report.html import save

            save(steady_parts(log, stretches), picture)
        found.append(operating_points(log, stretches))
    if not found or (not needed and sum(len(p) for p in found) < ENOUGH_STRETCHES):
        if needed:
            raise InputError(
                f"no log has a steady stretch of {seconds:g} s",
                "lower --seconds, or use --method balance",
            )
        return None
    return joined(found)


def _table_remarks(table: FlightLog, file: VehicleFile) -> list[str]:
    try:
        return check_rotor_speed(table, _nominal_rotor(file), file.vehicle, "rpm")
    except InputError as error:
        remedy = "give rpm_1, rpm_2 ... in revolutions per minute of the propeller"
        raise InputError(error.found, remedy, table.source) from None


def _rpm_remarks(log: FlightLog, file: VehicleFile) -> list[str]:
    unit = file.log.rotor_unit or ("rpm" if log.source.endswith(".ulg") else None)
    return check_rotor_speed(log, _nominal_rotor(file), file.vehicle, unit)


def _nominal_rotor(file: VehicleFile) -> Rotor:
    from propmap.model.airfoil import parameter_set
    from propmap.model.model import Model
    from propmap.rotor import Rotor

    model = Model(file.vehicle.propeller, parameter_set("paper-apc"), file.vehicle.air)
    return Rotor(model)


def all_level_tables(paths: Sequence[Path]) -> bool:
    """Whether all files are tables of operating points."""
    return all(is_level_table(path) for path in paths)


# -------------------------------------------------------------------------------------------------
# ``propmap fit flight``: section parameters from flight logs of a vehicle.

EVERY, FEW = 3, 1500
"""Of so many samples of whole flights one is fitted from all starts, and all from the best end."""


class Method(StrEnum):
    """Which balance of forces is fitted."""

    auto = "auto"
    level = "level"
    balance = "balance"


def fit_flight(
    logs: Annotated[
        list[Path],
        typer.Argument(metavar="LOG...", help="CSV, Parquet, ULog, bag, or a level-flight table."),
    ],
    vehicle: Annotated[
        Path, typer.Option("--vehicle", metavar="VEHICLE.toml", help="The vehicle.")
    ],
    output: Output,
    method: Annotated[
        Method,
        typer.Option(
            "--method",
            help="level: vertical balance of steady stretches, as in the paper; balance: all "
            "forces at all times; auto: level if there are enough steady stretches.",
        ),
    ] = Method.auto,
    free: Free = None,
    fix: Fix = None,
    prior: Priors = None,
    prior_from: PriorFrom = None,
    name_or_file: Annotated[
        str | None,
        typer.Option("--airfoil", metavar="NAME|FILE", help="Values of what is not free."),
    ] = None,
    physics: ModelOption = None,
    correction: Corrections = None,
    seconds: Annotated[float, typer.Option("--seconds", help="Shortest steady stretch [s].")] = 2.0,
    samples: Annotated[
        int, typer.Option("--samples", min=10, help="Samples used of a whole flight, at most.")
    ] = 500,
    low_pass: LowPass = None,
    hover_scale: HoverScale = True,
    residual: Residual = False,
    body_study: Annotated[
        bool,
        typer.Option("--body-study", help="Say whether body lift and drag pay."),
    ] = False,
    starts: Starts = 2,
    robust: Robust = False,
    folds: Folds = 5,
    bootstrap: Bootstrap = 0,
    seed: Seed = 2017,
    picture: Picture = None,
    stretches_picture: Annotated[
        Path | None,
        typer.Option("--stretches", metavar="FILE", help="Picture of the steady stretches."),
    ] = None,
    cluster: Cluster = None,
) -> None:
    """Fit flight logs of a vehicle.

    Whole flights have a thrust scale (where there are several) and a clock each. Wind is not
    estimated: state it in the vehicle file.
    """
    from propmap.vehicle.files import read_vehicle
    from propmap.vehicle.log import DERIVATIVE_CUTOFF

    check_outputs(output, picture, stretches_picture)
    base = constants(name_or_file) if name_or_file else None
    file = read_vehicle(vehicle)
    doubts = [*doubts_on_blade(file.vehicle.propeller), *doubts_on_air(file.vehicle.air)]
    say_doubts(doubts)

    from propmap.fit.comparison import (
        body_terms_verdict,
        by_flight,
        residual_trends,
        unlikely_constants,
    )
    from propmap.fit.files import fit_text
    from propmap.fit.fit import fit, range_warnings
    from propmap.fit.flight import ForceModel, balance_rows, hover_rows, level_rows, wing_values
    from propmap.fit.flight import HoverScale as Scale
    from propmap.fit.tunnel import first_guess, model_with

    cutoff = DERIVATIVE_CUTOFF if low_pass is None else low_pass
    flights = read_flights(
        logs,
        file,
        method.value,
        seconds=seconds,
        samples=samples,
        low_pass=cutoff,
        picture=stretches_picture,
    )
    default = free_by_default(file.vehicle, flights.log, level=flights.level)
    by_default = free is None and base is None
    blade = file.vehicle.propeller
    expected = section_prior(prior_from, blade.name, blade, by_default=by_default)
    wing = wing_values(file.vehicle)
    if not flights.level and free is None:
        # With one blade in one air, what hardly moves stays where other propellers have it.
        held = {text.partition("=")[0].strip() for text in fix or ()}
        free = ",".join(name for name in default if name not in held)
    chosen = choice_of(free, fix, prior, default, base, wing, expected)
    if not flights.level:
        known = flight_priors(file.vehicle, flights.log, hover=hover_scale)
        chosen = with_flight_priors(chosen, known)
    settings = settings_of(starts, robust, folds, bootstrap, seed)
    law = base or (expected.airfoil if expected else first_guess())
    law = with_physics(law, physics, correction)
    model = ForceModel(file.vehicle, flights.log, law)
    make = level_rows if flights.level else balance_rows
    fewer = None
    if not flights.level and flights.log.rotor_speed.size >= FEW:
        part = flights.log.picked(slice(None, None, EVERY))
        fewer = make(ForceModel(file.vehicle, part, law), chosen)
    remake = functools.partial(make, model, chosen)
    with workers_of_bootstrap(cluster, bootstrap) as workers:
        fitted = fit(remake(), chosen, settings, fewer, workers=workers, remake=remake)
    remarks = [*flights.remarks, *range_warnings(fitted.rows)]
    remarks += residual_trends(fitted, model.log)
    remarks += unlikely_constants(fitted)
    learned = learned_residual(model, fitted, wanted=residual, level=flights.level)
    remarks += learned.sentences() if learned else []
    if body_study:
        remarks += body_terms_verdict(fitted, lambda c: make(model, c))
    flown = by_flight(fitted, flights.log)
    wanted = hover_scale and not flights.level
    hovers = Scale.of(file.vehicle, flights.log) if wanted else None
    text = fit_text(
        fitted,
        kind="level flight" if flights.level else "flight",
        name=output.stem,
        model=model.model,
        data=[*logs, vehicle],
        covered=model.coverage(),
        hover=hover_rows(model, fitted.values, fitted.rows),
        remarks=[*say_prior(expected), *remarks, *doubts],
        options={
            "seconds": seconds,
            "samples": samples,
            "low_pass": 0.0 if flights.level else cutoff,
            "hover_reference": (hovers and hovers.reference_at(fitted.values)) or 0.0,
            "vehicle": file.vehicle.name,
            **({"learned_residual": learned.table()} if learned else {}),
        },
        flights=flown,
    )
    if picture is not None:
        _picture_of_flight(picture, fitted, model, flights.log)
    finish(fitted, model_with(model.model, fitted.values), remarks, text, output, flown)


def _picture_of_flight(picture: Path, fitted: Fitted, model: ForceModel, log: FlightLog) -> None:
    from propmap.fit.tunnel import section_with
    from propmap.report.fit_curves import level_flight
    from propmap.report.html import save

    law = section_with(model.model.airfoil, fitted.values)
    save(level_flight(model.vehicle, log, law), picture)


# -------------------------------------------------------------------------------------------------
# ``propmap fit terms``: what each term of a flight fit is worth, as a page.

ALMOST_NONE = 1e-9
"""Area [m^2] of a mount that drags nothing."""

STALL = ("c_l1", "c_d", "alpha_0")
"""The paper's four without c_l2, which level flights do not tell."""

DRAGS, DOWN = ("drag_area_x", "drag_area_y", "drag_area_z"), ("download_area_x", "download_area_y")
ENDINGS = ("x", "y", "z")


def fit_terms_page(
    logs: Annotated[
        list[Path], typer.Argument(metavar="LOG...", help="CSV, Parquet, ULog or bag; two or more.")
    ],
    vehicle: Annotated[
        Path, typer.Option("--vehicle", metavar="VEHICLE.toml", help="The vehicle.")
    ],
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FOLDER", help="New, empty, or written by this command."
        ),
    ],
    samples: Annotated[
        int, typer.Option("--samples", min=10, help="Samples that each fit takes, at most.")
    ] = 300,
    low_pass: LowPass = None,
    prior_from: PriorFrom = None,
    prediction: Annotated[
        str | None,
        typer.Option(
            "--prediction",
            metavar="COLUMNS",
            help="Three columns of CSV logs, separated by commas: forces along x, y, z [N] that "
            "something else predicts. By default those ending in _fx, _fy, _fz.",
        ),
    ] = None,
) -> None:
    """A page that says which terms of a flight fit pay.

    Hover model, vertical balance, then one term more at a time, each fitted to all flights but
    one and checked on that one, beside a prediction that comes with the logs.
    """
    from propmap.report.html import PAGE, TERMS_FILES, check_folder, write_folder
    from propmap.vehicle.files import read_vehicle
    from propmap.vehicle.log import DERIVATIVE_CUTOFF

    check_folder(output, TERMS_FILES)
    file = read_vehicle(vehicle)
    # Moments play no part here, and the wakes are one of the terms.
    file = replace(file, vehicle=replace(file.vehicle, inertia=None, wakes=None))

    from propmap.fit.comparison import fit_terms
    from propmap.report.terms_page import terms_pages

    cutoff = DERIVATIVE_CUTOFF if low_pass is None else low_pass
    flights, remarks = read_pairs(logs, file, cutoff, prediction)
    prior = expected(prior_from, file.vehicle)
    law = prior.airfoil.with_corrections(["pitt-peters"])
    found = fit_terms(
        file.vehicle,
        flights,
        steps(file.vehicle, prior, flight_priors(file.vehicle, flights[0].passed, hover=False)),
        law,
        samples=samples,
        tell=lambda text: typer.echo(text, err=True),
    )
    pages = terms_pages(
        file.vehicle, flights, found, low_pass=cutoff, samples=samples, remarks=remarks
    )
    write_folder(output, pages, TERMS_FILES)
    typer.echo(f"wrote {output / PAGE} and {len(pages) - 1} files beside it")


def expected(prior_from: str | None, vehicle: Vehicle) -> SectionPrior:
    """What other propellers tell of the vehicle's blade; ``InputError`` for none."""
    blade = vehicle.propeller
    prior = section_prior(prior_from, blade.name, blade, by_default=True)
    if prior is None:
        raise InputError("the terms are fitted with a prior", "leave --prior-from none out")
    return prior


def steps(vehicle: Vehicle, prior: SectionPrior, known: Mapping[str, Prior]) -> list[Step]:
    """The models of a ``vehicle``'s flights, each with one term more, in order.

    ``prior`` is what other propellers tell of the blade, ``known`` what is known of other terms.
    """
    from propmap.fit.comparison import Step

    own_mounts = any(one.drag for one in vehicle.mounts)
    mount = () if own_mounts else tuple(MOUNT)
    drag = DRAGS if own_mounts else (*mount, "drag_area_z")
    blade = (*BLADE, *drag, *SENSOR)
    wakes = tuple(WAKES) if len(vehicle.mounts) > 1 else ()
    named = {
        "three axes, body drag": (*BLADE, *DRAGS),
        "accelerometer's place and clock": (*BLADE, *DRAGS, *SENSOR),
        "drag of the mounts for the body's in x, y": () if own_mounts else blade,
        "the rotors' wakes": (*blade, *wakes) if wakes else (),
        "blades that give way": (*blade, *wakes, *FLEX),
        "download of the body": (*blade, *wakes, *FLEX, *DOWN),
    }

    def choice(free: tuple[str, ...]) -> Choice:
        return with_flight_priors(_choice(free, prior, mount), known)

    found = [Step("vertical balance alone", choice(STALL), vertical=True)]
    return found + [Step(name, choice(f)) for name, f in named.items() if f]


def _choice(free: tuple[str, ...], prior: SectionPrior, mount: tuple[str, ...]) -> Choice:
    """What is free, everything else where other propellers have it, or absent."""
    absent = {**dict.fromkeys(mount, ALMOST_NONE), **dict.fromkeys(FLEX, 0.0)}
    at = {name: float(getattr(prior.airfoil, name)) for name in SECTION}
    fixed = {name: value for name, value in {**at, **absent}.items() if name not in free}
    start = {name: value for name, value in at.items() if name in free}
    return Choice(free, fixed, {}, start, prior)


def read_pairs(
    paths: Sequence[Path], file: VehicleFile, cutoff: float, prediction: str | None
) -> tuple[list[RecordedFlight], list[str]]:
    """Flights with their signals low-passed and not, and remarks on them.

    Parameters
    ----------
    paths, file : sequence of Path, VehicleFile
        Logs, and what flew.
    cutoff : float
        Of the low-pass [Hz].
    prediction : str or None
        As ``--prediction``.

    Raises
    ------
    InputError
        For bad logs, and columns that are not there.
    """
    from propmap.fit.comparison import RecordedFlight

    names = [path.stem for path in paths]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise InputError(f"two logs are called {twice[0]!r}", "give each flight once")
    found: list[RecordedFlight] = []
    remarks: list[str] = []
    for path in paths:
        passed, raw = (
            read_flights([path], file, "balance", seconds=2.0, samples=2**31, low_pass=hz)
            for hz in (cutoff, 0.0)
        )
        remarks += passed.remarks
        if not np.isfinite(passed.log.specific_force).all():
            raise InputError(
                "there is no specific force (accelerometer) for all samples", "log it", str(path)
            )
        both = [
            _predicted(path, file, flown.log.time, hz, prediction)
            for flown, hz in ((passed, cutoff), (raw, 0.0))
        ]
        found.append(RecordedFlight(path.stem, passed.log, raw.log, *both))
    return found, remarks


def _predicted(
    path: Path, file: VehicleFile, time: Floats, cutoff: float, columns: str | None
) -> Floats | None:
    """Forces [N] (n, 3) that columns of a CSV log predict at these times, low-passed."""
    from propmap.vehicle.log import FlightLog, low_passed

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
