"""``propmap fit flight``: section parameters from flight logs of a vehicle."""

from __future__ import annotations

import functools
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.cli.cluster_option import Cluster, workers_of_bootstrap
from propmap.cli.fit_options import (
    Bootstrap,
    Fix,
    Folds,
    Free,
    Priors,
    Robust,
    Seed,
    Starts,
    choice_of,
    settings_of,
)
from propmap.cli.fit_output import Output, Picture, check_outputs, finish
from propmap.cli.flight_options import (
    HoverScale,
    LowPass,
    Residual,
    flight_priors,
    free_by_default,
    learned_residual,
    with_flight_priors,
)
from propmap.cli.plausibility import say_doubts
from propmap.cli.prior_options import PriorFrom, say_prior, section_prior
from propmap.cli.rotor_options import Corrections, ModelOption, constants, with_physics
from propmap.model.plausibility import doubts_on_air, doubts_on_blade

if TYPE_CHECKING:
    from propmap.fit.fit import Fitted
    from propmap.fit.flight import ForceModel
    from propmap.vehicle.log import FlightLog

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
        typer.Option("--body-study", help="Say whether body lift and drag earn their place."),
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
    from propmap.cli.flight_files import read_flights
    from propmap.vehicle.files import read_vehicle
    from propmap.vehicle.log import DERIVATIVE_CUTOFF

    check_outputs(output, picture, stretches_picture)
    base = constants(name_or_file) if name_or_file else None
    file = read_vehicle(vehicle)
    doubts = [*doubts_on_blade(file.vehicle.propeller), *doubts_on_air(file.vehicle.air)]
    say_doubts(doubts)

    from propmap.fit.comparison import body_terms_verdict, doubts_on_constants, still_explained
    from propmap.fit.files import fit_text
    from propmap.fit.fit import fit, range_warnings
    from propmap.fit.flight import ForceModel, balance_rows, hover_rows, level_rows, wing_values
    from propmap.fit.flight import HoverScale as Scale
    from propmap.fit.flight_study import by_flight
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
    remarks += still_explained(fitted, model.log)
    remarks += doubts_on_constants(fitted)
    learned = learned_residual(model, fitted, wanted=residual, level=flights.level)
    remarks += learned.told() if learned else []
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
