"""What a fit's parameters are for flights, of which it may have seen some."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from propmap.fit.fit_record import Source
from propmap.fit.flight_parameters import of_others
from propmap.fit.parameters import EVERY, PER_FLIGHT, of_flight
from propmap.fit.result_file import FitFile
from propmap.fit.thrust_scale import HoverScale
from propmap.vehicle.flight_log import FlightLog
from propmap.vehicle.flight_names import flight_names
from propmap.vehicle.vehicle import Vehicle


def values_for(
    file: FitFile, vehicle: Vehicle, log: FlightLog, paths: Sequence[Path]
) -> tuple[dict[str, float], list[str]]:
    """Parameters for flights, and what is to be said of them.

    A flight of the fit keeps its own.  Of any other, the thrust scale is what its own hover has
    beside the hover of the fit's flights, where that tells; else it is the mean of the fit's
    flights, as its clock is.

    Parameters
    ----------
    file : FitFile
        The fit.
    vehicle, log : Vehicle, FlightLog
        What flew, and how.
    paths : sequence of Path
        The flights' files.
    """
    logs = file.record.data[:-1]  # The vehicle's file is the last.
    names = flight_names([source.file for source in logs])
    seen = {source.sha256: name for source, name in zip(logs, names, strict=True)}
    values, told = of_others(file.values), []
    by_hover, telling = dict[str, float](), dict[str, float]()
    if file.hover_reference:
        hovers = HoverScale.of(vehicle, log, file.hover_reference)
        by_hover, telling = hovers.scales, hovers.telling
    for flight, path in zip(log.flights, paths, strict=True):
        name = seen.get(Source.of(path).sha256)
        for one in PER_FLIGHT:
            here = of_flight(one, flight)
            values.pop(here, None)
            if name is not None:
                common = values.get(one, EVERY[one].start)
                values[here] = file.values.get(of_flight(one, name), common)
        scale = of_flight("thrust_scale", flight)
        if name is None and scale in by_hover:
            values |= {scale: telling[scale]} if scale in telling else {}
            why = "so much is applied" if scale in telling else "too near to 1 to be applied"
            told.append(
                f"in its hover flight {flight} has {by_hover[scale]:.3f} times the thrust of the "
                f"fit's flights at the same rotor speeds: {why}"
            )
    return values, told
