"""``propmap report``: a page on a fit or a table."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.errors import InputError

if TYPE_CHECKING:
    from propmap.fit.files import FitFile
    from propmap.report.fit_page import GivenData


def report(
    source: Annotated[Path, typer.Argument(metavar="FIT|MAP", help="Fit (.toml) or table (.npz).")],
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FOLDER", help="New, empty, or written by this command."
        ),
    ],
    data: Annotated[
        list[str] | None,
        typer.Option(
            "--data",
            metavar="DATA",
            help="Tunnel data or flight logs to draw and to check a fit with; may be repeated.",
        ),
    ] = None,
    vehicle: Annotated[
        Path | None,
        typer.Option("--vehicle", metavar="VEHICLE.toml", help="Vehicle, for flight logs."),
    ] = None,
) -> None:
    """A page that says whether a fit or a table can be trusted, and where.

    FOLDER gets index.html with all figures inside, and every figure as SVG and CSV; the files
    are there all at once or not at all.
    """
    from propmap.report.html import PAGE, REPORT_FILES, check_folder, write_folder

    check_folder(output, REPORT_FILES)
    endings = {".toml": _fit_files, ".npz": _table_files}
    make = endings.get(source.suffix.lower())
    if make is None:
        raise InputError(
            f"the file's ending is {source.suffix!r}",
            "give a fit (.toml) or a table (.npz)",
            str(source),
        )
    files = make(source, data or [], vehicle)
    write_folder(output, files, REPORT_FILES)
    typer.echo(f"wrote {output / PAGE} and {len(files) - 1} files beside it")


def _fit_files(source: Path, data: Sequence[str], vehicle: Path | None) -> dict[str, str | bytes]:
    from propmap.fit.files import read_fit

    file = read_fit(source)
    if vehicle is not None and not data:
        raise InputError("--vehicle is for flight logs", "name them with --data")
    if file.record.kind != "tunnel" and data and vehicle is None:
        raise InputError("--data with a fit of flights needs the vehicle", "add --vehicle FILE")

    from propmap.report.fit_page import fit_pages

    given = _given(file, data, vehicle) if data else None
    digest = hashlib.sha256(source.read_bytes()).hexdigest()
    return fit_pages(file, source.name, digest, given)


def _given(file: FitFile, data: Sequence[str], vehicle: Path | None) -> GivenData:
    from propmap.fit.comparison import (
        compare_forces,
        compare_level,
        compare_tunnel,
        flight_forces,
        force_trends,
        values_for,
    )
    from propmap.fit.files import DataSource
    from propmap.report.fit_page import GivenData

    if vehicle is None:
        from propmap.fit.tunnel import read_tunnel, sources

        measured = read_tunnel(data, file.model.propeller, file.model.air)
        found = compare_tunnel(file.model, measured)
        return GivenData([DataSource.of(item) for item in sources(data)], found, tunnel=measured)
    from propmap.cli.fit_flight import all_level_tables, read_flights
    from propmap.vehicle.files import read_vehicle

    described, paths = read_vehicle(vehicle), [Path(item) for item in data]
    level = all_level_tables(paths)
    method, passed = ("level", 0.0) if level else ("balance", file.low_pass)
    flights = read_flights(paths, described, method, seconds=2.0, samples=2**31, low_pass=passed)
    flown, log = described.vehicle, flights.log
    if level:
        errors = compare_level(flown, log, file.airfoil, file.values)
    else:
        values, _ = values_for(file, flown, log, paths)
        forces = flight_forces(flown, log, file.airfoil, values)
        errors = compare_forces(flown, log, forces)
    return GivenData(
        [DataSource.of(path) for path in paths],
        errors,
        level=(flown, log) if level else None,
        residuals=() if level else force_trends(flown, log, forces),
    )


def _table_files(source: Path, data: Sequence[str], vehicle: Path | None) -> dict[str, str | bytes]:
    if data or vehicle is not None:
        raise InputError(
            "--data and --vehicle are for fits",
            "compare data with the fit the table was built from",
        )
    from propmap.report.table_page import table_pages
    from propmap.table import LoadTable

    return table_pages(LoadTable.load(source), source.name)
