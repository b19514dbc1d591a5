"""A fit against the data given with the report."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from propmap.baselines.hover import HoverModel
from propmap.fit.comparison import Comparison, level_forces
from propmap.fit.fit_record import FitRecord, Source
from propmap.fit.result_file import FitFile
from propmap.fit.tunnel import TunnelData
from propmap.loads import LOADS
from propmap.report.fit_page.curves import RPM
from propmap.report.fit_page.errors import BandErrors, band_csv, band_figure, band_table
from propmap.report.fit_page.judgement import NAMES, WORDS, level_of, worst_of
from propmap.report.fit_pictures import level_flight, tunnel_fit
from propmap.report.page import Section, Text, Verdict, percent
from propmap.report.part import Part, files_of, picture
from propmap.report.sheet import csv_of_rows
from propmap.rotor import Rotor
from propmap.vehicle.flight_log import GRAVITY, FlightLog
from propmap.vehicle.vehicle import Vehicle

WITHOUT_UNIT = ("_Nm", "_N")


@dataclass(frozen=True, eq=False)
class GivenData:
    """Data beside the fit file, compared with the fit.

    sources : of the data.  errors : by load with its unit.
    tunnel : the rows, where they are from a tunnel.  level : the vehicle and its steady operating
    points, where these are what was given.
    """

    sources: Sequence[Source]
    errors: Mapping[str, Comparison]
    tunnel: TunnelData | None = None
    level: tuple[Vehicle, FlightLog] | None = None


def data_check(file: FitFile, fit: FitRecord, given: GivenData) -> Part:
    """Verdict, pictures, and errors by band."""
    bands = _bands(given.errors)
    pictures = []
    if given.tunnel is not None:
        rotor = Rotor(file.model)
        pictures.append(
            picture(
                tunnel_fit(given.tunnel, rotor),
                "fit-measured",
                "Measured against predicted loads. Dashed: the hover model, one value for each "
                "rotational speed.",
                "Predicted against measured loads, a panel for each.",
            )
        )
    if given.level is not None:
        pictures.append(
            picture(
                level_flight(*given.level, file.airfoil),
                "fit-measured",
                "Steady flights: loads summed over the rotors at the recorded rotor speeds, and "
                "the vertical force less the weight.",
                "Loads, vertical force error and pitch angle against flight speed.",
            )
        )
    pictures.append(
        picture(
            band_figure(bands),
            "fit-check",
            "Rms error by band of flight speed on the data given. Solid: this model. Dashed: the "
            "hover model with the constants of the same rotor at rest.",
            "Rms errors of both models against speed.",
        )
    )
    caption = "Model minus measurement by band of speed, on the data given."
    section = Section(
        "check",
        "Against the data given",
        (_verdict(given), Text(_same(fit, given)), *pictures, band_table(bands, caption)),
    )
    files = files_of(*pictures) | {"fit-check.csv": band_csv(bands)}
    if given.tunnel is not None:
        files["fit-measured.csv"] = _tunnel_csv(file, given.tunnel)
    if given.level is not None:
        files["fit-measured.csv"] = _level_csv(file, *given.level)
    return Part(section, files)


def _tunnel_csv(file: FitFile, data: TunnelData) -> str:
    rotor = Rotor(file.model)
    found = rotor.loads(data.omega, data.speed, data.beta)
    hover = HoverModel.of(rotor).loads(data.omega)
    columns = {
        "rpm": data.omega * RPM,
        "speed_mps": data.speed,
        "beta_deg": np.degrees(data.beta),
    }
    for load, values in data.loads.items():
        column = LOADS[load].column
        columns |= {
            f"measured_{column}": values,
            f"model_{column}": getattr(found, load),
            f"hover_{column}": hover[load],
        }
    return csv_of_rows(list(columns), np.stack(list(columns.values()), axis=1).tolist())


def _level_csv(file: FitFile, vehicle: Vehicle, log: FlightLog) -> str:
    model, hover = level_forces(vehicle, log, file.airfoil, file.values)
    weight = np.full(len(log), vehicle.mass * GRAVITY)
    heads = ("speed_mps", "weight_N", "model_vertical_force_N", "hover_vertical_force_N")
    return csv_of_rows(heads, np.stack([log.speed, weight, model, hover], axis=1).tolist())


def _bands(errors: Mapping[str, Comparison]) -> list[BandErrors]:
    found = []
    for name, c in errors.items():
        load, unit = _parted(name)
        for band, e in c.by_speed.items():
            found.append(BandErrors(load, unit, band, e.rows, e.rms, e.bias, e.worst, e.hover_rms))
    return found


def _parted(name: str) -> tuple[str, str]:
    """Load and unit of a name such as "torque_Nm"."""
    ending = next(end for end in WITHOUT_UNIT if name.endswith(end))
    return name.removesuffix(ending), {"_Nm": "N m", "_N": "N"}[ending]


def _verdict(given: GivenData) -> Verdict:
    sizes = {n: c.all.rms / c.all.relative_rms for n, c in given.errors.items() if c.all.rows}
    if given.tunnel is None:
        largest = max((s for s in sizes.values() if math.isfinite(s)), default=math.nan)
        sizes = dict.fromkeys(sizes, largest)
    shares = {n: (given.errors[n].all, size) for n, size in sizes.items()}
    told = ", ".join(
        f"{NAMES.get(_parted(n)[0], n)} {percent(e.rms / size)} (hover model "
        f"{percent(e.hover_rms / size)})"
        for n, (e, size) in shares.items()
    )
    level = worst_of([level_of(e.rms / size) for e, size in shares.values()] or ["bad"])
    rows = max((c.all.rows for c in given.errors.values()), default=0)
    return Verdict(level, WORDS[level], f"Typical errors on {rows} rows: {told or 'none'}.")


def _same(fit: FitRecord, given: GivenData) -> str:
    """Whether the fit has seen these data."""
    seen = {one.sha256 or one.name for one in fit.data}
    old = [one.name for one in given.sources if (one.sha256 or one.name) in seen]
    new = [one.name for one in given.sources if (one.sha256 or one.name) not in seen]
    told = []
    if new:
        told.append(
            f"Not among the fit's own data, so a test of it: {', '.join(new)}. (A changed copy of "
            "a fitted file counts as new.)"
        )
    if old:
        told.append(f"Among the fit's own data, so no independent test: {', '.join(old)}.")
    return " ".join(told)
