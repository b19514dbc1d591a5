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
from propmap.fit.fit_record import FitRecord, Source
from propmap.fit.result_file import FitFile
from propmap.fit.still_explained import Trend
from propmap.fit.tunnel import TunnelData
from propmap.loads import LOADS
from propmap.report.fit_page.errors import Bands
from propmap.report.fit_page.judgement import label_of, level_of, worst_of
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
    residuals : sequence of sequence of Trend
        Of each force of whole flights, its residual against every candidate.
    """

    sources: Sequence[Source]
    errors: Mapping[str, Comparison]
    tunnel: TunnelData | None = None
    level: tuple[Vehicle, FlightLog] | None = None
    residuals: Sequence[Sequence[Trend]] = ()

    @property
    def bands(self) -> Bands:
        """Errors by load with its unit, then by band of speed."""
        return {_parted(name): one.by_speed for name, one in self.errors.items()}

    @property
    def verdict(self) -> dict[str, Any]:
        """Level of trust, number of rows, and the label and both models' errors of each load.

        Errors are shares of what was measured; those of forces in flight, of the largest force.
        """
        found = {n: c.all for n, c in self.errors.items() if c.all.rows}
        sizes = {n: e.rms / e.relative_rms for n, e in found.items()}
        if self.tunnel is None:
            largest = max(filter(math.isfinite, sizes.values()), default=math.nan)
            sizes = dict.fromkeys(found, largest)
        errors = [
            (label_of(_parted(n)[0]), e.rms / sizes[n], e.hover_rms / sizes[n])
            for n, e in found.items()
        ]
        level = worst_of([level_of(own) for _, own, _ in errors] or ["bad"])
        rows = max((e.rows for e in found.values()), default=0)
        return {"level": level, "rows": rows, "errors": errors}

    def known_to(self, fit: FitRecord) -> tuple[list[str], list[str]]:
        """Names of the data that the fit has not seen, and of those that it has."""
        seen = {one.sha256 or one.name for one in fit.data}
        names: tuple[list[str], list[str]] = ([], [])
        for one in self.sources:
            names[(one.sha256 or one.name) in seen].append(one.name)
        return names

    def figure(self, file: FitFile) -> Figure | None:
        """Measured beside predicted; None where the data are neither from a tunnel nor steady."""
        if self.tunnel is not None:
            return tunnel_fit(self.tunnel, Rotor(file.model))
        return None if self.level is None else level_flight(*self.level, file.airfoil)

    def sheet(self, file: FitFile) -> str | None:
        """The figure's numbers as CSV."""
        if self.tunnel is not None:
            data, rotor = self.tunnel, Rotor(file.model)
            found = rotor.loads(data.omega, data.speed, data.beta)
            still = HoverModel.of(rotor).loads(data.omega)
            columns: dict[str, Any] = {"rpm": data.omega * RPM, "speed_mps": data.speed}
            columns["beta_deg"] = np.degrees(data.beta)
            for name, values in data.loads.items():
                columns[f"measured_{LOADS[name].column}"] = values
                columns[f"model_{LOADS[name].column}"] = getattr(found, name)
                columns[f"hover_{LOADS[name].column}"] = still[name]
            return csv_of_columns([columns])
        if self.level is None:
            return None
        vehicle, log = self.level
        model, hover = level_forces(vehicle, log, file.airfoil, file.values)
        return csv_of_columns(
            [
                {
                    "speed_mps": log.speed,
                    "weight_N": vehicle.mass * GRAVITY,
                    "model_vertical_force_N": model,
                    "hover_vertical_force_N": hover,
                }
            ]
        )


def _parted(name: str) -> tuple[str, str]:
    """Load and unit of a name such as "torque_Nm"."""
    load, _, unit = name.rpartition("_")
    return load, {"Nm": "N m"}.get(unit, unit)
