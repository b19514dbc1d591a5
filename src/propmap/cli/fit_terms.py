"""``propmap fit terms``: what each term of a flight fit is worth, as a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from propmap.cli.flight_options import BLADE, LowPass, flight_priors, with_flight_priors
from propmap.cli.prior_options import PriorFrom, section_prior
from propmap.errors import InputError, quoted
from propmap.fit.parameters import FLEX, MOUNT, SECTION, SENSOR, WAKES, Choice, Prior
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.fit.flight_study import Flight, Step
    from propmap.fit.parameters import SectionPrior
    from propmap.vehicle.files import VehicleFile
    from propmap.vehicle.vehicle import Vehicle

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

    from propmap.fit.flight_study import fit_terms
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
    from propmap.fit.flight_study import Step

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
) -> tuple[list[Flight], list[str]]:
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
    from propmap.cli.flight_files import read_flights
    from propmap.fit.flight_study import Flight

    names = [path.stem for path in paths]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise InputError(f"two logs are called {twice[0]!r}", "give each flight once")
    found: list[Flight] = []
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
        found.append(Flight(path.stem, passed.log, raw.log, *both))
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
