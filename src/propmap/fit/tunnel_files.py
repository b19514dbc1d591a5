"""DATA arguments of tunnel fits and checks: CSV files, UIUC files, names of the catalogue."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from propmap.catalogue.measurements import measurement, measurement_names
from propmap.errors import InputError, quoted
from propmap.fit.tunnel import TunnelData, merged
from propmap.io.operating_points import RPM
from propmap.io.points_file import LOAD_COLUMNS, read_points
from propmap.io.uiuc_loads import Coefficients, looks_like_uiuc_loads, read_uiuc_loads
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


def measured_in_catalogue(name: str, air: Air) -> TunnelData:
    """The measurement of the catalogue called ``name``, as loads in this ``air``."""
    m = measurement(name)
    # As published they are coefficients at this density.
    loads = {n: v * (air.density / m.air_density) for n, v in m.loads.items()}
    return TunnelData(name, m.omega, m.speed, m.beta, loads)


def measured_loads(path: Path) -> Callable[[Propeller, Air], TunnelData]:
    """The loads in a file, as a function of the propeller and the air that coefficients need.

    ``path`` is that of a CSV or UIUC file, which is read now.
    """
    if looks_like_uiuc_loads(path):
        return functools.partial(_of_coefficients, path.name, read_uiuc_loads(path))
    file = read_points(path, LOAD_COLUMNS)
    if not file.further:
        raise InputError(
            "there is no column with a load", f"add one of {', '.join(LOAD_COLUMNS)}", str(path)
        )
    points = file.points
    found = TunnelData(
        path.name,
        points.rpm * RPM,
        points.speed_mps,
        np.radians(points.beta_deg),
        {LOAD_COLUMNS[name]: values for name, values in file.further.items()},
    )
    return lambda _propeller, _air: found


def _read(item: Path | str, propeller: Propeller, air: Air) -> TunnelData:
    if isinstance(item, str):
        return measured_in_catalogue(item, air)
    return measured_loads(item)(propeller, air)


def _of_coefficients(name: str, c: Coefficients, propeller: Propeller, air: Air) -> TunnelData:
    turns, diameter = c.rpm / 60.0, 2.0 * propeller.radius
    force = air.density * turns**2 * diameter**4
    torque = c.power * force * diameter / (2.0 * np.pi)
    return TunnelData(
        name,
        c.rpm * RPM,
        c.advance * turns * diameter,
        np.zeros_like(c.rpm),
        {"thrust": c.thrust * force, "torque": torque},
    )
