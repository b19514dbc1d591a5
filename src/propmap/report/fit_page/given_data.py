"""A fit against the data given with the report."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from propmap.baselines.hover import HoverModel
from propmap.fit.comparison import Comparison, level_forces
from propmap.fit.fit_record import Source
from propmap.fit.result_file import FitFile
from propmap.fit.tunnel import TunnelData
from propmap.loads import LOADS
from propmap.report.fit_page.errors import Bands
from propmap.report.fit_page.judgement import LABELS, WORDS, level_of, worst_of
from propmap.report.fit_pictures import level_flight, tunnel_fit
from propmap.report.page import csv_of_columns
from propmap.report.style import RPM
from propmap.rotor import Rotor
from propmap.vehicle.flight_log import GRAVITY, FlightLog
from propmap.vehicle.vehicle import Vehicle


@dataclass(frozen=True, eq=False)
class GivenData:
    """Data beside the fit file, compared with the fit.

    Attributes
    ----------
    sources : sequence of Source
        Of the data.
    errors : mapping of str to Comparison
        By load with its unit, such as "torque_Nm".
    tunnel : TunnelData, optional
        The rows, where they are from a tunnel.
    level : tuple of Vehicle and FlightLog, optional
        What flew, and its steady operating points, where these were given.
    """

    sources: Sequence[Source]
    errors: Mapping[str, Comparison]
    tunnel: TunnelData | None = None
    level: tuple[Vehicle, FlightLog] | None = None

    @property
    def bands(self) -> Bands:
        """Errors by load with its unit, then by band of speed."""
        return {_parted(name): one.by_speed for name, one in self.errors.items()}


def measured_figure(file: FitFile, given: GivenData) -> Figure | None:
    """Measured beside predicted; None where the data are neither from a tunnel nor steady."""
    if given.tunnel is not None:
        return tunnel_fit(given.tunnel, Rotor(file.model))
    return None if given.level is None else level_flight(*given.level, file.airfoil)


def measured_sheet(file: FitFile, given: GivenData) -> str | None:
    """The figure's numbers as CSV."""
    columns: dict[str, Any] = {}
    if given.level is not None:
        vehicle, log = given.level
        model, hover = level_forces(vehicle, log, file.airfoil, file.values)
        columns = {
            "speed_mps": log.speed,
            "weight_N": vehicle.mass * GRAVITY,
            "model_vertical_force_N": model,
            "hover_vertical_force_N": hover,
        }
    elif given.tunnel is not None:
        data, rotor = given.tunnel, Rotor(file.model)
        found = rotor.loads(data.omega, data.speed, data.beta)
        still = HoverModel.of(rotor).loads(data.omega)
        columns = {"rpm": data.omega * RPM, "speed_mps": data.speed}
        columns["beta_deg"] = np.degrees(data.beta)
        for name, values in data.loads.items():
            columns[f"measured_{LOADS[name].column}"] = values
            columns[f"model_{LOADS[name].column}"] = getattr(found, name)
            columns[f"hover_{LOADS[name].column}"] = still[name]
    return csv_of_columns(columns) if columns else None


def check_verdict(given: GivenData) -> dict[str, Any]:
    """The verdict: level, word, number of rows, and label and both models' errors by load.

    Errors are shares of what was measured; those of forces in flight, of the largest force.
    """
    found = {n: c.all for n, c in given.errors.items() if c.all.rows}
    sizes = {n: e.rms / e.relative_rms for n, e in found.items()}
    if given.tunnel is None:
        sizes = dict.fromkeys(found, max(filter(math.isfinite, sizes.values()), default=math.nan))
    errors = []
    for name, e in found.items():
        load, _ = _parted(name)
        errors.append((LABELS.get(load, load), e.rms / sizes[name], e.hover_rms / sizes[name]))
    level = worst_of([level_of(own) for _, own, _ in errors] or ["bad"])
    rows = max((e.rows for e in found.values()), default=0)
    return {"level": level, "word": WORDS[level], "rows": rows, "errors": errors}


def _parted(name: str) -> tuple[str, str]:
    """Load and unit of a name such as "torque_Nm"."""
    load, _, unit = name.rpartition("_")
    return load, {"Nm": "N m"}.get(unit, unit)
