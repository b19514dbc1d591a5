"""DATA arguments of tunnel fits and checks: CSV files, UIUC files, names of the catalogue."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from propmap.catalogue.measurements import measurement, measurement_names
from propmap.errors import InputError, quoted
from propmap.fit.tunnel import TunnelData, merged
from propmap.io.operating_points import RPM
from propmap.io.points_file import LOAD_COLUMNS, read_points
from propmap.io.uiuc_loads import looks_like_uiuc_loads, read_uiuc_loads
from propmap.model.air import Air
from propmap.model.plausible import doubts_on_points
from propmap.model.plausible_loads import doubts_on_loads
from propmap.model.propeller import Propeller


def sources(data: Sequence[str]) -> list[Path | str]:
    """Files as paths, measurements of the catalogue by name; ``InputError`` for neither."""
    known = measurement_names()
    found: list[Path | str] = []
    for item in data:
        if item.strip().lower() in known:
            found.append(item.strip().lower())
        elif Path(item).is_file():
            found.append(Path(item))
        else:
            raise InputError(
                f"{quoted(item)} is neither a file nor a measurement of the catalogue",
                f"give a path or one of {', '.join(known)}",
            )
    return found


def read_tunnel(data: Sequence[str], propeller: Propeller, air: Air) -> TunnelData:
    """All of it as one set; coefficients become loads with this propeller and air."""
    return merged([_read(item, propeller, air) for item in sources(data)])


def doubts_on_tunnel(data: Sequence[str], propeller: Propeller, air: Air) -> list[str]:
    """What does not fit this propeller, for each file by itself, with the likely cause.

    Raises ``InputError`` where there can be no such loads or points.
    """
    found = []
    for item in sources(data):
        part = _read(item, propeller, air)
        points = part.omega, part.speed, part.beta
        try:
            doubts = doubts_on_points(propeller, *points)
            doubts += doubts_on_loads(propeller, air, *points, part.loads)
        except InputError as error:
            raise InputError(error.found, error.remedy, part.source) from None
        found += [f"{part.source}: {doubt}" for doubt in doubts]
    return found


def _read(item: Path | str, propeller: Propeller, air: Air) -> TunnelData:
    if isinstance(item, str):
        m = measurement(item)
        # As published they are coefficients at this density.
        loads = {n: v * (air.density / m.air_density) for n, v in m.loads.items()}
        return TunnelData(item, m.omega, m.speed, m.beta, loads)
    if looks_like_uiuc_loads(item):
        c = read_uiuc_loads(item)
        turns, diameter = c.rpm / 60.0, 2.0 * propeller.radius
        force = air.density * turns**2 * diameter**4
        torque = c.power * force * diameter / (2.0 * np.pi)
        return TunnelData(
            item.name,
            c.rpm * RPM,
            c.advance * turns * diameter,
            np.zeros_like(c.rpm),
            {"thrust": c.thrust * force, "torque": torque},
        )
    file = read_points(item, LOAD_COLUMNS)
    if not file.further:
        raise InputError(
            "there is no column with a load", f"add one of {', '.join(LOAD_COLUMNS)}", str(item)
        )
    points = file.points
    return TunnelData(
        item.name,
        points.rpm * RPM,
        points.speed_mps,
        np.radians(points.beta_deg),
        {LOAD_COLUMNS[name]: values for name, values in file.further.items()},
    )
