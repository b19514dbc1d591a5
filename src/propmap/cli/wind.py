"""``propmap wind``: the wind over a flight, estimated from the forces on a fitted vehicle."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.cli.fit_flight import read_flights
from propmap.fit.files import read_fit
from propmap.flight.wind import COMPONENTS, estimate_wind
from propmap.io.csv import numbers_of
from propmap.vehicle.files import read_vehicle


def wind(
    fit: Annotated[
        Path,
        Argument(metavar="FIT.toml", help="Fit file from `propmap fit flight --method balance`."),
    ],
    log: Annotated[
        Path, Argument(metavar="LOG", help="Flight log (CSV, Parquet, ULog, DataFlash, bag).")
    ],
    vehicle: opt.VehicleOption,
    picture: Annotated[
        Path | None, Option(metavar="FILE", help="Picture of the wind: .png, .svg or .pdf.")
    ] = None,
    format_: out.FormatOption = None,
    output: out.TextOutput = None,
) -> None:
    """Estimate the wind over a flight, with 95 % bands.

    The estimate follows from the forces on the vehicle. The command ignores a wind in the vehicle
    file. CSV and JSON contain the wind at all samples. If the log contains a measured airspeed
    (air_speed in [log.columns]), the command compares it with the estimate.
    """
    out.check_pictures(picture)
    form = out.chosen_format(format_, output)
    file, fitted = read_vehicle(vehicle), read_fit(fit)
    still = replace(file, log=replace(file.log, wind=(0.0, 0.0, 0.0)))
    read = read_flights([log], still, "balance", low_pass=fitted.low_pass, curve=fitted.curve)
    with out.blamed_on(fit):
        found = estimate_wind(fitted, file.vehicle, read.log)
    out.note(*read.remarks, *found.remarks)
    if form == "table":
        columns = found.mean, found.mean_half_width, found.gusts
        table = zip(COMPONENTS, *columns, strict=True)
        rows = [(name, *(out.digits(v, 2) for v in values)) for name, *values in table]
        heads = "<wind toward|mean [m/s]|95 % +- [m/s]|gusts, standard deviation [m/s]"
        out.show(output, out.grid(heads, rows, str(log)), found.summary)
    else:
        flat = {name: numbers_of(values) for name, values in found.columns.items()}
        flat |= {"status": found.status.tolist()}
        samples = [dict(zip(flat, row, strict=True)) for row in zip(*flat.values(), strict=True)]
        whole = {
            "summary": found.summary,
            "mean_mps": numbers_of(found.mean),
            "mean_half_width_95_mps": numbers_of(found.mean_half_width),
            "gusts_std_mps": numbers_of(found.gusts),
            "well_determined": found.well_determined,
            "samples": samples,
        }
        out.emit_rows(list(flat), samples, form, output, whole=whole)
    if picture is not None:
        from propmap.report.pictures import wind_picture

        out.save_picture(wind_picture(found), picture)
