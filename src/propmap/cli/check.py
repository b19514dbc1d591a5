"""``propmap check`` and ``propmap report``: errors of a fit, and web pages on fits and tables."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import numpy as np
from typer import Argument, Option, echo

from propmap.catalogue.lookup import airfoil, propeller
from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.cli.fit_flight import all_level_tables, read_flights
from propmap.errors import InputError
from propmap.fit import comparison
from propmap.fit.files import DataSource, FitFile, is_fit, read_fit
from propmap.fit.flight import wing_values
from propmap.fit.tunnel import read_tunnel, sources
from propmap.model.air import Air
from propmap.model.corrections import in_words
from propmap.model.model import Model
from propmap.model.plausibility import blade_warnings
from propmap.vehicle.files import read_vehicle
from propmap.vehicle.log import hub_flow

if TYPE_CHECKING:
    from rich.table import Table

    from propmap.model.airfoil import Airfoil, SectionTable
    from propmap.report.fit_page import GivenData


def check(
    fit: Annotated[
        Path, Argument(metavar="FIT.toml", help="Fit, parameter set or section table to check.")
    ],
    data: Annotated[
        list[str],
        Argument(metavar="DATA...", help="Wind-tunnel data, or flight logs with --vehicle."),
    ],
    vehicle: opt.VehicleOfLogs = None,
    prop: Annotated[
        str | None,
        Option(
            metavar="PROP",
            help="Propeller of tunnel data; required if FIT.toml has no table [fit].",
        ),
    ] = None,
    model: opt.ModelOption = None,
    correction: opt.Corrections = None,
    format_: out.FormatOption = None,
    output: out.TextOutput = None,
) -> None:
    """Compare a fit with held-out measurements."""
    chosen = out.chosen_format(format_, output)
    law = opt.with_physics(airfoil(fit), model, correction)
    if vehicle is not None:
        opt.refuse_two_mounts(read_vehicle(vehicle).vehicle, correction)
    found = _compare(fit, law, data, vehicle, prop)
    if chosen == "table":
        out.show(output, _table(found, law))
        return
    loads = {
        name: _numbers(c.all)
        | {
            "by_speed": {band: _numbers(e) for band, e in c.by_speed.items()},
            "in_band": None if np.isnan(c.in_band) else c.in_band,
            "by_envelope": {band: _numbers(e) for band, e in c.by_envelope.items()},
        }
        for name, c in found.items()
    }
    rows = max((c.all.rows for c in found.values()), default=0)
    whole = {"corrections": list(law.corrections or ()), "rows": rows, "loads": loads}
    columns = ("load", "band", "rows", "rms", "relative_rms", "bias", "worst", "hover_rms")
    bands = [
        {"load": name, "band": band} | _numbers(e)
        for name, c in found.items()
        for band, e in c.bands.items()
    ]
    out.emit_rows(columns, bands, chosen, output, whole=whole)


def _compare(
    fit: Path, law: Airfoil | SectionTable, data: list[str], vehicle: Path | None, prop: str | None
) -> Mapping[str, comparison.SpeedErrors]:
    """Compare with tunnel data, or with flight logs if there is a vehicle."""
    fitted = read_fit(fit) if is_fit(fit) else None
    if vehicle is None:
        if fitted is None and prop is None:
            fault = "the propeller is unknown: the file has no table [fit]"
            raise InputError(fault, "add --prop NAME", str(fit))
        air = fitted.model.air if fitted else Air()
        blade = fitted.model.propeller if fitted and prop is None else propeller(prop or "")
        model = Model(blade, law, air)
        measured = read_tunnel(data, blade, air)
        opt.note_reynolds(model, measured.omega, measured.speed, measured.beta)
        if prop is not None:
            opt.note_reading(prop, blade)
        out.note(*blade_warnings(blade), *measured.remarks)
        beyond = fitted.beyond(measured.flow, blade.radius) if fitted else None
        out.note(*(beyond.sentences("rows") if beyond else ()))
        return comparison.compare_tunnel(model, measured, beyond)

    if prop is not None:
        raise InputError("--prop is given, but the vehicle file has a propeller", "leave it out")
    file = read_vehicle(vehicle)
    flown, paths = file.vehicle, [Path(item) for item in data]
    cutoff = fitted.low_pass if fitted else 0.0
    curve = fitted.curve if fitted else {}
    _, log, remarks, _ = read_flights(paths, file, "balance", low_pass=cutoff, curve=curve)
    values, more = (
        comparison.values_for(fitted, flown, log, paths) if fitted else (wing_values(flown), [])
    )
    forces = comparison.flight_forces(flown, log, law, values)
    sure = comparison.force_errors(fitted, flown, log, values) if fitted else None
    beyond = fitted.beyond(hub_flow(flown, log)[:3], flown.propeller.radius) if fitted else None
    out.note(*remarks, *more, *(beyond.sentences("samples") if beyond else ()))
    found = comparison.compare_forces(flown, log, forces, beyond, sure and sure.deviations)
    for name, errors in found.items():
        out.note(*comparison.useless(name.rpartition("_")[0], errors.all.relative_rms))
    return found


def _numbers(errors: Any) -> dict[str, Any]:
    return {k: None if np.isnan(v) else v for k, v in msgspec.structs.asdict(errors).items()}


def _table(
    found: Mapping[str, comparison.SpeedErrors], law: Airfoil | SectionTable, besides: str = ""
) -> Table:
    rows = [
        (
            name if band == "all" else "",
            band,
            str(e.rows),
            f"{e.rms:.4g}",
            out.percent(e.relative_rms, 1),
            f"{e.bias:+.3g}",
            f"{e.worst:+.3g}",
            f"{e.hover_rms:.4g}",
            "" if band != "all" or np.isnan(c.in_band) else f"{100.0 * c.in_band:.0f} %",
        )
        for name, c in found.items()
        for band, e in c.bands.items()
    ]
    physics = f", with {in_words(law.corrections or ())}{besides}"
    heads = "<load|<range|rows|rms|relative|bias|worst|hover model's rms|in 95 % band"
    return out.grid(heads, rows, f"Model minus measurement{physics}")


def report(
    source: Annotated[Path, Argument(metavar="FIT|TABLE", help="Fit (.toml) or table (.npz).")],
    output: out.FolderOutput,
    data: Annotated[
        list[str] | None,
        Option(
            metavar="DATA",
            help="Wind-tunnel data or flight log to draw and to compare with the fit; may be "
            "repeated.",
        ),
    ] = None,
    vehicle: opt.VehicleOfLogs = None,
) -> None:
    """Write a web page on the accuracy and limits of a fit or a table.

    The output folder contains index.html with all figures, and each figure as SVG and CSV. The
    command writes either all files or none.
    """
    from propmap.report.html import PAGE, REPORT_FILES, check_folder, write_folder

    check_folder(output, REPORT_FILES)
    ending = source.suffix.lower()
    if ending == ".toml":
        from propmap.report.fit_page import fit_pages

        file = read_fit(source)
        if vehicle is not None and not data:
            raise InputError("--vehicle needs flight logs", "add them with --data")
        if file.record.kind != "tunnel" and data and vehicle is None:
            raise InputError("--data for a fit to flights needs the vehicle", "add --vehicle FILE")
        given = _given(file, data, vehicle) if data else None
        digest = hashlib.sha256(source.read_bytes()).hexdigest()
        files = fit_pages(file, source.name, digest, given)
    elif ending == ".npz":
        if data or vehicle is not None:
            found = "--data and --vehicle apply to fits only"
            raise InputError(found, "compare data with the fit from which the table was built")
        from propmap.report.table_page import table_pages
        from propmap.table import LoadTable

        files = table_pages(LoadTable.load(source), source.name)
    else:
        found = f"the file extension is {source.suffix!r}"
        raise InputError(found, "give a fit (.toml) or a table (.npz)", str(source))
    write_folder(output, files, REPORT_FILES)
    echo(f"wrote {output / PAGE} and {len(files) - 1} other files")


def _given(file: FitFile, data: Sequence[str], vehicle: Path | None) -> GivenData:
    """Compare a fit with the data of ``--data``."""
    from propmap.report.fit_page import GivenData

    if vehicle is None:
        measured = read_tunnel(data, file.model.propeller, file.model.air)
        beyond = file.beyond(measured.flow, file.model.propeller.radius)
        found = comparison.compare_tunnel(file.model, measured, beyond)
        named = [DataSource.of(item) for item in sources(data)]
        return GivenData(named, found, tunnel=measured, beyond=beyond)

    described, paths = read_vehicle(vehicle), [Path(item) for item in data]
    flown, files = described.vehicle, [DataSource.of(path) for path in paths]
    if all_level_tables(paths):
        log = read_flights(paths, described, "level").log
        beyond = file.beyond(hub_flow(flown, log)[:3], flown.propeller.radius)
        errors = comparison.compare_level(flown, log, file.airfoil, file.values, beyond)
        return GivenData(files, errors, level=(flown, log), beyond=beyond)
    log = read_flights(paths, described, "balance", low_pass=file.low_pass, curve=file.curve).log
    values, _ = comparison.values_for(file, flown, log, paths)
    forces = comparison.flight_forces(flown, log, file.airfoil, values)
    beyond = file.beyond(hub_flow(flown, log)[:3], flown.propeller.radius)
    errors = comparison.compare_forces(flown, log, forces, beyond)
    trends = comparison.force_trends(flown, log, forces)
    return GivenData(files, errors, residuals=trends, beyond=beyond)
